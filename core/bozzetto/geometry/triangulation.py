"""Constrained Delaunay triangulation of the inside of rings, with indices."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bozzetto.arrays import Array, Index


@dataclass(frozen=True, eq=False)
class Triangulation:
    """Triangles whose corners are the vertices of rings.

    Attributes
    ----------
    points : (n, 2) float
        Vertices of all rings, ring after ring.
    triangles : (t, 3) int
        Corners.
    chords : (c, 2) int
        Edges inside the region, each once: the end points.
    across : (c, 2) int
        The two triangles on either side of each chord.
    sides : (t, 3) int
        Chord number of the edge from corner k to corner k + 1, or -1 on the outline.
        The count of chords tells the kind: 1 terminal, 2 sleeve, 3 junction.
    """

    points: Array
    triangles: Index
    chords: Index
    across: Index
    sides: Index


def triangulate(outer: Array, holes: tuple[Array, ...] = ()) -> Triangulation:
    """Triangulate one outer ring with its holes.

    Parameters
    ----------
    outer : (n, 2) float
        Simple ring, first vertex not repeated.
    holes : tuple of (m, 2) floats
        Simple rings inside `outer`.

    Returns
    -------
    Triangulation

    Raises
    ------
    ValueError
        When the rings cross, so that their vertices cannot be recovered.

    Notes
    -----
    shapely returns polygons, not indices; GEOS copies coordinates unrounded, so that they
    are recovered exactly by matching them as complex numbers.
    """
    import shapely

    rings = [np.ascontiguousarray(r, dtype=np.float64) for r in (outer, *holes)]
    points = np.concatenate(rings) + 0.0  # turns -0.0 into 0.0: one number, one pattern
    polygon = shapely.Polygon(rings[0], rings[1:])
    try:
        pieces = shapely.get_parts(shapely.constrained_delaunay_triangles(polygon))
    except shapely.GEOSException as problem:
        raise ValueError("the rings cross or touch") from problem
    corners = shapely.get_coordinates(pieces).reshape(-1, 4, 2)[:, :3].reshape(-1, 2) + 0.0
    key, wanted = points.view(np.complex128).ravel(), corners.view(np.complex128).ravel()
    order = np.argsort(key)
    found = order[np.minimum(np.searchsorted(key, wanted, sorter=order), len(key) - 1)]
    if not np.array_equal(key[found], wanted):
        raise ValueError("the rings cross or touch: triangle corners are not ring vertices")
    triangles = found.reshape(-1, 3)

    n = len(points)
    after, _ = ring_links([len(r) for r in rings])
    a, b = triangles, np.roll(triangles, -1, axis=1)
    keys = np.minimum(a, b) * n + np.maximum(a, b)
    edges, label, uses = np.unique(keys, return_inverse=True, return_counts=True)
    label = label.reshape(-1, 3)
    first, second = edges // n, edges % n
    rim = (after[first] == second) | (after[second] == first)
    inner = ~rim & (uses == 2)
    number = np.where(inner, np.cumsum(inner) - 1, -1)
    sides = number[label]
    owner = np.repeat(np.arange(len(triangles)), 3)[np.argsort(sides.ravel(), kind="stable")]
    across = owner[(sides == -1).sum() :].reshape(-1, 2)
    return Triangulation(
        points, triangles, np.stack([first[inner], second[inner]], axis=1), across, sides
    )


def ring_links(counts: list[int]) -> tuple[Index, Index]:
    """Return successor and predecessor of every vertex of rings stored one after another.

    Parameters
    ----------
    counts : list of int
        Number of vertices of each ring.

    Returns
    -------
    after, before : (n,) int
        Numbers of vertices; the last one of a ring is followed by its first.
    """
    after = np.arange(sum(counts), dtype=np.intp) + 1
    start = 0
    for count in counts:
        after[start + count - 1] = start
        start += count
    before = np.empty_like(after)
    before[after] = np.arange(len(after))
    return after, before
