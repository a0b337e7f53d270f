"""A touch on a face leaves it out, as of a box without a lid; another touch closes it again."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bozzetto.errors import UserError
from bozzetto.plugin import Context, Gesture, NextStep, Tap, override
from bozzetto.scene import Scene
from bozzetto_polyhedron.drawing_on.body_hits import face_under
from bozzetto_polyhedron.model.state import Body, Opening, PolyhedronState
from bozzetto_polyhedron.solid.planar_body import PlanarBody
from bozzetto_polyhedron.solve.open_faces import is_open, name_of, open_by, opened, top_of
from bozzetto_polyhedron.solve.picking import solids_in
from bozzetto_polyhedron.solve.pipeline import changed_until
from bozzetto_polyhedron.tools.erase import ErasingTool
from bozzetto_polyhedron.view.scene import scene_after


class OpenFace(ErasingTool):
    """Faces left out and closed again, one by one."""

    id = "open"
    title = "Open face"
    icon = "icons/open.svg"
    group = "Faces"
    hint = "Touch a face to leave it out, as of a box without a lid. Touch it again to close it."
    gesture = "tap"
    hovers = True

    @override
    def tap(self, state: PolyhedronState, tap: Tap, context: Context) -> PolyhedronState:
        """Leave out the face that is touched, or close it where it is open."""
        for body in solids_in(state):
            made = changed_until(body, state).body
            camera = tap.camera.moved(body.placement.inverse())
            hit = face_under(made, camera, np.array([tap.x, tap.y]))
            if hit is None:
                continue
            if is_open(made, hit[1], body, state):
                return _closed(state, body, made, hit[1])
            return _opened(state, body, made, hit[1])
        raise UserError("There is no face here. Touch a face of a solid.")

    @override
    def preview(self, state: PolyhedronState, gesture: Gesture, context: Context) -> Scene:
        """Return the body as it would be."""
        return scene_after(self.apply(state, gesture, context), context.sources)

    @override
    def next_step(self, state: PolyhedronState) -> NextStep:
        """Return the hint, what comes before, or how an open solid becomes one that prints."""
        bodies = solids_in(state)
        if not bodies:
            return NextStep("Turn a drawing into a solid first.", tool="turn")
        body = bodies[0]
        if body.wall == 0.0 and (body.lid == "open" or state.openings_of(body)):
            return NextStep(
                "To print what is open, choose “Sheet or solid”: faces get a thickness."
            )
        return NextStep(self.hint)


def _opened(state: PolyhedronState, body: Body, made: PlanarBody, face: int) -> PolyhedronState:
    place, normal = name_of(made, face)
    after = state.with_node(
        Opening(
            id=state.unused_id(),
            name=state.unused_name("Open face"),
            body=body.id,
            place=place,
            normal=normal,
        )
    )
    opened(made, body, after)
    return after


def _closed(state: PolyhedronState, body: Body, made: PlanarBody, face: int) -> PolyhedronState:
    known = [each.id for each in open_by(made, face, state.openings_of(body))]
    if body.lid == "open" and face == top_of(made, body):
        body = replace(body, lid="closed")
    return state.without_nodes(*known).with_node(body)
