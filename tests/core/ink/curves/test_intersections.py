"""Crossings against shapely (GEOS), against counts known in closed form, and on nasty ink."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from bozzetto.ink.curves.intersections import crossings, self_crossings

grid_polylines = arrays(
    float, st.tuples(st.integers(2, 25), st.just(2)), elements=st.integers(0, 6).map(float)
)


def at(points, parameter, closed=False):
    """The place on a polyline at index plus share."""
    ring = np.vstack((points, points[:1])) if closed else np.asarray(points)
    index = min(int(parameter), len(ring) - 2)
    return ring[index] + (parameter - index) * (ring[index + 1] - ring[index])


def test_a_figure_of_eight():
    found = self_crossings([[0, 0], [2, 2], [2, 0], [0, 2]])
    np.testing.assert_allclose(found.places, [[1, 1]])
    np.testing.assert_allclose((found.first[0], found.second[0]), (0.5, 2.5))


@pytest.mark.parametrize(("a", "b"), [(2, 3), (5, 7), (11, 13)])
def test_lissajous_curves_have_the_known_number(a, b):
    # A closed Lissajous curve with coprime a, b and a generic phase: 2ab - a - b crossings.
    angle = np.linspace(0, 2 * np.pi, 5000, endpoint=False)
    points = np.column_stack((np.sin(a * angle + 0.3), np.sin(b * angle)))
    assert len(self_crossings(points, closed=True)) == 2 * a * b - a - b


def test_through_a_vertex_once():
    points = [[0, 0], [1, 1], [2, 0], [2, 2], [1, 1], [0, 2]]
    found = self_crossings(points)
    np.testing.assert_allclose(found.places, [[1, 1]])
    np.testing.assert_allclose((found.first[0], found.second[0]), (1, 4))


def test_a_shared_stretch_once():
    points = [[0, 0], [4, 0], [4, 1], [3, 1], [3, 0], [2, 0], [1, 0], [1, -1]]
    found = self_crossings(points)
    assert len(found) == 1
    np.testing.assert_allclose(found.places, [[1, 0]])


def test_a_curve_that_folds_back_on_itself_is_told():
    assert len(self_crossings([[0, 0], [4, 0], [1, 0], [1, 3]])) == 1


def test_the_closing_point_is_no_crossing_but_a_bow_tie_is():
    square = [[0, 0], [1, 0], [1, 1], [0, 1]]
    assert len(self_crossings(square, closed=True)) == 0
    assert len(self_crossings([*square, square[0]], closed=True)) == 0
    assert len(self_crossings([*square, square[0]])) == 1  # open: the ends touch
    assert len(self_crossings([[0, 0], [1, 1], [1, 0], [0, 1]], closed=True)) == 1


def test_parameters_count_in_the_points_given_even_with_repeats():
    clean = np.array([[0.0, 0], [2, 2], [2, 0], [0, 2]])
    repeated = np.repeat(clean, [3, 1, 4, 2], axis=0)
    found = self_crossings(repeated)
    assert len(found) == 1
    for parameter in (found.first[0], found.second[0]):
        np.testing.assert_allclose(at(repeated, parameter), [1, 1])


@pytest.mark.parametrize("points", [np.zeros((0, 2)), [[1, 1]], [[1, 1]] * 5])
@pytest.mark.parametrize("closed", [False, True])
def test_nothing_to_cross(points, closed):
    assert len(self_crossings(points, closed=closed)) == 0
    assert len(self_crossings([[0, 0], [1, 1]])) == 0


@given(grid_polylines, st.booleans())
@settings(max_examples=300, deadline=None)
def test_simple_means_what_shapely_says_and_the_places_are_true(points, closed):
    found = self_crossings(points, closed=closed)
    for place, first, second in zip(found.places, found.first, found.second, strict=True):
        np.testing.assert_allclose(at(points, first, closed), place, atol=1e-6)
        np.testing.assert_allclose(at(points, second, closed), place, atol=1e-6)
        assert first <= second
    distinct = points[np.append(True, (np.diff(points, axis=0) != 0).any(axis=1))]
    if closed or len(distinct) < 2:
        return
    line = shapely.LineString(distinct)
    # GEOS lets a line that only closes count as simple; touching ends are a crossing here.
    if not (distinct[0] == distinct[-1]).all():
        assert (len(found) == 0) == line.is_simple


@given(grid_polylines, st.integers(-3, 3))
@settings(max_examples=100, deadline=None)
def test_scale_and_place_do_not_matter(points, power):
    moved = points * 10.0**power + 1000 * 10.0**power
    assert len(self_crossings(moved)) == len(self_crossings(points))


def test_random_lines_match_shapely_one_by_one():
    rng = np.random.default_rng(11)
    one, other = rng.random((60, 2)), rng.random((50, 2))
    found = crossings(one, other)
    expected = shapely.get_coordinates(
        shapely.intersection(shapely.LineString(one), shapely.LineString(other))
    )
    assert len(found) == len(expected) > 50
    distance = np.linalg.norm(found.places[:, None] - expected, axis=2)
    assert distance.min(1).max() < 1e-9
    assert distance.min(0).max() < 1e-9


def test_two_closed_curves_that_meet_at_their_seam():
    square = np.array([[0.0, 0], [2, 0], [2, 2], [0, 2]])
    other = np.array([[0.0, 0], [-1, 0.5], [-1, -1]])
    found = crossings(square, other, one_closed=True, other_closed=True)
    np.testing.assert_allclose(found.places, [[0, 0]], atol=1e-12)


def test_a_scribble_to_and_fro_on_one_line_ends_and_is_bounded():
    points = np.column_stack((np.arange(3000) % 2, np.zeros(3000)))
    assert 0 < len(self_crossings(points)) < 10_000


def test_a_step_that_is_lost_beside_a_long_one_has_a_number_all_the_same():
    far = [(0, 0), (1e20, 0), (1e20, 1), (1e20, 3), (5, 5), (5, -5)]
    found = self_crossings(far)
    assert len(found.first)
    assert np.isfinite([found.first, found.second]).all()
