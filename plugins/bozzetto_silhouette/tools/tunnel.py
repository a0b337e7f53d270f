"""Tunnels: a closed line from any side is cut through everything that it is seen on."""

from __future__ import annotations

from typing import Literal

from bozzetto.errors import Unfinished, UserError
from bozzetto.ink import Strokes
from bozzetto.plugin import Context, Gesture, Ink
from bozzetto.scene import Scene
from bozzetto_silhouette.ink_to_outline import outline_of
from bozzetto_silhouette.sheet import sheet_under
from bozzetto_silhouette.state import Part, SilhouetteState
from bozzetto_silhouette.tools.carving import check_that_it_carves
from bozzetto_silhouette.tools.draw import meets_itself

__all__ = ["DrawTunnel"]


class DrawTunnel:
    """A closed outline goes straight through what lies under it."""

    id = "tunnel"
    title = "Tunnel"
    icon = "icons/tunnel.svg"
    hint = "Draw a closed outline over the shape; it goes straight through."
    gesture: Literal["ink", "tap", "drag"] = "ink"

    def preview(self, state: SilhouetteState, gesture: Gesture, context: Context) -> Scene:
        """The ink says it all."""
        return Scene()

    def apply(self, state: SilhouetteState, gesture: Gesture, context: Context) -> SilhouetteState:
        """Carve what is seen inside the outline, near and far.

        Raises
        ------
        Unfinished
            If the ends are far apart and more strokes may come.
        UserError
            If the ink is no outline, or lies beside the shape or all around it.
        """
        if not isinstance(gesture, Ink):
            raise UserError("Draw the outline of the tunnel with the pen.")
        if not gesture.committed and not meets_itself(gesture.strokes):
            raise Unfinished("Go on with the outline, or press Enter to close it.")
        part = Part(
            id=state.unused_id(),
            name=state.unused_name("Tunnel"),
            strokes=Strokes(gesture.strokes),
            sheet=sheet_under(gesture.strokes[0], context),
            surface="straight",
            operation="carve",
            blend=0.0,
        )
        outline_of(part)
        carved = state.with_node(part)
        check_that_it_carves(state, carved)
        return carved
