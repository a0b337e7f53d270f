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
from bozzetto.errors import UserError
from bozzetto.ink import Stroke, Strokes, distances_to_polyline, is_one_view, on_canvas, resample
from bozzetto.view import Camera
from bozzetto_symmetry.ink.polyline import length_of
from bozzetto_symmetry.ink.sides import MOST_STROKES
from bozzetto_symmetry.model.state import AskedReading, Curve, SymmetryState
from bozzetto_symmetry.solve.curve_solver import Trace, trace_of
from bozzetto_symmetry.stereo.epipolar_signal import Signal
from bozzetto_symmetry.stereo.mirror_camera import MIRROR, Stereo

ALONG: Final = 14.0
"""Distance, px, up to which ink runs along what is drawn already: about four times what two
strokes that are meant to be one lie apart."""

MOSTLY: Final = 0.8
"""Share of a stroke that must run along."""

WORTH: Final = 0.25
"""Share of the curve's length that a stroke along it must have: shorter ones are details."""

STRAIGHT: Final = (2.5, 0.01)
"""Distance from the way between its ends (rms), px and as a share of that way, up to which a side
may be straight: a hand of 1 px strays by less."""

LEFT_OUT: Final = (0.1, 12.0)
"""Share of a straight side, and px, that may lack a partner. Two straight lines match along some
stretch whatever they are, so only their ends say that they are a pair; of pairs that were drawn
whole 5 % lack one at most, of others 17 % and more."""

LOOKS: Final = 60
"""Places of a stroke that are looked at."""

SURE_PAIR: Final = 8.0
"""Cost of a pair, px, above which two strokes are rather two curves. Sides of one curve cost
up to 5, if an end is missing; two curves cost 16 and more."""


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
    owner = _owner(state, strokes)
    if owner is None:
        owner = Curve(
            id=state.unused_id(),
            name=state.unused_name("Curve"),
            strokes=Strokes(strokes),
            color=strokes[0].color,
        )
        trace_of(owner, state)
    else:
        owner = replace(owner, strokes=owner.strokes.extended(strokes))
    return state.with_node(owner)


def _owner(state: SymmetryState, strokes: tuple[Stroke, ...]) -> Curve | None:
    """Return the curve that new strokes belong to: the chosen one, or one that waits.

    Only the chosen curve can be gone over again; beside others it is a new curve that is
    meant.
    """
    known = [(curve, trace) for curve in state.shown_curves if (trace := _trace(curve, state))]
    for curve, trace in known:
        if (
            curve.id == state.selected
            and curve.canvas is None
            and runs_along(strokes, trace, state)
        ):
            return curve
    fits = [
        (curve.id != state.selected, cost, curve)
        for curve, trace in known
        if waits(curve, trace) and np.isfinite(cost := _as_pair(curve, strokes, state, trace.rest))
    ]
    return min(fits, key=lambda fit: fit[:2])[2] if fits else None


def waits(curve: Curve, trace: Trace) -> bool:
    """Return whether a curve may still get its other side, or more of it.

    It has one side, and nobody said what it is; or only a part of the other one was drawn.

    A side alone can look like a curve across the plane, or in it.
    """
    if curve.canvas is not None:
        return False
    one_sided = len(trace.views) == 1 and len(trace.views[0].sides) == 1
    return trace.reading == "half" or trace.rest > 0.0 or (one_sided and curve.reading == "auto")


def waiting_view(state: SymmetryState) -> Camera | None:
    """Return the camera, in the model's frame, of the view in which the chosen curve waits."""
    trace = None if state.chosen is None else _trace(state.chosen, state)
    if state.chosen is None or trace is None or trace.reading != "half":
        return None
    return state.chosen.strokes[-1].camera


def _trace(curve: Curve, state: SymmetryState) -> Trace | None:
    try:
        return trace_of(curve, state)
    except UserError:
        return None


def _as_pair(curve: Curve, strokes: tuple[Stroke, ...], state: SymmetryState, rest: float) -> float:
    """Return how badly new strokes fit a waiting side, px; inf: not at all.

    A whole side also waits for its mirror image in another view. Where only a part of a side waits,
    they must leave less of it waiting, in its own view.
    """
    here = any(is_one_view(strokes[0].camera, stroke.camera) for stroke in curve.strokes)
    if (rest and not here) or not shares_lines(curve, strokes, state):
        return float("inf")
    both = _trace(replace(curve, strokes=curve.strokes.extended(strokes)), state)
    if (
        both is None
        or both.reading != "pair"
        or both.cost > SURE_PAIR
        or (rest and both.rest >= rest)
        or _is_chance(both, state)
    ):
        return float("inf")
    return both.cost


def shares_lines(curve: Curve, strokes: tuple[Stroke, ...], state: SymmetryState) -> bool:
    """Return whether new strokes cross epipolar lines that ink of a curve in their view crosses.

    What comes nowhere nearer to its lines than a pair may cost is no second side of it. That is
    known at once, where matching the two takes some hundredths of a second. Ink in other views says
    nothing: it shares other lines.
    """
    camera = strokes[0].camera
    drawn = [on_canvas(s, camera) for s in curve.strokes if is_one_view(camera, s.camera)]
    if len(drawn) < len(curve.strokes):
        return True
    stereo = Stereo.of(camera, state.plane)
    old, new = (
        [Signal.of(stereo, resample(stroke.points, count=LOOKS)) for stroke in ink]
        for ink in (drawn, strokes)
    )
    return any(_apart(one, two.shifted(stereo, one)) <= SURE_PAIR for one in old for two in new)


def _apart(one: Signal, two: Signal) -> float:
    """Return the least distance of the epipolar lines of two strokes, px; negative: shared."""
    gap = max(two.angles.min() - one.angles.max(), one.angles.min() - two.angles.max())
    return float(gap) * float(min(one.scales.min(), two.scales.min()))


def _is_chance(pair: Trace, state: SymmetryState) -> bool:
    """Return whether two straight lines match only along a stretch, as any two of them do."""
    if len(pair.views) > 1 or not all(_is_straight(side.pixels) for side in pair.views[0].sides):
        return False
    found = pair.views[0].reader.read("pair", state.bounds)[0].pairing
    if found is None:
        return False
    share, most = LEFT_OUT
    sides = zip(pair.views[0].sides, found.coverage, strict=True)
    return any((1.0 - met) > max(share, most / length_of(side.pixels)) for side, met in sides)


def _is_straight(line: Array) -> bool:
    off = distances_to_polyline(line, line[[0, -1]])
    most, share = STRAIGHT
    chord = float(np.linalg.norm(line[-1] - line[0]))
    return float(np.sqrt(np.mean(off**2))) < max(most, share * chord)


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
