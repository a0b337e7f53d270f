"""Triangles through the boundary of a loop (Kara & Shimada, book chapter, section 13.2.3.1).

A fan about the centroid of the boundary; then edges are swapped where that makes the worse one of
two triangles better, and split where they are long, with Laplacian smoothing between the rounds.
All edges of a round are changed at once: those that are best, or longest, for both of their
triangles. So the outcome depends on no order but that of the boundary.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags, Index, cross_product
from bozzetto_product.fill.fill_mesh import corner_ratios
from bozzetto_product.paper.neighbours import edges_of, neighbour_means

LONGEST: Final = 1.4
"""Length at which edges are split, in lengths of the longest one of the boundary or of the
spacing: the pieces of a split edge are not much shorter than the boundary's."""

GAIN: Final = 1e-6
"""Least gain of the worse radius ratio for which an edge is swapped."""

SWAP_ROUNDS: Final = 40
"""Most rounds of swaps at a time."""

SPLIT_ROUNDS: Final = 48
"""Most rounds of splits: each halves the longest edges."""

SWEEPS: Final = 3
"""Sweeps of Laplacian smoothing after each round."""

MOST_POINTS: Final = 20_000
"""Points of one surface; no edge is split beyond it."""


@dataclass(frozen=True, eq=False)
class Triangles:
    """Triangles with a boundary that stays.

    Parameters
    ----------
    points : (n, 3) float
        mm; those of the boundary come first, once round.
    faces : (m, 3) int
        Counter-clockwise where the boundary runs so.
    border : int
        How many points are on the boundary.
    """

    points: Array
    faces: Index
    border: int


@dataclass(frozen=True, eq=False)
class InnerEdges:
    """Edges between two triangles.

    Parameters
    ----------
    ends : (k, 2) int
        As the first triangle runs along the edge.
    apexes : (k, 2) int
        The third corners of the first and the second triangle.
    faces : (k, 2) int
        The first and the second triangle.
    """

    ends: Index
    apexes: Index
    faces: Index


def inner_edges(faces: Index) -> InnerEdges:
    """Return the edges that two triangles of opposite senses share."""
    tails, heads = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    tips = np.roll(faces, -2, axis=1).ravel()
    owners = np.repeat(np.arange(len(faces)), 3)
    count = int(faces.max(initial=0)) + 1
    keys = np.minimum(tails, heads) * count + np.maximum(tails, heads)
    order = np.argsort(keys, kind="stable")
    ranked = keys[order]
    pair = np.flatnonzero(ranked[1:] == ranked[:-1])
    one, two = order[pair], order[pair + 1]
    return InnerEdges(
        np.column_stack((tails[one], heads[one])),
        np.column_stack((tips[one], tips[two])),
        np.column_stack((owners[one], owners[two])),
    )


def triangulated(boundary: Array, spacing: float) -> Triangles:
    """Return triangles through a boundary.

    Parameters
    ----------
    boundary : (b, 3) float
        Once round, mm.
    spacing : float
        Wanted length of edges, mm.
    """
    made = _swapped(_fan(boundary))
    around = np.linalg.norm(np.roll(boundary, -1, axis=0) - boundary, axis=1)
    longest = LONGEST * max(spacing, float(around.max()))
    for _ in range(SPLIT_ROUNDS):
        split = _split(made, longest)
        if split is made:
            break
        made = smoothed(_swapped(split))
    return smoothed(_swapped(made))


def _fan(boundary: Array) -> Triangles:
    count = len(boundary)
    numbers = np.arange(count)
    apex = np.full(count, count)
    faces = np.column_stack((numbers, np.roll(numbers, -1), apex))
    return Triangles(np.vstack((boundary, boundary.mean(axis=0))), faces, count)


def _areas(points: Array, faces: Index) -> Array:
    a, b, c = (points[faces[:, k]] for k in range(3))
    return cross_product(b - a, c - a)


