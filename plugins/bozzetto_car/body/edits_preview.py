"""Carry the effect of edits over to another car, while a mark or a slider is dragged.

Repeating an edit takes as long as a frame. What the edits have changed of one car is added to the
other one, mm for mm. A traced edge, though, stays where its stroke is on the picture, and the
camera of the picture moves with the marks: its nodes and handles are seen through the new camera
where they were seen through the old one, and only their depth is carried over.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto.errors import UserError
from bozzetto.view import Camera
from bozzetto_car.body.body import Body
from bozzetto_car.body.chain_smoothing import smooth_chains
from bozzetto_car.body.drag import drag_places
from bozzetto_car.body.edge_pictures import edge_pictures, project_points
from bozzetto_car.body.edit_row import drawn_through
from bozzetto_car.body.space_edits import car_then
from bozzetto_car.body.stroke_reader import NEAR_END
from bozzetto_car.state import CarState, TracedEdges
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
    views = _by_view(traced)
    made = with_positions(made, _nodes(made, old, start, new, views))
    made = with_tangents(made, _handles(made, old, views))
    held = {edge for group in views for _, one in group for edge in one.edges}
    return smooth_chains(made, leading=held) if held else made


def _by_view(traced: Iterable[OnPicture]) -> list[list[tuple[int, OnPicture]]]:
    """Return what is traced through the same cameras together, each with its number in order."""
    groups: dict[Hashable, list[tuple[int, OnPicture]]] = {}
    for number, one in enumerate(traced):
        groups.setdefault((one.before, one.now, one.shift), []).append((number, one))
    return list(groups.values())


def _nodes(
    made: Network,
    old: Network,
    start: Network,
    new: Network,
    views: list[list[tuple[int, OnPicture]]],
) -> dict[int, Array]:
    """Return the nodes that edits have moved with the places, mm, where they are on the pictures.

    As when the edit is repeated, a node that is far from the end of its stroke does not go there.
    Of several strokes that end at a node the last one counts.
    """
    ends, image = made.template.edges, made.template.mirrored
    moved = (old.positions != start.positions).any(axis=1)
    found: list[tuple[int, int, Array]] = []
    for group in views:
        view = group[0][1]
        on = [(number, edge) for number, one in group if one.nodes_follow for edge in one.edges]
        if not on:
            continue
        number, edge = np.repeat(np.array(on, np.intp), 2, axis=0).T
        both = np.stack((number, ends[edge[::2]].ravel()), axis=1)
        lengths = np.repeat(_lengths(new, edge[::2], view.now), 2)
        (number, node), which = _distinct_rows(both[moved[both[:, 1]]])
        shortest = np.full(len(node), np.inf)
        np.minimum.at(shortest, which, lengths[moved[both[:, 1]]])
        goals = project_points(view.before, old.positions[node]) + view.shift
        away = np.linalg.norm(goals - project_points(view.now, new.positions[node]), axis=1)
        near = away <= NEAR_END * shortest
        going = near & _are_seen(view, made.positions[node][:, None], goals[:, None])
        free = np.ones((len(node), 3), bool)
        free[:, 1] = image[node] != node
        places = np.array(new.positions[node])
        places[going] = drag_places(
            made.positions[node[going]], goals[going], view.now, free[going]
        )
        rows = zip(number.tolist(), node.tolist(), places, strict=True)
        found += [row for row, has_place in zip(rows, going | ~near, strict=True) if has_place]
    return {node: place for _, node, place in sorted(found, key=lambda row: row[0])}


def _handles(
    made: Network, old: Network, views: list[list[tuple[int, OnPicture]]]
) -> dict[tuple[int, int], Array]:
    """Return ends of edges with tangents, mm, whose handles are where they are on the pictures."""
    found: list[tuple[int, tuple[int, int], Array]] = []
    for group in views:
        view = group[0][1]
        on = np.array([(number, edge) for number, one in group for edge in one.edges], np.intp)
        edges = on[:, 1]
        goals = project_points(view.before, old.control_points[edges, 1:3].reshape(-1, 3))
        goals = goals.reshape(-1, 2, 2) + view.shift
        seen = _are_seen(view, made.control_points[edges], goals)
        on, edges, goals = on[seen], edges[seen], goals[seen]
        places = drag_places(
            made.control_points[edges, 1:3].reshape(-1, 3),
            goals.reshape(-1, 2),
            view.now,
            made.free_axes[edges].reshape(-1, 3),
        ).reshape(-1, 2, 3)
        tangents = (places - made.ends[edges]) / HANDLE * ((1.0,), (-1.0,))
        for (number, edge), (first, last) in zip(on.tolist(), tangents, strict=True):
            found += [(number, (edge, 0), first), (number, (edge, 1), last)]
    return {end: tangent for _, end, tangent in sorted(found, key=lambda row: row[0])}


def _lengths(network: Network, edges: Index, camera: Camera) -> Array:
    """Return the lengths of the pictures of edges, px; not finite where one is not all seen."""
    pictures = edge_pictures(camera, network.control_points[edges], PIECES)
    with np.errstate(invalid="ignore"):  # between two places that are not seen
        steps = np.linalg.norm(np.diff(pictures, axis=1), axis=2)
    return np.asarray(steps.sum(axis=1))


def _are_seen(view: OnPicture, points: Array, goals: Array) -> Flags:
    """Whether all points (k, n, 3) are before the eye, and their goals (k, m, 2) were, (k,)."""
    places = project_points(view.now, points.reshape(-1, 3)).reshape(len(points), -1)
    return np.asarray(np.isfinite(places).all(axis=1) & np.isfinite(goals).all(axis=(1, 2)))


def _distinct_rows(rows: Index) -> tuple[Index, Index]:
    """Return the columns (2, k) of the distinct rows (n, 2), and which of them each is, (n,)."""
    distinct, which = np.unique(rows, axis=0, return_inverse=True)
    return np.asarray(distinct.T), np.asarray(which.ravel())


def carried_body(old: Body, old_start: Body, start: Body, before: CarState) -> Body:
    """Return the body `start` with what the edits of a car changed from `old_start` to `old`."""
    traced = list(_on_pictures(old, start, before))
    network = carried(old.network, old_start.network, start.network, traced)
    return replace(old, network=network, solved=start.solved, is_dragged=True)


def _on_pictures(old: Body, start: Body, before: CarState) -> Iterator[OnPicture]:
    """Yield what was traced on a body as it was and as it is seen now.

    What was traced on a stretched body is seen on another one than this; it is left out.
    """
    for number, edges in old.traced:
        edit = before.edits[number]
        assert isinstance(edit, TracedEdges)
        if edit.dimensions.given() or car_then(edit, before) is not None:
            continue
        try:
            (was, then), (is_now, now) = (drawn_through(body, edit) for body in (old, start))
        except UserError:  # its sketch has no camera any more, and is told where edits are repeated
            continue
        shift = (is_now[0] - was[0]).tolist()
        yield OnPicture(edges, edit.nodes_follow, then, now, (shift[0], shift[1]))
