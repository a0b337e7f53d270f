"""Chains: one direction at joints, least bending, shorter tangents; nodes never move."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline, CubicSpline

from bozzetto.geometry.patches.coons import coons_nets
from bozzetto.geometry.patches.crease import SMOOTH, crease_angles
from bozzetto_car.body.chain_smoothing import anneal, shorten_tangents, smooth_chains
from bozzetto_car.template.loader import bundled
from bozzetto_car.template.model import Template
from bozzetto_car.template.network import (
    Network,
    as_hermite,
    edge_called,
    junctions,
    node_called,
    with_tangents,
)
from tests.plugins.car.traced_car import symmetric

Array = NDArray[np.float64]


def disturbed(template: Template, by: float, seed: int = 0) -> Network:
    """A symmetric car whose tangents were changed at random, mm."""
    rng = np.random.default_rng(seed)
    network = Network.of(template)
    return with_tangents(
        network,
        {
            (edge, end): network.tangents[edge, end] + rng.normal(0.0, by, 3)
            for edge in range(len(template.edges))
            for end in (0, 1)
        },
    )


def kinks(network: Network) -> Array:
    """Angles at all joints, radians."""
    found = []
    for joint in junctions(network.template):
        a = joint.senses[0] * network.tangents[joint.before]
        b = joint.senses[1] * network.tangents[joint.after]
        found.append(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b))
    return np.array(found)


@pytest.mark.parametrize("seed", range(5))
def test_joints_take_one_direction_and_keep_their_lengths(template: Template, seed: int) -> None:
    rough = disturbed(template, 200.0, seed)
    smooth = smooth_chains(rough)
    assert kinks(rough).max() > 0.1
    assert kinks(smooth).max() < 1e-9
    before, after = (np.linalg.norm(n.tangents, axis=2) for n in (rough, smooth))
    assert np.abs(after - before).max() < 1e-9
    assert np.array_equal(smooth.positions, rough.positions)
    assert symmetric(smooth)
    assert np.array_equal(smooth_chains(smooth).tangents, smooth.tangents)


def test_a_sound_template_is_smooth_already(template: Template) -> None:
    assert np.array_equal(smooth_chains(Network.of(template)).tangents, template.tangents)


def test_the_longer_tangent_counts_for_more() -> None:
    sedan = bundled("sedan")
    network = Network.of(sedan)
    one, other = edge_called(sedan, "C2-C3"), edge_called(sedan, "C3-C4")
    long, short = np.array([300.0, 0.0, 0.0]), np.array([0.0, 0.0, 100.0])
    made = smooth_chains(with_tangents(network, {(one, 1): long, (other, 0): short}))
    assert np.degrees(np.arctan2(made.tangents[one, 1, 2], made.tangents[one, 1, 0])) == (
        pytest.approx(18.434948822922)
    )


def test_a_cusp_takes_the_direction_of_the_longer_tangent() -> None:
    sedan = bundled("sedan")
    one, other = edge_called(sedan, "C2-C3"), edge_called(sedan, "C3-C4")
    for lengths in ((300.0, 300.0 + 1e-8), (300.0, 300.0)):
        rough = with_tangents(
            Network.of(sedan), {(one, 1): [lengths[0], 0, 0], (other, 0): [-lengths[1], 0, 0]}
        )
        made = smooth_chains(rough)
        assert kinks(made).max() < 1e-9
        assert np.linalg.norm(made.tangents[one, 1]) == pytest.approx(300.0)


def test_tangents_without_a_length_do_no_harm() -> None:
    sedan = bundled("sedan")
    one, other = edge_called(sedan, "C2-C3"), edge_called(sedan, "C3-C4")
    single = smooth_chains(with_tangents(Network.of(sedan), {(one, 1): np.zeros(3)}))
    assert np.array_equal(single.tangents, with_tangents(single, {(one, 1): np.zeros(3)}).tangents)
    both = with_tangents(Network.of(sedan), {(one, 1): np.zeros(3), (other, 0): np.zeros(3)})
    assert np.array_equal(smooth_chains(both).tangents, both.tangents)


def test_who_leads_is_followed_and_does_not_turn(template: Template) -> None:
    rough = disturbed(template, 150.0)
    for name in ("C3-C4", "S3.L-S2.L"):
        edge = edge_called(template, name)
        made = smooth_chains(rough, leading=(edge,))
        assert np.array_equal(made.tangents[edge], rough.tangents[edge])
        assert kinks(made).max() < 1e-9
        assert symmetric(made)


def test_only_the_joints_asked_for_change() -> None:
    sedan = bundled("sedan")
    rough = disturbed(sedan, 150.0)
    node = node_called(sedan, "S3.L")
    made = smooth_chains(rough, nodes=(node,))
    changed = {
        sedan.names[sedan.edges[edge, end]]
        for edge, end in zip(
            *np.nonzero((made.tangents != rough.tangents).any(axis=2)), strict=True
        )
    }
    assert changed == {"S3.L", "S3.R"}


def test_tangents_are_shortened_to_a_third_of_the_chord(template: Template) -> None:
    rough = disturbed(template, 400.0)
    made = shorten_tangents(rough)
    chords = np.linalg.norm(rough.ends[:, 1] - rough.ends[:, 0], axis=1)
    lengths = np.linalg.norm(made.tangents, axis=2)
    assert (lengths <= chords[:, None] * (1 + 1e-9)).all()
    short = np.linalg.norm(rough.tangents, axis=2) <= chords[:, None]
    assert np.array_equal(made.tangents[short], rough.tangents[short])
    cosines = (made.tangents * rough.tangents).sum(axis=2)
    cosines /= lengths * np.linalg.norm(rough.tangents, axis=2)
    assert np.abs(cosines - 1.0).max() < 1e-12
    assert np.array_equal(shorten_tangents(made).tangents, made.tangents)
    assert np.array_equal(made.positions, rough.positions)
    assert symmetric(made)


def test_a_loop_is_gone_once_tangents_are_reduced() -> None:
    sedan = bundled("sedan")
    edge = edge_called(sedan, "C1-C2")
    chord = sedan.positions[sedan.node["C2"]] - sedan.positions[sedan.node["C1"]]
    wild = {(edge, 0): 6 * chord + [0, 0, 2000], (edge, 1): 6 * chord - [0, 0, 2000]}
    looped = with_tangents(Network.of(sedan), wild)

    def goes_back(network: Network) -> bool:
        hull = np.diff(network.control_points[edge] @ chord)
        at = np.linspace(0, 1, 201)
        speed = hull[0] * (1 - at) ** 2 + 2 * hull[1] * at * (1 - at) + hull[2] * at**2
        return bool(speed.min() < 0)

    assert goes_back(looped)
    assert not goes_back(shorten_tangents(looped))


def test_annealing_gives_the_natural_spline() -> None:
    """Against scipy, with knots whose ratios are those of the template's tangents."""
    sedan = bundled("sedan")
    names = ["C2", "C3", "C4", "C5", "C6"]
    edges = [edge_called(sedan, f"{a}-{b}") for a, b in pairwise(names)]
    made = anneal(disturbed(sedan, 200.0))
    steps = [1.0]
    for one, other in pairwise(edges):
        arriving, leaving = sedan.tangents[one, 1], sedan.tangents[other, 0]
        steps.append(steps[-1] * float(np.linalg.norm(leaving) / np.linalg.norm(arriving)))
    knots = np.concatenate(([0.0], np.cumsum(steps)))
    spline = CubicSpline(knots, [sedan.positions[sedan.node[n]] for n in names], bc_type="natural")
    for edge, step, begin, end in zip(edges, steps, knots[:-1], knots[1:], strict=True):
        assert np.abs(made.tangents[edge, 0] - step * spline(begin, 1)).max() < 1e-9
        assert np.abs(made.tangents[edge, 1] - step * spline(end, 1)).max() < 1e-9


