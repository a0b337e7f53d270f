"""Loop: a touch inside an area switches its surface on or off."""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto.errors import UserError
from bozzetto.plugin import Context, Gesture, NextStep, Tap, override
from bozzetto.scene import Layer, Scene
from bozzetto_product.loops.picking import loops_at
from bozzetto_product.model.patches import Patch
from bozzetto_product.model.state import ProductState
from bozzetto_product.network.net import Loop, Net
from bozzetto_product.network.outlines import rim_edges
from bozzetto_product.solve.found_patches import found_loops, switched
from bozzetto_product.solve.solver import loops_of_patch, net_of_state
from bozzetto_product.tools.product_tool import ProductTool, has_curves, standing
from bozzetto_product.view.scene import LOOP_TOOL, edge_lines

NO_LOOP: Final = "Draw curves that enclose an area first: it gets a surface by itself."

LIT: Final = 6.0
"""Width of the light on the loop that is meant, px."""

_NONE: Final = (
    "No loop of curves runs round this place. Touch inside an area that curves enclose; draw or "
    "join what is missing."
)


class SwitchLoop(ProductTool):
    """Switches the surface of the area under the pen; a further touch takes another loop."""

    id = LOOP_TOOL
    title = "Loop"
    icon = "icons/loop.svg"
    hint = "Touch inside an area to switch its surface on or off."
    gesture = "tap"
    hovers = True

    @override
    def next_step(self, state: ProductState) -> NextStep:
        """Return the gesture, and what the lit edges are; where there is no curve, that first."""
        if not has_curves(state):
            return NextStep(NO_LOOP, tool="draw")
        if not state.of_kind(Patch):
            return NextStep(self.hint)
        return NextStep(f"{self.hint} Edges with a light have a surface on one side only.")

    @override
    @standing
    def preview(self, state: ProductState, gesture: Gesture, context: Context) -> Scene:
        """Return the loop that a touch would mean, lit."""
        if not isinstance(gesture, Tap):
            return Scene()
        net = net_of_state(state)
        meant = _meant(state, net, gesture)
        if meant is None:
            return Scene()
        edges = [net.edges[edge] for edge, _ in meant]
        return Scene((Layer("lit", (edge_lines(edges, "accent", LIT, 0.55),)),))

    @override
    @standing
    def tap(self, state: ProductState, tap: Tap, context: Context) -> ProductState:
        """Switch the surface under the pen.

        Where the place has a surface, that goes; else the likeliest loop round it comes, and after
        one that was switched off the next.

        Raises
        ------
        UserError
            If no loop runs round the place.
        """
        net = net_of_state(state)
        meant = _meant(state, net, tap)
        if meant is None:
            raise UserError(_NONE)
        return switched(state, net, meant)


def _candidates(state: ProductState, net: Net, tap: Tap) -> list[Loop]:
    rays = tap.camera.rays(np.array([[tap.x, tap.y]]))
    return list(loops_at(net, found_loops(state, net), rays.origins[0], rays.directions[0]))


def _meant(state: ProductState, net: Net, tap: Tap) -> Loop | None:
    """Return the loop that a touch means: one with a surface, else the next not rejected."""
    row = _candidates(state, net, tap)
    if not row:
        return None
    loops = (loop for patch in state.of_kind(Patch) for loop in loops_of_patch(net, patch))
    own = {rim_edges(net, loop) for loop in loops}
    if rim_edges(net, row[0]) in own:
        return row[0]
    rejected = _rejected_edges(state, net)
    taken = own | rejected
    return next((loop for loop in row if rim_edges(net, loop) not in taken), row[0])


def _rejected_edges(state: ProductState, net: Net) -> set[frozenset[int]]:
    patches = [Patch(boundary=boundary) for boundary in state.rejected]
    return {rim_edges(net, loop) for patch in patches for loop in loops_of_patch(net, patch)}
