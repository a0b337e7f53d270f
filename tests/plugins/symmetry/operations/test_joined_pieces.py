"""Lines within which the pen was lifted: pieces are one curve, and that is never silent."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise, permutations

import numpy as np
import pytest

from bozzetto.arrays import Array
from bozzetto.ink import Stroke, carried_places, resample
from bozzetto.plugin import Context
from bozzetto_symmetry.commands import all_commands
from bozzetto_symmetry.ink.continuation import OpenLine, continuation, meeting
from bozzetto_symmetry.model.state import SymmetryState
from bozzetto_symmetry.operations.assign_stroke import add_drawing, add_strokes
from bozzetto_symmetry.report import cautions_of
from bozzetto_symmetry.solve.curve_solver import trace_of
from bozzetto_symmetry.solve.pieces import may_go_on, open_links
from bozzetto_symmetry.stereo.mirror_camera import MIRROR
from bozzetto_symmetry.tools.erase import erase
from tests.plugins.symmetry import meant_drawings as m
from tests.plugins.symmetry import scenes as s
from tests.plugins.symmetry.figures_lifted import outcome
from tests.plugins.symmetry.lifted_drawings import PAIRS, lifted

VIEW = s.camera(35, 20, pixels=800.0)
RAIL = s.PAIRS["roof rail"]
ARC = np.column_stack((np.cos(TURN := np.linspace(0, 2.0, 300)), np.sin(TURN))) * 200.0
CORNER = resample(np.array(((0.0, 0.0), (200.0, 0.0), (230.0, 180.0))), spacing=2.0)


def strokes(curve: Array, *cuts: float) -> list[Stroke]:
    """A curve drawn in pieces from cut to cut, shares of its places."""
    pixels = VIEW.project(curve)[0]
    ends = [0, *(round(cut * len(pixels)) for cut in cuts), len(pixels)]
    pieces = [pixels[i : j + 1] for i, j in pairwise(ends)]
    return [Stroke(piece[:, 0], piece[:, 1], VIEW) for piece in pieces]


def off(state: SymmetryState, curve: Array) -> float:
    """Greatest distance of a state's one curve from a true one, either side, mm."""
    points = trace_of(state.curves[0], state).points
    return min(float(s.distances(side, curve).max()) for side in (points, points * MIRROR))


def switched(state: SymmetryState) -> SymmetryState:
    (command,) = (one for one in all_commands() if one.key == "X")
    return command.run(state, Context(camera=VIEW))


# -- ends of lines -----------------------------------------------------------------------------


@pytest.mark.parametrize("cut", [60, 150, 220])
@pytest.mark.parametrize("apart", [-12, 0, 2])
def test_a_line_goes_on_where_it_was_cut_whatever_its_senses(cut: int, apart: int) -> None:
    one, other = ARC[:cut], ARC[cut + apart :]
    found = {
        continuation(OpenLine(first), OpenLine(second))
        for a, b in ((one, other), (other, one))
        for first in (a, a[::-1])
        for second in (b, b[::-1])
    }
    bends = [each.bend for each in found if each is not None]
    assert len(bends) == len(found)
    assert all(each is not None and each.sure for each in found)
    # An overlap of twelve places turns by 4.6°, and each direction is good to a degree.
    assert max(bends) < 8.0


def test_a_corner_may_go_on_and_is_not_sure() -> None:
    corner = int(np.argmin(np.linalg.norm(CORNER - (200.0, 0.0), axis=1)))
    found = continuation(OpenLine(CORNER[:corner]), OpenLine(CORNER[corner:]))
    assert found is not None
    assert not found.sure
    assert found.bend == pytest.approx(np.degrees(np.arctan2(180.0, 30.0)), abs=1.0)


@pytest.mark.parametrize(
    "way", [(60.0, 0.0), (0.0, 60.0), (25.0, 25.0)], ids=["ahead", "beside", "both"]
)
def test_ends_far_from_one_another_do_not_go_on(way: tuple[float, float]) -> None:
    line = resample(np.array(((0.0, 0.0), (200.0, 0.0))), spacing=2.0)
    on = OpenLine(line + np.array((200.0, 0.0)) + way)
    assert continuation(OpenLine(line), on) is None


def test_lines_that_run_back_or_alongside_do_not_go_on() -> None:
    line = resample(np.array(((0.0, 0.0), (200.0, 0.0))), spacing=2.0)
    back, tick = line[::-1] + np.array((0.0, 4.0)), line[:3] + np.array((200.0, 0.0))
    assert continuation(OpenLine(line), OpenLine(back)) is None
    assert continuation(OpenLine(line), OpenLine(tick)) is None


