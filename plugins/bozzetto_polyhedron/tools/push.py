"""Draw a loop or a circle on a face, then drag it in, out or through; drag edges wider."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import Unfinished, UserError
from bozzetto.ink import Stroke, Strokes
from bozzetto.plugin import Context, Drag, Gesture, Ink, NextStep, Tap, override
from bozzetto.scene import Scene
from bozzetto_polyhedron.drawing_on.push import dragged_depth
from bozzetto_polyhedron.model.changes import EdgeChange, Push
from bozzetto_polyhedron.model.state import Body, PolyhedronState
from bozzetto_polyhedron.solve.changes import loop_of, outline_of
from bozzetto_polyhedron.solve.open_faces import is_open
from bozzetto_polyhedron.solve.picking import solids_in
from bozzetto_polyhedron.solve.pipeline import changed_until, with_change
from bozzetto_polyhedron.tools.chamfer import rounded
from bozzetto_polyhedron.tools.erase import ErasingTool
from bozzetto_polyhedron.view.loops import (
    HANDLE,
    WIDTH_HANDLE,
    edge_in_model,
    loop_in_model,
)
from bozzetto_polyhedron.view.scene import scene_after

FIRST_DEPTH: Final = 0.25
"""Depth of a loop that was just drawn, in its own extent: enough to be seen and taken hold of."""

SMALL: Final = 1e-3
"""Depth, in the extent of the loop, below which it lies flat again."""


class DrawOnFace(ErasingTool):
    """A closed loop or a circle on a face becomes a boss, which can be pushed in as well."""

    id = "loop"
    title = "Draw on a face"
    icon = "icons/loop.svg"
    group = "Faces"
    hint = "Draw a closed loop or a circle on a face of a solid."

    @override
    def draw(self, state: PolyhedronState, ink: Ink, context: Context) -> PolyhedronState:
        """Add a loop on the face that is seen under it."""
        problem: UserError | None = None
        for body in solids_in(state):
            try:
                return _with_loop(state, body, ink.strokes)
            except UserError as found:
                problem = problem or found
        if problem is None:
            raise UserError("There is no solid to draw on. Turn a drawing into one first.")
        if not ink.committed and len(ink.strokes) < 12:
            raise Unfinished("Draw on until the loop closes on one face.") from problem
        raise problem

    @override
    def next_step(self, state: PolyhedronState) -> NextStep:
        """Return the hint; after a loop, that it can be dragged."""
        if not solids_in(state):
            return NextStep("Turn a drawing into a solid first.", tool="turn")
        if state.chosen_of(Push) is not None:
            return NextStep("Take “Push or pull” and drag its dot in or out.", tool=PushLoop.id)
        return NextStep(self.hint)


class PushLoop(ErasingTool):
    """Loops on faces have a dot that takes them in and out, changed edges one that widens them."""

    id = "push"
    title = "Push or pull"
    icon = "icons/push.svg"
    group = "Faces"
    hint = "Drag the dot of a loop in or out; touch it to cut through."
    gesture = "drag"

    @override
    def drag(self, state: PolyhedronState, drag: Drag, context: Context) -> PolyhedronState:
        """Give the loop whose dot is dragged another depth."""
        for push in state.shown(Push):
            if drag.handle == HANDLE + push.id:
                return _dragged(state, push, drag)
        for change in state.shown(EdgeChange):
            if drag.handle == WIDTH_HANDLE + change.id:
                return _widened(state, change, drag)
        raise UserError(self.hint)

    @override
    def tap(self, state: PolyhedronState, tap: Tap, context: Context) -> PolyhedronState:
        """Cut the chosen loop through the body, or no longer."""
        push = state.chosen_of(Push)
        if push is None:
            raise UserError(self.hint)
        return state.with_node(replace(push, through=not push.through))

    @override
    def preview(self, state: PolyhedronState, gesture: Gesture, context: Context) -> Scene:
        """Return the body as it would be."""
        return scene_after(self.apply(state, gesture, context), context.sources)


def _with_loop(state: PolyhedronState, body: Body, strokes: tuple[Stroke, ...]) -> PolyhedronState:
    back = body.placement.inverse()
    own = Strokes([s if body.placement.is_identity else s.moved(back) for s in strokes])
    made = changed_until(body, state).body
    push = Push(
        id=state.unused_id(),
        name=state.unused_name("Loop"),
        body=body.id,
        strokes=own,
        outline=outline_of(made, own),
    )
    if push.outline == "circle":
        push = replace(push, name=state.unused_name("Circle"))
    loop = loop_of(made, push)
    if is_open(made, loop.face, body, state):
        raise UserError("This face is open. Close it with “Open face” before you draw on it.")
    extent = _extent(loop.corners)
    return with_change(state, body, replace(push, depth=rounded(FIRST_DEPTH * extent)))


def _dragged(state: PolyhedronState, push: Push, drag: Drag) -> PolyhedronState:
    body = state.node(push.body)
    corners, normal = loop_in_model(state, body, push)
    x, y = (float(value) for value in drag.path.points[-1])
    depth = dragged_depth(drag.camera, normal, corners.mean(axis=0), (x, y))
    depth /= body.placement.scale
    extent = _extent(corners)
    made = replace(
        push, depth=rounded(depth) if abs(depth) > SMALL * extent else 0.0, through=False
    )
    return with_change(state, body, made)


def _widened(state: PolyhedronState, change: EdgeChange, drag: Drag) -> PolyhedronState:
    body = state.node(change.body)
    start, along, per_size = edge_in_model(state, body, change)
    x, y = (float(value) for value in drag.path.points[-1])
    size = dragged_depth(drag.camera, along, start, (x, y)) / per_size / body.placement.scale
    return with_change(state, body, change.sized(max(rounded(size), 0.0)))


def _extent(corners: Array) -> float:
    return float(np.linalg.norm(np.ptp(corners, axis=0)))
