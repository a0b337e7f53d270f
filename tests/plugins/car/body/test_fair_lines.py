"""Lines of solved cars: bent once, like the template's, and smooth where its lines are."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.geometry.patches import coons_nets, crease_angles
from bozzetto_car.body.chain_smoothing import anneal, lock_ratios, smooth_chains
from bozzetto_car.body.fair_lines import (
    SUNK,
    crested,
    crests,
    double_bends,
    fair_network,
    straightened,
    turned_with_chords,
)
from bozzetto_car.template.loader import TEMPLATES, bundled
from bozzetto_car.template.model import MIRROR, Template
from bozzetto_car.template.network import Network
from bozzetto_car.template.network_validation import NARROWEST_CORNER
from tests.plugins.car.sketched import rubbery, styled
from tests.plugins.car.unseen import KINDS, unseen


def trembling(template: Template, seed: int) -> np.ndarray:
    """A styled car with 15 mm of tremor in each node."""
    car = styled(template, seed)
    moves = np.random.default_rng(seed).normal(0.0, 15.0, car.shape)
    car += 0.5 * (moves + moves[template.mirrored] * MIRROR)
    car[template.centre, 1] = 0.0
    return car


@pytest.mark.parametrize("seed", range(5))
def test_no_edge_bends_twice(template: Template, seed: int) -> None:
    was = (double_bends(Network.of(template, trembling(template, seed))) > 1e-6).sum()
    made = fair_network(template, trembling(template, seed))
    assert was >= 8
    assert double_bends(made).max() <= 1e-6


def widest(network: Network) -> float:
    """Widest corner of all patches of both sides, degrees, seen from outside."""
    found = 0.0
    for patch in network.template.patches:
        places = network.positions[list(patch.nodes)]
        normal = np.cross(places[2] - places[0], places[3] - places[1])
        ring = [bezier[[0, 1]] if edge >= 0 else bezier[[3, 2]] for edge, bezier in (
            (edge, network.control_points[max(edge, ~edge)]) for edge in patch.edges)]  # fmt: skip
        back = [bezier[[3, 2]] if edge >= 0 else bezier[[0, 1]] for edge, bezier in (
            (edge, network.control_points[max(edge, ~edge)]) for edge in patch.edges)]  # fmt: skip
        for number in range(4):
            ahead, behind = (leg[1] - leg[0] for leg in (ring[number], back[number - 1]))
            flat = [way - (way @ normal) * normal / (normal @ normal) for way in (ahead, behind)]
            sine = np.cross(*flat) @ normal / np.linalg.norm(normal)
            angle = np.degrees(np.arctan2(sine, flat[0] @ flat[1])) % 360.0
            found = max(found, float(angle))
    return found


def test_no_two_edges_of_a_patch_come_to_run_in_one_line() -> None:
    """In a van the post behind the last window is one straight line from the roof down."""
    van = bundled(KINDS["van"].template)
    cars = [unseen(KINDS["van"], 300 + seed) for seed in range(8)]
    before = [widest(straightened(anneal(turned_with_chords(van, car)))) for car in cars]
    after = [fair_network(van, car) for car in cars]
    assert max(before) > 180.0 - NARROWEST_CORNER
    assert max(map(widest, after)) < 180.0 - NARROWEST_CORNER
    assert max(double_bends(made).max() for made in after) <= 1e-6


def test_nodes_stay_and_both_sides_are_the_same(template: Template) -> None:
    car = trembling(template, 1)
    made = fair_network(template, car)
    assert np.array_equal(made.positions, car)
    image = template.mirrored_edges
    for edge, twin in enumerate(image.tolist()):
        own = made.tangents[edge]
        other = made.tangents[twin] if twin >= 0 else -made.tangents[~twin, ::-1]
        assert np.array_equal(own, other * MIRROR) or np.allclose(own, other * MIRROR, atol=1e-9)


def test_smooth_joints_stay_smooth(template: Template) -> None:
    """Surfaces that the template joins smoothly are smooth in every car."""

    def creases(network: Network) -> np.ndarray:
        nets = coons_nets(network.control_points, template.sides)
        return crease_angles(nets, template.sides, len(template.edges))

    smooth = creases(Network.of(template)) < 1e-6
    assert smooth.sum() >= 10
    for seed in range(3):
        assert creases(fair_network(template, trembling(template, seed)))[smooth].max() < 1e-6


def test_a_turned_and_stretched_car_has_the_templates_edges(template: Template) -> None:
    """A similarity in the plane of symmetry takes tangents along exactly."""
    turn = np.radians(20.0)
    matrix = 1.3 * np.array(
        [
            [np.cos(turn), 0.0, np.sin(turn)],
            [0.0, 1.0, 0.0],
            [-np.sin(turn), 0.0, np.cos(turn)],
        ]
    )
    made = turned_with_chords(template, template.positions @ (1.3 * np.eye(3)))
    assert made.tangents == pytest.approx(1.3 * template.tangents, abs=1e-9)
    flat = np.isin(template.edges, template.centre).all(axis=1)
    made = turned_with_chords(template, template.positions @ matrix.T)
    assert made.tangents[flat] == pytest.approx(template.tangents[flat] @ matrix.T, abs=1e-9)


def test_what_does_not_bend_twice_is_left_alone(template: Template) -> None:
    network = fair_network(template, rubbery(template, 2))
    again = straightened(network)
    assert np.array_equal(again.tangents, network.tangents)
    smoothed = smooth_chains(again)
    assert smoothed.tangents == pytest.approx(again.tangents, abs=1e-9)


@pytest.mark.parametrize("name", TEMPLATES)
def test_the_highest_point_of_the_roof_stays_the_highest(name: str) -> None:
    """Whatever the nodes around it did, as long as they are lower; also where surfaces are locked
    to be smooth. Where one is higher the line only bends as little as before."""
    template = bundled(name)
    before, top, after = (template.node[node] for node in ("C3", "C4", "C5"))
    pairs = (before, top), (top, after)
    roof = [max(edge, ~edge) for edge in (template.edge_between[pair] for pair in pairs)]
    along = np.linspace(0.0, 1.0, 201)[:, None]
    judged = 0
    for seed in range(20):
        made = lock_ratios(fair_network(template, trembling(template, seed)))
        heights = made.positions[[before, top, after], 2]
        assert double_bends(made)[roof].max() <= 1e-6
        if heights[1] > heights[[0, 2]].max():
            # By de Casteljau's scheme, all heights along both edges.
            points = made.control_points[roof, :, 2].T[:, None]
            for _ in range(3):
                points = (1.0 - along) * points[:-1] + along * points[1:]
            assert points.max() <= heights[1] + 0.01
            judged += 1
    assert judged >= 10


@pytest.mark.parametrize("name", TEMPLATES)
def test_lines_do_not_leap_while_nodes_move(name: str) -> None:
    """In small steps from one car to another a handle moves a few times as far as a node."""
    template = bundled(name)
    for seed in range(2):
        begin, end = trembling(template, seed), trembling(template, seed + 100)
        step = (end - begin) / 200.0
        farthest = np.linalg.norm(step, axis=1).max()
        made = [fair_network(template, begin + number * step) for number in range(40)]
        points = np.array([one.control_points for one in made])
        moves = np.linalg.norm(np.diff(points, axis=0), axis=-1)
        assert farthest < 2.0
        assert moves.max() <= 3.0 * farthest


@pytest.mark.parametrize("name", TEMPLATES)
def test_lines_do_not_leap_where_their_highest_node_sinks_to_a_neighbour(name: str) -> None:
    """The line was level there, or as the rest has it, from one half millimetre to the next."""
    template = bundled(name)
    judged = 0
    for seed in (20, 21):
        places = trembling(template, seed)
        for joint in crests(template):
            pair = [joint.node, int(template.mirrored[joint.node])]
            level = places[list(joint.neighbours), 2].max()
            made = []
            for height in (0.75, 0.25, -0.25, -0.75):
                places[pair, 2] = level + height
                made.append(fair_network(template, places).control_points)
            moves = np.linalg.norm(np.diff(made, axis=0), axis=-1)
            assert moves.max() <= 3.0 * 0.5
            judged += 1
    assert judged >= 2


@pytest.mark.parametrize("name", TEMPLATES)
def test_a_node_far_below_its_neighbour_is_no_crest(name: str) -> None:
    """Its line is as fair as any other's, and not level."""
    template = bundled(name)
    for joint in crests(template):
        places = trembling(template, 22)
        pair = [joint.node, int(template.mirrored[joint.node])]
        places[pair, 2] = places[list(joint.neighbours), 2].max() - SUNK - 1.0
        before = straightened(anneal(turned_with_chords(template, places)))
        after = crested(before)
        for end in (joint.before, joint.after):
            np.testing.assert_array_equal(after.tangents[end], before.tangents[end])
