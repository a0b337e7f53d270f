"""Sketch over: a stroke over the outline of a part replaces its nearest stretch."""

from __future__ import annotations

from typing import Literal

from bozzetto.errors import UserError
from bozzetto.plugin import Context, Gesture, Ink
from bozzetto.scene import Scene
from bozzetto_silhouette.ink.oversketch import ring_drawn_over
from bozzetto_silhouette.model.state import Oversketch, SilhouetteState
from bozzetto_silhouette.tools.erase import erased
from bozzetto_silhouette.tools.outline_edits import edited_part, preview_of
from bozzetto_silhouette.tools.posing_hints import TellsOfJoints

__all__ = ["SketchOver"]


class SketchOver(TellsOfJoints):
    """An open stroke replaces a piece of the outline, a closed one all of a ring."""

    id = "oversketch"
    title = "Sketch over"
    icon = "icons/oversketch.svg"
    hint = "Draw a piece of the outline anew, from the line back to the line."
    gesture: Literal["ink", "tap", "drag"] = "ink"

    def preview(self, state: SilhouetteState, gesture: Gesture, context: Context) -> Scene:
        """The outline that would come."""
        return preview_of(state, gesture, ring_drawn_over, Oversketch)

    def apply(self, state: SilhouetteState, gesture: Gesture, context: Context) -> SilhouetteState:
        """Change the outline of the part that the ink is over.

        Raises
        ------
        UserError
            If no outline is near, or the new one crosses itself.
        """
        if not isinstance(gesture, Ink):
            raise UserError("Draw over the outline with the pen.")
        if gesture.strokes[-1].tool == "eraser":
            return erased(state, gesture.strokes[-1])
        for stroke in gesture.strokes:
            state = state.with_node(edited_part(state, stroke, ring_drawn_over, Oversketch))
        return state