def _ratios(points: Array, faces: Index) -> Array:
    return corner_ratios(points[faces])


def _chosen(edges: InnerEdges, worth: Array, count: int) -> Flags:
    """Return which edges are worth more than all others of both of their triangles."""
    rank = np.empty(len(worth), np.intp)
    rank[np.argsort(worth, kind="stable")] = np.arange(len(worth))
    best = np.full(count, -1)
    np.maximum.at(best, edges.faces.ravel(), np.repeat(rank, 2))
    return np.asarray((best[edges.faces] == rank[:, None]).all(axis=1))


def _swapped(mesh: Triangles) -> Triangles:
    """Swap edges while that raises the lesser radius ratio of their two triangles.

    None is swapped where the two triangles would look to opposite sides.
    """
    points, faces = mesh.points, mesh.faces
    for _ in range(SWAP_ROUNDS):
        edges = inner_edges(faces)
        (tail, head), (one, two) = edges.ends.T, edges.apexes.T
        first, second = np.column_stack((tail, two, one)), np.column_stack((two, head, one))
        before = _ratios(points, faces)[edges.faces].min(axis=1)
        gain = np.minimum(_ratios(points, first), _ratios(points, second)) - before
        across, other = _areas(points, first), _areas(points, second)
        whole = _areas(points, faces)[edges.faces].sum(axis=1)
        alike = (across * other).sum(axis=1) > 0.0
        alike &= ((across * whole).sum(axis=1) > 0.0) & ((other * whole).sum(axis=1) > 0.0)
        wanted = alike & (gain > GAIN) & ~_is_edge(faces, one, two)
        take = wanted & _chosen(edges, np.where(wanted, gain, -1.0), len(faces))
        number = np.flatnonzero(take)
        keys = np.sort(edges.apexes[number], axis=1)
        number = number[np.sort(np.unique(keys, axis=0, return_index=True)[1])]
        if not len(number):
            break
        faces = faces.copy()
        faces[edges.faces[number, 0]] = first[number]
        faces[edges.faces[number, 1]] = second[number]
    return Triangles(points, faces, mesh.border)


def _is_edge(faces: Index, one: Index, two: Index) -> Flags:
    count = int(faces.max(initial=0)) + 1
    ends = edges_of(faces)
    keys = np.minimum(one, two) * count + np.maximum(one, two)
    return np.isin(keys, ends[:, 0] * count + ends[:, 1])


def _split(mesh: Triangles, longest: float) -> Triangles:
    """Halve the edges beyond a length that are the longest of both of their triangles."""
    points, faces = mesh.points, mesh.faces
    edges = inner_edges(faces)
    lengths = np.linalg.norm(points[edges.ends[:, 0]] - points[edges.ends[:, 1]], axis=1)
    # An edge of the boundary is never beyond that length, so it hides no inner one that is.
    take = np.flatnonzero((lengths > longest) & _chosen(edges, lengths, len(faces)))
    if not len(take) or len(points) + len(take) > MOST_POINTS:
        return mesh
    (tail, head), (one, two) = edges.ends[take].T, edges.apexes[take].T
    middle = len(points) + np.arange(len(take))
    made = faces.copy()
    made[edges.faces[take, 0]] = np.column_stack((tail, middle, one))
    made[edges.faces[take, 1]] = np.column_stack((head, middle, two))
    more = (np.column_stack((middle, head, one)), np.column_stack((middle, tail, two)))
    middles = 0.5 * (points[tail] + points[head])
    return Triangles(np.vstack((points, middles)), np.vstack((made, *more)), mesh.border)


def smoothed(mesh: Triangles, sweeps: int = SWEEPS) -> Triangles:
    """Move inner points to the mean of their neighbours, some times over."""
    means = neighbour_means(mesh.faces, len(mesh.points))[mesh.border :]
    points = mesh.points.copy()
    for _ in range(sweeps):
        points[mesh.border :] = means @ points
    return Triangles(points, mesh.faces, mesh.border)
