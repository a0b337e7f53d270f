"""One edit of a body after the other, and all strokes along its edges at once."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.plugin import override, remembered
from bozzetto.view import Camera, triple
from bozzetto_car.body.body import FEW_REMEMBERED, REMEMBERED, Body, Trouble
from bozzetto_car.body.chain_smoothing import anneal, lock_ratios, shorten_tangents
from bozzetto_car.body.default_shape import pull_out_panels
from bozzetto_car.body.drag import bend_edge
from bozzetto_car.body.edit_list import Edit
from bozzetto_car.body.reshaped import map_to
from bozzetto_car.body.space_edits import Moved, moved_for
from bozzetto_car.body.stretch import stretch, undo_stretch
from bozzetto_car.body.stroke_reader import Line
from bozzetto_car.body.trace_edges import trace_all
from bozzetto_car.solver.pipeline import Solved
from bozzetto_car.state import BentEdge, CarState, MovedNode, TracedEdges, Treatment
from bozzetto_car.template.model import Template
from bozzetto_car.template.network import Network, edge_called, node_called, with_positions

DRAWN: Final = 1e2
"""Firmness of an edge that was drawn or bent by hand, relative to one that came from the marks,
when the lengths of tangents are adjusted for smooth surfaces."""


IN_HAND: Final = 1e4
"""Firmness of the edge that was bent last, and of all edges that strokes hold: they stay where the
pen has put them."""


HELD: Final = 1.0
"""Standard deviation of a movement of nodes that would change a kept dimension, mm."""


def left_alone(
    strokes: tuple[int, ...], edit: Edit, edits: tuple[Edit, ...], template: Template
) -> tuple[int, ...]:
    """Return the numbers of strokes whose edges another edit leaves where they were drawn.

    A later stroke does not bring the others back to theirs.
    """
    if isinstance(edit, Treatment):
        return ()
    try:
        if isinstance(edit, MovedNode):
            node = node_called(template, edit.node)
            ends = {node, int(template.mirrored[node])}
            touched = {
                edge for edge, own in enumerate(template.edges.tolist()) if ends.intersection(own)
            }
        else:
            assert isinstance(edit, BentEdge)
            touched = set(with_images(template, (edge_called(template, edit.edge),)))
    except UserError:  # another template has no such node or edge, and the edit was left out
        return strokes
    names = {template.edge_names[edge] for edge in touched}
    names |= {"-".join(reversed(name.split("-"))) for name in names}
    traced = {number: edit for number, edit in enumerate(edits) if isinstance(edit, TracedEdges)}
    return tuple(number for number in strokes if names.isdisjoint(traced[number].edges))


class Same:
    """A key that is equal only to a key of the very same object.

    Comparing all samples of fifty strokes would take longer than repeating one edit.
    """

    __slots__ = ("own",)

    def __init__(self, own: object) -> None:
        self.own = own

    @override
    def __hash__(self) -> int:
        return id(self.own)

    @override
    def __eq__(self, other: object) -> bool:
        return isinstance(other, Same) and other.own is self.own


def drawn_through(body: Body, edit: TracedEdges) -> tuple[Array, Camera]:
    """Return the samples of a stroke, (k, 2) px, and the camera that it was drawn through.

    Raises
    ------
    UserError
        If the sketch that it was drawn on is gone.
    """
    stroke = edit.strokes[0]
    if not edit.sketch:
        return stroke.points, stroke.camera
    placed = body.solved.placed.get(edit.sketch)
    if placed is None or not placed.is_known:
        raise UserError(
            "The sketch on which an edge was traced is gone, or its camera is not known. Show the "
            "sketch and mark more points, or trace the edge again."
        )
    return stroke.points - placed.sketch_camera.shift, placed.sketch_camera.camera


@remembered(
    limit=REMEMBERED,
    key=lambda body, edit, number, smooth, moved: (body, Same(edit), number, smooth, moved),
)
def edited(body: Body, edit: Edit, number: int, smooth: bool, moved: Moved | None) -> Body:
    """Return a body after one more edit; the same body and the reason where that is impossible."""
    try:
        map_ = map_to(body.network, edit.dimensions) if moved is None else moved.back
        there = body.network if map_ is None else stretch(body.network, map_)
        network, edges = _changed(there, edit)
    except UserError as problem:
        return replace(body, troubles=(*body.troubles, Trouble(number, problem.message)))
    in_hand = with_images(body.template, edges)
    if smooth:
        network = lock_ratios(network, firmness(body, in_hand))
    if map_ is not None:
        network = undo_stretch(body.network, there, network, map_)
    return replace(body, network=network, drawn=body.drawn | in_hand)


@remembered(
    limit=REMEMBERED,
    key=lambda body, state, strokes: (
        body,
        tuple((number, Same(state.edits[number])) for number in strokes),
        (state.smooth, state.default_shape, state.annealed, state.joints),
        state.dimensions if state.lock else None,
    ),
)
def with_strokes(body: Body, state: CarState, strokes: tuple[int, ...]) -> Body:
    """Return a body after strokes, all of them at once; those that are impossible are left out."""
    lines: list[Line] = []
    numbers: list[int] = []
    problems: dict[int, str] = {}
    moves: dict[Hashable, Moved | None] = {}
    for number in strokes:
        edit = state.edits[number]
        assert isinstance(edit, TracedEdges)
        world = (edit.dimensions, edit.kept, bool(edit.sketch))
        if world not in moves:
            moves[world] = moved_for(edit, body, state)
        try:
            lines.append(_line(body, edit, moves[world]))
        except UserError as problem:
            problems[number] = problem.message
        else:
            numbers.append(number)
    made = trace_all(body.network, lines, even=state.smooth, information=_information(body.solved))
    problems |= {numbers[at]: message for at, message in made.problems.items()}
    known = {trouble.number for trouble in body.troubles}
    troubles = [Trouble(at, message) for at, message in problems.items() if at not in known]
    edges = {
        numbers[at]: tuple(max(edge, ~edge) for edge in run.edges) for at, run in made.runs.items()
    }
    in_hand = with_images(body.template, tuple(edge for row in edges.values() for edge in row))
    network = lock_ratios(made.network, firmness(body, in_hand)) if state.smooth else made.network
    return replace(
        body,
        network=network,
        drawn=body.drawn | in_hand,
        traced=tuple(sorted((dict(body.traced) | edges).items())),
        troubles=tuple(sorted((*body.troubles, *troubles), key=lambda trouble: trouble.number)),
    )


def _line(body: Body, edit: TracedEdges, moved: Moved | None) -> Line:
    """Return a stroke as the network of a body is fitted to it.

    Raises
    ------
    UserError
        If its sketch is gone, or the body cannot have the dimensions that it was drawn in.
    """
    points, camera = drawn_through(body, edit)
    map_ = map_to(body.network, edit.dimensions) if moved is None else moved.back
    if moved is not None and moved.along:
        way = (moved.along, 0.0, 0.0)
        eye, target = (triple(np.add(at, way)) for at in (camera.eye, camera.target))
        camera = replace(camera, eye=eye, target=target)
    edges = tuple(edge_called(body.template, name) for name in edit.edges)
    return Line(points, camera, edges, edit.nodes_follow, edit.sketch, map_)


@remembered(limit=FEW_REMEMBERED)
def _information(solved: Solved) -> Array | None:
    """Return what the marks and the template tell of the variables of a car, (q, q) mm⁻²."""
    if solved.joint is None:
        return None
    span = solved.joint.span
    told = span @ solved.joint.information @ span.T
    if span.shape[0] == span.shape[1]:
        return np.asarray(told)
    within = span @ np.linalg.solve(span.T @ span, span.T)
    return np.asarray(told + (np.eye(len(span)) - within) / HELD**2)


def _changed(network: Network, edit: Edit) -> tuple[Network, tuple[int, ...]]:
    """Return a network after an edit that is no stroke, and the edges that it has drawn."""
    template = network.template
    if isinstance(edit, MovedNode):
        node = node_called(template, edit.node)
        return with_positions(network, {node: network.positions[node] + edit.by}), ()
    if isinstance(edit, BentEdge):
        edge = edge_called(template, edit.edge)
        return bend_edge(network, edge, edit.end, edit.tangent), (edge,)
    assert isinstance(edit, Treatment)
    if edit.kind == "anneal":
        return anneal(network), ()
    return (shorten_tangents(network) if edit.kind == "reduce" else pull_out_panels(network)), ()


def with_images(template: Template, edges: tuple[int, ...]) -> frozenset[int]:
    """Return edges and their mirror images."""
    image = template.mirrored_edges
    return frozenset(own for edge in edges for own in (edge, max(image[edge], ~image[edge])))


def firmness(body: Body, in_hand: frozenset[int]) -> Array:
    """Return how firm each edge is where lengths of tangents are adjusted, (m,)."""
    firm = np.ones(len(body.template.edges))
    firm[list(body.drawn)] = DRAWN
    firm[list(in_hand)] = IN_HAND
    return firm
