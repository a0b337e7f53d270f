"""Cuts: an open line across the shape, and the smaller side falls away."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

from bozzetto.errors import UserError
from bozzetto.ink import Stroke, Strokes
from bozzetto.ink.closing import is_closed_gesture
from bozzetto.plugin import Context, Gesture, Ink
from bozzetto.scene import Scene
from bozzetto_silhouette.sheet import sheet_under
from bozzetto_silhouette.state import Cut, SilhouetteState
from bozzetto_silhouette.tools.carving import check_that_it_carves
from bozzetto_silhouette.touch import shape_seen

__all__ = ["DrawCut"]


class DrawCut:
    """An open line cuts straight through; what falls away can be changed afterwards."""

    id = "cut"
    title = "Cut"
    icon = "icons/cut.svg"
    hint = "Draw a line right across the shape; the smaller side falls away."
    gesture: Literal["ink", "tap", "drag"] = "ink"

    def preview(self, state: SilhouetteState, gesture: Gesture, context: Context) -> Scene:
        """The ink says it all."""
        return Scene()

    def apply(self, state: SilhouetteState, gesture: Gesture, context: Context) -> SilhouetteState:
        """Carve the side of the line that has less volume.

        Raises
        ------
        UserError
            If the line closes, crosses itself, or leaves nothing on one of its sides.
        """
        if not isinstance(gesture, Ink):
            raise UserError("Draw the line of the cut with the pen.")
        if len(gesture.strokes) > 1:
            raise UserError("A cut is one line. Draw it in one stroke, right across the shape.")
        stroke = gesture.strokes[0]
        if _is_hole(state, stroke):
            raise UserError(
                "This line comes back to its start. Draw it right across the shape, or take "
                "the tunnel for a hole."
            )
        cut = Cut(
            id=state.unused_id(),
            name=state.unused_name("Cut"),
            strokes=Strokes((stroke,)),
            sheet=sheet_under(stroke, context),
            surface="straight",
            operation="carve",
            blend=0.0,
            side="left",
        )
        choices = [state.with_node(cut), state.with_node(replace(cut, side="right"))]
        return max(choices, key=lambda choice: check_that_it_carves(state, choice))


def _is_hole(state: SilhouetteState, stroke: Stroke) -> bool:
    """Whether a line comes back to its start on the shape; beside it, it is a slot."""
    touch = shape_seen(state)
    if touch is None or not is_closed_gesture(stroke.points):
        return False
    return bool(touch.under(stroke.points[[0, -1]], stroke.camera).hit.any())
