"""Smooth: rubbing along the outline of a part takes corners and ripples away."""

from __future__ import annotations

from typing import Literal

from bozzetto.errors import UserError
from bozzetto.plugin import Context, Gesture, Ink
from bozzetto.scene import Scene
from bozzetto_silhouette.ink.ring_smoothing import rubbed_ring
from bozzetto_silhouette.model.state import SilhouetteState, Smoothing
from bozzetto_silhouette.tools.erase import erased
from bozzetto_silhouette.tools.outline_edits import edited_part, preview_of
from bozzetto_silhouette.tools.posing_hints import TellsOfJoints

__all__ = ["Smooth"]


class Smooth(TellsOfJoints):
    """The stretch under the stroke is smoothed: more where the rub is broad or comes back."""

    id = "smooth"
    title = "Smooth"
    icon = "icons/smooth.svg"
    hint = "Rub along the outline; broad or repeated rubbing smooths more."
    gesture: Literal["ink", "tap", "drag"] = "ink"

    def preview(self, state: SilhouetteState, gesture: Gesture, context: Context) -> Scene:
        """The outline that would come."""
        return preview_of(state, gesture, rubbed_ring, Smoothing)

    def apply(self, state: SilhouetteState, gesture: Gesture, context: Context) -> SilhouetteState:
        """Smooth the outline of the part that was rubbed.

        Raises
        ------
        UserError
            If no outline is near.
        """
        if not isinstance(gesture, Ink):
            raise UserError("Rub along the outline with the pen.")
        if gesture.strokes[-1].tool == "eraser":
            return erased(state, gesture.strokes[-1])
        for stroke in gesture.strokes:
            state = state.with_node(edited_part(state, stroke, rubbed_ring, Smoothing))
        return state
