"""Charts of a texture: triangles that are joined in its picture, and the same on a coarser mesh.

A chart may meet itself, as the unrolled side of a can does: a vertex of its seam is at two places.
Such charts are cut in two, across the way between these places, until none is.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.geometry.texture import Texture

if TYPE_CHECKING:
    from bozzetto.arrays import Array, Index
    from bozzetto.geometry.mesh import Mesh

CUTS: Final = 12
"""Rounds of cutting charts in two."""


def charts(mesh: Mesh, texture: Texture) -> Index:
    """Return the number of the chart of each triangle, (f,).

    Triangles are in one chart that share an edge on the surface and in the picture, as long as no
    vertex is at two places of one chart.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    count = len(mesh.faces)
    corner = _corners(mesh, texture)
    begin, end = corner.ravel(), np.roll(corner, -1, axis=1).ravel()
    span = np.int64(corner.max(initial=0)) + 1
    keys = np.minimum(begin, end) * span + np.maximum(begin, end)
    order = np.argsort(keys, kind="stable")
    same = keys[order][1:] == keys[order][:-1]
    face = np.repeat(np.arange(count), 3)[order]
    one, other = face[1:][same], face[:-1][same]
    links = coo_array((np.ones(len(one), np.int8), (one, other)), shape=(count, count))
    _, number = connected_components(links, directed=False)
    chart = np.asarray(number, np.int64)
    middles = texture.corners.mean(axis=1, dtype=np.float64)
    for _ in range(CUTS):
        apart = _apart(mesh, texture, corner, chart)
        torn = np.flatnonzero(apart.any(axis=1))
        if not len(torn):
            break
        rank = np.full(len(apart), -1)
        rank[torn] = np.arange(len(torn))
        of_face = rank[chart]
        inside = np.flatnonzero(of_face >= 0)
        own = of_face[inside]
        along = middles[inside, apart[torn].argmax(axis=1)[own]]
        middle = np.bincount(own, along) / np.bincount(own)
        chart[inside[along > middle[own]]] += len(apart)
        _, chart = np.unique(chart, return_inverse=True)
    return chart.astype(np.intp)


def _apart(mesh: Mesh, texture: Texture, corner: Index, chart: Index) -> Array:
    """Return for each chart how far apart a vertex of it is from itself at most, (c, 2)."""
    span = np.int64(len(mesh.vertices))
    keys = (chart[:, None] * span + mesh.faces).ravel()
    order = np.lexsort((corner.ravel(), keys))
    key, own = keys[order], corner.ravel()[order]
    again = np.flatnonzero((key[1:] == key[:-1]) & (own[1:] != own[:-1]))
    places = texture.corners.reshape(-1, 2).astype(np.float64)[order]
    found = np.zeros((int(chart.max(initial=-1)) + 1, 2))
    np.maximum.at(found, key[again] // span, np.abs(places[again + 1] - places[again]))
    return found


def on_fewer(
    mesh: Mesh, texture: Texture, chart: Index, corners: Index, kept: Index
) -> Texture | None:
    """Return a texture for fewer triangles of the same charts.

    Parameters
    ----------
    mesh, texture
        The surface with all its triangles.
    chart : (f,) int
        Of each triangle, as `charts` gives it.
    corners : (g, 3) int
        Fewer triangles, over the vertices of the mesh.
    kept : (g,) int
        The chart of each of these.

    Returns
    -------
    Texture or None
        None where a chart meets itself so that nobody knows which of its places is meant.
    """
    span = np.int64(len(mesh.vertices))
    known = (chart[:, None] * span + mesh.faces).ravel()
    keys, first = np.unique(known, return_index=True)
    if _apart(mesh, texture, _corners(mesh, texture), chart).any():
        return None
    wanted = (kept[:, None] * span + corners).ravel()
    at = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
    if (keys[at] != wanted).any():
        return None
    places = texture.corners.reshape(-1, 2)[first[at]]
    return Texture(texture.pixels, places.reshape(-1, 3, 2))


def _corners(mesh: Mesh, texture: Texture) -> NDArray[np.int64]:
    """Return a number for each corner, (f, 3): the same at one vertex and one place."""
    # + 0.0 makes the two zeros one, so that equal places have equal bits.
    places = np.ascontiguousarray(texture.corners + np.float32(0.0)).reshape(-1, 2)
    _, place = np.unique(places.view(np.int64), return_inverse=True)
    pairs = mesh.faces.ravel().astype(np.int64) * (int(place.max(initial=0)) + 1) + place.ravel()
    _, number = np.unique(pairs, return_inverse=True)
    return np.asarray(number.reshape(-1, 3), np.int64)
