"""The tools that change curves, from ink to states."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.ink import Stroke, Strokes
from bozzetto.ink.curves.nearest import distances_to_polyline
from bozzetto.plugin import Context, Drag, Ink, Tap
from bozzetto_symmetry.model.state import Curve, Line, Modification, Snap, SymmetryState, Trim
from bozzetto_symmetry.operations.curve_ends import ends_of, with_joint, with_nearest_joined
from bozzetto_symmetry.operations.snap_candidates import with_ends_caught
from bozzetto_symmetry.operations.trim_or_extend import with_ends_met
from bozzetto_symmetry.solve.curve_solver import solve_curve
from bozzetto_symmetry.solve.picking import seen_curves, solved_curves, target_of
from bozzetto_symmetry.stereo.mirror_camera import MIRROR, Stereo
from bozzetto_symmetry.tools import all_tools
from bozzetto_symmetry.tools.erase import erase
from bozzetto_symmetry.tools.join import JoinCurves
from bozzetto_symmetry.tools.modify import Modify
from bozzetto_symmetry.tools.split import Split
from tests.plugins.symmetry.scenes import ACROSS, PAIRS, camera, drawn
from tests.previews import preview_of

VIEW = camera(35, 20, pixels=700.0)
OTHER_VIEW = camera(110, 35, pixels=700.0)
CONTEXT = Context(camera=VIEW)
TOOLS = [Modify(), Split(), JoinCurves()]


def stroke(places, view=VIEW, **facts) -> Stroke:
    places = np.asarray(places, float)
    return Stroke(places[:, 0], places[:, 1], view, **facts)


def ink(places, view=VIEW, **facts) -> Ink:
    return Ink((stroke(places, view, **facts),))


def pair(curve_id, points) -> Curve:
    sides = (stroke(drawn(side, VIEW)) for side in (points, points * MIRROR))
    return Curve(id=curve_id, name=curve_id, strokes=Strokes(sides))


@cache
def drawing() -> SymmetryState:
    rail = pair("rail", PAIRS["roof rail"])
    bumper = Curve(
        "bumper", "bumper", strokes=Strokes([stroke(drawn(ACROSS["wavy bumper"], VIEW))])
    )
    return SymmetryState(nodes=(rail, bumper))


def curve_of(state, curve_id):
    return solve_curve(next(node for node in state.curves if node.id == curve_id), state)


def image(state, curve_id, begin=0.0, end=1.0, *, view=VIEW, mirrored=False, count=200):
    spline = curve_of(state, curve_id).spline
    low, high = spline.range
    points = spline.value(np.linspace(low + begin * (high - low), low + end * (high - low), count))
    stereo = Stereo.of(view, state.plane)
    return stereo.project(points * MIRROR if mirrored else points)


def hump(places, height):
    return places + np.sin(np.linspace(0, np.pi, len(places)))[:, None] ** 2 * [0.0, height]


# -- modify --------------------------------------------------------------------------------------


@pytest.mark.parametrize("view", [VIEW, OTHER_VIEW])
@pytest.mark.parametrize("mirrored", [False, True])
def test_the_curve_goes_where_it_is_drawn_over(view, mirrored):
    state = drawing()
    goal = hump(image(state, "rail", 0.3, 0.6, view=view, mirrored=mirrored), 12.0)
    made = Modify().apply(state, ink(goal, view), CONTEXT)
    assert made.selected == "rail"
    (edit,) = made.node("rail").edits
    assert edit.mirrored == mirrored
    path = image(made, "rail", view=view, mirrored=mirrored, count=2000)
    assert np.median(distances_to_polyline(goal, path)) < 1.0
    assert made.node("bumper") is state.node("bumper")


def test_strokes_close_to_one_another_act_together_and_others_anew():
    state = drawing()
    path = image(state, "rail", 0.3, 0.6)
    once = Modify().apply(state, ink(hump(path, 12.0)), CONTEXT)
    twice = Modify().apply(once, ink(hump(path, 18.0)), CONTEXT)
    (edit,) = twice.node("rail").edits
    assert len(edit.strokes) == 2
    thrice = Modify().apply(twice, ink(hump(path, -30.0)), CONTEXT)
    assert [len(edit.strokes) for edit in thrice.node("rail").edits] == [2, 1]
    goal = hump(path, -30.0)
    off = distances_to_polyline(goal, image(thrice, "rail", count=2000))
    assert np.median(off) < 2.0  # of 48 px on a short stretch, which resists


def test_the_chosen_curve_is_preferred_among_those_about_as_near():
    rail = pair("one", PAIRS["roof rail"])
    near = pair("two", PAIRS["roof rail"] + np.array([0.0, 0.0, 3.0]))
    state = SymmetryState(nodes=(rail, near), selected="one")
    seen = seen_curves(state, VIEW)
    between = 0.4 * image(state, "one") + 0.6 * image(state, "two")
    for chosen, meant in (("one", "one"), ("two", "two"), ("", "two")):
        assert target_of(seen, between, chosen).node.id == meant
    assert target_of(seen, image(state, "two"), "one").node.id == "two"
    assert target_of(seen, image(state, "two") + 500.0, "one") is None


def test_ink_far_from_all_curves_is_refused():
    with pytest.raises(UserError, match="no curve near the stroke"):
        Modify().apply(drawing(), ink([[5, 5], [60, 20]]), CONTEXT)
    with pytest.raises(UserError, match="no curve near the stroke"):
        Modify().apply(SymmetryState(), ink([[5, 5], [60, 20]]), CONTEXT)


# -- split ---------------------------------------------------------------------------------------


def test_a_stroke_across_cuts_what_it_crosses():
    state = drawing()
    place = image(state, "rail", 0.4, 0.4, count=1)[0]
    made = Split().apply(state, ink(place + np.array([[0, -9], [0, 9]])), CONTEXT)
    assert [node.name for node in made.nodes] == ["rail", "rail b", "bumper"]
    lengths = [solve_curve(node, made).spline.length for node in made.curves[:2]]
    assert sum(lengths) == pytest.approx(curve_of(state, "rail").spline.length, rel=1e-9)
    end = image(made, "rail", 1.0, 1.0, count=1)[0]
    assert np.linalg.norm(end - place) < 2.0


@pytest.mark.parametrize("share", [0.1, 0.85])
def test_a_touch_on_either_half_leaves_the_middle_and_a_pair(share):
    state = drawing()
    place = image(state, "bumper", share, share, count=1)[0]
    made = Split().apply(state, Tap(*place, VIEW), CONTEXT)
    readings = [solve_curve(node, made).reading for node in made.curves]
    assert readings == ["pair", "self", "pair"]
    dot = place + np.array([[-0.5, -0.5], [0.5, 0.5]])
    by_ink = Split().apply(state, ink(dot), CONTEXT)
    cuts = [next(node for node in s.curves if node.id == "bumper").edits[0] for s in (made, by_ink)]
    assert cuts[0].end == pytest.approx(cuts[1].end, abs=1e-4)


def test_there_is_nothing_to_cut_at_the_plane_nor_at_an_end():
    state = drawing()
    with pytest.raises(UserError, match="crosses the centre plane here"):
        Split().apply(state, Tap(*image(state, "bumper", 0.5, 0.5, count=1)[0], VIEW), CONTEXT)
    with pytest.raises(UserError, match="ends here"):
        Split().apply(state, Tap(*image(state, "rail", 0.0, 0.0, count=1)[0], VIEW), CONTEXT)
    with pytest.raises(UserError, match="no curve here"):
        Split().apply(state, Tap(5.0, 5.0, VIEW), CONTEXT)


# -- join ----------------------------------------------------------------------------------------


def test_what_was_split_is_joined_again():
    state = drawing()
    place = image(state, "rail", 0.4, 0.4, count=1)[0]
    cut = Split().apply(state, Tap(*place, VIEW), CONTEXT)
    made = JoinCurves().apply(cut, ink(place + np.array([[-4, 0], [4, 0]])), CONTEXT)
    assert [node.name for node in made.nodes] == ["rail", "bumper"]
    length = curve_of(state, "rail").spline.length
    assert curve_of(made, "rail").spline.length == pytest.approx(length, rel=1e-9)
    chosen = with_nearest_joined(cut.with_node(cut.node("rail")), CONTEXT)
    assert curve_of(chosen, "rail").spline.length == pytest.approx(length, rel=1e-9)


def test_an_end_and_its_image_make_a_curve_across_the_plane():
    state = drawing()
    ends = [image(state, "rail", 0.0, 0.0, mirrored=m, count=1)[0] for m in (False, True)]
    made = JoinCurves().apply(state, ink(ends), CONTEXT)
    assert curve_of(made, "rail").reading == "self"
    ends = [image(made, "rail", s, s, count=1)[0] for s in (0.0, 1.0)]
    ring = JoinCurves().apply(made, ink(ends), CONTEXT)
    assert curve_of(ring, "rail").closed


def test_both_ends_of_a_curve_close_it():
    state = drawing()
    ends = [image(state, "rail", s, s, count=1)[0] for s in (0.0, 1.0)]
    made = JoinCurves().apply(state, ink(ends), CONTEXT)
    assert curve_of(made, "rail").closed
    with pytest.raises(UserError, match="no end of a curve where the stroke begins"):
        JoinCurves().apply(made, ink(ends), CONTEXT)


def test_ends_that_cannot_meet_are_refused_and_the_state_stays():
    state = drawing()
    ends = {(end.number, end.mirrored): end for end in ends_of(solved_curves(state)[:1])}
    with pytest.raises(UserError, match="cannot meet"):
        with_joint(state, ends[0, False], ends[1, True])
    begin = image(state, "rail", 0.0, 0.0, count=1)[0]
    with pytest.raises(UserError, match="no end of a curve where the stroke ends"):
        JoinCurves().apply(state, ink([begin, begin + 90.0]), CONTEXT)
    with pytest.raises(UserError, match="Choose the curve"):
        with_nearest_joined(state, CONTEXT)


# -- ends that meet ------------------------------------------------------------------------------


def gap(state) -> float:
    ends = [end for end in ends_of(solved_curves(state)) if not end.mirrored]
    return min(
        float(np.linalg.norm(one.point - other.point))
        for one in ends
        for other in ends
        if one.node.id != other.node.id
    )


@pytest.mark.parametrize(
    ("second", "kinds"),
    [
        (lambda rail: rail[158:], [Snap]),
        (lambda rail: rail[152:] + np.array([0.0, 2.0, 2.0]), [Snap]),
        (lambda rail: rail[140:], [Trim, Snap]),
    ],
)
def test_ends_are_led_on_where_they_fall_short_and_cut_where_they_pass(second, kinds):
    rail = PAIRS["roof rail"]
    state = SymmetryState(nodes=(pair("a", rail[:150]), pair("b", second(rail))))
    made = with_ends_met(state, CONTEXT)
    for node in made.curves:
        assert [type(edit) for edit in node.edits] == kinds
    assert gap(made) < 1e-9
    before, after = (
        sum(solve_curve(node, s).spline.length for node in s.curves) for s in (state, made)
    )
    assert after == pytest.approx(before, abs=8.0)
    with pytest.raises(UserError, match="No ends nearly meet"):
        with_ends_met(made, CONTEXT)


@pytest.mark.parametrize(("begin", "cut"), [(-2.0, True), (2.5, False)])
def test_an_end_that_nearly_meets_a_curve_ends_on_it(begin, cut):
    rail = PAIRS["roof rail"]
    way = np.linspace(begin, 60.0, 200)[:, None] * np.array([0.3, 0.1, 1.0])
    state = SymmetryState(nodes=(pair("a", rail), pair("b", rail[120] + way)))
    made = with_ends_met(state, CONTEXT)
    assert made.node("a").edits == ()
    kinds = [type(edit) for edit in made.node("b").edits]
    assert kinds == ([Trim, Snap] if cut else [Snap])
    end = curve_of(made, "b").spline
    place = end.value(end.range[:1])
    spline = curve_of(made, "a").spline
    assert np.linalg.norm(spline.value(spline.foot_points(place)) - place) < 1e-9
    assert np.linalg.norm(place - rail[120]) < 1.0
    with pytest.raises(UserError, match="No ends nearly meet"):
        with_ends_met(made, CONTEXT)


def test_an_end_near_the_plane_meets_its_image_there():
    half = ACROSS["wavy bumper"][299:]
    away = half + np.array([0.0, 2.0, 0.0])
    state = SymmetryState(nodes=(pair("a", away),))
    made = with_ends_met(state, CONTEXT)
    point = curve_of(made, "a").spline.value([0.0])[0]
    assert abs(point[1]) < 1e-9


def test_the_chosen_curve_snaps_to_the_end_of_another():
    rail = PAIRS["roof rail"]
    state = SymmetryState(nodes=(pair("a", rail[:150]), pair("b", rail[153:])), selected="b")
    made = with_ends_caught(state, CONTEXT)
    assert made.node("a") is state.node("a")
    (snap,) = made.node("b").edits
    assert snap.end == 0
    assert gap(made) < 1e-9
    with pytest.raises(UserError, match="free ends"):
        with_ends_caught(SymmetryState(), CONTEXT)
    alone = SymmetryState(nodes=(pair("b", 0.5 * rail),), selected="b")
    with pytest.raises(UserError, match="nothing near"):
        with_ends_caught(alone, CONTEXT)


# -- erase ---------------------------------------------------------------------------------------


def eraser(places, view=VIEW):
    return stroke(places, view, tool="eraser")


@pytest.mark.parametrize("tool", all_tools())
def test_a_part_that_is_rubbed_over_is_cut_out(tool):
    state = drawing()
    made = tool.apply(state, Ink((eraser(image(state, "rail", 0.3, 0.5)),)), CONTEXT)
    assert [node.name for node in made.nodes] == ["rail", "rail b", "bumper"]
    first, second = (node.edits[-1] for node in made.curves[:2])
    assert first.begin == 0.0
    assert 0.22 < first.end < 0.3
    assert 0.5 < second.begin < 0.58


def test_what_is_mostly_rubbed_over_goes_whole_and_what_is_only_crossed_stays():
    state = drawing()
    made = erase(state, eraser(image(state, "rail", 0.05, 0.95)))
    assert [node.name for node in made.nodes] == ["bumper"]
    across = erase(state, eraser(image(state, "bumper", 0.02, 0.98)))
    assert [node.name for node in across.nodes] == ["rail"]


def test_the_middle_of_a_curve_across_the_plane_leaves_a_pair():
    state = drawing()
    made = erase(state, eraser(image(state, "bumper", 0.4, 0.6)))
    assert curve_of(made, "bumper").reading == "pair"


def test_sides_that_wait_and_construction_lines_go():
    waiting = Curve("w", "w", strokes=Strokes([stroke(drawn(PAIRS["hook"], VIEW))]))
    line = Line("l", "l", begin=(-90.0, 0.0, -45.0), end=(90.0, 0.0, -45.0))
    state = SymmetryState(nodes=(waiting, line))
    assert [n.id for n in erase(state, eraser(drawn(PAIRS["hook"], VIEW))).nodes] == ["l"]
    ends = VIEW.project([line.begin, line.end])[0]
    path = ends[0] + np.linspace(0, 1, 50)[:, None] * (ends[1] - ends[0])
    assert [n.id for n in erase(state, eraser(path)).nodes] == ["w"]
    with pytest.raises(UserError, match="no curve under the eraser"):
        erase(state, eraser([[3.0, 3.0], [9.0, 9.0]]))


# -- all of them ---------------------------------------------------------------------------------


@pytest.mark.parametrize("tool", TOOLS)
def test_previews_never_fail_and_change_nothing(tool):
    state = drawing()
    gestures = [
        ink([[400.0, 300.0]]),
        ink(image(state, "rail", 0.3, 0.6)),
        ink(hump(image(state, "rail", 0.3, 0.6), 20)),
        ink(image(state, "rail", 0.0, 1.0)[[0, -1]]),
        ink([[0.0, 0.0], [900.0, 900.0]]),
        Ink((eraser(image(state, "rail")),)),
        Tap(500.0, 400.0, VIEW),
        Drag("x", stroke([[0.0, 0.0]])),
    ]
    for gesture in gestures:
        for current in (state, SymmetryState()):
            preview_of(tool, current, gesture, CONTEXT)
    shown = [bool(preview_of(tool, state, gesture, CONTEXT).layers) for gesture in gestures[1:5]]
    assert any(shown)
    with pytest.raises(UserError):
        tool.apply(state, gestures[-1], CONTEXT)


def test_a_modification_is_kept_as_ink():
    state = drawing()
    goal = hump(image(state, "rail", 0.3, 0.6), 12.0)
    made = Modify().apply(state, ink(goal), CONTEXT)
    assert made.node("rail").edits == (Modification(Strokes((stroke(goal),)), False),)