def test_no_other_tangents_bend_less() -> None:
    """By the integral of squared second derivatives, over random velocities at the nodes."""
    sedan = bundled("sedan")
    made = anneal(disturbed(sedan, 200.0))
    chain = next(chain for chain in sedan.chains if chain.name == "sill.R")
    points = [
        made.control_points[e] if e >= 0 else made.control_points[~e][::-1] for e in chain.edges
    ]
    tangents = np.array([as_hermite(p)[1] for p in points])
    places = np.array([[p[0], p[3]] for p in points])
    steps = np.ones(len(points))
    for at in range(1, len(points)):
        steps[at] = steps[at - 1] * (
            np.linalg.norm(tangents[at, 0]) / np.linalg.norm(tangents[at - 1, 1])
        )
    speeds = np.vstack((tangents[:, 0] / steps[:, None], tangents[-1:, 1] / steps[-1]))

    def bending(speeds: Array) -> float:
        """Integral of squared second derivatives; Simpson's rule is exact for quadratics."""
        total = 0.0
        for at, step in enumerate(steps):
            piece = CubicHermiteSpline([0.0, step], places[at], speeds[at : at + 2])
            squares = (piece([0.0, step / 2.0, step], 2) ** 2).sum(axis=1)
            total += float(squares @ [1.0, 4.0, 1.0]) * step / 6.0
        return total

    least = bending(speeds)
    rng = np.random.default_rng(4)
    for _ in range(20):
        assert bending(speeds + rng.normal(0, 0.05 * np.abs(speeds).max(), speeds.shape)) > least


def test_annealing_moves_no_node_and_is_done_once(template: Template) -> None:
    rough = disturbed(template, 200.0)
    made = anneal(rough)
    assert np.array_equal(made.positions, rough.positions)
    assert symmetric(made)
    assert kinks(made).max() < 1e-9
    assert np.array_equal(anneal(made).tangents, made.tangents)
    # Posts and single edges between corners are in no smooth part: they are left alone.
    for name in ("S2.R-B2.R", "R1.R-S2.R", "C0-C1"):
        edge = edge_called(template, name)
        assert np.array_equal(made.tangents[edge], rough.tangents[edge])


def test_only_the_chains_asked_for_are_annealed() -> None:
    sedan = bundled("sedan")
    rough = disturbed(sedan, 200.0)
    made = anneal(rough, ("shoulder.R",))
    changed = (made.tangents != rough.tangents).any(axis=(1, 2))
    names = {sedan.edge_names[edge].replace(".L", ".R") for edge in np.flatnonzero(changed)}
    assert names == {"S2.R-S1.R", "S3.R-S2.R", "S4.R-S3.R", "S5.R-S4.R"}


def test_annealing_keeps_surfaces_smooth(template: Template) -> None:
    sides = [patch.edges for patch in template.patches]

    def creases(network: Network) -> Array:
        return crease_angles(coons_nets(network.control_points, sides), sides, len(template.edges))

    network = Network.of(template)
    smooth = creases(network) < SMOOTH
    assert smooth.sum() >= 15
    assert creases(anneal(network))[smooth].max() < 1e-9
