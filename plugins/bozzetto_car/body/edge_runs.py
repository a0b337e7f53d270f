"""Find the edges that a stroke runs along: the nearest one, or several in a row."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array, Flags, Index
from bozzetto.errors import UserError
from bozzetto.ink import (
    FARTHEST,
    arc_length,
    distinct,
    ordered_feet,
    places_on_sheet,
    resample,
)
from bozzetto.view import Camera
from bozzetto_car.body.edge_pictures import edge_pictures
from bozzetto_car.camera.visibility import facing
from bozzetto_car.template.model import Template
from bozzetto_car.template.network import Network

SHORTEST: Final = 4.0
"""Length of a stroke, px, below which it is a dot."""

STROKE_PLACES: Final = 64
"""Places of the stroke, at equal steps, that are compared with the edges."""

SENSE: Final = 4
"""Every how many of these places one is used to find the direction of a stroke."""

EDGE_PLACES: Final = 20
"""Pieces of the polyline that stands for an edge."""

PASSED: Final = 0.3
"""Share of the first or last edge of a row that a stroke must cover to mean that edge; with less,
the stroke has begun too early or ended too late."""

CANDIDATES: Final = 4
"""Number of rows, the nearest first, that are compared in detail."""

HIDDEN: Final = (2.0, 4.0)
"""Penalty on the distance of an edge on the far side of the car, as a factor and as px to add: a
person who means such an edge draws exactly on it."""

ENDS: Final = (0.3, 40.0)
"""Penalty on the distance of a stroke's ends from the nodes that a row ends in, as a factor, and
the distance, px, beyond which it grows no more. A person draws from node to node or a part of an
edge; so of two edges that run beside the stroke alike it is the one that ends where it does."""

REACH: Final = 0.12
"""Mean distance beyond which a stroke means no edge, per diagonal of the car's picture."""


@dataclass(frozen=True, eq=False)
class Run:
    """Edges in a row, and the parts of a stroke that belong to each.

    Attributes
    ----------
    edges : tuple of int
        In the order in which the stroke passes them; ``~edge`` where it runs against one.
    nodes : tuple of int
        One more than the edges.
    parts : tuple of (k, 2) float
        The samples of the stroke that belong to each edge, px.
    distance : float
        Mean distance of the stroke from the edges, px.
    """

    edges: tuple[int, ...]
    nodes: tuple[int, ...]
    parts: tuple[Array, ...]
    distance: float


def find_run(
    network: Network,
    stroke: ArrayLike,
    camera: Camera,
    edges: Sequence[int] = (),
    *,
    directed: bool = True,
) -> Run:
    """Find the edges that a stroke traces.

    It may be a single edge, or a part of one, or several in a row along a chain or along the
    middle of the car. The row with the least mean distance is taken (Kara & Shimada, book
    chapter, section 13.2).

    Parameters
    ----------
    network : Network
        The car.
    stroke : (k, 2) array_like
        Samples of the stroke, px, in either direction.
    camera : Camera
        The view that the stroke was drawn in.
    edges : sequence of int, optional
        The edges that are meant, in the order of the row that they make. The stroke then
        belongs to all of them, and there is no search.
    directed : bool
        Whether it matters in which direction a stroke passes a single edge that is meant. If
        not, the run has that of the edge, and half of the time is saved.

    Raises
    ------
    UserError
        If the stroke is a dot, is not on the sheet, or runs along no edge; or if the edges
        that are meant do not follow each other.
    """
    points = places_on_sheet(stroke, "stroke")
    points = points[distinct(points)]
    if arc_length(points)[-1] < SHORTEST:
        raise UserError("The stroke is a dot. Draw along an edge of the car.")
    known = [_in_row(network.template, edges)] if edges else _rows(network.template)
    looked_at = {max(edge, ~edge) for row in known for edge in row}
    paths, visible = _pictured(network, camera, np.array(sorted(looked_at)))
    rows = [row for row in known if all(visible[max(e, ~e)] for e in row)]
    if not rows:
        what = "The edge that is meant is not" if edges else "No edge of the car is"
        raise UserError(f"{what} in view. Turn or move the view until it is.")
    places = resample(points, count=STROKE_PLACES)
    if len(edges) == 1 and not directed:
        row = rows[0]
    elif edges:
        row = _directed(paths, rows[0], places)
    else:
        row = _nearest_row(network, camera, paths, rows, places)
    distance = float(_distances(places, paths[[max(e, ~e) for e in row]]).min(axis=1).mean())
    # What is near for the size of the edges that are meant is near for that of the whole car.
    if distance > _reach(paths[visible]) and (
        not edges or distance > _reach_of_car(network, camera)
    ):
        raise UserError("The stroke is far from every edge of the car. Draw along one of them.")
    ends = [network.template.edges[max(e, ~e)][:: 1 if e >= 0 else -1].tolist() for e in row]
    nodes = (ends[0][0], *(end for _, end in ends))
    return Run(row, nodes, _parts(points, paths, row), distance)