@pytest.mark.parametrize("seed", range(4))
def test_of_many_lines_those_meet_that_meet_two_by_two(seed: int) -> None:
    """Lines that fork, overlap, close up and miss each other a little, and some far away."""
    dice = np.random.default_rng(seed)
    lines, at = [], np.zeros((1, 2))
    for _ in range(40):
        at = at[-1] + dice.normal(0.0, dice.choice((3.0, 25.0, 300.0)), 2)
        turn = np.cumsum(dice.normal(0.0, 0.03) + dice.normal(0.0, 0.02, int(dice.integers(3, 90))))
        way = dice.uniform(0.0, 2.0 * np.pi) + turn
        at = at + np.cumsum(2.0 * np.column_stack((np.cos(way), np.sin(way))), axis=0)
        lines.append(OpenLine(at if dice.random() < 0.5 else at[::-1], float(dice.uniform(0, 3))))
    found = {(i, j): how for i, j, how in meeting(lines)}
    for i, one in enumerate(lines):
        for j, other in enumerate(lines[i + 1 :], i + 1):
            assert found.get((i, j)) == continuation(one, other)
    assert len(found) > 5


# -- what pieces are read as -------------------------------------------------------------------


@pytest.mark.parametrize("order", list(permutations(range(3))), ids=str)
def test_a_side_in_two_pieces_pairs_in_any_order(order: tuple[int, ...]) -> None:
    ink = (*strokes(RAIL, 0.45), *strokes(RAIL * MIRROR))
    state = add_drawing(SymmetryState(), [ink[k] for k in order])
    whole = add_drawing(SymmetryState(), (*strokes(RAIL), *strokes(RAIL * MIRROR)))
    assert len(state.curves) == 1
    assert trace_of(state.curves[0], state).reading == "pair"
    assert off(state, RAIL) < off(whole, RAIL) + 0.003 * s.DIAGONAL
    assert not trace_of(state.curves[0], state).warnings


@pytest.mark.parametrize("in_turn", [False, True])
def test_both_sides_in_three_pieces_are_one_pair(in_turn: bool) -> None:
    one, other = strokes(RAIL, 0.3, 0.7), strokes(RAIL * MIRROR, 0.35, 0.6)
    ink = [x for both in zip(one, other, strict=True) for x in both] if in_turn else one + other
    state = add_drawing(SymmetryState(), ink)
    assert len(state.curves) == 1
    assert trace_of(state.curves[0], state).reading == "pair"
    assert off(state, RAIL) < 0.005 * s.DIAGONAL


def test_pieces_that_meet_at_a_corner_are_one_when_their_partner_was_drawn() -> None:
    side = PAIRS["chair frame with corners"]
    heights = np.linalg.norm(np.diff(side, 2, axis=0), axis=1)
    (first, second) = sorted(np.argsort(heights)[-2:] / len(side))
    ink = strokes(side, first, second)
    waiting = add_drawing(SymmetryState(), ink)
    assert len(waiting.curves) > 1
    state = add_drawing(waiting, strokes(side * MIRROR))
    assert len(state.curves) == 1
    assert trace_of(state.curves[0], state).reading == "pair"
    assert off(state, side) < 0.02 * s.DIAGONAL


@pytest.mark.parametrize("cuts", [(0.3,), (0.62,), (0.25, 0.7)], ids=str)
@pytest.mark.parametrize("name", ["hood U", "wavy bumper"])
def test_a_curve_across_the_plane_in_pieces(name: str, cuts: tuple[float, ...]) -> None:
    state = add_drawing(SymmetryState(), strokes(s.ACROSS[name], *cuts))
    whole = add_drawing(SymmetryState(), strokes(s.ACROSS[name]))
    assert len(state.curves) == 1
    assert trace_of(state.curves[0], state).reading == "self"
    assert off(state, s.ACROSS[name]) < off(whole, s.ACROSS[name]) + 0.005 * s.DIAGONAL


def test_two_lines_that_meet_at_a_corner_stay_two() -> None:
    """A leg and an arm of a chair, each left and right in turn."""
    leg = np.array((30.0, 30.0, -45.0)) + np.outer(s.S, (5.0, 0.0, 45.0))
    arm = leg[-1] + np.outer(s.S, (-70.0, 4.0, 3.0)) + np.outer(np.sin(np.pi * s.S), (0, 0, 8.0))
    ink = [x for side in (leg, arm) for x in (*strokes(side), *strokes(side * MIRROR))]
    state = add_drawing(SymmetryState(), ink)
    assert [len(curve.strokes) for curve in state.curves] == [2, 2]
    assert all(not curve.pieces for curve in state.curves)


def test_strokes_in_other_views_are_no_pieces() -> None:
    (one, _), other = strokes(RAIL, 0.45), s.camera(-40, 15, pixels=800.0)
    state = add_strokes(SymmetryState(), (one,))
    seen = Stroke(*(one.points[-1] + ARC[:100] - ARC[0]).T, other)
    assert open_links(add_strokes(state, (seen,)).curves[-1], state) == ()


