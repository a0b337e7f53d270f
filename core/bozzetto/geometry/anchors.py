"""Vertices of a skin that are fixed to curves, so that the curves become edges of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bozzetto.geometry.icosphere import Icosphere, edges_of
from bozzetto.geometry.wireframe import MIRROR, Wireframe

__all__ = ["Anchors", "anchored", "with_edges"]

Array = NDArray[np.float64]
Index = NDArray[np.intp]
Pairs = list[tuple[int, int]]


@dataclass(frozen=True, eq=False)
class Anchors:
    """Where a skin is held.

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


def anchored(sphere: Icosphere, vertices: Array, frame: Wireframe, reached: Array) -> Anchors:
    """Choose the vertices that follow the curves most closely.

    Each place of a curve is given to the nearest vertex. The row of vertices along a curve is
    then straightened: one that only makes a corner between two neighbours is let go. Of a
    symmetric network the half is given to the half, and places of the plane to vertices of it.

    Parameters
    ----------
    sphere : Icosphere
    vertices : (v, 3) float
        The skin as it is, near the curves.
    frame : Wireframe
    reached : (n,) bool
        The places that it should be fixed to.
    """
    from scipy.spatial import cKDTree

    places = frame.places
    distance, owner = cKDTree(vertices).query(places)
    owner = np.asarray(owner, np.intp)
    if frame.symmetric:
        middle = np.flatnonzero(sphere.mirrored == np.arange(len(vertices)))
        level = np.flatnonzero(places[:, 1] == 0)
        distance[level], nearest = cKDTree(vertices[middle]).query(places[level])
        owner[level] = middle[nearest]
        other = sphere.mirrored[owner]
        owner = np.where(vertices[owner, 1] < 0, other, owner)
    links, kept = _rows(sphere, owner, frame, reached)
    order = np.lexsort((distance, ~frame.sharp, owner))
    order = order[kept[owner[order]] & reached[order]]
    first = np.append(True, np.diff(owner[order]) != 0)[: len(order)]
    chosen = order[first]
    held, at = owner[chosen], places[chosen]
    if frame.symmetric:
        aside = sphere.mirrored[held] != held
        at = np.where(aside[:, None], at, at * (1.0, 0.0, 1.0))
        held = np.concatenate((held, sphere.mirrored[held[aside]]))
        at = np.vstack((at, at[aside] * MIRROR))
        image = sphere.mirrored
        links += [(int(image[a]), int(image[b])) for a, b in links]
    return Anchors(held, at, links)


def _rows(
    sphere: Icosphere, owner: Index, frame: Wireframe, reached: Array
) -> tuple[Pairs, NDArray[np.bool_]]:
    """The straightened row of vertices of each piece: its links, and which vertices it keeps."""
    edges = edges_of(sphere.faces)[0]
    beside = set(map(tuple, edges.tolist()))
    changes = np.append(True, (np.diff(owner) != 0) | (np.diff(frame.piece) != 0))
    changes |= frame.sharp
    kept = np.zeros(len(sphere.directions), bool)
    links: Pairs = []
    at = np.flatnonzero(changes & reached)
    rows: dict[int, list[tuple[int, bool]]] = {}
    for piece, vertex, sharp in zip(
        frame.piece[at].tolist(), owner[at].tolist(), frame.sharp[at].tolist(), strict=True
    ):
        row = rows.setdefault(piece, [])
        _append(row, vertex, sharp, beside)
    for row in rows.values():
        names = [vertex for vertex, _ in row]
        kept[names] = True
        links += list(zip(names[:-1], names[1:], strict=True))
    return links, kept


def _append(
    row: list[tuple[int, bool]], vertex: int, sharp: bool, beside: set[tuple[int, ...]]
) -> None:
    """Go on to a vertex, by the shortest way."""
    while row:
        last, fixed = row[-1]
        if last == vertex:
            row[-1] = (vertex, sharp or fixed)
            return
        if len(row) < 2 or fixed:
            break
        before = row[-2][0]
        if before != vertex and (min(before, vertex), max(before, vertex)) not in beside:
            break
        row.pop()
    row.append((vertex, sharp))


def with_edges(faces: Index, links: Pairs) -> Index:
    """Flip edges that cross a link, so that the link is one.

    A link that crosses more than one edge is left alone, and so is an edge that is a link.

    Parameters
    ----------
    faces : (f, 3) int
    links : list of (int, int)

    Returns
    -------
    (f, 3) int
        The same triangles but for pairs whose common edge was flipped.
    """
    edges, of_face = edges_of(faces)
    order = np.argsort(of_face, axis=None, kind="stable").reshape(-1, 2)
    opposite = np.sort(np.roll(faces, 1, axis=1).ravel()[order], axis=1)
    crossed = {
        (a, b): number for number, (a, b) in enumerate(opposite.tolist())
    }
    taken = set(map(tuple, edges.tolist()))
    wanted = {(min(link), max(link)) for link in links}
    flipped, used = faces.copy(), set()
    for link in sorted(wanted - taken):
        number = crossed.get(link)
        if number is None or tuple(edges[number].tolist()) in wanted:
            continue
        one, two = (order[number] // 3).tolist()
        if one in used or two in used:
            continue
        used |= {one, two}
        corner = int(order[number][0] % 3)
        start, end = faces[one, corner], faces[one, (corner + 1) % 3]
        over, under = faces[one, corner - 1], int(sum(faces[two]) - start - end)
        flipped[one], flipped[two] = (over, start, under), (under, end, over)
    return flipped
