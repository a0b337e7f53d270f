"""Draw curves: one side and then the other, or one stroke across the centre plane."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.ink import arc_length, is_one_view, on_canvas
from bozzetto.plugin import Context, Gesture, Ink, NextStep, Preview, Tap, override
from bozzetto.scene import Layer, Lines, Scene
from bozzetto.view import Camera
from bozzetto_symmetry.ink.polyline import length_of
from bozzetto_symmetry.model.state import SymmetryState
from bozzetto_symmetry.operations.assign_stroke import add_strokes
from bozzetto_symmetry.operations.canvas_ink import add_in_plane, add_on_surface
from bozzetto_symmetry.operations.drawn_snaps import known_places, with_drawn_snaps
from bozzetto_symmetry.operations.second_sides import waits
from bozzetto_symmetry.operations.snap_targets import Targets, without_own
from bozzetto_symmetry.solve.curve_solver import trace_of
from bozzetto_symmetry.stereo.mirror_camera import MIRROR
from bozzetto_symmetry.tools.erase import ErasingTool
from bozzetto_symmetry.view.box import segments
from bozzetto_symmetry.view.drawing_plane import PLANE_TOOL
from bozzetto_symmetry.view.hints import FIRST, next_step
from bozzetto_symmetry.view.live_preview import GrowingCurve
from bozzetto_symmetry.view.magnets import (
    caught_by,
    guide_layer,
    magnet_layer,
    on_plane,
    tangent_layer,
)

LIVE_WIDTH: Final = 2.5
"""Width of a curve that grows, px."""

RUNGS: Final = 16
"""Rungs over a curve that is as long as the box's diagonal."""

MOST_RUNGS: Final = 2000
"""Rungs of a curve that leaves the box by far, as the pen may at an extreme zoom."""

RUNG_WIDTH, RUNG_OPACITY = 1.2, 0.6
"""Width in px and opacity 0 … 1: rungs are seen over the grid of the centre plane."""


DRAW_ON: Final = {
    "plane": "Draw in the plane: its mirror image comes with it. L leads back to curves in space.",
    "surface": "Draw on the surface of another object. L leads back to curves in space.",
}
NO_PLANE: Final = "No drawing plane is set. Touch a place with the tool “Plane”, or draw in space."


class DrawCurve(ErasingTool):
    """Draws left and right in any order, over and over, or across in one stroke."""

    id = "draw"
    title = "Draw curve"
    icon = "icons/draw.svg"
    hint = FIRST
    hovers = True

    @override
    def next_step(self, state: SymmetryState) -> NextStep:
        """Return what the chosen curve was read as, what is wrong with it, and what comes next."""
        if state.lay == "plane" and state.drawing_plane is None:
            return NextStep(NO_PLANE, tool=PLANE_TOOL)
        chosen = state.chosen
        if state.lay != "space" and (chosen is None or chosen.canvas is None):
            return NextStep(DRAW_ON[state.lay])
        return NextStep(next_step(state))

    @override
    def begin(self, state: SymmetryState, context: Context) -> Preview[SymmetryState]:
        """Return the preview of a curve that grows."""
        return GrowingPreview(self, state, context)

    @override
    def draw(self, state: SymmetryState, ink: Ink, context: Context) -> SymmetryState:
        """Add the ink to the curve that it belongs to, or begin a new one, and snap its ends.

        Raises
        ------
        UserError
            If the ink is a dot, or does not lie on the plane or surface that is asked for.
        """
        plane = state.drawing_plane
        if state.lay == "surface":
            drawn = add_on_surface(state, ink.strokes, context)
        elif state.lay == "plane":
            if plane is None:
                raise UserError(NO_PLANE)
            drawn = add_in_plane(state, ink.strokes, plane)
        else:
            drawn = add_strokes(state, ink.strokes)
        if state.snapping:
            drawn = with_drawn_snaps(drawn, without_own(context, state))
        elif drawn.chosen is not None:
            drawn = drawn.with_node(replace(drawn.chosen, settles=False))
        # Solved here, the curve is remembered when several ask for it at once.
        if drawn.chosen is not None:
            with suppress(UserError):
                trace_of(drawn.chosen, drawn)
        return drawn


