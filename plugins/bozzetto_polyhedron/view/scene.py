"""The scene of a model: drawings on their sheets, solids in space."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from bozzetto.arrays import Array
from bozzetto.scene import Hidden, Item, Layer, Lines, Scene
from bozzetto_polyhedron.flat_pages import page_curves
from bozzetto_polyhedron.model.changes import Mirror
from bozzetto_polyhedron.model.followed import Followed
from bozzetto_polyhedron.model.state import Body, PolyhedronState
from bozzetto_polyhedron.rounds.round_curves import number_at
from bozzetto_polyhedron.rounds.straightened import straightened
from bozzetto_polyhedron.solve.followed import Sources
from bozzetto_polyhedron.solve.measured_edges import edge_at
from bozzetto_polyhedron.solve.moving import NOTHING, Moving, is_mechanism, moving
from bozzetto_polyhedron.solve.picking import solids_in
from bozzetto_polyhedron.solve.pipeline import Solved, joined_bodies, solved
from bozzetto_polyhedron.solve.round_lines import round_lines
from bozzetto_polyhedron.solve.spots import is_linkage
from bozzetto_polyhedron.view.drawing_layers import (
    finding_items,
    ink_items,
    ink_on_edges,
    line_items,
)
from bozzetto_polyhedron.view.fittings import fitting_items, force_items, trace_items
from bozzetto_polyhedron.view.loops import loop_items
from bozzetto_polyhedron.view.motion import anchor_items, followed_items, moved_items
from bozzetto_polyhedron.view.solid_layers import (
    added_items,
    measure_item,
    page_items,
    round_size_item,
    solid_items,
    wire_items,
)

LAYERS = (
    *("solid", "added", "ink", "lines", "findings", "dimensions"),
    *("fittings", "chosen fitting", "forces", "traces", "anchors", "page", "handles"),
)
"""Names of the layers in the order in which they are drawn."""

CHOSEN = "chosen fitting"
"""Name of the layer that is shown while the object is selected."""

HANDLES = "handles"
"""Name of the layer that is shown with the tool that drags it."""


def scene_of(
    state: PolyhedronState, results: Mapping[str, Solved], sources: Sources = NOTHING
) -> Scene:
    """Return ink, lines, findings and solids of all bodies that are shown.

    A drawing shows its lines until it is turned into a solid, by a touch; from then on its ink
    lies on the edges. A drawing that already closes has its faces under the lines.
    """
    layers: dict[str, list[Item]] = {name: [] for name in LAYERS}
    known = bool(results or sources)
    made = moving(state, sources) if known and is_mechanism(state) else None
    joined = joined_bodies(results)
    bodies = [body for body in state.shown(Body) if body.id not in joined]
    for body in bodies:
        found = results.get(body.id)
        if found is None:
            layers["ink"] += ink_items(body)
        elif made is not None and body.id in made.numbers:
            _add_moving(layers, body, found, state, made)
        elif body.choice is None or is_linkage(body, state):
            _add_drawing(layers, body, found, state)
        else:
            _add_solid(layers, body, found, state)
    if made is not None:
        for part in state.shown(Followed):
            if part.id in made.numbers:
                layers["solid"] += followed_items(part, made, made.motion(state.moved))
                layers["anchors"] += anchor_items(part, made, made.motion(state.moved))
        motion = made.motion(state.moved)
        layers["fittings"] += fitting_items(state, made, motion)
        layers[CHOSEN] += fitting_items(state, made, motion, chosen=True)
        if state.forces:
            layers["forces"] += force_items(state, made)
        layers["traces"] += trace_items(state, made)
    if state.moved is None:
        for body in bodies:
            if body.id in results and body.choice is not None:
                layers[HANDLES] += loop_items(state, body)
    layers["solid"] = [_behind(item, state.behind) for item in layers["solid"]]
    layers["page"] += page_items(page_curves(state, results))
    return Scene(
        tuple(
            Layer(
                name,
                tuple(items),
                tool="push" if name == HANDLES else "",
                chosen=name == CHOSEN,
            )
            for name, items in layers.items()
            if items
        )
    )


def _behind(item: Item, hidden: Hidden) -> Item:
    """Return an item whose hidden edges are shown as the state says."""
    if isinstance(item, Lines) and item.hidden == "faint":
        return replace(item, hidden=hidden)
    return item


def scene_after(state: PolyhedronState, sources: Sources) -> Scene:
    """Return the scene of a state that a gesture would make: solids are solved for it."""
    return scene_of(state, {body.id: solved(body, state) for body in solids_in(state)}, sources)


def _add_drawing(
    layers: dict[str, list[Item]], body: Body, found: Solved, state: PolyhedronState
) -> None:
    layers["ink"] += ink_items(body)
    layers["lines"] += line_items(body, found.graph)
    if is_linkage(body, state):
        return
    layers["findings"] += finding_items(body, found)
    if found.body is not None and found.body.closed and not found.graph.health:
        layers["solid"] += solid_items(body, found, body.id == state.selected)


def _add_moving(
    layers: dict[str, list[Item]],
    body: Body,
    found: Solved,
    state: PolyhedronState,
    made: Moving,
) -> None:
    motion = made.motion(state.moved)
    layers["anchors"] += anchor_items(body, made, motion)
    if state.moved is None and (body.choice is None or is_linkage(body, state)):
        _add_drawing(layers, body, found, state)
    elif state.moved is None:
        _add_solid(layers, body, found, state)
    else:
        layers["solid"] += moved_items(body, made, motion)


def _add_solid(
    layers: dict[str, list[Item]], body: Body, found: Solved, state: PolyhedronState
) -> None:
    if found.answer is None:
        layers["ink"] += ink_items(body)
        layers["lines"] += line_items(body, found.graph)
    elif found.body is None:
        layers["solid"] += wire_items(body, found)
    else:
        layers["solid"] += solid_items(body, found, body.id == state.body_of_chosen())
        layers["added"] += added_items(body, found)
        if not any(isinstance(each, Mirror) for each in state.changes_of(body)):
            layers["ink"] += ink_on_edges(body, found.graph, found.answer)
        for measure in state.measures_of(body):
            edge = edge_at(found.graph, measure.begin, measure.end)
            if edge is not None and found.base is not None:
                ends = found.base.vertices[list(edge)]
                layers["dimensions"].append(measure_item(measure, ends))
        layers["dimensions"] += _round_size_items(body, found, state)
    if found.body is None or not found.body.closed:
        layers["findings"] += finding_items(body, found)


def _round_size_items(body: Body, found: Solved, state: PolyhedronState) -> list[Item]:
    """Return the typed sizes of what was drawn round in a body."""
    reading = straightened(body.strokes, body.evidence).reading
    sizes = state.round_sizes_of(body)
    if reading is None or not sizes:
        return []
    points: dict[int, Array] = {}
    for line in round_lines(body, found):
        if len(line.points):
            points.setdefault(line.curve.number, line.points)
    numbers = [number_at(reading, np.array(size.place)) for size in sizes]
    return [
        round_size_item(size, points[number])
        for size, number in zip(sizes, numbers, strict=True)
        if number in points
    ]
