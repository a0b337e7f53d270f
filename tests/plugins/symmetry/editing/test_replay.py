"""Edits in order; those that fit no more are left out and told."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bozzetto.geometry.spline import Spline
from bozzetto.ink import Stroke, Strokes
from bozzetto_symmetry.editing import edit_sequence
from bozzetto_symmetry.editing.edit_sequence import apply_edit
from bozzetto_symmetry.fitting.space_curve import SpaceCurve
from bozzetto_symmetry.model.state import Curve, Joint, Modification, Snap, SymmetryState, Trim
from bozzetto_symmetry.model.symmetry_plane import CentrePlane
from bozzetto_symmetry.stereo.mirror_camera import MIRROR
from tests.plugins.symmetry.edited_curves import ALL, FLAT, LOOP, PAIR, RAIL, check, same
from tests.plugins.symmetry.scenes import camera

STATE = SymmetryState()
VIEW = camera(35, 20, pixels=700.0)
DOT = Strokes((Stroke([0.0], [0.0], VIEW),))
OTHER = Curve(id="other", strokes=DOT)


class Made(NamedTuple):
    curve: SpaceCurve
    warnings: tuple[str, ...]


def applied(*arguments) -> Made:
    return Made(*edit_sequence.apply_edits(*arguments))


def nobody(curve: Curve, state: SymmetryState) -> SpaceCurve | None:
    return None


def rail(curve: Curve, state: SymmetryState) -> SpaceCurve | None:
    return RAIL


def over(spline, begin, end, height) -> Modification:
    at = np.linspace(*spline.range, 101)[round(100 * begin) : round(100 * end)]
    ink = VIEW.project(spline.value(at))[0] + np.array([0.0, height])
    return Modification(Strokes((Stroke(ink[:, 0], ink[:, 1], VIEW),)))


def test_edits_are_done_in_order():
    edits = (Trim(0.2, 1.0), Snap(0, (-60.0, 30.0, 10.0)), over(PAIR.spline, 0.6, 0.9, 8.0))
    made = applied(PAIR, edits, STATE, nobody)
    one = PAIR
    for edit in edits:
        one = apply_edit(one, edit, STATE, nobody)
    assert made.warnings == ()
    assert (made.curve.spline.control_points == one.spline.control_points).all()
    end = made.curve.spline.value([0.2])[0]
    np.testing.assert_allclose(end, (-60.0, 30.0, 10.0), atol=1e-12)


def test_what_was_done_is_remembered():
    edit = over(PAIR.spline, 0.2, 0.5, 9.0)
    assert apply_edit(PAIR, edit, STATE, nobody) is apply_edit(PAIR, edit, STATE, nobody)
    other = apply_edit(PAIR, edit, replace(STATE, restitution=1.5), nobody)
    assert same(other.spline, apply_edit(PAIR, edit, STATE, nobody).spline) > 0.01


@pytest.mark.parametrize(
    ("curve", "edit", "why"),
    [
        (PAIR, Trim(0.6, 0.6), "Nothing would be left"),
        (LOOP, Snap(0, (0.0, 0.0, 0.0)), "closed curve has no end"),
        (PAIR, Joint(1, OTHER, 0), "only one side"),
        (FLAT, Joint(1, None, 1, mirrored=True), "its own mirror image"),
    ],
)
def test_what_fits_no_more_is_left_out_and_told(curve, edit, why):
    made = applied(curve, (edit, edit), STATE, nobody)
    assert made.curve is curve
    (warning,) = made.warnings
    assert why in warning
    assert warning.startswith("A change of the curve was left out.")


def test_a_joint_without_ink_joins_the_curve_to_itself():
    across = applied(PAIR, (Joint(0, None, 0, mirrored=True),), STATE, nobody)
    assert across.curve.reading == "self"
    closed = applied(PAIR, (Joint(0, None, 1),), STATE, nobody)
    assert closed.curve.closed
    ring = applied(across.curve, (Joint(1, None, 1, mirrored=True),), STATE, nobody)
    assert ring.curve.closed
    check(ring.curve)


def test_a_joint_takes_what_the_other_recipe_gives():
    made = applied(PAIR, (Joint(1, OTHER, 0),), STATE, rail)
    assert made.curve.spline.length > PAIR.spline.length + 0.5 * RAIL.spline.length


def test_places_are_in_the_frame_of_the_model():
    state = replace(STATE, symmetry="free", free_plane=CentrePlane((10, 20, 30), (1, 2, 2)))
    goal = (-33.0, 44.0, 5.0)
    made = applied(PAIR, (Snap(1, goal),), state, nobody)
    end = state.plane.placement.points(made.curve.spline.value([1.0]))[0]
    np.testing.assert_allclose(end, goal, atol=1e-10)


share = st.floats(-0.2, 1.4)
edits = st.one_of(
    st.builds(Trim, share, share),
    st.builds(Snap, st.integers(0, 1), st.tuples(*[st.floats(-120, 120)] * 3)),
    st.builds(
        Joint, st.integers(0, 1), st.sampled_from([None, OTHER]), st.integers(0, 1),
        st.booleans(),
    ),
    st.builds(
        over, st.sampled_from([PAIR.spline, FLAT.spline]), st.floats(0, 0.4),
        st.floats(0.5, 1.0), st.floats(-60, 60),
    ),
)  # fmt: skip


@settings(max_examples=60, deadline=None)
@given(name=st.sampled_from(list(ALL)), row=st.lists(edits, min_size=1, max_size=5))
def test_any_edits_leave_a_curve_of_a_symmetric_thing(name, row):
    made = applied(ALL[name], row, STATE, rail)
    check(made.curve)
    assert len(made.curve.spline.control_points) < 2000


@pytest.mark.parametrize(
    "row",
    [
        (Joint(0, None, 0, mirrored=True),),
        (Joint(0, None, 0, mirrored=True), Joint(1, None, 1, mirrored=True)),
        (Joint(0, None, 0, mirrored=True), Trim(0.0, 0.7), over(PAIR.spline, 0.2, 0.4, 9.0)),
    ],
)
def test_edited_curves_are_handed_over_with_two_exactly_equal_halves(row):
    made = applied(PAIR, row, STATE, nobody).curve
    (handed,) = made.to_curves()
    points = np.asarray(handed.control_points)
    assert (points[::-1] * MIRROR == points).all()
    again = Spline(handed.knots, points)
    share = np.linspace(0.0, 1.0, 300)
    one, other = (
        spline.value(spline.range[0] + share * np.ptp(spline.range))
        for spline in (again, made.spline)
    )
    np.testing.assert_allclose(one, other, atol=1e-9)
