"""Strokes along a car, and what becomes of the edges that they mean."""

from __future__ import annotations

from typing import Literal

import numpy as np
import pytest
from numpy.typing import NDArray

from bozzetto.errors import UserError
from bozzetto.ink.curves.nearest import distances_to_polyline
from bozzetto.view import Camera
from bozzetto_car.body.chain_smoothing import smooth_chains
from bozzetto_car.body.trace_edges import trace
from bozzetto_car.template.loader import PAPER_TEMPLATES, bundled
from bozzetto_car.template.network import Network, edge_called, junctions, with_tangents
from tests.plugins.car.traced_car import SEEN, path, symmetric, view

Array = NDArray[np.float64]
Kind = Literal["perspective", "orthographic"]
KINDS: tuple[Kind, ...] = ("perspective", "orthographic")


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", PAPER_TEMPLATES)
def test_its_own_picture_changes_nothing(kind: Kind, name: str) -> None:
    network, camera = Network.of(bundled(name)), view(48.0, 14.0, kind)
    for edge in ("C1-S1.R", "S3.R-S2.R", "C2-C3", "S2.R-B2.R"):
        stroke = path(camera, network, [edge])
        for way in (stroke, stroke[::-1]):
            made = trace(network, way, camera)
            assert made.network.template.edge_names[max(made.run.edges[0], ~made.run.edges[0])] == (
                edge
            )
            assert np.abs(made.network.control_points - network.control_points).max() < 1e-6
            assert max(made.deviations) < 0.5


@pytest.mark.parametrize("kind", KINDS)
def test_traced_edges_are_seen_where_they_were_drawn(kind: Kind) -> None:
    rng = np.random.default_rng(2)
    sedan = bundled("sedan")
    network = Network.of(sedan)
    worst = []
    for trial in range(26):
        camera = view(rng.uniform(40, 65), rng.uniform(8, 20), kind)
        name = SEEN[trial % len(SEEN)]
        edge = edge_called(sedan, name)
        aim = with_tangents(
            network, {(edge, e): network.tangents[edge, e] + rng.normal(0, 150, 3) for e in (0, 1)}
        )
        stroke = path(camera, aim, [name])
        made = trace(network, stroke, camera)
        assert max(made.run.edges[0], ~made.run.edges[0]) == edge
        seen = path(camera, made.network, [name])
        off = max(
            distances_to_polyline(seen, stroke).max(), distances_to_polyline(stroke, seen).max()
        )
        assert off <= made.deviations[0] + 0.3
        worst.append(off)
        assert np.array_equal(made.network.positions, network.positions)
        assert symmetric(made.network)
        for joint in junctions(sedan):
            a = joint.senses[0] * made.network.tangents[joint.before]
            b = joint.senses[1] * made.network.tangents[joint.after]
            assert np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b) < 1e-9
    assert max(worst) <= 2.0


@pytest.mark.parametrize("kind", KINDS)
def test_chains_traced_in_one_stroke_are_followed_and_smooth(kind: Kind) -> None:
    rng = np.random.default_rng(3)
    sedan = bundled("sedan")
    network = Network.of(sedan)
    names = ["S1.R-S2.R", "S2.R-S3.R", "S3.R-S4.R"]
    for _ in range(6):
        camera = view(rng.uniform(60, 110), rng.uniform(8, 20), kind)
        edges = [edge_called(sedan, name) for name in names]
        aim = smooth_chains(with_tangents(network, {
            (edge, end): network.tangents[edge, end] + rng.normal(0, 80, 3)
            for edge in edges for end in (0, 1)
        }))  # fmt: skip
        made = trace(network, path(camera, aim, names), camera)
        assert [max(edge, ~edge) for edge in made.run.edges] == edges
        assert max(made.deviations) <= 2.0
        assert symmetric(made.network)
        assert np.array_equal(smooth_chains(made.network).tangents, made.network.tangents)