def _pictured(network: Network, camera: Camera, edges: Index) -> tuple[Array, Flags]:
    """Return the pictures of some edges, (m, k, 2) px, infinite for others; and which are in view.

    The rows are those of all edges of the car.
    """
    count = len(network.template.edges)
    paths, visible = np.full((count, EDGE_PLACES + 1, 2), np.inf), np.zeros(count, bool)
    paths[edges] = found = edge_pictures(camera, network.control_points[edges], EDGE_PLACES)
    visible[edges] = (np.abs(found) <= FARTHEST).all(axis=(1, 2))
    return paths, visible


def _reach(paths: Array) -> float:
    """Return the mean distance beyond which a stroke means none of some edges, px."""
    return REACH * float(np.linalg.norm(np.ptp(paths, axis=(0, 1))))


def _reach_of_car(network: Network, camera: Camera) -> float:
    paths, visible = _pictured(network, camera, np.arange(len(network.template.edges)))
    return _reach(paths[visible])


def _in_row(template: Template, edges: Sequence[int]) -> tuple[int, ...]:
    """Return edges that follow each other, each with the sign of its direction in the row."""
    if len(edges) == 1:
        return (edges[0],)
    ends = template.edges[list(edges)].tolist()
    row: list[int] = []
    for number, (edge, (start, end)) in enumerate(zip(edges, ends, strict=True)):
        # Towards the next edge; the last edge leads away from the one before.
        forward = end in ends[number + 1] if number + 1 < len(edges) else start in ends[number - 1]
        row.append(edge if forward else ~edge)
    heads = [end if own >= 0 else start for own, (start, end) in zip(row, ends, strict=True)]
    tails = [start if own >= 0 else end for own, (start, end) in zip(row, ends, strict=True)]
    if heads[:-1] != tails[1:]:
        names = ", ".join(template.edge_names[edge] for edge in edges)
        raise UserError(f"The edges {names} make no line. Name edges that follow each other.")
    return tuple(row)


def _nearest_row(
    network: Network,
    camera: Camera,
    paths: Array,
    rows: list[tuple[int, ...]],
    places: Array,
) -> tuple[int, ...]:
    """Return the edges, in the direction of a stroke, of the row that the stroke means."""
    toward = facing(network.template, network.positions, camera)
    faces = np.asarray(toward[network.template.edges].all(axis=1))
    known = sorted({max(edge, ~edge) for row in rows for edge in row})
    away = np.full((len(places), len(paths)), np.inf)
    away[:, known] = _distances(places, paths[known])
    best, least = rows[0], np.inf
    for whole in sorted(rows, key=lambda row: _cost(away, row, faces))[:CANDIDATES]:
        if _distance(away, whole) >= least:
            continue  # a part of it is no nearer than the whole
        row = _passed(paths, whole, places)
        cost = _cost(away, row, faces) + _ends_apart(paths, row, places)
        if cost < least:
            best, least = row, cost
    return best


def _rows(template: Template) -> list[tuple[int, ...]]:
    """Return the rows that a stroke may follow: chains, the middle, and all other single edges."""
    rows = [chain.edges for chain in template.chains]
    part: list[int] = []
    for pair in pairwise(template.centre.tolist()):
        if pair in template.edge_between:
            part.append(template.edge_between[pair])
        elif part:
            rows.append(tuple(part))
            part = []
    rows += [tuple(part)] if part else []
    known = {max(edge, ~edge) for row in rows for edge in row}
    return rows + [(edge,) for edge in range(len(template.edges)) if edge not in known]


def _laid_out(paths: Array, row: tuple[int, ...]) -> Array:
    """Return the picture of edges in a row as one polyline; each node is in it once."""
    pieces = [paths[edge] if edge >= 0 else paths[~edge][::-1] for edge in row]
    return np.concatenate([pieces[0], *(piece[1:] for piece in pieces[1:])])


