"""Details over edges between surfaces: cuts over creases, outlines that begin on an edge."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from bozzetto.geometry import Solid
from bozzetto.plugin import Job
from bozzetto_product.hand_over.imported import product_of_network
from bozzetto_product.hand_over.shapes import shapes_of
from bozzetto_product.solve.result import ProductResult
from bozzetto_product.solve.solver import solve_product
from tests.plugins.product.test_creased_pieces import dome, facts
from tests.plugins.product.test_network_file import box

RADIUS = 8.0
TURN = 0.013 + np.linspace(0.0, 2.0 * np.pi, 64, endpoint=False)


def over_edge() -> list[list[float]]:
    """A circle, seen at 45°, about the edge between the top and the front of the box."""
    x, s = 50.0 + RADIUS * np.cos(TURN), RADIUS * np.sin(TURN) * np.sqrt(2.0)
    return np.column_stack((x, np.maximum(s, 0.0), 40.0 + np.minimum(s, 0.0))).tolist()


def solved(network: dict[str, Any], **detail: Any) -> tuple[ProductResult, tuple[Solid, ...]]:
    network["network"]["details"] = [{"depth": 2.0, **detail}]
    state = product_of_network(network)
    result = solve_product(state, Job())
    return result, shapes_of(state, result).solids


def volume(solid: Solid) -> float:
    a, b, c = (solid.mesh.vertices[solid.mesh.faces[:, k]].astype(float) for k in range(3))
    return abs(float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum())) / 6.0


def test_a_window_across_the_edge_of_a_box_has_its_volume() -> None:
    """A cylinder at 45°, less what its end is slanted by: A·l − 2·(2/3)·r³, l = 40·√2."""
    result, (solid,) = solved(box(), kind="cut", draft=0.0, outlines=[over_edge()])
    (detail,) = result.detailed.details
    assert detail.problem == ""
    assert solid.exact is not None
    assert solid.exact.is_closed
    hole = np.pi * RADIUS**2 * 40.0 * np.sqrt(2.0) - 4.0 / 3.0 * RADIUS**3
    assert 100.0 * 60.0 * 40.0 - volume(solid) == pytest.approx(hole, rel=5e-3)


def test_a_split_over_a_crease_colours_both_sides_and_changes_no_shape() -> None:
    result, (solid,) = solved(
        box(), kind="split", outlines=[over_edge()], color=[200, 40, 20], name="Badge"
    )
    assert [one.problem for one in result.detailed.details] == [""]
    assert volume(solid) == pytest.approx(240_000.0, rel=1e-6)
    assert solid.exact is not None
    assert solid.exact.is_closed
    colors = [group.color for group in solid.groups for _ in range(group.count)]
    a, b, c = (solid.mesh.vertices[solid.mesh.faces[:, k]].astype(float) for k in range(3))
    areas = 0.5 * np.cross(b - a, c - a)[[color == (200, 40, 20) for color in colors]]
    half = 0.5 * np.pi * RADIUS**2 * np.sqrt(2.0)
    assert np.abs(areas).sum(axis=0) == pytest.approx([0.0, half, half], rel=5e-3, abs=1e-9)


@pytest.mark.parametrize("kind", ["in", "raised", "button", "cut", "split"])
@pytest.mark.parametrize("middle", [(-12.0, 0.0), (0.0, 0.0), (0.0, 12.0)])
def test_an_outline_may_begin_on_an_edge(kind: str, middle: tuple[float, float]) -> None:
    """Its first point lies exactly on the edge between two surfaces that meet smoothly."""
    turn = np.linspace(0.0, 2.0 * np.pi, 40, endpoint=False)
    if middle[1]:
        turn = turn + 0.5 * np.pi
    ring = dome(middle[0] + 5.0 * np.cos(turn), middle[1] + 5.0 * np.sin(turn))
    result, _ = solved(facts(), kind=kind, depth=1.0, gap=0.4, outlines=[ring])
    assert [one.problem for one in result.detailed.details] == [""]
