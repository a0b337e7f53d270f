"""Carry the effect of edits over to another car, while a mark or a slider is dragged.

Repeating an edit takes as long as a frame. What the edits have changed of one car is added to the
other one, mm for mm. A traced edge, though, stays where its stroke is on the picture, and the
camera of the picture moves with the marks: its nodes and handles are seen through the new camera
where they were seen through the old one, and only their depth is carried over.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.view import Camera
from bozzetto_car.body.chain_smoothing import smooth_chains
from bozzetto_car.body.drag import drag_place
from bozzetto_car.body.edge_fit import edge_pictures, project_points
from bozzetto_car.body.trace_edges import NEAR_END
from bozzetto_car.template.network import HANDLE, Network, with_positions, with_tangents

PIECES: Final = 8
"""Pieces of an edge in which the length of its picture is measured."""


@dataclass(frozen=True)
class OnPicture:
    """Edges that lie on a stroke, seen before and now.

    Parameters
    ----------
    edges : tuple of int
        Indices of the edges.
    nodes_follow : bool
        Whether their nodes lie on the stroke, too.
    before, now : Camera
        Of the view that the stroke was drawn in.
    shift : (float, float)
        From the places of the old camera to those of the new one, px.
    """

    edges: tuple[int, ...]
    nodes_follow: bool
    before: Camera
    now: Camera
    shift: tuple[float, float] = (0.0, 0.0)


def carried(old: Network, start: Network, new: Network, traced: Iterable[OnPicture]) -> Network:
    """Return a network with the change that edits have made of another.

    Parameters
    ----------
    old : Network
        With the edits.
    start : Network
        The same without them.
    new : Network
        To be changed; its template has the same nodes and edges.
    traced : iterable of OnPicture
        The edges among them that lie on strokes, in the order of the edits.
    """
    made = Network(
        new.template,
        new.positions + (old.positions - start.positions),
        new.tangents + (old.tangents - start.tangents),
    )
    traced = tuple(traced)
    places = [_nodes(made, old, start, new, one) for one in traced if one.nodes_follow]
    made = with_positions(made, {node: at for some in places for node, at in some})
    handles = [_handles(made, old, one) for one in traced]
    made = with_tangents(made, {end: at for some in handles for end, at in some})
    held = {edge for one in traced for edge in one.edges}
    return smooth_chains(made, leading=held) if held else made


def _nodes(
    made: Network, old: Network, start: Network, new: Network, one: OnPicture
) -> Iterator[tuple[int, Array]]:
    """Yield the nodes that edits have moved with the places, mm, where they are on the picture.

    As when the edit is repeated, a node that is far from the end of its stroke does not go there.
    """
    edges = list(one.edges)
    ends = np.unique(made.template.edges[edges])
    nodes = ends[(old.positions[ends] != start.positions[ends]).any(axis=1)].tolist()
    goals = project_points(one.before, old.positions[nodes]) + one.shift
    without = project_points(one.now, new.positions[nodes])
    lengths = _lengths(new, edges, one.now)
    image = made.template.mirrored
    for node, goal, own in zip(nodes, goals, without, strict=True):
        beside = lengths[(made.template.edges[edges] == node).any(axis=1)]
        if not np.linalg.norm(goal - own) <= NEAR_END * beside.min():
            yield node, new.positions[node]
        elif _are_seen(one, made.positions[[node]], goal):
            free = np.array([True, bool(image[node] != node), True])
            yield node, drag_place(made.positions[node], goal, one.now, free)


def _handles(
    made: Network, old: Network, one: OnPicture
) -> Iterator[tuple[tuple[int, int], Array]]:
    """Yield ends of edges with tangents, mm, whose handles are where they are on the picture."""
    for edge in one.edges:
        handles = made.control_points[edge, 1:3]
        goals = project_points(one.before, old.control_points[edge, 1:3]) + one.shift
        if not _are_seen(one, made.control_points[edge], goals):
            continue
        for end, sign in ((0, 1.0), (1, -1.0)):
            place = drag_place(handles[end], goals[end], one.now, made.free_axes[edge, end])
            yield (edge, end), sign * (place - made.ends[edge, end]) / HANDLE


def _lengths(network: Network, edges: list[int], camera: Camera) -> Array:
    """Return the lengths of the pictures of edges, px; not finite where one is not all seen."""
    pictures = edge_pictures(camera, network.control_points[edges], PIECES)
    steps = np.linalg.norm(np.diff(pictures, axis=1), axis=2)
    return np.asarray(steps.sum(axis=1))


def _are_seen(one: OnPicture, points: Array, goals: Array) -> bool:
    """Whether points are before the eye, and their goals were."""
    return bool(np.isfinite(project_points(one.now, points)).all() and np.isfinite(goals).all())
