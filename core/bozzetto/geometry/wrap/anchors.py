"""Vertices of a skin that are fixed to curves, so that the curves become edges of it."""

from __future__ import annotations

import itertools
from collections import Counter
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto.geometry.wrap.icosphere import Icosphere, edges_of
from bozzetto.geometry.wrap.wireframe import MIRROR, Wireframe

Pairs = list[tuple[int, int]]
Row = list[tuple[int, int]]

EVENING: Final = 8
"""How often the steps along a curve are evened: some edges far, so that rows of vertices beside
the curve need not shear."""


@dataclass(frozen=True, eq=False)
class Anchors:
    """Vertices of a shrunk surface that are fixed to curves.

    Attributes
    ----------
    vertices : (k,) int
        Each once.
    places : (k, 3) float
        On the curves.
    links : list of (int, int)
        Vertices that follow one another along a curve.
    """

    vertices: Index
    places: Array
    links: Pairs


def choose_anchors(sphere: Icosphere, vertices: Array, frame: Wireframe, reached: Flags) -> Anchors:
    """Choose the vertices that follow the curves most closely.

    Each place of a curve is given to the nearest vertex. The row of vertices along a curve is
    then straightened: one that only makes a corner between two neighbours is let go. Of a
    symmetric network the half is given to the half, and places of the plane to vertices of it.

    Parameters
    ----------
    sphere : Icosphere
        The triangles of the surface.
    vertices : (v, 3) float
        The skin as it is, near the curves.
    frame : Wireframe
        The curves to follow.
    reached : (n,) bool
        The places that it should be fixed to.
    """
    places = frame.places
    distance, owner = _owners(sphere, vertices, frame)
    rows = _rows(sphere, owner, distance, frame, reached)
    shared = Counter(vertex for row in rows for vertex in {vertex for vertex, _ in row})
    held: dict[int, Array] = {}
    near: dict[int, float] = {}
    links: Pairs = []
    for pairs in rows:
        row = [vertex for vertex, _ in pairs]
        at = np.array([place for _, place in pairs])
        fixed = frame.sharp[at] | np.array([shared[vertex] > 1 for vertex in row])
        where = _evened(at.astype(float), fixed)
        low = np.minimum(where.astype(int), len(places) - 2)
        share = (where - low)[:, None]
        on_curve = (1.0 - share) * places[low] + share * places[low + 1]
        for vertex, place, gap, sharp in zip(
            row, on_curve, distance[at].tolist(), frame.sharp[at].tolist(), strict=True
        ):
            gap = gap - 1.0 if sharp else gap  # ends and corners before others
            if gap < near.get(vertex, np.inf):
                held[vertex], near[vertex] = place, gap
        links += list(itertools.pairwise(row))
    number, at = np.array(list(held), np.intp), np.array(list(held.values()))
    if frame.symmetric:
        image = sphere.mirrored
        aside = image[number] != number
        at = np.where(aside[:, None], at, at * (1.0, 0.0, 1.0))
        number = np.concatenate((number, image[number[aside]]))
        at = np.vstack((at, at[aside] * MIRROR))
        links += [(int(image[a]), int(image[b])) for a, b in links]
    return Anchors(number, at, links)


def _changes(*columns: Index) -> Flags:
    """Return where a column differs from its predecessor, from the second one on."""
    return np.asarray(np.any([np.diff(column) != 0 for column in columns], axis=0), bool)


def _evened(at: Array, fixed: Flags) -> Array:
    """Move places along a curve towards even steps; those that are fixed stay."""
    fixed = fixed.copy()
    fixed[[0, -1]] = True
    for _ in range(EVENING):
        between = 0.25 * at[:-2] + 0.5 * at[1:-1] + 0.25 * at[2:]
        at[1:-1] = np.where(fixed[1:-1], at[1:-1], between)
    return at


def _owners(sphere: Icosphere, vertices: Array, frame: Wireframe) -> tuple[Array, Index]:
    """Return the distance of each place from its nearest vertex, and that vertex."""
    from scipy.spatial import cKDTree

    found = cKDTree(vertices).query(frame.places)
    distance, owner = np.array(found[0], np.float64), np.array(found[1], np.intp)
    if frame.symmetric:
        middle = np.flatnonzero(sphere.mirrored == np.arange(len(vertices)))
        level = np.flatnonzero(frame.places[:, 1] == 0)
        distance[level], nearest = cKDTree(vertices[middle]).query(frame.places[level])
        owner[level] = middle[nearest]
        owner = np.where(vertices[owner, 1] < 0, sphere.mirrored[owner], owner)
    return distance, owner


def _rows(
    sphere: Icosphere, owner: Index, distance: Array, frame: Wireframe, reached: Flags
) -> list[Row]:
    """Return the straightened row of vertices along each piece."""
    gap = np.where(frame.sharp, -1.0, distance)
    kept = np.flatnonzero(reached)
    starts = np.flatnonzero(np.append(True, _changes(owner[kept], frame.piece[kept])))[: len(kept)]
    rows: dict[int, Row] = {}
    for run in np.split(kept, starts[1:]):
        best = int(run[np.argmin(gap[run])])
        row = rows.setdefault(int(frame.piece[best]), [])
        _append(row, int(owner[best]), best, gap, sphere.neighbours)
    return list(rows.values())


def _append(row: Row, vertex: int, at: int, gap: Array, beside: frozenset[tuple[int, int]]) -> None:
    """Continue to a vertex, by the shortest way."""
    while row:
        last, place = row[-1]
        if last == vertex:
            row[-1] = (vertex, at if gap[at] < gap[place] else place)
            return
        if len(row) < 2 or gap[place] < 0:
            break
        before = row[-2][0]
        if before != vertex and (min(before, vertex), max(before, vertex)) not in beside:
            break
        row.pop()
    row.append((vertex, at))


def flip_to_links(faces: Index, links: Pairs) -> Index:
    """Flip edges that cross a link, so that the link is one.

    A link that crosses more than one edge is left alone, and so is an edge that is a link.

    Parameters
    ----------
    faces : (f, 3) int
        Vertices of each triangle.
    links : list of (int, int)
        Pairs of vertices that shall be joined by an edge.

    Returns
    -------
    (f, 3) int
        The same triangles but for pairs whose common edge was flipped.
    """
    if not links:
        return faces
    count = int(faces.max()) + 1
    edges, of_face = edges_of(faces)
    order = np.argsort(of_face, axis=None, kind="stable").reshape(-1, 2)
    opposite = np.sort(np.roll(faces, 1, axis=1).ravel()[order], axis=1)
    keys, crossed = edges @ (count, 1), opposite @ (count, 1)
    wanted = np.unique(np.sort(np.array(links), axis=1) @ (count, 1))
    free = np.isin(crossed, wanted) & ~np.isin(crossed, keys) & ~np.isin(keys, wanted)
    flipped, used = faces.copy(), set[int]()
    for number in np.flatnonzero(free):
        one, two = (order[number] // 3).tolist()
        if one in used or two in used:
            continue
        used |= {one, two}
        corner = int(order[number][0] % 3)
        start, end = faces[one, corner], faces[one, (corner + 1) % 3]
        over, under = faces[one, corner - 1], int(sum(faces[two]) - start - end)
        flipped[one], flipped[two] = (over, start, under), (under, end, over)
    return flipped