def test_a_stroke_over_the_middle_bends_both_sides_alike() -> None:
    sedan = bundled("sedan")
    network, camera = Network.of(sedan), view(25.0, 25.0)
    edge = edge_called(sedan, "C1-S1.R")
    aim = with_tangents(network, {(edge, 0): (0.0, 1000.0, 0.0), (edge, 1): (500.0, 500.0, -60.0)})
    made = trace(network, path(camera, aim, ["S1.L-C1", "C1-S1.R"]), camera)
    assert len(made.run.edges) == 2
    assert max(made.deviations) < 1.0
    assert symmetric(made.network)
    assert made.network.tangents[edge, 0, [0, 2]].tolist() == [0.0, 0.0]
    before, after = (
        np.abs(n.control_points[edge] - aim.control_points[edge]).max()
        for n in (network, made.network)
    )
    assert after < 0.5 * before


def test_edges_of_the_middle_stay_in_their_plane() -> None:
    sedan = bundled("sedan")
    network, camera = Network.of(sedan), view(60.0, 15.0)
    edge = edge_called(sedan, "C1-C2")
    stroke = path(camera, network, ["C1-C2"])
    bulge = 12.0 * np.sin(np.linspace(0.0, np.pi, len(stroke)))
    made = trace(network, stroke - np.column_stack((0 * bulge, bulge)), camera)
    assert (made.network.control_points[edge, :, 1] == 0.0).all()
    assert max(made.deviations) <= 2.0


def test_nodes_follow_when_asked() -> None:
    sedan = bundled("sedan")
    network, camera = Network.of(sedan), view(60.0, 15.0)
    names = ["S1.R-S2.R", "S2.R-S3.R"]
    stroke = path(camera, network, names) + np.array([3.0, -9.0])
    fixed = trace(network, stroke, camera).network
    assert np.array_equal(fixed.positions, network.positions)
    made = trace(network, stroke, camera, nodes_follow=True)
    nodes = [sedan.node[name] for name in ("S1.R", "S2.R", "S3.R")]
    pixels, depth = camera.project(made.network.positions[nodes])
    assert distances_to_polyline(pixels, stroke).max() < 1e-6
    assert np.abs(depth - camera.project(network.positions[nodes])[1]).max() < 1e-6
    assert max(made.deviations) < 2.0
    assert symmetric(made.network)


@pytest.mark.parametrize(
    ("stroke", "message"),
    [
        (np.zeros((0, 2)), "no points"),
        (np.array([[600.0, 400.0], [601.0, 400.0]]), "is a dot"),
        (np.array([[np.nan, 1.0], [2.0, 3.0]]), "not on the sheet"),
        (np.array([[-9000.0, -9000.0], [-8000.0, -9000.0]]), "far from every edge"),
    ],
    ids=("empty", "dot", "nan", "far"),
)
def test_mistakes_are_told(stroke: Array, message: str) -> None:
    with pytest.raises(UserError, match=message):
        trace(Network.of(bundled("sedan")), stroke, view(60.0, 15.0))


def test_a_car_behind_the_eye_is_told() -> None:
    network = Network.of(bundled("sedan"))
    away = Camera(eye=(9000.0, 0.0, 600.0), target=(20000.0, 0.0, 600.0))
    with pytest.raises(UserError, match="No edge of the car is in view"):
        trace(network, [[100.0, 100.0], [300.0, 300.0]], away)


def test_any_scribble_gives_a_finite_car_or_a_message() -> None:
    rng = np.random.default_rng(5)
    network, answers = Network.of(bundled("sedan")), 0
    for trial in range(16):
        camera = view(rng.uniform(-180, 180), rng.uniform(-5, 60), KINDS[trial % 2])
        stroke = np.cumsum(rng.normal(0, 1 + 20 * rng.random(), (40, 2)), axis=0)
        stroke += (600, 400)
        try:
            made = trace(network, stroke, camera, nodes_follow=bool(trial % 3 == 0))
        except UserError:
            continue
        answers += 1
        assert np.isfinite(made.deviations).all()
        assert np.isfinite(made.network.control_points).all()
        assert symmetric(made.network)
    assert answers > 8


def test_an_edge_that_is_seen_end_on_is_told_by_its_name() -> None:
    network, camera = Network.of(bundled("sedan")), view(0.0, 2.0, "orthographic")
    with pytest.raises(UserError, match="along C3-C4, seen end-on"):
        trace(network, path(camera, network, ["C3-C4"]), camera)
