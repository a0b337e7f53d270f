"""Nodes and handles dragged."""

from __future__ import annotations

from typing import Literal

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto_car.body.drag import drag_handle, drag_node, drag_place, drag_places
from bozzetto_car.template.loader import bundled
from bozzetto_car.template.network import Network, edge_called, node_called
from tests.plugins.car.traced_car import symmetric, view

Kind = Literal["perspective", "orthographic"]
KINDS: tuple[Kind, ...] = ("perspective", "orthographic")


@pytest.mark.parametrize("kind", KINDS)
def test_places_go_parallel_to_the_image_plane(kind: Kind) -> None:
    rng = np.random.default_rng(0)
    for _ in range(50):
        camera = view(rng.uniform(-180, 180), rng.uniform(-10, 60), kind)
        place, pixel = rng.normal((2000, 0, 700), 600), rng.uniform(0, 800, 2)
        moved = drag_place(place, pixel, camera)
        seen, depth = camera.project(np.stack((place, moved)))
        assert np.abs(seen[1] - pixel).max() < 1e-9
        assert abs(depth[1] - depth[0]) < 1e-8


@pytest.mark.parametrize("kind", KINDS)
def test_in_a_plane_they_go_to_where_the_ray_meets_it(kind: Kind) -> None:
    camera = view(50.0, 20.0, kind)
    place, pixel = np.array([2000.0, 0.0, 1200.0]), np.array([400.0, 250.0])
    moved = drag_place(place, pixel, camera, (True, False, True))
    goal = camera.on_plane(pixel[None], (0.0, 0.0, 0.0), (0.0, 1.0, 0.0))[0]
    assert moved[1] == 0.0
    assert np.abs(moved - goal).max() < 1e-6


@pytest.mark.parametrize("kind", KINDS)
def test_many_go_where_each_one_goes_by_itself(kind: Kind) -> None:
    rng = np.random.default_rng(1)
    camera = view(50.0, 20.0, kind)
    places, pixels = rng.normal((2000, 0, 700), 600, (60, 3)), rng.uniform(0, 800, (60, 2))
    free = np.array([(True, True, True), (True, False, True), (False, True, False)])[
        np.arange(60) % 3
    ]
    moved = drag_places(places, pixels, camera, free)
    alone = [
        drag_place(*each[:2], camera, each[2]) for each in zip(places, pixels, free, strict=True)
    ]
    # The nearest place on a line is where a square is least: it is known to half of the digits.
    np.testing.assert_allclose(moved, alone, rtol=0.0, atol=1e-4)
    np.testing.assert_array_equal(moved[~free], places[~free])


def test_in_a_plane_seen_edge_on_they_do_not_fly_away() -> None:
    camera = view(0.0, 0.0)
    moved = drag_place([2000.0, 0.0, 1200.0], [900.0, 300.0], camera, (True, False, True))
    pixel, _ = camera.project(moved)
    assert abs(pixel[0, 1] - 300.0) < 1e-6
    assert abs(moved[0] - 2000.0) < 0.1 * abs(moved[2] - 1200.0)


@pytest.mark.parametrize("kind", KINDS)
def test_nodes_go_where_they_are_dragged_and_keep_their_tangents(kind: Kind) -> None:
    sedan = bundled("sedan")
    network, camera = Network.of(sedan), view(55.0, 18.0, kind)
    for name in ("S3.R", "S2.L", "C3"):
        node = node_called(sedan, name)
        goal = camera.project(network.positions[[node]])[0][0] + [25.0, -14.0]
        made = drag_node(network, node, goal, camera)
        assert np.abs(camera.project(made.positions[[node]])[0][0] - goal).max() < 1e-6
        assert np.array_equal(made.tangents, network.tangents)
        assert symmetric(made)
        others = np.ones(len(sedan.names), bool)
        others[[node, sedan.mirrored[node]]] = False
        assert np.array_equal(made.positions[others], network.positions[others])


@pytest.mark.parametrize("kind", KINDS)
def test_handles_go_where_they_are_dragged_and_chains_stay_smooth(kind: Kind) -> None:
    sedan = bundled("sedan")
    network, camera = Network.of(sedan), view(55.0, 18.0, kind)
    for name, end in (("S3.R-S2.R", 0), ("C3-C4", 1), ("S2.R-B2.R", 1)):
        edge = edge_called(sedan, name)
        goal = camera.project(network.control_points[edge, [1 + end]])[0][0] + [10.0, -20.0]
        made = drag_handle(network, edge, end, goal, camera)
        seen = camera.project(made.control_points[edge, [1 + end]])[0][0]
        assert np.abs(seen - goal).max() < 1e-6
        assert np.array_equal(made.positions, network.positions)
        assert symmetric(made)
    neighbour = edge_called(sedan, "S4.R-S3.R")
    edge = edge_called(sedan, "S3.R-S2.R")
    goal = camera.project(network.control_points[edge, [1]])[0][0] + [0.0, -30.0]
    made = drag_handle(network, edge, 0, goal, camera)
    one, other = made.tangents[edge, 0], made.tangents[neighbour, 1]
    assert np.linalg.norm(np.cross(one, other)) < 1e-9 * (one @ other)
    assert np.linalg.norm(other) == pytest.approx(np.linalg.norm(network.tangents[neighbour, 1]))


def test_handles_across_the_middle_stay_at_a_right_angle() -> None:
    sedan = bundled("sedan")
    network, camera = Network.of(sedan), view(30.0, 25.0)
    edge = edge_called(sedan, "C2-S2.R")
    made = drag_handle(network, edge, 0, (700.0, 300.0), camera)
    assert made.tangents[edge, 0, [0, 2]].tolist() == [0.0, 0.0]
    assert made.tangents[edge, 0, 1] != network.tangents[edge, 0, 1]
    assert symmetric(made)


def test_a_handle_on_its_node_keeps_a_direction() -> None:
    sedan = bundled("sedan")
    network, camera = Network.of(sedan), view(55.0, 18.0, "orthographic")
    edge = edge_called(sedan, "S3.R-S2.R")
    handle = network.control_points[edge, 1]
    node = network.ends[edge, 0]
    depth = camera.axes[2]
    # Where the handle is as deep as its node, it can be dragged right on it.
    level = node + (handle - node) - ((handle - node) @ depth) * depth
    first = Network(
        sedan, network.positions,
        np.array([[(level - node) * 3.0, t[1]] if e == edge else t
                  for e, t in enumerate(network.tangents)]),
    )  # fmt: skip
    made = drag_handle(first, edge, 0, camera.project(node[None])[0][0], camera)
    assert np.linalg.norm(made.tangents[edge, 0]) > 1.0


def test_mistakes_are_told() -> None:
    network, camera = Network.of(bundled("sedan")), view(55.0, 18.0)
    with pytest.raises(UserError, match="not on the sheet"):
        drag_node(network, 0, (np.nan, 0.0), camera)
    behind = camera.__class__(eye=(2300.0, 0.0, 600.0), target=(9000.0, 0.0, 600.0))
    with pytest.raises(UserError, match="node C0 is behind the eye"):
        drag_node(network, network.template.node["C0"], (10.0, 10.0), behind)
    with pytest.raises(UserError, match="edge C0-C1 is behind the eye"):
        drag_handle(network, 0, 0, (10.0, 10.0), behind)
