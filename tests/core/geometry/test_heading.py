"""Turning a placement about the vertical: what is told comes back, and nothing else changes."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from bozzetto.errors import UserError
from bozzetto.geometry.placement import Placement

ANGLES = st.floats(-360.0, 360.0)


def placement(turns, scale, offset, mirrored=False):
    rows = Rotation.from_rotvec(turns).as_matrix()
    if mirrored:
        rows = rows @ np.diag([1.0, -1.0, 1.0])
    return Placement(tuple(rows.ravel()), scale, offset)


PLACES = st.builds(
    placement,
    st.tuples(*[st.floats(-3.0, 3.0)] * 3),
    st.floats(0.01, 100.0),
    st.tuples(*[st.floats(-1e5, 1e5)] * 3),
    st.booleans(),
)


def apart(one, other):
    return abs((one - other + 180.0) % 360.0 - 180.0)


@given(PLACES, ANGLES)
def test_the_heading_that_is_asked_for_is_told(place, angle):
    assert apart(place.headed(angle).heading, angle) < 1e-6


@given(PLACES, ANGLES)
def test_only_a_turn_about_the_vertical_is_made(place, angle):
    turned = place.headed(angle)
    assert (turned.scale, turned.offset, turned.mirrors) == (
        place.scale, place.offset, place.mirrors,
    )  # fmt: skip
    by = Rotation.from_euler("z", angle - place.heading, degrees=True).as_matrix()
    points = np.array([[1.0, 2.0, 3.0], [-4.0, 0.5, 7.0]])
    mine = turned.directions(points)
    assert np.allclose(mine, place.directions(points) @ by.T, atol=1e-6)
    assert np.allclose(mine[:, 2], place.directions(points)[:, 2], atol=1e-6), "heights stay"


@given(PLACES)
def test_its_own_heading_changes_nothing(place):
    assert place.headed(place.heading) is place


def test_quarter_turns_are_exact_and_four_of_them_are_none():
    place = Placement(offset=(10.0, 20.0, 30.0))
    quarter = place.headed(90.0)
    assert quarter.rotation == (0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0)
    assert place.headed(90.0).headed(180.0).headed(-90.0).headed(0.0) == place


def test_thousands_of_small_turns_stay_a_rotation():
    place = placement((0.3, -0.2, 0.9), 2.0, (0.0, 0.0, 0.0))
    for number in range(5000):
        place = place.headed(0.37 * number)
    rows = np.reshape(place.rotation, (3, 3))
    assert np.abs(rows @ rows.T - np.eye(3)).max() < 1e-12


def test_no_number_is_no_heading():
    with pytest.raises(UserError, match="finite"):
        Placement().headed(float("nan"))
