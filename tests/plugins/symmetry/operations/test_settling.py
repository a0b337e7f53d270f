"""Ends that settle where they nearly meet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from bozzetto.ink import Drawing, Stroke, Strokes
from bozzetto.plugin import Context, Ink, Job
from bozzetto_symmetry.model.state import Curve, SymmetryState
from bozzetto_symmetry.modeler import Symmetry
from bozzetto_symmetry.operations.assign_stroke import add_drawing
from bozzetto_symmetry.operations.settling import with_settled
from bozzetto_symmetry.solve.curve_solver import trace_of
from bozzetto_symmetry.stereo.mirror_camera import MIRROR
from bozzetto_symmetry.tools.draw_curve import DrawCurve
from bozzetto_symmetry.view.hints import SETTLED, next_step
from tests.plugins.symmetry import meeting_drawings as m
from tests.plugins.symmetry import scenes as s
from tests.plugins.symmetry.figures_settling import End, ends_of
from tests.plugins.symmetry.meeting_drawings import Line

CONTEXT = Context(camera=s.camera(40, 22, pixels=800.0))


def lines_of(kind: str, seed: int, noise: float = 1.0) -> list[Line]:
    return m.KINDS[kind](noise, np.random.default_rng(seed))


def drawn(lines: Sequence[Line], order: Sequence[int] | None = None) -> SymmetryState:
    """The curves as they are read one by one, with their ends where they settle."""
    numbers = order if order is not None else range(len(lines))
    nodes = tuple(Curve(id=f"c{k}", strokes=Strokes(lines[k].strokes)) for k in numbers)
    return with_settled(SymmetryState(nodes=nodes), CONTEXT)


def drawn_on(state: SymmetryState, lines: Sequence[Line]) -> SymmetryState:
    """The state after lines were drawn with the tool."""
    for line in lines:
        for stroke in line.strokes:
            state = DrawCurve().apply(state, Ink((stroke,)), CONTEXT)
    return state


def curves(state: SymmetryState) -> dict[Stroke, s.Array]:
    """Places along every curve by its first stroke."""
    return {node.strokes[0]: trace_of(node, state).points for node in state.curves}


def mean_off(ends: Sequence[End]) -> float:
    return float(np.mean([end.off for end in ends]))


@pytest.mark.parametrize("seed", [7001, 7002])
def test_ends_of_a_box_frame_meet_exactly_and_err_by_half(seed: int) -> None:
    lines = lines_of("box frames", seed)
    free, settled = ends_of(lines, False), ends_of(lines, True)
    assert len(settled) >= 10
    assert all(end.moved for end in settled)
    assert mean_off(settled) < 0.6 * mean_off(free)


@pytest.mark.parametrize("kind", ["box frames", "posts with bars", "bicycle frames"])
def test_the_order_of_the_curves_does_not_tell(kind: str) -> None:
    lines = lines_of(kind, 7011)
    one = drawn(lines)
    other = drawn(lines, np.random.default_rng(3).permutation(len(lines)).tolist())
    found, again = curves(one), curves(other)
    assert len(found) >= 5
    assert found.keys() == again.keys()
    for stroke, points in found.items():
        np.testing.assert_allclose(again[stroke], points, atol=1e-6)


@pytest.mark.parametrize("kind", list(m.KINDS))
def test_settling_twice_changes_nothing(kind: str) -> None:
    once = with_settled(drawn(lines_of(kind, 7021)), CONTEXT)
    assert with_settled(once, CONTEXT) == once


@pytest.mark.parametrize("kind", list(m.KINDS))
def test_curves_stay_symmetric(kind: str) -> None:
    state = drawn(lines_of(kind, 7031))
    for node in state.curves:
        curve = trace_of(node, state).curve
        if curve is None:
            continue
        points = curve.spline.control_points
        if curve.reading == "self":
            np.testing.assert_array_equal(points[::-1] * MIRROR, points)
        if curve.reading == "plane":
            assert not points[:, 1].any()


def test_no_end_goes_farther_than_a_person_sees_it_caught() -> None:
    for kind in m.KINDS:
        state = drawn(lines_of(kind, 7041))
        for node in state.curves:
            solved = trace_of(node, state)
            free = trace_of(replace(node, settles=False, axis=-1), state)
            if solved.curve is None or free.curve is None:
                continue
            camera = node.strokes[0].camera
            ends = [each.curve.spline.value(each.curve.spline.range) for each in (solved, free)]
            seen = [camera.project(each)[0] for each in ends]
            assert np.linalg.norm(seen[0] - seen[1], axis=1).max() < 8.0 + 4.0  # and the axis


@pytest.mark.parametrize("seed", [7051, 7052])
def test_what_meets_nothing_stays_as_it_was_drawn(seed: int) -> None:
    lines = lines_of("bars and pairs that meet nothing", seed, 0.5)
    far = [end for end in ends_of(lines, True) if not end.meant]
    assert len(far) >= 4
    assert not any(end.moved for end in far)


def test_what_is_drawn_while_the_key_suspends_it_never_settles() -> None:
    lines = lines_of("box frames", 7061)
    state = drawn_on(SymmetryState(snapping=False), lines[:2])
    assert not any(node.settles for node in state.curves)
    before = curves(state)
    state = drawn_on(replace(state, snapping=True), lines[2:4])
    after = curves(state)
    for stroke, points in before.items():
        np.testing.assert_array_equal(after[stroke], points)
    assert any(node.end_snaps for node in state.curves)


def test_one_curve_is_let_go_and_goes_back_where_it_was_drawn() -> None:
    state = drawn(lines_of("box frames", 7071))
    node = next(node for node in state.curves if node.end_snaps)
    free = trace_of(replace(node, end_snaps=()), state)
    let_go = trace_of(replace(node, settles=False), state)
    np.testing.assert_array_equal(let_go.points, free.points)
    assert np.abs(trace_of(node, state).points - free.points).max() > 0.0


def test_an_end_that_is_drawn_first_comes_to_meet_what_is_drawn_later() -> None:
    lines = lines_of("box frames", 7111)
    pair = next(line for line in lines if len(line.strokes) == 2)
    bar = next(
        line for line in lines
        if len(line.strokes) == 1 and s.distances(line.ends, pair.truth).min() < 1e-6
    )  # fmt: skip
    state = drawn_on(SymmetryState(), (bar, pair))
    one, other = (trace_of(node, state).curve for node in state.curves)
    assert one is not None
    assert other is not None
    ends = [each.spline.value(each.spline.range) for each in (one, *(other, other))]
    ends[2] = ends[1] * MIRROR
    gaps = [np.linalg.norm(ends[0][:, None] - each, axis=2).min() for each in ends[1:]]
    assert min(gaps) < 1e-9
    assert len(state.curves[0].end_snaps) == 1


def test_the_person_is_told() -> None:
    state = drawn(lines_of("box frames", 7081))
    node = next(node for node in state.curves if len(node.end_snaps) == 2)
    assert SETTLED[2] in next_step(replace(state, selected=node.id))
    modeler = Symmetry()
    report = modeler.report(state, modeler.solve(state, Job("final")), Job("final"))
    assert sum(entry["settled"] for entry in report["curves"]) >= 8
    freed = state.with_node(replace(node, settles=False))
    assert SETTLED[2] not in next_step(freed)


def test_ends_of_an_ink_file_settle_and_do_not_on_a_box_that_is_put_around_it() -> None:
    lines = lines_of("box frames", 7091)
    ink = [stroke for line in lines for stroke in line.strokes]
    state = Symmetry().read_drawing(Drawing(tuple(ink), ink[0].camera), CONTEXT, Job("final"))
    assert sum(len(node.end_snaps) for node in state.curves) >= 10
    alone = Symmetry().read_drawing(Drawing(tuple(ink[:2]), ink[0].camera), CONTEXT, Job("final"))
    assert not any(node.end_snaps for node in alone.curves)


def test_hostile_curves_settle_nothing_and_raise_nothing() -> None:
    lines = lines_of("posts with bars", 7101)
    state = add_drawing(SymmetryState(), [stroke for line in lines for stroke in line.strokes])
    twin = state.curves[0]
    odd = (
        Curve(id="empty"),
        replace(twin, id="twin"),
        replace(twin, id="hidden", visible=False),
        replace(twin, id="tiny", strokes=Strokes()),
    )
    many = replace(state, nodes=(*state.nodes, *odd))
    found = with_settled(many, CONTEXT)
    assert [node.id for node in found.nodes] == [node.id for node in many.nodes]
    assert with_settled(SymmetryState(), CONTEXT) == SymmetryState()
