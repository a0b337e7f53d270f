"""Cuts: an open line across the shape, and the smaller side falls away."""

from __future__ import annotations

from dataclasses import replace

from bozzetto.errors import UserError
from bozzetto.ink import Stroke, Strokes, is_closed_gesture, resample
from bozzetto.plugin import Context, Gesture, Ink, override
from bozzetto.scene import Scene
from bozzetto_silhouette.model.sketch_plane import sheet_under
from bozzetto_silhouette.model.state import Cut, Part, SilhouetteState
from bozzetto_silhouette.tools.cut_preview import cut_preview
from bozzetto_silhouette.tools.erasing_tool import ErasingTool
from bozzetto_silhouette.tools.insert_node import check_that_it_carves, insert_node
from bozzetto_silhouette.tools.reflection import (
    reflected_scene,
    reflection_of,
    with_reflected_tool,
)
from bozzetto_silhouette.tools.through_preview import trace_of
from bozzetto_silhouette.view.picking import shape_seen

LOOKS = 96
"""Lines of sight along the line."""


class DrawCut(ErasingTool):
    """An open line cuts straight through; what falls away can be changed afterwards."""

    id = "cut"
    title = "Cut"
    icon = "icons/cut.svg"
    hint = "Draw a line right across the shape; the smaller side falls away."

    @override
    def preview(self, state: SilhouetteState, gesture: Gesture, context: Context) -> Scene:
        """Show where the cut would run, carried on at its ends, and what would fall away."""
        if not isinstance(gesture, Ink):
            return Scene()
        cut = _cut(state, gesture.strokes[-1], context)
        touch = shape_seen(state)
        if touch is None:
            return Scene()
        scene = cut_preview(cut, touch)
        return (
            reflected_scene(scene, reflection_of(cut.sheet, context)) if state.mirrored else scene
        )

    @override
    def draw(self, state: SilhouetteState, ink: Ink, context: Context) -> SilhouetteState:
        """Carve the side of the line that has less volume.

        Raises
        ------
        UserError
            If the line closes, crosses itself, or leaves nothing on one of its sides.
        """
        if len(ink.strokes) > 1:
            raise UserError("A cut is one line. Draw it in one stroke, right across the shape.")
        stroke = ink.strokes[0]
        if _is_hole(state, stroke):
            raise UserError(
                "This line comes back to its start. Draw it right across the shape, or take "
                "the tunnel for a hole."
            )
        cut = _cut(state, stroke, context)
        choices = (cut, replace(cut, side="right"))
        chosen = max(choices, key=lambda one: check_that_it_carves(state, state.with_node(one)))
        done = insert_node(state, chosen, _under(state, stroke))
        if not state.mirrored:
            return done
        return with_reflected_tool(state, done, cut.id, cut.sheet, context)


def _cut(state: SilhouetteState, stroke: Stroke, context: Context) -> Cut:
    return Cut(
        id=state.unused_id(),
        name=state.unused_name("Cut"),
        strokes=Strokes((stroke,)),
        sheet=sheet_under(stroke, context),
        surface="straight",
        operation="carve",
        blend=0.0,
        side="left",
    )


def _under(state: SilhouetteState, stroke: Stroke) -> list[Part]:
    """Return the parts that a line is drawn over."""
    touch = shape_seen(state)
    if touch is None:
        return []
    line = resample(stroke.points, count=LOOKS)
    return trace_of(touch, line, stroke.camera).parts(state)


def _is_hole(state: SilhouetteState, stroke: Stroke) -> bool:
    """Whether a line comes back to its start on the shape; beside it, it is a slot."""
    touch = shape_seen(state)
    if touch is None or not is_closed_gesture(stroke.points):
        return False
    return bool(touch.under(stroke.points[[0, -1]], stroke.camera).hit.any())
