"""Where underlays lie: laws of similarities in the plane of a picture."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from bozzetto.document.model import Underlay
from bozzetto.document.underlay_place import (
    LARGEST,
    UnderlayPlace,
    aligned,
    place_of,
    placed,
    places_under,
)
from bozzetto.errors import UserError
from bozzetto.view.camera import Camera

PIXELS = np.full((2, 3, 4), 255, np.uint8)

UPRIGHT = Underlay("u", "photo", PIXELS, (-60.0, 0.0, 80.0), (120.0, 0.0, 0.0), (0.0, 0.0, -80.0))
FLAT = replace(UPRIGHT, corner=(0.0, 0.0, 5.0), across=(30.0, 0.0, 0.0), down=(0.0, -20.0, 0.0))
SIDE = replace(UPRIGHT, corner=(7.0, 30.0, 40.0), across=(0.0, -60.0, 0.0), down=(0.0, 0.0, -40.0))
SLANTED = replace(UPRIGHT, corner=(1.0, 2.0, 3.0), across=(9.0, 3.0, 2.0), down=(-1.0, 5.0, -3.0))

LAID = (UPRIGHT, FLAT, SIDE, SLANTED)

mm = st.floats(-500.0, 500.0).filter(lambda v: abs(v) > 1e-3)
widths = st.floats(0.5, 900.0)
angles = st.floats(-179.9, 180.0)


def seen_at(underlay, u, v):
    """The place in the world of a share of the way across and down."""
    return np.array(underlay.corner) + u * np.array(underlay.across) + v * np.array(underlay.down)


def test_a_dropped_picture_lies_level_in_its_middle():
    assert place_of(UPRIGHT) == UnderlayPlace((0.0, 0.0, 40.0), 120.0, 0.0)
    assert place_of(FLAT) == UnderlayPlace((15.0, -10.0, 5.0), 30.0, 0.0)
    assert place_of(SIDE) == UnderlayPlace((7.0, 0.0, 20.0), 60.0, 0.0)


@pytest.mark.parametrize("underlay", LAID)
@given(middle=st.tuples(mm, mm, mm), width=widths, turn=angles)
def test_what_is_put_is_found_there_and_keeps_its_shape(underlay, middle, width, turn):
    told = UnderlayPlace(middle, width, turn)
    made = placed(underlay, told)
    found = place_of(made)
    np.testing.assert_allclose(found.middle, middle, atol=1e-9)
    assert found.width == pytest.approx(width)
    assert abs((found.turn - turn + 180.0) % 360.0 - 180.0) < 1e-8
    across, down = np.array(made.across), np.array(made.down)
    was = np.linalg.norm(underlay.down) / np.linalg.norm(underlay.across)
    assert np.linalg.norm(down) / np.linalg.norm(across) == pytest.approx(was)
    assert abs(across @ down) <= 1e-9 * width**2
    before, after = np.cross(underlay.across, underlay.down), np.cross(across, down)
    np.testing.assert_allclose(
        before / np.linalg.norm(before), after / np.linalg.norm(after), atol=1e-9
    )


def test_a_turn_is_counterclockwise_as_one_looks_at_the_front():
    """From the front, x goes to the right and z up: the right end of the upper side rises."""
    made = placed(UPRIGHT, replace(place_of(UPRIGHT), turn=90.0))
    np.testing.assert_allclose(made.across, (0.0, 0.0, 120.0), atol=1e-12)
    np.testing.assert_allclose(made.down, (80.0, 0.0, 0.0), atol=1e-12)


@pytest.mark.parametrize("underlay", LAID)
@given(
    st.lists(st.floats(0.0, 1.0), min_size=4, max_size=4),
    st.lists(st.floats(-2.0, 3.0), min_size=4, max_size=4),
)
def test_two_places_come_to_lie_at_their_goals(underlay, shares, goals):
    underlay = placed(underlay, place_of(underlay))  # at right angles
    (a, b), (c, d) = np.reshape(shares, (2, 2)), np.reshape(goals, (2, 2))
    assume(min(np.hypot(*(a - b)), np.hypot(*(c - d))) >= 0.05)
    goal = [seen_at(underlay, *c), seen_at(underlay, *d)]
    made = aligned(underlay, [seen_at(underlay, *a), seen_at(underlay, *b)], goal)
    found = np.array([seen_at(made, *a), seen_at(made, *b)])
    np.testing.assert_allclose(found, goal, atol=1e-8 * np.linalg.norm(made.across))
    ratio = np.linalg.norm(made.down) / np.linalg.norm(made.across)
    assert ratio == pytest.approx(np.linalg.norm(underlay.down) / np.linalg.norm(underlay.across))


def test_aligned_with_itself_it_stays_and_back_it_comes_back():
    places = [seen_at(UPRIGHT, 0.2, 0.3), seen_at(UPRIGHT, 0.9, 0.6)]
    goals = [seen_at(UPRIGHT, 0.5, 0.1), seen_at(UPRIGHT, 0.1, 0.8)]
    for there, back in ((places, places), (goals, places)):
        made = aligned(aligned(UPRIGHT, places, there), there, back)
        for name in ("corner", "across", "down"):
            np.testing.assert_allclose(getattr(made, name), getattr(UPRIGHT, name), atol=1e-9)


def test_what_cannot_be_is_refused_in_words():
    here = place_of(UPRIGHT)
    with pytest.raises(UserError, match="wide"):
        placed(UPRIGHT, replace(here, width=0.0))
    with pytest.raises(UserError, match="far away"):
        placed(UPRIGHT, replace(here, middle=(0.0, 2.0 * LARGEST, 0.0)))
    with pytest.raises(UserError, match="far away"):
        placed(UPRIGHT, replace(here, turn=float("nan")))
    one, other = seen_at(UPRIGHT, 0.0, 0.0), seen_at(UPRIGHT, 1.0, 0.0)
    for places, goals in (([one, one], [one, other]), ([one, other], [other, other])):
        with pytest.raises(UserError, match="are one"):
            aligned(UPRIGHT, places, goals)
    line = replace(UPRIGHT, down=(1.0, 0.0, 0.0))
    with pytest.raises(UserError, match="no area"):
        place_of(line)


@pytest.mark.parametrize("kind", ["perspective", "orthographic"])
def test_a_pixel_is_over_the_place_that_is_seen_there(kind):
    camera = replace(Camera(), kind=kind, eye=(90.0, -400.0, 120.0), target=(0.0, 0.0, 40.0))
    pixels = np.array([(300.0, 250.0), (500.0, 420.0)])
    found = places_under(UPRIGHT, camera.rays(pixels))
    assert found is not None
    np.testing.assert_allclose(found[:, 1], 0.0, atol=1e-9)
    np.testing.assert_allclose(camera.project(found)[0], pixels, atol=1e-6)
    edge_on = replace(camera, eye=(400.0, 0.0, 40.0))
    assert (
        places_under(UPRIGHT, edge_on.rays(pixels * 0.0 + 0.5 * np.array(camera.viewport))) is None
    )
