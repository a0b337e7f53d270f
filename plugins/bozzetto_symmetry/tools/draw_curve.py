"""Draw curves: one side and then the other, or one stroke across the centre plane."""

from __future__ import annotations

from contextlib import suppress
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from bozzetto.errors import UserError
from bozzetto.ink import arc_length
from bozzetto.plugin import Context, Gesture, Ink, Memory, NextStep, Tool, override
from bozzetto.scene import Layer, Lines, Scene
from bozzetto_symmetry.ink.same_view import is_one_view, on_canvas
from bozzetto_symmetry.model.state import Curve, SymmetryState
from bozzetto_symmetry.operations.assign_stroke import add_strokes, waits
from bozzetto_symmetry.solve.curve_solver import trace_of
from bozzetto_symmetry.stereo.mirror_camera import MIRROR
from bozzetto_symmetry.tools.erase import erase
from bozzetto_symmetry.view.box import segments
from bozzetto_symmetry.view.hints import FIRST, next_step
from bozzetto_symmetry.view.live_preview import GrowingCurve

LIVE_WIDTH: Final = 2.5
"""Width of a curve that grows, px."""

RUNGS: Final = 16
"""Rungs over a curve that is as long as the box's diagonal."""

MOST_RUNGS: Final = 2000
"""Rungs of a curve that leaves the box by far, as the pen may at an extreme zoom."""

RUNG_WIDTH, RUNG_OPACITY = 1.2, 0.6
"""Width in px and opacity 0 … 1: rungs are seen over the grid of the centre plane."""

Array = NDArray[np.float64]

_growing: Memory[GrowingCurve] = Memory(limit=4)


class DrawCurve(Tool[SymmetryState]):
    """Draws left and right in any order, over and over, or across in one stroke."""

    id = "draw"
    title = "Draw curve"
    icon = "icons/draw.svg"
    hint = FIRST
    gesture: Literal["ink", "tap", "drag"] = "ink"

    @override
    def next_step(self, state: SymmetryState) -> NextStep:
        """Return what the chosen curve was read as, what is wrong with it, and what comes next."""
        return NextStep(next_step(state))

    def preview(self, state: SymmetryState, gesture: Gesture, context: Context) -> Scene:
        """Return the curve in space that grows while its second side is drawn.

        On the sheet the curve lies on the ink; that it is in space is seen by the rungs from
        each of its places to the mirrored one. They replace what is shown of the first
        side alone.
        """
        if not isinstance(gesture, Ink) or gesture.strokes[-1].tool == "eraser":
            return Scene()
        points = _grown(state, gesture)
        if points is None or len(points) < 2:
            return Scene()
        place = state.plane.placement
        sides = ((points, "accent"), (points * MIRROR, "second"))
        lines = (
            Lines(
                place.points(side).astype(np.float32), color=color, width=LIVE_WIDTH, hidden="show"
            )
            for side, color in sides
        )
        ends = rungs(points, state.diagonal / RUNGS)
        pairs = place.points(ends.reshape(-1, 3)).reshape(-1, 2, 3)
        ladder = segments(pairs, "accent", RUNG_WIDTH, RUNG_OPACITY)
        return Scene((Layer("ghost", (ladder,)), Layer("heat", tuple(lines))))

    def apply(self, state: SymmetryState, gesture: Gesture, context: Context) -> SymmetryState:
        """Add the ink to the curve that it belongs to, or begin a new one.

        Raises
        ------
        UserError
            If the ink is a dot, or there is nothing under the eraser.
        """
        if not isinstance(gesture, Ink):
            raise UserError("Draw a curve with the pen.")
        if gesture.strokes[-1].tool == "eraser":
            return erase(state, gesture.strokes[-1])
        drawn = add_strokes(state, gesture.strokes)
        # Solved here, the curve is remembered when several ask for it at once.
        if drawn.chosen is not None:
            with suppress(UserError):
                trace_of(drawn.chosen, drawn)
        return drawn


def rungs(points: Array, step: float) -> Array:
    """Return straight pieces from places of a curve to their images, first and last included.

    Parameters
    ----------
    points : (n, 3) float
        In the frame of the plane, mm.
    step : float
        About the way between two of them along the curve, mm.

    Returns
    -------
    (k, 2, 3) float
    """
    along = arc_length(points)
    marks = np.linspace(0.0, along[-1], max(2, int(min(along[-1] / step, MOST_RUNGS)) + 1))
    ends = points[np.unique(np.searchsorted(along, marks).clip(max=len(points) - 1))]
    return np.stack((ends, ends * MIRROR), axis=1)


def _grown(state: SymmetryState, gesture: Ink) -> Array | None:
    """Return what has grown from the side that waits in this view; the chosen or the newest one."""
    curves = sorted(reversed(state.shown_curves), key=lambda c: c.id != state.selected)
    for curve in curves:
        points = _grown_from(curve, state, gesture)
        if points is not None:
            return points
    return None


def _grown_from(curve: Curve, state: SymmetryState, gesture: Ink) -> Array | None:
    if not any(is_one_view(gesture.camera, stroke.camera) for stroke in curve.strokes):
        return None
    try:
        trace = trace_of(curve, state)
    except UserError:
        return None
    if not waits(curve, trace):
        return None
    (view,) = (v for v in trace.views if is_one_view(gesture.camera, v.strokes[0].camera))
    drawn = on_canvas(gesture.strokes[-1], view.strokes[0].camera).points
    growing = _growing.recall(
        (view, drawn[:1].tobytes()), lambda: GrowingCurve(view.stereo, view.sides[0].pixels)
    )
    return growing.points(drawn)
