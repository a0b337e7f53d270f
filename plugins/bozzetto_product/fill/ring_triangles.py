"""Even triangles between the vertices of rings: a grid inside, smoothed, joined by Delaunay."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto.geometry import ring_links
from bozzetto_product.fill.domain import cross

CLEAR: Final = 0.7
"""Least distance of inner vertices from boundary vertices, in spacings."""

SMOOTHINGS: Final = 24
"""Rounds in which inner vertices go to the mean of their neighbours."""

FLAT: Final = 1e-9
"""Area of a triangle over the square of the spacing that counts as none."""

FINER: Final = (1.0, 0.7, 0.5)
"""Spacings that are tried until every side of the ring is one of a triangle."""

Inside = Callable[[Array], Flags]
"""Whether places, (n, 2), are inside."""


def even_triangles(
    rings: Sequence[Array], spacing: float, centre: Array, inside: Inside
) -> tuple[Array, Index] | None:
    """Return inner vertices, and triangles between them and those of rings.

    Parameters
    ----------
    rings : sequence of (b, 2) float
        The outline, counter-clockwise, and those of holes, clockwise; none crosses another one.
    spacing : float
        Of the inner vertices.
    centre : (2,) float
        From which the grid of these starts.
    inside : callable
        Whether places are within the outline, and in no hole.

    Returns
    -------
    places : (m, 2) float
    triangles : (t, 3) int
        Counter-clockwise; the vertices of the rings are counted first.
    or None where a side of a ring was in no triangle.
    """
    ring, (after, _) = np.concatenate(rings), ring_links([len(each) for each in rings])
    for finer in FINER:
        places = _even_places(ring, finer * spacing, centre, inside)
        triangles = _between(np.concatenate((ring, places)), spacing, inside)
        places = _smoothed(ring, places, triangles)
        triangles = _between(np.concatenate((ring, places)), spacing, inside)
        if _fits(triangles, after, len(ring) + len(places)):
            return places, triangles
    return None


def _even_places(ring: Array, spacing: float, centre: Array, inside: Inside) -> Array:
    """Return places of a triangular grid that are inside and clear of the boundary."""
    from scipy.spatial import cKDTree

    low, high = ring.min(axis=0), ring.max(axis=0)
    step = spacing * np.array((1.0, np.sqrt(0.75)))
    counts = np.ceil((high - low) / step).astype(int) + 1
    i, j = np.meshgrid(*(np.arange(-count, count + 1) for count in counts), indexing="ij")
    places = centre + np.column_stack(((i + 0.5 * (j % 2)).ravel(), j.ravel())) * step
    places = places[((places > low) & (places < high)).all(axis=1)]
    places = places[inside(places)]
    if not len(places):
        return centre[None].copy()
    distance, _ = cKDTree(ring).query(places)
    return np.asarray(places[distance > CLEAR * spacing])


def _between(places: Array, spacing: float, inside: Inside) -> Index:
    """Return the Delaunay triangles of places that are inside."""
    from scipy.spatial import Delaunay

    triangles = np.asarray(Delaunay(places).simplices, np.intp)
    a, b, c = (places[triangles[:, corner]] for corner in range(3))
    area = cross(b - a, c - a)
    triangles[area < 0] = triangles[area < 0][:, [0, 2, 1]]
    kept = (np.abs(area) > FLAT * spacing**2) & inside((a + b + c) / 3.0)
    return triangles[kept]


def _smoothed(ring: Array, inside: Array, triangles: Index) -> Array:
    """Return inner places after some rounds of moving each to the mean of its neighbours."""
    from scipy.sparse import csr_array

    count = len(ring) + len(inside)
    rows = triangles[:, [0, 1, 2, 1, 2, 0]].ravel()
    columns = triangles[:, [1, 2, 0, 0, 1, 2]].ravel()
    links = csr_array((np.ones(len(rows)), (rows, columns)), shape=(count, count))[len(ring) :]
    total = np.maximum(np.asarray(links.sum(axis=1)).ravel(), 1.0)[:, None]
    places = np.concatenate((ring, inside))
    for _ in range(SMOOTHINGS):
        places[len(ring) :] = (links @ places) / total
    return places[len(ring) :]


def _fits(triangles: Index, after: Index, count: int) -> bool:
    """Whether triangles use all vertices and have the boundary, and nothing else, for border."""
    sides = np.concatenate([triangles[:, [k, (k + 1) % 3]] for k in range(3)])
    keys = sides[:, 0] * count + sides[:, 1]
    back = sides[:, 1] * count + sides[:, 0]
    open_keys = np.sort(keys[~np.isin(keys, back)])
    wanted = np.sort(np.arange(len(after)) * count + after)
    return bool(
        len(np.unique(triangles)) == count
        and len(np.unique(keys)) == len(keys)
        and np.array_equal(open_keys, wanted)
    )
