"""Mirror copies: a tap on a part makes its twin across the plane of symmetry."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bozzetto.errors import UserError
from bozzetto.plugin import Context, Tap, override
from bozzetto_silhouette.model.state import Part, SilhouetteState
from bozzetto_silhouette.solids.part_solid import body_of
from bozzetto_silhouette.tools.arrange import after_motion
from bozzetto_silhouette.tools.erasing_tool import ErasingTool
from bozzetto_silhouette.view.drag_motion import mirrored
from bozzetto_silhouette.view.picking import TOUCHED_CELLS, touched_part

UP = (0.0, 0.0, 1.0)
"""The world's."""

SAME = 0.02
"""Distance between a part and its mirror image below which they are one, as a share of the
part's size: the meshes of two like halves differ by less."""


class MirrorCopy(ErasingTool):
    """A twin across the plane of symmetry, right after the part itself.

    With Shift, and for a part that is its own mirror image there, across the upright plane
    that crosses it: what was drawn from the front has its left and its right.
    """

    id = "mirror"
    title = "Mirror copy"
    icon = "icons/mirror.svg"
    hint = "Tap a part for its mirror image across the plane of symmetry; Shift: left and right."
    gesture = "tap"

    @override
    def tap(self, state: SilhouetteState, tap: Tap, context: Context) -> SilhouetteState:
        """Add the twin.

        Raises
        ------
        UserError
            If there is no part under the pen, or it is its own mirror image.
        """
        part = touched_part(state, tap.x, tap.y, tap.camera)
        if part is None:
            raise UserError("There is no part here. Tap the part whose mirror image you want.")
        point, normal = np.asarray(context.symmetry_point), np.asarray(context.symmetry_normal)
        across = np.cross(normal, UP)
        planes = [across] if tap.shift else [normal, across]
        twins = (
            replace(
                after_motion(state, part, mirrored(point, plane)),
                id=state.unused_id(),
                name=_name_of_twin(state, part),
            )
            for plane in planes
            if np.linalg.norm(plane) > 0.0
        )
        twin = next((twin for twin in twins if not _is_alike(part, twin)), None)
        if twin is None:
            raise UserError(
                "This part is its own mirror image. Move it to one side, then mirror it."
            )
        place = state.nodes.index(part) + 1
        nodes = (*state.nodes[:place], twin, *state.nodes[place:])
        return replace(state, nodes=nodes, selected=twin.id)


def _name_of_twin(state: SilhouetteState, part: Part) -> str:
    """Return the name of a twin, with a number only where it is not the first."""
    name = f"{part.name} mirrored"
    taken = any(node.name == name for node in state.nodes)
    return state.unused_name(name) if taken else name


def _is_alike(part: Part, twin: Part) -> bool:
    """Whether two parts of one group take up the same space."""
    from scipy.spatial import cKDTree

    one, other = (body_of(node, TOUCHED_CELLS).vertices for node in (part, twin))
    gap = np.asarray(cKDTree(one).query(other)[0])
    return bool(gap.max() < SAME * np.ptp(one, axis=0).max())
