"""Shape nodes and tangents by hand: drag nodes, touch them to show their tangents."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.plugin import Context, Drag, Gesture, NextStep, Tap, Tool, override
from bozzetto.scene import Scene
from bozzetto.view import triple
from bozzetto_car.body.body import Body
from bozzetto_car.body.build import body_in_work, body_of, world_of
from bozzetto_car.body.drag import drag_handle, drag_node
from bozzetto_car.body.edit_list import add_drag
from bozzetto_car.state import BentEdge, CarState, MovedNode
from bozzetto_car.template.network import edge_called, node_called
from bozzetto_car.view.edge_items import NODE, SHAPE_TOOL, TANGENT
from bozzetto_car.view.picking import touched
from bozzetto_car.view.scene import body_layers

STILL: Final = 3.0
"""Movement of the pen, px, below which a handle is touched and not dragged."""


class ShapeNodes(Tool[CarState]):
    """The tool for nodes and tangents: nodes move parallel to the picture, handles bend edges.

    Smooth neighbours follow. A touch on a node or an edge reveals its tangents. Successive drags
    of one handle are one edit.
    """

    id = SHAPE_TOOL
    title = "Nodes and tangents"
    icon = "icons/nodes.svg"
    hint = "Drag a node. Touch a node or an edge for its tangents, and drag their ends."
    gesture = "drag"

    @override
    def next_step(self, state: CarState) -> NextStep:
        """Return what the visible handles do."""
        if not state.revealed:
            return NextStep(self.hint)
        return NextStep(f"Drag the tangents of {state.revealed}, or touch another node or edge.")

    @override
    def preview(self, state: CarState, gesture: Gesture, context: Context) -> Scene:
        """Show the body after the drag."""
        if not isinstance(gesture, Drag):
            return Scene()
        made = self.drag(state, gesture, context)
        return Scene(tuple(body_layers(made, body_of(made), gesture.camera)))

    @override
    def tap(self, state: CarState, tap: Tap, context: Context) -> CarState:
        """Reveal the tangents of what is touched.

        Raises
        ------
        UserError
            If there is no body yet.
        """
        name = touched(body_in_work(state).network, (tap.x, tap.y), tap.camera)
        return replace(state, revealed=name)

    @override
    def drag(self, state: CarState, drag: Drag, context: Context) -> CarState:
        """Move a node, or bend an edge; of a handle that is only touched, reveal the tangents.

        Raises
        ------
        UserError
            If there is no body yet, or the handle does not belong to it or is behind the eye.
        """
        body = body_in_work(state)
        if np.ptp(drag.path.points, axis=0).max() < STILL:
            return replace(state, revealed=_touched_handle(state, drag.handle))
        edit = _edit_of(state, body, drag)
        return replace(state, edits=add_drag(state.edits, edit))


def _touched_handle(state: CarState, handle: str) -> str:
    """Return what is revealed after a touch: the node's tangents; revealed tangents stay."""
    return handle.removeprefix(NODE) if handle.startswith(NODE) else state.revealed


def _edit_of(state: CarState, body: Body, drag: Drag) -> MovedNode | BentEdge:
    """Return the edit of a drag; of mirror images it names one, so that drags of both add up."""
    template, network = body.template, body.network
    if drag.handle.startswith(NODE):
        node = node_called(template, drag.handle.removeprefix(NODE))
        goal = _pen(drag, network.positions[node])
        own = min(node, int(template.mirrored[node]))
        moved = drag_node(network, node, goal, drag.camera).positions[own]
        way = triple(moved - network.positions[own])
        return MovedNode(world_of(state, body), template.names[own], way, kept=state.lock)
    name, _, last = drag.handle.removeprefix(TANGENT).rpartition(" ")
    if not drag.handle.startswith(TANGENT) or last not in ("0", "1"):
        raise UserError("This handle is not of this body. Drag a node or the end of a tangent.")
    edge, end = edge_called(template, name), int(last)
    goal = _pen(drag, network.control_points[edge, 1 + end])
    bent = drag_handle(network, edge, end, goal, drag.camera)
    image = int(template.mirrored_edges[edge])
    if max(image, ~image) < edge:
        edge, end = (image, end) if image >= 0 else (~image, 1 - end)
    tangent = triple(bent.tangents[edge, end])
    name = template.edge_names[edge]
    return BentEdge(world_of(state, body), name, end, tangent, kept=state.lock)


def _pen(drag: Drag, held: Array) -> Array:
    """Return where on the sheet the held place goes: the pen may hold it a little beside."""
    seen, _ = drag.camera.project(held)
    points = drag.path.points
    return np.asarray(seen[0] + points[-1] - points[0])
