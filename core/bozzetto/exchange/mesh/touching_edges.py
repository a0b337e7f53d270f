"""Bodies that touch themselves or one another along edges, taken apart there.

Edges of four or more faces have no one neighbour for each face. Cut along them, as A. Guéziec,
G. Taubin, F. Lazarus and W. Horn have it ("Converting sets of polygons to manifold surfaces by
cutting and stitching", IEEE Visualization 1998), and each side stitched to the one across its own
material, they are closed skins that lie at one place.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Array, Faces, Index

__all__ = ["apart_at_touching_edges"]


def apart_at_touching_edges(
    vertices: NDArray[np.float32], faces: Faces
) -> tuple[Index, Faces] | None:
    """Return a mesh whose faces have one neighbour at each side, where touching edges allow it.

    Parameters
    ----------
    vertices : (n, 3) float32
        Places.
    faces : (m, 3) int32
        Triangles, wound one way.

    Returns
    -------
    kept : (k,) int
        The vertex that each of the new ones lies at.
    faces : (m, 3) int32
        The faces over these.

        None where no edge has more than two faces, and where an edge has more to one side than to
        the other, faces that lie on one another, or material that overlaps.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    begin = faces.astype(np.int64).ravel()
    end = np.roll(faces, -1, axis=1).astype(np.int64).ravel()
    forth, low, high = begin < end, np.minimum(begin, end), np.maximum(begin, end)
    order = np.lexsort((forth, high, low))
    is_first = (np.diff(low[order], prepend=-1) != 0) | (np.diff(high[order], prepend=-1) != 0)
    first = np.flatnonzero(is_first)
    count = np.diff(first, append=len(order))
    balanced = np.add.reduceat(forth[order].astype(np.intp), first) * 2 == count
    if count.max() <= 2 or not balanced.all():
        return None
    many = np.flatnonzero(np.repeat(count > 2, count))
    start, size = (np.repeat(each, count)[many] for each in (first, count))
    angles = _angles(vertices, faces, order[many], order[start])
    sorting = np.lexsort((angles, start))
    is_next = np.diff(start) == 0
    if (np.diff(angles[sorting])[is_next] == 0.0).any():
        return None
    around = order[many][sorting]
    place = np.arange(len(many)) - np.searchsorted(start, start)
    # Material lies from a side that goes back to the next one, about the edge, that goes forth.
    shift = forth[around[np.searchsorted(start, start)]]
    around = around[np.searchsorted(start, start) + (place - shift) % size]
    if (forth[around] != place % 2).any():
        return None
    order[many] = around
    back, ahead = order.reshape(-1, 2).T
    following = np.roll(np.arange(faces.size).reshape(-1, 3), -1, axis=1).ravel()
    rows, columns = np.append(back, following[back]), np.append(following[ahead], ahead)
    links = coo_array((np.ones(len(rows), bool), (rows, columns)), shape=(faces.size, faces.size))
    number, label = connected_components(links, directed=False)
    kept = np.empty(number, np.intp)
    kept[label] = begin
    return kept, label.reshape(-1, 3).astype(np.int32)


def _angles(vertices: NDArray[np.float32], faces: Faces, sides: Index, others: Index) -> Array:
    """Return the directions in which faces leave an edge, about it.

    Parameters
    ----------
    vertices, faces
        As above.
    sides : (s,) int
        Corners at which the edge begins in its faces, numbered through all faces.
    others : (s,) int
        The same of another face at the edge of each, from which directions count.

    Returns
    -------
    (s,) float
        Radians, looking along the edge from the lower of its vertices to the higher.
    """
    flat, places = faces.ravel(), vertices.astype(float)
    ends = np.stack((flat[sides], faces[sides // 3, (sides % 3 + 1) % 3]))
    low, high = places[ends.min(axis=0)], places[ends.max(axis=0)]
    along = high - low
    along /= np.maximum(np.linalg.norm(along, axis=1), np.finfo(float).tiny)[:, None]
    away, zero = (places[faces[one // 3, (one % 3 + 2) % 3]] - low for one in (sides, others))
    aside = np.cross(along, zero)
    angles: Array = np.arctan2(
        np.einsum("ij,ij->i", away, aside),
        np.einsum("ij,ij->i", away, np.cross(aside, along)),
    )
    return angles