@pytest.mark.parametrize("seed", [7301, 7308])
def test_pieces_drawn_while_the_window_changes_its_size_are_read_alike(seed: int) -> None:
    thing = lifted(seed, 1.0)
    resized = []
    for number, stroke in enumerate(thing.strokes):
        camera = stroke.camera
        if number % 2:
            width, height = camera.viewport
            camera = camera.with_viewport(1.5 * width, 1.5 * height)
        places = carried_places(stroke.points, stroke.camera, camera)
        resized.append(Stroke(*places.T, camera))
    before, after = (add_drawing(SymmetryState(), strokes) for strokes in (thing.strokes, resized))
    assert len(before.curves) == len(after.curves) == 1
    assert trace_of(after.curves[0], after).reading == thing.reading
    assert after.curves[0].pieces == before.curves[0].pieces


# -- what a person is told, and can do ---------------------------------------------------------


def test_what_may_go_on_is_told_and_the_key_takes_it() -> None:
    side = PAIRS["chair frame with corners"]
    bend = int(np.argmax(np.linalg.norm(np.diff(side, 2, axis=0), axis=1))) / len(side)
    state = add_drawing(SymmetryState(), strokes(side, bend))
    assert len(state.curves) == 2
    joined = switched(state)
    assert len(joined.curves) == 1
    assert joined.curves[0].pieces
    assert {x.digest for x in joined.curves[0].strokes} == {
        x.digest for curve in state.curves for x in curve.strokes
    }


def test_the_key_takes_pieces_apart_and_joins_them_again() -> None:
    state = add_drawing(SymmetryState(), strokes(RAIL, 0.45))
    assert len(state.curves) == 1
    seen, now = [state], state
    for _ in range(12):
        now = switched(now)
        seen.append(now)
        if len(now.curves) == 1 and len(seen) > 2 and len(seen[-2].curves) == 2:
            break
    apart = [each for each in seen if len(each.curves) == 2]
    assert apart
    assert len(now.curves) == 1
    assert now.curves[0].pieces
    for each in seen:
        assert sum(len(curve.strokes) for curve in each.curves) == 2


def test_what_a_person_took_apart_stays_apart() -> None:
    state = add_drawing(SymmetryState(), strokes(RAIL, 0.45))
    while len(state.curves) == 1:
        state = switched(state)
    assert state.curves[1].id not in may_go_on(state)
    state = add_drawing(state, strokes(RAIL * MIRROR))
    assert len(state.curves) == 2


def test_a_join_that_was_not_made_is_told_in_files_too() -> None:
    side = PAIRS["chair frame with corners"] + np.array((60.0, 30.0, 40.0))
    bend = int(np.argmax(np.linalg.norm(np.diff(side, 2, axis=0), axis=1))) / len(side)
    state = add_drawing(SymmetryState(), strokes(side, bend))
    assert len(state.curves) == 2
    traces = {curve.id: trace_of(curve, state) for curve in state.curves}
    assert any(trace.reading == "half" for trace in traces.values())
    told = [caution.message for caution in cautions_of(state, traces, {})]
    assert any("may go on where" in text for text in told)


def test_an_erased_piece_leaves_the_others_joined() -> None:
    state = add_drawing(SymmetryState(), strokes(RAIL, 0.3, 0.6))
    (curve,) = state.curves
    assert len(curve.strokes) == 3
    if trace_of(curve, state).curve is not None:
        state = state.with_node(replace(curve, reading="half"))
    left = erase(state, curve.strokes[0]).curves[0]
    assert [x.digest for x in left.strokes] == [x.digest for x in curve.strokes[1:]]
    assert all(0 <= number < 2 for piece in left.pieces for number in piece)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("noise", [0.0, 1.0])
@pytest.mark.parametrize("bars_first", [True, False])
def test_frames_of_whole_strokes_are_as_they_were(
    seed: int, noise: float, bars_first: bool
) -> None:
    """Corners of a box hang together at their ends, and yet each edge is a curve."""
    across, along = m.frame(noise, np.random.default_rng(seed))
    edges = (*across, *along) if bars_first else (*along, *across)
    state = add_drawing(SymmetryState(), [x for edge in edges for x in edge.strokes])
    assert sorted(len(curve.strokes) for curve in state.curves) == [1] * 4 + [2] * 4
    assert all(not curve.pieces for curve in state.curves)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(400, 416))
def test_things_drawn_in_pieces_are_as_those_of_whole_strokes(seed: int) -> None:
    """By a hand of 1 px: right, or told."""
    found = outcome(lifted(seed, 1.0))
    assert found.right or found.told or not outcome(lifted(seed, 1.0, whole=True)).right
