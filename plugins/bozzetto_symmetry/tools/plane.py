"""Plane: touches and a handle set the plane that new curves lie in."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.errors import UserError
from bozzetto.plugin import Context, Drag, Gesture, NextStep, Tap, override
from bozzetto.scene import Layer, Points, Scene
from bozzetto.view import triple
from bozzetto_symmetry.model.axes import along
from bozzetto_symmetry.model.box_grid import grid_step
from bozzetto_symmetry.model.canvas import DrawingPlane
from bozzetto_symmetry.model.state import SymmetryState
from bozzetto_symmetry.operations.drawing_planes import Touched, plane_of_touches, touched
from bozzetto_symmetry.tools.erase import ErasingTool
from bozzetto_symmetry.view.drawing_plane import PLANE_HANDLE, PLANE_TOOL, plane_layers

MOST: Final = 3
"""Places that make a plane; one more begins another plane."""

DOT: Final = 9.0
"""Size of the dot at the place that a touch would take, px."""

_NEXT: Final = (
    "Touch a corner, an edge, a curve or its end: new curves lie in a plane through it.",
    "New curves lie in this plane. Take the pen to draw, touch a second place to turn it there, or "
    "drag its middle.",
    "The plane goes through both places. Take the pen to draw, touch a third one, or drag its "
    "middle.",
    "The plane goes through three places. Take the pen to draw, drag its middle, or touch a place "
    "for another one.",
)


class SetPlane(ErasingTool):
    """Sets the drawing plane: through one, two or three places, and moved along its normal.

    One place gives a plane of the box, and an end of a curve one that holds the curve's tangent;
    of several such planes it is the one that faces the eye most. A second and a third place turn
    it through these.
    """

    id = PLANE_TOOL
    title = "Plane"
    icon = "icons/plane.svg"
    hint = _NEXT[0]
    gesture = "drag"
    hovers = True

    @override
    def next_step(self, state: SymmetryState) -> NextStep:
        """Return what the next touch does."""
        return NextStep(_NEXT[len(state.plane_places)])

    @override
    def preview(self, state: SymmetryState, gesture: Gesture, context: Context) -> Scene:
        """Return the plane as it would be, or the place that a touch would take."""
        if isinstance(gesture, Drag):
            return Scene(plane_layers(self.drag(state, gesture, context)))
        if not isinstance(gesture, Tap):
            return Scene()
        found = touched(state, (gesture.x, gesture.y), gesture.camera, context)
        if found is None:
            return Scene()
        dot = Points(np.array([found.point], np.float32), color="accent", size=DOT)
        return Scene((Layer("lit", (dot,)),))

    @override
    def tap(self, state: SymmetryState, tap: Tap, context: Context) -> SymmetryState:
        """Take one more place.

        Raises
        ------
        UserError
            If nothing is under the pen, or the places do not make a plane.
        """
        found = touched(state, (tap.x, tap.y), tap.camera, context)
        if found is None:
            raise UserError(
                "There is nothing here. Touch a corner or an edge of the box, a curve or a surface."
            )
        known = state.plane_places if len(state.plane_places) < MOST else ()
        # Only the first place says a direction: a second one says it better.
        marks = (*(Touched(place) for place in known), found)
        plane = plane_of_touches(marks, tap.camera)
        places = tuple(mark.point for mark in marks)
        return replace(state, plane_places=places, drawing_plane=plane, lay="plane")

    @override
    def drag(self, state: SymmetryState, drag: Drag, context: Context) -> SymmetryState:
        """Move the plane along its normal, by whole steps of the grid; with Shift by any.

        Raises
        ------
        UserError
            If the handle is none of a plane, or the normal is seen end-on.
        """
        plane = state.drawing_plane
        if plane is None or drag.handle != PLANE_HANDLE:
            raise UserError(self.hint)
        base, normal = np.asarray(plane.point), np.asarray(plane.normal)
        begin, end = drag.path.points[[0, -1]]
        seen, _ = drag.camera.project(base)
        way = along(drag.camera, seen[0] + end - begin, base, normal)
        if way is None:
            raise UserError("The plane faces you. Turn the view, then drag it nearer or farther.")
        if not drag.shift:
            step = grid_step(max(state.size))
            way = step * round(way / step)
        moved = DrawingPlane(triple(base + way * normal), plane.normal)
        return replace(state, drawing_plane=moved, lay="plane")
