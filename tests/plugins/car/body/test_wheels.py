"""Wheels: where they stand, that they are seen beside their panels, and both sides alike."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.geometry import Mesh
from bozzetto.geometry.patches.coons import coons_nets
from bozzetto.geometry.patches.ray_intersections import ray_hits
from bozzetto_car.parts.wheels import wheels_of
from bozzetto_car.template.loader import TEMPLATES, bundled
from bozzetto_car.template.model import Template
from bozzetto_car.template.network import Network, with_positions
from tests.plugins.car.sketched import rubbery, styled


def nets_of(network: Network) -> np.ndarray:
    return coons_nets(network.control_points, network.template.sides)


def as_seen(network: Network) -> tuple[Mesh, Mesh]:
    """All wheels of the right side in one, and those of the left side."""
    seen = {part.name: part.mesh() for part in wheels_of(network, nets_of(network), sunk=False)}
    right, left = (
        [mesh for name, mesh in seen.items() if name.endswith(side)] for side in ("right", "left")
    )
    return joined(right), joined(left)


def joined(meshes: list[Mesh]) -> Mesh:
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    rows = [(mesh.vertices, mesh.normals, mesh.colors) for mesh in meshes]
    vertices, normals, colors = (np.concatenate(row) for row in zip(*rows, strict=True))
    faces = [mesh.faces + start for mesh, start in zip(meshes, starts, strict=False)]
    return Mesh(vertices, np.concatenate(faces), normals, colors)


def cars(template: Template) -> list[Network]:
    made = [
        template.positions,
        *(styled(template, seed) for seed in range(3)),
        rubbery(template, 1),
    ]
    return [Network.of(template, car) for car in made]


@pytest.mark.parametrize("name", TEMPLATES)
def test_wheels_stand_on_the_ground_under_their_nodes_and_both_sides_are_alike(name: str) -> None:
    template = bundled(name)
    for network in cars(template):
        right, left = as_seen(network)
        assert np.array_equal(right.vertices * np.float32([1, -1, 1]), left.vertices)
        assert right.vertices[:, 2].min() == pytest.approx(0.0, abs=0.01)
        tyres = right.colors[:, 0] == 46
        for node in template.wheels[:, 0]:
            x, _, z = network.positions[node]
            near = np.hypot(right.vertices[:, 0] - x, right.vertices[:, 2] - z) < 1.001 * z
            own = right.vertices[tyres & near]
            assert (own[:, 0].min() + own[:, 0].max()) / 2 == pytest.approx(x, abs=0.01)
            assert np.ptp(own[:, 0]) == pytest.approx(2 * z, abs=0.01)


@pytest.mark.parametrize("name", TEMPLATES)
def test_no_panel_swallows_the_face_of_a_wheel(name: str) -> None:
    """Rays from outside, another way to look at the body than the one the wheels are set by."""
    template = bundled(name)
    for network in cars(template):
        right, _ = as_seen(network)
        rng = np.random.default_rng(3)
        for node in template.wheels[:, 0]:
            centre, radius = network.positions[node], network.positions[node, 2]
            away, turn = 0.95 * radius * np.sqrt(rng.random(60)), rng.uniform(0, 2 * np.pi, 60)
            start = np.stack(
                (centre[0] + away * np.cos(turn), np.full(60, 4e3), radius + away * np.sin(turn)), 1
            )
            _, far = ray_hits(nets_of(network), start, np.tile((0.0, -1.0, 0.0), (60, 1)))
            near = np.hypot(right.vertices[:, 0] - centre[0], right.vertices[:, 2] - radius)
            face = right.vertices[(near < 0.9 * radius), 1].max()
            panel = 4e3 - far[np.isfinite(far)]
            assert len(panel) > 10
            assert face - 0.052 * radius > panel.max()
            assert face < panel.max() + 60.0


def test_faces_look_the_way_of_their_normals() -> None:
    network = Network.of(bundled("sedan"))
    for mesh in as_seen(network):
        a, b, c = mesh.vertices[mesh.faces].astype(float).transpose(1, 0, 2)
        normal = np.cross(b - a, c - a)
        area = np.linalg.norm(normal, axis=1)
        told = mesh.normals[mesh.faces].astype(float).mean(axis=1)
        good = area > 1.0
        assert ((normal * told).sum(axis=1)[good] > 0.3 * area[good]).all()
        assert np.abs(np.linalg.norm(mesh.normals, axis=1) - 1.0).max() < 1e-5


def test_wheels_below_the_ground_and_beside_the_body_are_no_mistake() -> None:
    network = Network.of(bundled("sedan"))
    front = int(network.template.wheels[0, 0])
    sunk = with_positions(network, {front: (900.0, 785.0, -10.0)})
    assert len(as_seen(sunk)[0].vertices) < len(as_seen(network)[0].vertices)
    far = with_positions(network, {front: (-9000.0, 785.0, 300.0)})
    assert all(np.isfinite(mesh.vertices).all() for mesh in as_seen(far))
