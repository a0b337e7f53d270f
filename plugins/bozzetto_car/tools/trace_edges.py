"""Trace edges: a stroke along an edge, in the sketch or from any side, bends it."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.ink import Stroke, Strokes
from bozzetto.plugin import Context, Gesture, Ink, Tool, override
from bozzetto.scene import Layer, Scene
from bozzetto.view import Camera
from bozzetto_car.body.body import Body
from bozzetto_car.body.build import body_in_work, body_of, unstretched_body_of, world_of
from bozzetto_car.body.edge_runs import find_run
from bozzetto_car.body.edit_list import without_last_of
from bozzetto_car.body.edit_row import drawn_through
from bozzetto_car.body.reshaped import in_world_of
from bozzetto_car.body.trace_edges import trace
from bozzetto_car.camera.sketch_camera import SketchCamera, upright_camera
from bozzetto_car.state import CarState, TracedEdges
from bozzetto_car.template.network import Network
from bozzetto_car.view.edge_items import edge_items
from bozzetto_car.view.picking import edges_under
from bozzetto_car.view.stroke_items import TRACE_TOOL
from bozzetto_car.view.view_advice import camera_looked_through, cars_seen

Seen = tuple[CarState, ...]

NOTHING: Final = "No edge that was traced is under the eraser. Rub along one."


class TraceEdges(Tool[CarState]):
    """The tool that bends edges to strokes; the other side of the car follows.

    A stroke on the sketch is kept in the pixels of its picture: it stays on the line that it
    traces when the camera changes. While this tool is in the hand it is shown with its distance
    from the body; drawn again along the same edge, it takes the place of the last one. The eraser
    takes back the last stroke or drag that bent the edge under it.
    """

    id = TRACE_TOOL
    title = "Trace edges"
    icon = "icons/trace.svg"
    hint = "Draw along an edge where it is to run. Draw again to correct; the eraser takes back."

    @override
    def preview(self, state: CarState, gesture: Gesture, context: Context) -> Scene:
        """Show the edges after the stroke."""
        if not isinstance(gesture, Ink):
            return Scene()
        made, edit = _traced(state, gesture.strokes[-1], cars_seen(context))
        body = body_of(made)
        if any(trouble.number == len(made.edits) - 1 for trouble in body.troubles):
            return Scene()
        held = [body.template.edge_names.index(name) for name in edit.edges]
        return Scene((Layer("network", tuple(edge_items(made, body, held))),))

    @override
    def draw(self, state: CarState, ink: Ink, context: Context) -> CarState:
        """Bend the edges that the strokes run along, one stroke after the other.

        Raises
        ------
        UserError
            If a stroke runs along no edge, or is seen end-on.
        """
        for stroke in ink.strokes:
            state, _ = _traced(state, stroke, cars_seen(context))
            told = body_of(state).troubles
            if told and told[-1].number == len(state.edits) - 1:
                raise UserError(told[-1].message)
        return state

    @override
    def erase(self, state: CarState, ink: Ink, context: Context) -> CarState:
        """Take back the last stroke or drag that bent the edge under the eraser.

        Raises
        ------
        UserError
            If nothing that was traced is under it.
        """
        return _erased(state, ink.strokes[-1])


def _traced(state: CarState, stroke: Stroke, seen: Seen) -> tuple[CarState, TracedEdges]:
    """Return the car after a stroke, and the edit with the edges that were found."""
    body = body_in_work(state)
    edit = _edit_of(state, body, stroke, seen)
    unstretched = unstretched_body_of(state)
    points, camera = drawn_through(unstretched, edit)
    there = in_world_of(unstretched, edit)
    run = find_run(there, points, camera)
    edges = tuple(max(edge, ~edge) for edge in run.edges)
    names = tuple(body.template.edge_names[edge] for edge in edges)
    # A stroke that takes the place of another one holds the nodes that the other one held.
    held = any(
        isinstance(other, TracedEdges) and other.sketch == edit.sketch and other.nodes_follow
        and not {*names}.isdisjoint(other.edges) for other in state.edits
    )  # fmt: skip
    edit = replace(
        edit, edges=names, nodes_follow=edit.nodes_follow or (held and bool(edit.sketch))
    )
    if unstretched.drawn.issuperset(edges) and _is_followed(there, points, camera, edges):
        return state, edit
    return replace(state, edits=(*state.edits, edit)), edit


def _is_followed(network: Network, points: Array, camera: Camera, edges: tuple[int, ...]) -> bool:
    """Whether edges are seen along a stroke already, so that it has nothing to add."""
    try:
        return trace(network, points, camera, edges=edges).network is network
    except UserError:
        return False


def _edit_of(state: CarState, body: Body, stroke: Stroke, seen: Seen) -> TracedEdges:
    """Return a stroke as an edit: in pixels of the sketch if the view is through it.

    The car, and the camera of the sketch with it, may have changed since the person saw them.
    """
    sketch, sketch_camera = state.sketch, None
    if sketch is not None:
        sketch_camera = camera_looked_through(sketch, body, stroke.camera, seen)
    if sketch is None or sketch_camera is None:
        return TracedEdges(
            dimensions=world_of(state, body),
            kept=state.lock,
            strokes=Strokes((stroke,)),
            nodes_follow=state.nodes_follow,
        )
    own = _on_picture(stroke, sketch_camera, sketch.size)
    return TracedEdges(strokes=Strokes((own,)), sketch=sketch.id, nodes_follow=state.nodes_follow)


def _on_picture(stroke: Stroke, sketch_camera: SketchCamera, size: tuple[float, float]) -> Stroke:
    """Return a stroke in pixels of the picture that is seen behind it."""
    u, v = sketch_camera.seen_at(stroke.camera, stroke.points).T
    return Stroke(
        u, v, upright_camera(size).camera,
        pressure=stroke.pressure if stroke.has_pressure else None,
        t=stroke.t if stroke.has_time else None,
        tool=stroke.tool,
    )  # fmt: skip


def _erased(state: CarState, eraser: Stroke) -> CarState:
    """Return the state without the last stroke or drag that bent an edge under the eraser."""
    body = body_in_work(state)
    template = body.template
    under = edges_under(body.network, eraser.points, eraser.camera)
    images = template.mirrored_edges[under]
    both = {*under, *np.maximum(images, ~images).tolist()}
    edits = without_last_of(state.edits, (template.edge_names[edge] for edge in both))
    if edits is None:
        raise UserError(NOTHING)
    return replace(state, edits=edits)
