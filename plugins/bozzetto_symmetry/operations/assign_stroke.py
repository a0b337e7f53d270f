"""Which curve new ink belongs to: one that waits, one that it is drawn along, or a new one.

A person draws one side and then the other, goes over a curve again until it settles, looks
at it from elsewhere and draws it once more. Ink files do the same with strokes in a row.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.ink import Stroke, Strokes, distances_to_polyline, is_one_view, on_canvas, resample
from bozzetto_symmetry.ink.polyline import length_of
from bozzetto_symmetry.ink.sides import MOST_STROKES
from bozzetto_symmetry.model.state import AskedReading, Curve, SymmetryState
from bozzetto_symmetry.operations.joined_pieces import WHOLE, joined_with_new, with_joined
from bozzetto_symmetry.operations.second_sides import LOOKS, as_pair, waits
from bozzetto_symmetry.solve.curve_solver import Trace, trace_if_any, trace_of
from bozzetto_symmetry.stereo.mirror_camera import MIRROR, Stereo

ALONG: Final = 14.0
"""Distance, px, up to which ink runs along what is drawn already: about four times what two
strokes that are meant to be one lie apart."""

MOSTLY: Final = 0.8
"""Share of a stroke that must run along."""

WORTH: Final = 0.25
"""Share of the curve's length that a stroke along it must have: shorter ones are details."""


def ignore(fraction: float, step: str) -> None:
    """Do nothing: the checkpoint of those who have none."""


def add_drawing(
    state: SymmetryState,
    strokes: Sequence[Stroke],
    readings: Mapping[str, AskedReading] | None = None,
    checkpoint: Callable[[float, str], None] = ignore,
) -> SymmetryState:
    """Return the state with the strokes of a whole drawing.

    Strokes of one group are one curve, whose id is the group's name. Others find their own
    place one by one.

    Parameters
    ----------
    state : SymmetryState
        What the drawing is added to.
    strokes : sequence of Stroke
        All of the drawing, in the order drawn.
    readings : mapping, optional
        What curves are, by their id, where the drawing says so.
    checkpoint : callable
        Called before each stroke with the share that is done; what it raises ends the work.
    """
    asked = readings or {}
    groups: dict[str, list[Stroke]] = {}
    for stroke in strokes:
        if stroke.group:
            groups.setdefault(stroke.group, []).append(stroke)
    for name, drawn in groups.items():
        curve = Curve(
            id=name,
            name=name,
            strokes=Strokes(drawn),
            reading=asked.get(name, "auto"),
            color=drawn[0].color,
        )
        state = state.with_node(curve)
    for number, stroke in enumerate(strokes):
        checkpoint(number / len(strokes), "")
        if stroke.group:
            continue
        again = _gone_over(state, stroke)
        state = add_strokes(state, (stroke,)) if again is None else state.with_node(again)
    return state


def _gone_over(state: SymmetryState, stroke: Stroke) -> Curve | None:
    """Return the chosen curve with one more stroke along its first and its last one, if it is that.

    What goes over the same ink again belongs to it whatever that ink means: nothing is solved, and
    many equal strokes take no longer than they must.
    """
    curve = state.chosen
    if curve is None or curve.canvas is not None or len(curve.strokes) < 2:
        return None
    if len(curve.strokes) >= MOST_STROKES:
        return None
    for drawn in (curve.strokes[0], curve.strokes[-1]):
        if not is_one_view(stroke.camera, drawn.camera):
            return None
        if not _is_along(on_canvas(stroke, drawn.camera).points, drawn.points):
            return None
    return replace(curve, strokes=curve.strokes.extended((stroke,)))


def add_strokes(state: SymmetryState, strokes: tuple[Stroke, ...]) -> SymmetryState:
    """Return the state with new ink, which becomes part of a curve or a curve of its own.

    Raises
    ------
    UserError
        If the ink is no more than a dot.
    """
    chosen = state.chosen
    trace = None if chosen is None else trace_if_any(chosen, state)
    if chosen is not None and trace is not None and chosen.canvas is None:
        # Only the chosen curve can be gone over again; beside others a new curve is meant.
        if runs_along(strokes, trace, state):
            return state.with_node(_with(chosen, strokes))
    new = Curve(
        id=state.unused_id(),
        name=state.unused_name("Curve"),
        strokes=Strokes(strokes),
        color=strokes[0].color,
    )
    second = _as_second_side(state, strokes)
    cost, whole = (np.inf, False) if second is None else (second[1].cost, _is_whole(second[1]))
    joined = joined_with_new(state, new, cost, whole)
    if joined is not None:
        return with_joined(state, joined)
    if second is not None:
        return state.with_node(_with(second[0], strokes))
    trace_of(new, state)
    return state.with_node(new)


def _with(curve: Curve, strokes: tuple[Stroke, ...]) -> Curve:
    return replace(curve, strokes=curve.strokes.extended(strokes))


def _as_second_side(
    state: SymmetryState, strokes: tuple[Stroke, ...]
) -> tuple[Curve, Trace] | None:
    """Return the curve that waits for new strokes, the chosen one first, and what comes of both."""
    fits = []
    for curve in state.shown_curves:
        trace = trace_if_any(curve, state)
        if trace is not None and waits(curve, trace):
            both = as_pair(curve, strokes, state, trace.rest)
            if both is not None:
                fits.append((curve.id != state.selected, both.cost, curve, both))
    return min(fits, key=lambda fit: fit[:2])[2:] if fits else None


def _is_whole(pair: Trace) -> bool:
    """Return whether all ink of a pair in one view has its partner."""
    if len(pair.views) > 1:
        return True
    return pair.rest == 0.0 and pair.coverage >= WHOLE


def runs_along(strokes: Iterable[Stroke], trace: Trace, state: SymmetryState) -> bool:
    """Return whether strokes are drawn along a curve, or along ink of it in the same view."""
    return all(_runs_along_one(stroke, trace, state) for stroke in strokes)


def _runs_along_one(stroke: Stroke, trace: Trace, state: SymmetryState) -> bool:
    """Return whether one stroke is drawn along a curve, as `runs_along`."""
    lines: list[Array] = []
    for view in trace.views:
        canvas = view.strokes[0].camera
        if is_one_view(stroke.camera, canvas):
            stroke = on_canvas(stroke, canvas)
            lines += [side.pixels for side in view.sides]
    stereo = Stereo.of(stroke.camera, state.plane)
    if trace.curve is not None:
        images = [trace.points] + ([trace.points * MIRROR] if trace.reading == "pair" else [])
        lines += [stereo.project(points) for points in images]
    seen = (line for line in lines if len(line) > 1 and np.isfinite(line).all())
    return any(_is_along(stroke.points, line) for line in seen)


def _is_along(ink: Array, line: Array) -> bool:
    if len(np.unique(ink, axis=0)) < 2:
        return False
    places = resample(ink, count=LOOKS)
    near = distances_to_polyline(places, line) < ALONG
    return bool(near.mean() >= MOSTLY and length_of(places) >= WORTH * length_of(line))
