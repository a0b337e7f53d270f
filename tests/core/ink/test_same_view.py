"""Strokes of one view on several canvases, of several sizes and of parts of the sheet."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.arrays import Array
from bozzetto.ink import Stroke, carried_places, is_one_view, on_canvas, on_sheet_of
from bozzetto.view import Camera
from bozzetto.view.navigation import orbit, pan, with_kind, zoom

SEEDS = range(12)


def _camera(chance: np.random.Generator, kind: str = "orthographic") -> Camera:
    eye, target = chance.uniform(-400.0, 400.0, (2, 3))
    wide, high = chance.uniform(300.0, 2000.0, 2)
    camera = Camera(
        eye=tuple(eye),
        target=tuple(target),
        height=chance.uniform(1.0, 900.0),
        viewport=(wide, high),
    )
    return replace(camera, kind=kind)


def _moved_over_the_sheet(camera: Camera, chance: np.random.Generator) -> Camera:
    """A person moves the view, enlarges it about some place, and moves it again."""
    for _ in range(3):
        camera = pan(camera, *chance.uniform(-800.0, 800.0, 2))
        camera = zoom(
            camera, float(np.exp(chance.uniform(-2.0, 2.0))), tuple(chance.uniform(0, 900, 2))
        )
    return camera.with_viewport(*chance.uniform(300.0, 2000.0, 2))


def _stroke(chance: np.random.Generator, camera: Camera) -> Stroke:
    x, y = chance.uniform(0.0, 900.0, (2, 20))
    return Stroke(x, y, camera, pressure=chance.uniform(0.1, 1.0, 20), t=np.arange(20.0))


def _in_space(places: Array, camera: Camera, sheet: Camera) -> Array:
    return camera.on_plane(places, sheet.target, sheet.axes[2])


@pytest.mark.parametrize("seed", SEEDS)
def test_a_parallel_view_that_is_moved_and_enlarged_is_the_same_view(seed: int) -> None:
    chance = np.random.default_rng(seed)
    before = _camera(chance)
    now = _moved_over_the_sheet(before, chance)
    assert is_one_view(before, now)
    assert is_one_view(now, before)
    points = chance.uniform(-300.0, 300.0, (30, 3))
    seen, _ = now.project(points)
    carried = carried_places(before.project(points)[0], before, now)
    assert np.abs(carried - seen).max() < 1e-8 * (1.0 + np.abs(seen).max())


@pytest.mark.parametrize("kind", ["orthographic", "perspective"])
@pytest.mark.parametrize("seed", SEEDS)
def test_a_view_that_is_turned_is_another_one(seed: int, kind: str) -> None:
    chance = np.random.default_rng(seed)
    before = _camera(chance, kind)
    assert not is_one_view(before, orbit(before, *chance.uniform(5.0, 90.0, 2)))
    assert not is_one_view(
        before, with_kind(before, "perspective" if kind == "orthographic" else "orthographic")
    )


@pytest.mark.parametrize("seed", SEEDS)
def test_an_eye_that_moves_in_perspective_sees_another_view(seed: int) -> None:
    chance = np.random.default_rng(seed)
    before = _camera(chance, "perspective")
    assert not is_one_view(before, pan(before, 40.0, 0.0))
    assert not is_one_view(before, zoom(before, 1.3, (200.0, 300.0)))


@pytest.mark.parametrize("seed", SEEDS)
def test_a_stroke_that_is_carried_there_and_back_is_the_same(seed: int) -> None:
    chance = np.random.default_rng(seed)
    before = _camera(chance)
    now = _moved_over_the_sheet(before, chance)
    stroke = _stroke(chance, before)
    there = on_canvas(stroke, now)
    back = on_canvas(there, before)
    assert there.camera == now
    assert back.camera == before
    single = float(np.finfo(np.float32).eps)  # in which strokes keep their places
    enlarged = (before.viewport[1] / before.height) / (now.viewport[1] / now.height)
    reach = 4.0 * single * (900.0 + enlarged * np.abs(there.points).max())
    assert np.abs(back.points - stroke.points).max() < reach
    assert np.array_equal(there.pressure, stroke.pressure)
    assert np.array_equal(there.t, stroke.t)


@pytest.mark.parametrize(
    "kinds",
    [(a, b) for a in ("orthographic", "perspective") for b in ("orthographic", "perspective")],
)
@pytest.mark.parametrize("seed", SEEDS)
def test_a_line_on_the_sheet_stays_where_it_lies(seed: int, kinds: tuple[str, str]) -> None:
    chance = np.random.default_rng(seed)
    before = _camera(chance, kinds[0])
    now = with_kind(_moved_over_the_sheet(before, chance), kinds[1])
    stroke = _stroke(chance, now)
    carried = on_sheet_of(stroke, before)
    here = _in_space(stroke.points, now, before)
    there = _in_space(carried.points, before, before)
    assert np.abs(here - there).max() < 1e-7 * (1.0 + np.abs(here).max())
