"""Mirror copies: a tap on a part makes its twin across the plane of symmetry."""

from __future__ import annotations

from dataclasses import replace

from bozzetto.errors import UserError
from bozzetto.plugin import Context, Tap, override
from bozzetto_silhouette.model.state import SilhouetteState
from bozzetto_silhouette.tools.erasing_tool import ErasingTool
from bozzetto_silhouette.tools.reflection import reflections, twin_of, with_twin
from bozzetto_silhouette.view.picking import touched_part


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
        images = reflections(context)
        twins = (twin_of(state, part, image) for image in (images[1:] if tap.shift else images))
        twin = next((twin for twin in twins if twin is not None), None)
        if twin is None:
            raise UserError(
                "This part is its own mirror image. Move it to one side, then mirror it."
            )
        return replace(with_twin(state, part, twin), selected=twin.id)
