"""Grids: steps that are easy to count, lines that stay in the box."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bozzetto_symmetry.model.box_grid import HEAVY_EVERY, clip_to_box, grid_in_box, grid_step

RANDOM = np.random.default_rng(8)


@given(st.floats(0.1, 1e6))
@settings(max_examples=200)
def test_steps_are_one_two_five_and_eight_to_twenty_five_fit(longest: float) -> None:
    step = grid_step(longest)
    assert 8.0 <= longest / step <= 25.0 * (1.0 + 1e-5)
    mantissa = step / 10.0 ** np.floor(np.log10(step) + 1e-9)
    assert min(abs(mantissa - digit) for digit in (1.0, 2.0, 5.0)) < 1e-6


@pytest.mark.parametrize(("longest", "step"), [(200.0, 10.0), (250.0, 10.0), (100.0, 5.0)])
def test_steps_of_usual_boxes(longest: float, step: float) -> None:
    assert grid_step(longest) == step


def test_clipping_against_places_along_the_lines() -> None:
    centre, size = np.array([5.0, -3.0, 2.0]), np.array([40.0, 20.0, 10.0])
    places = centre + RANDOM.uniform(-30, 30, (300, 3))
    ways = RANDOM.normal(size=(300, 3))
    begin, end, inside = clip_to_box(places, ways, centre, size)
    at = np.linspace(-200, 200, 40001)
    for place, way, low, high, hit in zip(places, ways, begin, end, inside, strict=True):
        within = (np.abs(place + at[:, None] * way - centre) <= 0.5 * size).all(axis=1)
        if within.any():
            assert hit
            assert low == pytest.approx(at[within].min(), abs=0.011)
            assert high == pytest.approx(at[within].max(), abs=0.011)
        elif hit:
            assert high - low < 0.02  # between two of the places


def test_lines_along_a_face_are_inside() -> None:
    begin, end, inside = clip_to_box(
        [[0, 0, 5], [0, 0, 5.1]], [1.0, 0.0, 0.0], [0, 0, 0], [40, 20, 10]
    )
    assert inside.tolist() == [True, False]
    assert (begin[0], end[0]) == (-20.0, 20.0)


def test_the_floor_of_a_box_has_the_lines_one_counts() -> None:
    grid = grid_in_box(
        (0, 0, -50), (1, 0, 0), (0, 1, 0), 10.0, centre=(0, 0, 0), size=(200, 100, 100)
    )
    lengths = np.linalg.norm(grid.ends - grid.begins, axis=1)
    # Between the edges: 9 along the length, 19 along the width; every fifth from the middle.
    assert sorted(lengths.round(9).tolist()) == [100.0] * 19 + [200.0] * 9
    assert int(grid.heavy.sum()) == 1 + 3
    assert np.all(grid.begins[:, 2] == -50.0)


@pytest.mark.parametrize("seed", range(6))
def test_a_grid_lies_in_its_plane_and_in_its_box(seed: int) -> None:
    random = np.random.default_rng(seed)
    frame, _ = np.linalg.qr(random.normal(size=(3, 3)))
    centre, size = random.uniform(-50, 50, 3), random.uniform(30, 200, 3)
    middle = centre + 0.2 * random.uniform(-1, 1, 3) * size
    step = grid_step(float(size.max()))
    grid = grid_in_box(middle, frame[0], frame[1], step, centre=centre, size=size)
    assert len(grid.heavy) > 3
    for ends in (grid.begins, grid.ends):
        assert np.abs((ends - middle) @ frame[2]).max() < 1e-9 * size.max()
        assert (np.abs(ends - centre) <= 0.5 * size + 1e-6).all()
        # Every end is on a face, and every line a whole number of steps from the middle.
        assert np.abs(np.abs(ends - centre) - 0.5 * size).min(axis=1).max() < 1e-6
    rows = np.abs((grid.begins - grid.ends) @ frame[0]) > 1e-9
    aside = np.where(rows, (grid.begins - middle) @ frame[1], (grid.begins - middle) @ frame[0])
    number = np.round(aside / step)
    assert np.abs(aside / step - number).max() < 1e-9
    assert ((number % HEAVY_EVERY == 0) == grid.heavy).all()


def test_a_plane_beside_the_box_has_no_grid() -> None:
    grid = grid_in_box((0, 0, 90), (1, 0, 0), (0, 1, 0), 10.0, centre=(0, 0, 0), size=(100,) * 3)
    assert not len(grid.heavy)


def test_a_sheet_of_a_box_has_no_lines_across() -> None:
    grid = grid_in_box((0, 0, 0), (1, 0, 0), (0, 1, 0), 10.0, centre=(0, 0, 0), size=(200, 0.1, 80))
    assert (grid.begins[:, 0] == grid.ends[:, 0]).sum() == 19