def _distances(places: Array, paths: Array) -> Array:
    """Return the distances of places (k, 2) from the pictures of edges (m, l, 2), (k, m) px."""
    middle = places.mean(axis=0)
    own, laid = places - middle, paths - middle
    begin, step = laid[:, :-1].reshape(-1, 2), np.diff(laid, axis=1).reshape(-1, 2)
    squares = np.maximum((step**2).sum(axis=1), np.finfo(float).tiny)
    along = own @ step.T - (begin * step).sum(axis=1)
    share = np.clip(along / squares, 0.0, 1.0)
    away = (own**2).sum(axis=1)[:, None] + (begin**2).sum(axis=1) - 2.0 * own @ begin.T
    away += share * (share * squares - 2.0 * along)
    least = away.reshape(len(own), len(paths), -1).min(axis=2)
    return np.asarray(np.sqrt(np.maximum(least, 0.0)))


def _distance(away: Array, row: tuple[int, ...]) -> float:
    """Return the mean distance of a stroke from a row, px."""
    return float(away[:, [max(edge, ~edge) for edge in row]].min(axis=1).mean())


def _cost(away: Array, row: tuple[int, ...], faces: Flags) -> float:
    """Return the mean distance of a stroke from a row with the penalty for hidden edges, px."""
    distance = _distance(away, row)
    factor, more = HIDDEN
    hidden = sum(not faces[max(edge, ~edge)] for edge in row) / len(row)
    return distance + hidden * ((factor - 1.0) * distance + more)


def _ends_apart(paths: Array, row: tuple[int, ...], places: Array) -> float:
    """Return the penalty for a stroke whose ends are not where those of a row are, px."""
    ends = _laid_out(paths, row)[[0, -1]]
    away = np.linalg.norm(places[[0, -1]] - ends, axis=1)
    factor, most = ENDS
    return factor * float(np.minimum(away, most).mean())


def _feet(paths: Array, row: tuple[int, ...], places: Array) -> tuple[Array, Index]:
    """Return lengths along the picture of a row, and the vertices there that a stroke passes."""
    path = _laid_out(paths, row)
    along = arc_length(path)
    step = float(arc_length(places)[-1]) / len(places)
    return along, ordered_feet(places, step, path, np.gradient(along))


def _directed(paths: Array, row: tuple[int, ...], places: Array) -> tuple[int, ...]:
    """Return a row in the direction of a stroke."""
    _, feet = _feet(paths, row, places[::SENSE])
    return row if feet[0] <= feet[-1] else tuple(~edge for edge in row[::-1])


def _passed(paths: Array, row: tuple[int, ...], places: Array) -> tuple[int, ...]:
    """Return the edges of a row that a stroke covers, in the direction of the stroke."""
    along, feet = _feet(paths, row, places)
    if feet[0] > feet[-1]:
        row, feet = tuple(~edge for edge in row[::-1]), len(along) - 1 - feet
        along = along[-1] - along[::-1]
    nodes = along[::EDGE_PLACES]
    low, high = along[feet[0]], along[feet[-1]]
    covered = np.clip(np.minimum(nodes[1:], high) - np.maximum(nodes[:-1], low), 0.0, None)
    share = covered / np.maximum(np.diff(nodes), np.finfo(float).tiny)
    passed = np.flatnonzero(share >= PASSED)
    if not len(passed):
        return (row[int(np.argmax(covered))],)
    return row[passed[0] : passed[-1] + 1]


def _parts(points: Array, paths: Array, row: tuple[int, ...]) -> tuple[Array, ...]:
    """Split a stroke where it is nearest to the nodes within a row of edges.

    The samples at which it is split belong to both sides, so that no part is empty.
    """
    if len(row) == 1:
        return (points,)
    path = _laid_out(paths, row)
    count = min(len(points), STROKE_PLACES)
    kept = np.linspace(0, len(points) - 1, count).round().astype(int)
    feet = ordered_feet(points[kept], 1.0, path, np.ones(len(path)))
    cuts = [0]
    for number in range(1, len(row)):
        node = path[number * EDGE_PLACES]
        # Only between the middles of both edges: the stroke may pass the node again elsewhere.
        low = kept[np.searchsorted(feet, (number - 0.5) * EDGE_PLACES).clip(0, count - 1)]
        high = kept[np.searchsorted(feet, (number + 0.5) * EDGE_PLACES).clip(0, count - 1)]
        low, high = max(low, cuts[-1]), max(high, cuts[-1])
        away = np.linalg.norm(points[low : high + 1] - node, axis=1)
        cuts.append(int(low + np.argmin(away)))
    cuts.append(len(points) - 1)
    return tuple(points[begin : end + 1] for begin, end in pairwise(cuts))