class GrowingPreview(Preview[SymmetryState]):
    """The curve in space that grows while its second side is drawn.

    On the sheet the curve lies on the ink; that it is in space is seen by the rungs from
    each of its places to the mirrored one. They replace what is shown of the first side alone.
    """

    _side: tuple[Camera, GrowingCurve] | None = None
    _is_known = False
    _places: Targets | None = None

    @override
    def update(self, gesture: Gesture) -> Scene:
        """Return what has grown, with its mirror image, and what the pen is caught by."""
        if isinstance(gesture, Tap):
            return Scene(self._magnets(gesture.camera, np.array([[gesture.x, gesture.y]])))
        if not isinstance(gesture, Ink) or gesture.erases:
            return Scene()
        stroke = gesture.strokes[-1]
        grown = self._grown(gesture)
        held = self._magnets(gesture.camera, stroke.points[[0, -1]], grown)
        if self._places is not None:
            held = (*held, *tangent_layer(stroke, self._places, self.context.pen.tolerance))
        if self.state.snapping and self.state.lay == "space":
            held = (*held, *guide_layer(self.state, stroke))
        return Scene(held) + (Scene() if grown is None else _scene_of(self.state, grown))

    def _magnets(
        self, camera: Camera, pixels: Array, grown: Array | None = None
    ) -> tuple[Layer, ...]:
        """Return what holds the pen at some places (n, 2) of the sheet.

        Where nothing does at one of them, the place in space that has grown there may lie on a
        face of the box or on the centre plane; without depth nothing can.
        """
        if not self.state.snapping:
            return ()
        if self._places is None:
            self._places = known_places(self.state, self.context)
        tolerance = self.context.pen.tolerance
        held = [caught_by(pixel, camera, self._places, tolerance) for pixel in pixels]
        if grown is not None:
            ends = self.state.plane.placement.points(grown[[0, -1]])
            held = [
                on_plane(end, camera, self.state) if place is None else place
                for place, end in zip(held, ends, strict=True)
            ]
        return magnet_layer(held)

    def _grown(self, ink: Ink) -> Array | None:
        """Return the curve in space so far, (n, 3) mm in the frame of the plane."""
        if self.state.lay != "space":
            return None
        if not self._is_known:
            self._side = _waiting_side(self.state, ink.camera)
            self._is_known = True
        if self._side is None:
            return None
        canvas, growing = self._side
        points = growing.points(on_canvas(ink.strokes[-1], canvas).points)
        return points if len(points) > 1 else None


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


def _scene_of(state: SymmetryState, points: Array) -> Scene:
    place = state.plane.placement
    sides = ((points, "accent"), (points * MIRROR, "second"))
    lines = (
        Lines(place.points(side).astype(np.float32), color=color, width=LIVE_WIDTH, hidden="show")
        for side, color in sides
    )
    ends = rungs(points, state.diagonal / RUNGS)
    pairs = place.points(ends.reshape(-1, 3)).reshape(-1, 2, 3)
    ladder = segments(pairs, "accent", RUNG_WIDTH, RUNG_OPACITY)
    return Scene((Layer("ghost", (ladder,)), Layer("heat", tuple(lines))))


def _waiting_side(state: SymmetryState, camera: Camera) -> tuple[Camera, GrowingCurve] | None:
    """Return the side that waits in a view, and its canvas; of the chosen curve or the newest."""
    for curve in sorted(reversed(state.shown_curves), key=lambda c: c.id != state.selected):
        if not any(is_one_view(camera, stroke.camera) for stroke in curve.strokes):
            continue
        try:
            trace = trace_of(curve, state)
        except UserError:
            continue
        if waits(curve, trace):
            (view,) = (v for v in trace.views if is_one_view(camera, v.strokes[0].camera))
            longest = max(view.sides, key=lambda side: length_of(side.pixels))
            return view.strokes[0].camera, GrowingCurve(view.stereo, longest.pixels)
    return None
