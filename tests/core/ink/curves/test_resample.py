"""Arc length and equal steps: laws on any polyline, closed forms on known ones."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from bozzetto.ink.curves.resample import (
    arc_length,
    distinct,
    points_along,
    resample,
    steps_along,
)

polylines = arrays(
    float,
    st.tuples(st.integers(2, 40), st.just(2)),
    elements=st.integers(-50, 50).map(float),
)


def circle(count: int, radius: float = 1.0) -> np.ndarray:
    angle = np.linspace(0, 2 * np.pi, count, endpoint=False)
    return radius * np.column_stack((np.cos(angle), np.sin(angle)))


def test_arc_length_of_a_staircase():
    assert arc_length([[0, 0], [3, 4], [3, 4], [3, 5]]).tolist() == [0, 5, 5, 6]


def test_equal_neighbours_are_found_and_a_repeated_start_counts_as_one():
    points = [[0, 0], [0, 0], [1, 0], [1, 1], [1, 1], [0, 0], [0, 0]]
    assert distinct(points).tolist() == [0, 2, 3, 5]
    assert distinct(points, closed=True).tolist() == [0, 2, 3]


@given(polylines, st.integers(2, 60))
@settings(max_examples=80, deadline=None)
def test_every_point_lies_on_the_polyline_and_the_ends_stay(points, count):
    made = resample(points, count=count)
    assert made.shape == (count, 2)
    np.testing.assert_allclose(made[[0, -1]], points[[0, -1]], atol=1e-9)
    import shapely

    line = shapely.LineString(points)
    assert shapely.distance(line, shapely.points(made)).max() < 1e-9
    # Every station is count-1 equal parts of the length along the line.
    assert arc_length(made)[-1] <= arc_length(points)[-1] + 1e-9


def test_steps_on_a_straight_line_are_equal_whatever_the_samples():
    rng = np.random.default_rng(3)
    along = np.sort(rng.random(200))
    line = np.column_stack((3 * along, 4 * along))
    steps = np.diff(arc_length(resample(line, count=31)))
    np.testing.assert_allclose(steps, steps[0], rtol=1e-9)


def test_spacing_is_rounded_to_a_whole_number_of_steps():
    made = resample([[0, 0], [10, 0]], spacing=3.0)
    np.testing.assert_allclose(made[:, 0], [0, 10 / 3, 20 / 3, 10])


@pytest.mark.parametrize("repeat", [False, True])
def test_a_closed_curve_is_not_given_its_first_point_twice(repeat):
    ring = circle(400)
    if repeat:
        ring = np.vstack((ring, ring[:1]))
    made = resample(ring, count=8, closed=True)
    np.testing.assert_allclose(made, circle(8), atol=1e-9)


def test_a_dot_stays_a_dot():
    assert resample([[2, 3], [2, 3]], count=4).tolist() == [[2, 3]] * 4
    assert resample([[2, 3]], spacing=1.0).tolist() == [[2, 3]]


@pytest.mark.parametrize("wrong", [{}, {"spacing": 1.0, "count": 3}, {"spacing": 0.0}])
def test_asking_for_neither_or_both_is_a_mistake_of_the_caller(wrong):
    with pytest.raises(ValueError, match="spacing"):
        resample([[0, 0], [1, 1]], **wrong)


@given(st.integers(0, 10**6), st.integers(2, 40))
def test_steps_of_a_longer_line_begin_with_those_of_a_shorter_one(seed, count):
    random = np.random.default_rng(seed)
    line = random.normal(0.0, 30.0, (count, 2))
    step = float(random.uniform(0.5, 20.0))
    whole = steps_along(line, step, 400)
    part = steps_along(line[: count // 2 + 1], step, 400)
    np.testing.assert_array_equal(part, whole[: len(part)])
    at = arc_length(line)
    assert len(whole) == int(np.floor(at[-1] / step)) + 1
    np.testing.assert_allclose(whole, points_along(line, at, step * np.arange(len(whole))))


def test_a_leap_beyond_all_measure_has_few_steps():
    line = [[0.0, 0.0], [10.0, 0.0], [1e15, 0.0]]
    steps = steps_along(line, 1.0, 50)
    assert len(steps) == 11 + 50
    assert (np.diff(steps[:, 0]) > 0.0).all()
