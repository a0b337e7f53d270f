"""Whether new ink is the second side of a curve that waits for one."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.ink import Stroke, distances_to_polyline, is_one_view, on_canvas, resample
from bozzetto.view import Camera
from bozzetto_symmetry.ink.polyline import length_of
from bozzetto_symmetry.model.state import Curve, SymmetryState
from bozzetto_symmetry.solve.curve_solver import Trace, View, trace_if_any
from bozzetto_symmetry.stereo.epipolar_signal import Signal
from bozzetto_symmetry.stereo.mirror_camera import Stereo

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
    trace = None if state.chosen is None else trace_if_any(state.chosen, state)
    if state.chosen is None or trace is None or trace.reading != "half":
        return None
    return state.chosen.strokes[-1].camera


def as_pair(
    curve: Curve, strokes: tuple[Stroke, ...], state: SymmetryState, rest: float
) -> Trace | None:
    """Return a waiting curve with new strokes as its second side; None: they are none.

    A whole side also waits for its mirror image in another view. Where only a part of a side waits,
    they must leave less of it waiting, in its own view.
    """
    here = any(is_one_view(strokes[0].camera, stroke.camera) for stroke in curve.strokes)
    if (rest and not here) or not shares_lines(curve, strokes, state):
        return None
    both = trace_if_any(replace(curve, strokes=curve.strokes.extended(strokes)), state)
    if (
        both is None
        or both.reading != "pair"
        or both.cost > SURE_PAIR
        or (rest and both.rest >= rest)
        or (len(both.views) == 1 and is_chance(both.views[0], state))
    ):
        return None
    return both


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


def is_chance(view: View, state: SymmetryState) -> bool:
    """Return whether two straight lines match only along a stretch, as any two of them do."""
    if not all(_is_straight(side.pixels) for side in view.sides):
        return False
    found = view.reader.read("pair", state.bounds)[0].pairing
    if found is None:
        return False
    share, most = LEFT_OUT
    sides = zip(view.sides, found.coverage, strict=True)
    return any((1.0 - met) > max(share, most / length_of(side.pixels)) for side, met in sides)


def _is_straight(line: Array) -> bool:
    off = distances_to_polyline(line, line[[0, -1]])
    most, share = STRAIGHT
    chord = float(np.linalg.norm(line[-1] - line[0]))
    return float(np.sqrt(np.mean(off**2))) < max(most, share * chord)
