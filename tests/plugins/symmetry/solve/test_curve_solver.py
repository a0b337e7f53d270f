"""What is worked out once for a curve, and that it is what would be worked out again."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from bozzetto.ink import Stroke, Strokes
from bozzetto.plugin.cache import forget_all
from bozzetto_symmetry.fitting import bundle_adjustment
from bozzetto_symmetry.ink import sides
from bozzetto_symmetry.interpretation import pair, self_symmetric
from bozzetto_symmetry.model.state import Curve, SymmetryState
from bozzetto_symmetry.operations.assign_stroke import add_drawing
from bozzetto_symmetry.solve import curve_solver
from bozzetto_symmetry.solve.curve_solver import Trace, trace_of
from bozzetto_symmetry.solve.notices import EITHER, UNDECIDED_LOOPS
from bozzetto_symmetry.stereo.mirror_camera import MIRROR
from tests.plugins.symmetry import figures_loops, meant_drawings
from tests.plugins.symmetry import scenes as s

VIEW, ASIDE = s.camera(35, 20), s.camera(60, 30)
RAIL = s.PAIRS["roof rail"]
SIZES = [(200.0, 100.0, 100.0), (260.0, 100.0, 90.0), (150.0, 130.0, 60.0), (90.0, 40.0, 40.0)]


def stroke(curve: np.ndarray, view=VIEW, seed: int = 0) -> Stroke:
    ink = s.drawn(curve, view, noise=1.0, random=np.random.default_rng(seed))
    return Stroke(ink[:, 0], ink[:, 1], view)


def boxes(state: SymmetryState) -> Iterator[SymmetryState]:
    for length, width, height in SIZES:
        yield replace(state, length=length, width=width, height=height)


DRAWINGS = {
    "pair": (stroke(RAIL), stroke(RAIL * MIRROR, seed=1)),
    "across": (stroke(s.ACROSS["windscreen base"]),),
    "ring": (stroke(s.RINGS["grille"]),),
    "flat": (stroke(s.FLAT["roof line"]),),
    "two views": (
        stroke(RAIL), stroke(RAIL * MIRROR, seed=1), stroke(RAIL, ASIDE, 2),
        stroke(RAIL * MIRROR, ASIDE, 3),
    ),
}  # fmt: skip


def same(one: Trace, other: Trace) -> bool:
    """Whether two answers are equal to the last bit."""
    kinds = [(t.reading, t.choices, t.warnings, t.margin, t.cost, t.rms) for t in (one, other)]
    if kinds[0] != kinds[1] or (one.curve is None) != (other.curve is None):
        return False
    assert one.curve is None or other.curve is not None
    arrays = [(one.points, other.points), (one.sigma, other.sigma)]
    if one.curve is not None and other.curve is not None:
        arrays.append((one.curve.spline.control_points, other.curve.spline.control_points))
    return all(np.array_equal(a, b) for a, b in arrays)


@pytest.mark.parametrize("name", DRAWINGS)
def test_a_curve_in_other_boxes_is_what_it_is_for_who_never_saw_it(name: str) -> None:
    curve = Curve(id="c", name="c", strokes=Strokes(DRAWINGS[name]))
    remembered = [trace_of(curve, state) for state in boxes(SymmetryState())]
    for state, known in zip(boxes(SymmetryState()), remembered, strict=True):
        forget_all()
        assert same(trace_of(curve, state), known)


def test_a_box_of_another_size_matches_and_fits_nothing_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    forget_all()
    calls = []
    for module, name in (
        (pair, "pairings"), (self_symmetric, "foldings"), (curve_solver, "adjust_bundle"),
    ):  # fmt: skip
        work = getattr(module, name)

        def counted(*arguments, work=work, **named):
            calls.append(work)
            return work(*arguments, **named)

        monkeypatch.setattr(module, name, counted)
    curve = Curve(id="c", name="c", strokes=Strokes(DRAWINGS["pair"]))
    states = [replace(SymmetryState(), length=length) for length in (200.0, 203.0, 207.5, 240.0)]
    first = trace_of(curve, states[0])
    assert len(calls) > 1
    before = len(calls)
    for state in states[1:]:
        assert trace_of(curve, state).curve is first.curve
    assert len(calls) == before


def test_one_stroke_more_merges_only_its_own_side(monkeypatch: pytest.MonkeyPatch) -> None:
    forget_all()
    strokes = [stroke(side, seed=k) for k, side in enumerate([RAIL, RAIL * MIRROR] * 2)]
    merged = []
    work = sides.merge_strokes

    def counted(places, weights):
        merged.append(len(places))
        return work(places, weights)

    monkeypatch.setattr(sides, "merge_strokes", counted)
    state, curve = SymmetryState(), Curve(id="c", name="c", strokes=Strokes(strokes[:3]))
    trace_of(curve, state)
    assert merged == [2]
    whole = replace(curve, strokes=Strokes(strokes))
    known = trace_of(whole, state)
    assert merged == [2, 2]
    forget_all()
    assert same(trace_of(whole, state), known)


def test_no_control_points_are_lost() -> None:
    """The paper's seven are what an adaptive curve begins with."""
    curve = Curve(id="c", name="c", strokes=Strokes(DRAWINGS["pair"]), detail="seven")
    made = trace_of(curve, SymmetryState()).curve
    assert made is not None
    assert len(made.spline.control_points) == bundle_adjustment.FEWEST


def test_no_loop_is_read_in_the_wrong_sense_without_a_word() -> None:
    """In the wrong sense loops reach into the depth: the rounder and smaller one is meant."""
    found = []
    for seed in range(95000, 95006):
        for shape in ("ellipses", "rounded boxes"):
            for facing in ("the front", "anywhere"):
                random = np.random.default_rng(seed)
                side = figures_loops.loop(shape, facing, random)
                found.append(figures_loops.outcome(side, 1.0, False, random))
    assert not figures_loops.untold(found)
    assert figures_loops.wrong(found) < 0.15


def test_loops_that_fit_either_way_are_told_and_the_other_one_is_offered() -> None:
    told = []
    for seed in range(800, 806):
        random = np.random.default_rng(seed)
        side = figures_loops.loop("ellipses", "anywhere", random)
        view = meant_drawings.view_of(random)
        begun = np.roll(
            side, 100, axis=0
        )  # elsewhere: only the shapes can say which sense is meant
        strokes = tuple(
            meant_drawings.stroke(np.vstack((curve, curve[:1])), view, 1.0, random)
            for curve in (side, begun * MIRROR)
        )
        state = add_drawing(SymmetryState(), strokes)
        trace = trace_of(state.curves[0], state)
        pairs = [each.cost for each in trace.views[0].reader.read("pair", state.bounds)]
        told.append(EITHER in trace.warnings)
        if trace.reading == "pair":
            assert told[-1] == (len(pairs) > 1 and pairs[1] < UNDECIDED_LOOPS + pairs[0])
            assert trace.ghost is not None or not told[-1]
    assert any(told)
