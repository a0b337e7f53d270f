"""Mark the points that are asked for on the sketch; drag marks to correct them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.plugin import Context, Drag, Gesture, Ink, NextStep, Tap, Tool, override
from bozzetto.scene import Scene
from bozzetto.view import Camera
from bozzetto_car.body.body import Body
from bozzetto_car.body.build import body_of
from bozzetto_car.marking.edit_marks import set_mark, sketch_in_work, without_marks
from bozzetto_car.marking.mark_mesh import (
    asked_on_mesh,
    erased_on_mesh,
    marked_on_mesh,
    mesh_in_work,
)
from bozzetto_car.marking.next_mark import ALL_MARKED, HIDDEN, asked_of
from bozzetto_car.marking.points_on_mesh import right_name
from bozzetto_car.solver.pipeline import template_of
from bozzetto_car.state import CarState, Mark
from bozzetto_car.view.mark_items import MARK, MARK_TOOL, mark_preview
from bozzetto_car.view.mesh_items import mesh_layers
from bozzetto_car.view.next_step import next_mark_step
from bozzetto_car.view.view_advice import camera_looked_through, cars_seen

Seen = tuple[CarState, ...]

FARTHEST: Final = 5.0
"""Farthest place beside the picture that can be marked, in its diagonals from its middle."""

REACH: Final = 2.0
"""Distance from a mark, in tolerances of the pen, at which an eraser touches it."""

TOUCH: Final = 2.0
"""Farthest movement of a pen that only touches a mark, px."""

BESIDE: Final = (4.0, 8.0)
"""Least distance, px on the sheet, at which a touch is meant for a place beside a mark and not for
the mark, and the same of the newest mark: a hasty second touch is no next point."""

NOT_THROUGH: Final = (
    "Marks are set where the sketch is seen as it was drawn. Go back to it with T, then touch "
    "the point."
)


class MarkPoints(Tool[CarState]):
    """The tool for marks: a tap marks the node that is asked for, drags move, erasers remove."""

    id = MARK_TOOL
    title = "Mark points"
    icon = "icons/mark.svg"
    hint = "Drop a sketch on the sheet, then touch each point that is asked for."
    gesture = "drag"
    aims = True

    @override
    def next_step(self, state: CarState) -> NextStep:
        """Return which point to touch, in the template's words, and where it is expected."""
        return next_mark_step(state)

    @override
    def preview(self, state: CarState, gesture: Gesture, context: Context) -> Scene:
        """Show the car with the mark, on the picture."""
        if isinstance(gesture, Ink):
            return Scene()
        if state.mesh is not None:
            return Scene(mesh_layers(_on_mesh(state, gesture)))
        before = body_of(state)
        mark = _mark(state, before, gesture, cars_seen(context))
        moved = set_mark(state, mark.node, (mark.u, mark.v), before.template)
        after = body_of(moved, before=state)
        return mark_preview(before, after, moved, _same_mark(mark, sketch_in_work(moved).marks))

    @override
    def erase(self, state: CarState, ink: Ink, context: Context) -> CarState:
        """Remove the marks that the eraser runs over.

        Raises
        ------
        UserError
            If there is none under it.
        """
        if state.mesh is not None:
            return erased_on_mesh(state, ink.strokes, REACH * context.pen.tolerance)
        return _erased(state, _seen_body(state), ink, context.pen.tolerance)

    @override
    def tap(self, state: CarState, tap: Tap, context: Context) -> CarState:
        """Set the mark that is asked for.

        Raises
        ------
        UserError
            If there is nothing to mark, or the sketch is not seen as it was drawn.
        """
        if state.mesh is not None:
            return _on_mesh(state, tap)
        return _marked(state, _seen_body(state), tap, context)

    @override
    def drag(self, state: CarState, drag: Drag, context: Context) -> CarState:
        """Move a mark; a touch on it changes nothing, one beside it sets the next mark.

        Raises
        ------
        UserError
            If the handle is no mark, or the sketch is not seen as it was drawn.
        """
        if state.mesh is not None:
            return _dragged_on_mesh(state, drag)
        body = _seen_body(state)
        if not _is_touch(drag):
            return _marked(state, body, drag, context)
        if not _is_beside(state, body, drag, cars_seen(context)):
            return state
        x, y = drag.path.points[0].tolist()
        return _marked(state, body, Tap(x, y, drag.camera), context)


def _dragged_on_mesh(state: CarState, drag: Drag) -> CarState:
    """Return the state with a point of a mesh moved, or the next one set by a touch beside it."""
    if not _is_touch(drag):
        return _on_mesh(state, drag)
    points = mesh_in_work(state).points
    held = (one for point in points for one in point.on_both_sides())
    place = next((place for node, place in held if f"{MARK}{node}" == drag.handle), None)
    if place is None or asked_on_mesh(state) is None:
        return state
    is_newest = right_name(template_of(state), drag.handle.removeprefix(MARK)) == points[-1].node
    x, y = drag.path.points[0].tolist()
    off = float(np.linalg.norm(drag.camera.project(place)[0][0] - (x, y)))
    return state if off < BESIDE[is_newest] else _on_mesh(state, Tap(x, y, drag.camera))


