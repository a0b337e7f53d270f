"""The box and its section with the centre plane."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto_symmetry.model.box_geometry import box_edges, plane_outline
from bozzetto_symmetry.model.symmetry_plane import CentrePlane
from tests.plugins.symmetry.boxes import PLANES, STATE, tilted


def area(outline: np.ndarray, normal: np.ndarray) -> float:
    """Signed, of a plane polygon."""
    return 0.5 * float(np.cross(outline, np.roll(outline, -1, axis=0)).sum(axis=0) @ normal)


def test_the_twelve_edges_run_along_the_axes_in_turn() -> None:
    ways = np.diff(box_edges(STATE), axis=1)[:, 0]
    assert (np.count_nonzero(ways, axis=1) == 1).all()
    assert np.abs(ways).argmax(axis=1).tolist() == [0] * 4 + [1] * 4 + [2] * 4
    assert (ways.max(axis=1) > 0).all()


@pytest.mark.parametrize("symmetry", ["width", "length", "height"])
def test_the_box_s_own_planes_cut_it_in_half(symmetry: str) -> None:
    state = replace(STATE, symmetry=symmetry)
    axis = {"length": 0, "width": 1, "height": 2}[symmetry]
    outline = plane_outline(state)
    assert (outline[:, axis] == STATE.centre[axis]).all()
    expected = np.prod(np.delete(STATE.size, axis))
    normal = np.asarray(state.plane.normal)
    assert abs(area(outline, normal)) == pytest.approx(expected)


@pytest.mark.parametrize("plane", PLANES)
def test_a_tilted_plane_is_shown_where_it_is_in_the_box(plane: CentrePlane) -> None:
    outline = plane_outline(tilted(plane))
    normal = np.asarray(plane.normal)
    assert np.abs((outline - plane.point) @ normal).max() < 1e-9
    # Its area by random places of the plane.
    random = np.random.default_rng(3)
    frame = np.linalg.svd(normal[None])[2][1:]
    reach, foot = 320.0, outline.mean(axis=0)
    places = foot + random.uniform(-reach, reach, (400_000, 2)) @ frame
    inside = (np.abs(places - STATE.centre) <= 0.5 * np.asarray(STATE.size) + 1e-9).all(axis=1)
    assert abs(area(outline, normal)) == pytest.approx(inside.mean() * (2.0 * reach) ** 2, rel=0.02)
    # Convex and in order: every corner turns the same way.
    step = np.roll(outline, -1, axis=0) - outline
    turns = np.cross(step, np.roll(step, -1, axis=0)) @ normal
    assert (turns > 0).all() or (turns < 0).all()


def test_a_plane_that_misses_the_box_is_shown_all_the_same() -> None:
    outline = plane_outline(tilted(CentrePlane((0, 400, 0), (0, 1, 0.2))))
    assert len(outline) == 4
    assert np.linalg.norm(outline[1] - outline[0]) == pytest.approx(STATE.diagonal)
