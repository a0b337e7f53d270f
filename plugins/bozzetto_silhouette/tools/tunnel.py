"""Tunnels: a closed line from any side is cut through everything that it is seen on."""

from __future__ import annotations

from dataclasses import replace

from bozzetto.errors import Unfinished
from bozzetto.ink import Stroke, Strokes, is_one_view
from bozzetto.plugin import Context, Gesture, Ink, override
from bozzetto.scene import Scene
from bozzetto_silhouette.model.sketch_plane import Sheet, sheet_under
from bozzetto_silhouette.model.state import Part, SilhouetteState
from bozzetto_silhouette.model.view_rays import view_rays_through
from bozzetto_silhouette.outline.from_ink import outline_of
from bozzetto_silhouette.tools.draw_outline import meets_itself
from bozzetto_silhouette.tools.erasing_tool import ErasingTool
from bozzetto_silhouette.tools.insert_node import check_that_it_carves, insert_node
from bozzetto_silhouette.tools.reflection import (
    reflected_scene,
    reflection_of,
    with_reflected_tool,
)
from bozzetto_silhouette.tools.through_preview import Trace, trace_through


class DrawTunnel(ErasingTool):
    """A closed outline goes straight through what lies under it; the eraser takes parts away."""

    id = "tunnel"
    title = "Tunnel"
    icon = "icons/tunnel.svg"
    hint = "Draw a closed outline over the shape; it goes straight through, or to a depth."

    @override
    def preview(self, state: SilhouetteState, gesture: Gesture, context: Context) -> Scene:
        """Show where the tunnel goes in and comes out, and lines of sight through it."""
        if not isinstance(gesture, Ink):
            return Scene()
        sheet = sheet_under(gesture.strokes[0], context)
        trace = trace_through(state, gesture.strokes, sheet)
        if trace is None:
            return Scene()
        scene = trace.scene(through=True)
        return reflected_scene(scene, reflection_of(sheet, context)) if state.mirrored else scene

    @override
    def draw(self, state: SilhouetteState, ink: Ink, context: Context) -> SilhouetteState:
        """Carve what is seen inside the outline, near and far.

        Raises
        ------
        Unfinished
            If the ends are far apart and more strokes may come.
        UserError
            If the ink is no outline, or lies beside the shape or all around it.
        """
        if not ink.committed and not meets_itself(ink.strokes):
            raise Unfinished("Go on with the outline, or press Enter to close it.")
        part = Part(
            id=state.unused_id(),
            name=state.unused_name("Tunnel"),
            strokes=Strokes(ink.strokes),
            sheet=sheet_under(ink.strokes[0], context),
            surface="straight",
            operation="carve",
            blend=0.0,
        )
        outline_of(part)
        check_that_it_carves(state, state.with_node(part))
        sheet = part.sheet
        trace = trace_through(state, ink.strokes, sheet)
        if trace is None:
            return state.with_node(part)
        part = replace(part, sheet=_on_surface(sheet, trace, ink.strokes))
        carved = insert_node(state, part, trace.parts(state))
        if not state.mirrored:
            return carved
        return with_reflected_tool(state, carved, part.id, sheet, context)


def _on_surface(sheet: Sheet, trace: Trace, strokes: tuple[Stroke, ...]) -> Sheet:
    """Return the parallel sheet where the outline first meets the shape: depth is from there."""
    camera = strokes[0].camera
    if not trace.hit.any() or not all(is_one_view(stroke.camera, camera) for stroke in strokes):
        return sheet  # elsewhere what was drawn from two sides would not meet
    height = float(((trace.near[trace.hit] - sheet.origin) @ sheet.normal).max())
    _, most = view_rays_through(sheet, camera).before_eye(0.0, height)
    return sheet.at(height) if height <= most else sheet  # an eye in the shape sees no surface