def _on_mesh(state: CarState, gesture: Tap | Drag) -> CarState:
    """Return the state with the point that a gesture on the mesh of a car sets or moves."""
    if isinstance(gesture, Drag):
        node, at = gesture.handle.removeprefix(MARK), gesture.path.points[-1]
        return marked_on_mesh(state, node, gesture.camera, at)
    return marked_on_mesh(
        state, asked_on_mesh(state), gesture.camera, np.array([gesture.x, gesture.y])
    )


def _seen_body(state: CarState) -> Body:
    """Return the body under the sketch in work.

    Raises
    ------
    UserError
        If that sketch is hidden.
    """
    body = body_of(state)
    if sketch_in_work(state).id not in body.sketch_cameras:
        raise UserError(HIDDEN)
    return body


def _marked(state: CarState, body: Body, gesture: Tap | Drag, context: Context) -> CarState:
    mark = _mark(state, body, gesture, cars_seen(context))
    return set_mark(state, mark.node, (mark.u, mark.v), template_of(state))


def _mark(state: CarState, body: Body, gesture: Tap | Drag, seen: Seen) -> Mark:
    """Return the mark that a gesture sets."""
    sketch = sketch_in_work(state)
    if isinstance(gesture, Drag):
        node = gesture.handle.removeprefix(MARK)
        at = gesture.path.points[-1]
        if sketch.mark_of(node) is None:
            raise UserError("Touch the point that is asked for, or drag a mark.")
    else:
        asked = asked_of(state, body.solved)
        if asked is None:
            raise UserError(ALL_MARKED)
        node, at = asked.node, np.array([gesture.x, gesture.y])
    ((u, v),) = _pixels(state, body, gesture.camera, [at], seen).tolist()
    return Mark(node, u, v)


def _is_touch(gesture: Drag) -> bool:
    """Whether a mark was touched, and not moved."""
    path = gesture.path.points
    return float(np.abs(path - path[0]).max()) < TOUCH


def _is_beside(state: CarState, body: Body, drag: Drag, seen: Seen) -> bool:
    """Whether a touch that met the handle of a mark is meant for another point beside it."""
    sketch = sketch_in_work(state)
    touched = sketch.mark_of(drag.handle.removeprefix(MARK))
    sketch_camera = camera_looked_through(sketch, body, drag.camera, seen)
    if touched is None or sketch_camera is None or asked_of(state, body.solved) is None:
        return False
    shown = drag.camera.project(sketch_camera.lifted([(touched.u, touched.v)]))[0][0]
    least = BESIDE[touched is sketch.marks[-1]]
    return float(np.linalg.norm(drag.path.points[0] - shown)) >= least


def _pixels(
    state: CarState, body: Body, camera: Camera, places: Sequence[Array], seen: Seen
) -> Array:
    """Return pixels of the picture at places of a view through it.

    Raises
    ------
    UserError
        If the view is from elsewhere, or a place is far beside the picture.
    """
    sketch = sketch_in_work(state)
    sketch_camera = camera_looked_through(sketch, body, camera, seen)
    if sketch_camera is None:
        raise UserError(NOT_THROUGH)
    pixels = sketch_camera.seen_at(camera, places)
    off = np.abs(pixels - 0.5 * np.array(sketch.size)).max(initial=0.0)
    if not off <= FARTHEST * np.hypot(*sketch.size):
        raise UserError("That is far beside the picture. Touch a place on it or next to it.")
    return pixels


def _same_mark(mark: Mark, marks: tuple[Mark, ...]) -> Mark:
    """Return a mark with its node after it is set: that may have exchanged the sides."""
    return next(one for one in marks if (one.u, one.v) == (mark.u, mark.v))


def _erased(state: CarState, body: Body, gesture: Ink, tolerance: float) -> CarState:
    """Return the state without the marks that an eraser ran over."""
    sketch = sketch_in_work(state)
    sketch_camera = body.sketch_cameras[sketch.id]
    places = sketch_camera.lifted(
        np.array([(mark.u, mark.v) for mark in sketch.marks]).reshape(-1, 2)
    )
    met = set()
    for stroke in gesture.strokes:
        seen = stroke.camera.project(places)[0]
        near = np.linalg.norm(seen[:, None] - stroke.points, axis=2).min(axis=1)
        touched = np.flatnonzero(near <= REACH * tolerance)
        met |= {sketch.marks[number].node for number in touched.tolist()}
    if not met:
        raise UserError("There is no mark under the eraser. Rub over a mark to take it away.")
    return without_marks(state, met)
