"""Walls of products with details: as thick behind them, and open where they are cut."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.geometry import Mesh
from bozzetto.plugin import Job
from bozzetto_product.model.state import ProductState
from bozzetto_product.modeler import ProductModeler
from tests.plugins.product import detail_kit
from tests.plugins.product.test_walls import solid_of

PRODUCT = ProductModeler()


def with_details(*kinds: str) -> ProductState:
    """A ball with rounds of these kinds, in directions apart from one another."""
    state = detail_kit.ball()
    ways = ((1.0, 0.3, 0.35), (0.2, 1.0, -0.4), (-0.3, -0.2, 1.0))
    for kind, way in zip(kinds, ways, strict=False):
        place = tuple(detail_kit.RADIUS * np.array(way) / np.linalg.norm(way))
        row = detail_kit.loop_around(detail_kit.ball(), place, 8.0)
        state = detail_kit.with_detail(state, [row], kind=kind, depth=1.5, draft=0.0, gap=1.0)
    return replace(state, wall=2.0)


@pytest.mark.slow
def test_a_wall_is_as_thick_behind_what_is_pressed_in() -> None:
    state = with_details("in", "raised", "button")
    result = PRODUCT.solve(state, Job())
    assert not any(one.problem for one in result.detailed.details)
    (body,) = result.walls
    assert body.wall is not None
    assert not body.wall.rounded
    assert 0.97 * 2.0 <= body.wall.thinnest <= body.wall.thickest <= 1.03 * 2.0
    (solid,) = PRODUCT.shapes(state, result).solids
    made = solid_of(solid.mesh)
    outer, inner = sorted(made.decompose(), key=lambda part: -part.volume())
    assert (outer.genus(), inner.genus()) == (0, 0)
    names = {group.name for group in solid.groups}
    assert {"Detail 1", "Detail 1 wall", "Detail 3", "Surface 1", "Surface 1 wall"} <= names


@pytest.mark.slow
def test_what_is_cut_goes_through_both_walls_and_not_across_the_hollow() -> None:
    state = with_details("cut", "in")
    result = PRODUCT.solve(state, Job())
    (solid,) = PRODUCT.shapes(state, result).solids
    made = solid_of(solid.mesh)
    assert len(made.decompose()) == 1
    assert made.genus() == 1
    whole = PRODUCT.solve(with_details("split", "in"), Job()).walls[0].wall
    assert whole is not None
    # Between two balls a cylinder holds twice the difference of their caps' mean heights.
    around = 40.0 * np.sin(np.arctan(8.0 / 40.0))
    within = [
        2.0 / 3.0 * np.pi * (radius**3 - (radius**2 - around**2) ** 1.5) for radius in (40.0, 38.0)
    ]
    windows = 2.0 * (within[0] - within[1])
    assert solid_of(whole.mesh).volume() - made.volume() == pytest.approx(windows, rel=0.02)
    (owners,) = [body.opened for body in result.walls]
    assert 0 in owners


def test_cuts_are_left_out_of_walls_that_grow_outward_and_told() -> None:
    state = replace(with_details("cut"), wall_side="outside")
    result = PRODUCT.solve(state, Job())
    (solid,) = PRODUCT.shapes(state, result).solids
    assert len(solid_of(solid.mesh).decompose()) == 2
    assert any("left out of walls" in one.message for one in PRODUCT.cautions(state, result))


def test_walls_with_details_are_shown_once() -> None:
    state = with_details("cut")
    result = PRODUCT.solve(state, Job())
    scene = PRODUCT.scene(state, result)
    (solid,) = PRODUCT.shapes(state, result).solids
    names = {"surfaces", "walls"}
    shown = [item.mesh for layer in scene.layers if layer.name in names for item in layer.items]
    assert sum(map(area, shown)) == pytest.approx(area(solid.mesh), rel=5e-3)


def area(mesh: Mesh) -> float:
    a, b, c = mesh.vertices.astype(float)[mesh.faces].transpose(1, 0, 2)
    return 0.5 * float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())
