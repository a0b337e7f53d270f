"""A touch on a face joins a body with its mirror image in the plane of that face."""

from __future__ import annotations

import numpy as np

from bozzetto.errors import UserError
from bozzetto.plugin import Context, Tap, override
from bozzetto_polyhedron.drawing_on.body_hits import face_under
from bozzetto_polyhedron.drawing_on.named_edges import shares_of
from bozzetto_polyhedron.model.changes import Mirror
from bozzetto_polyhedron.model.state import PolyhedronState
from bozzetto_polyhedron.solve.picking import solids_in
from bozzetto_polyhedron.solve.pipeline import changed_until, with_change
from bozzetto_polyhedron.tools.change_tool import ChangeTool


class MirrorTool(ChangeTool):
    """Mirror images in faces."""

    id = "mirror"
    title = "Mirror"
    icon = "icons/mirror.svg"
    group = "Copies"
    hint = "Touch a face: the solid is mirrored in its plane, and both become one."
    gesture = "tap"
    hovers = True
    makes = Mirror

    @override
    def tap(self, state: PolyhedronState, tap: Tap, context: Context) -> PolyhedronState:
        """Mirror the solid in the face that is touched."""
        for body in solids_in(state):
            camera = tap.camera.moved(body.placement.inverse())
            made = changed_until(body, state).body
            hit = face_under(made, camera, np.array([tap.x, tap.y]))
            if hit is None:
                continue
            corner = made.vertices[made.faces[hit[1]][0][0]]
            x, y, z = (float(value) for value in shares_of(made, corner))
            a, b, c = (float(value) for value in made.normals[hit[1]])
            mirror = Mirror(
                id=state.unused_id(),
                name=state.unused_name("Mirror"),
                body=body.id,
                place=(x, y, z),
                normal=(a, b, c),
            )
            return with_change(state, body, mirror)
        raise UserError("There is no face here. Touch a face of a solid.")
