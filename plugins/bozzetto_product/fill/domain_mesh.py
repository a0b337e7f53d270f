"""Triangles over a domain: boundary vertices where the edges were sampled, even ones inside."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto.geometry import triangulate
from bozzetto.plugin import remembered
from bozzetto_product.fill.domain import Domain, cross

CLEAR: Final = 0.7
"""Least distance of inner vertices from boundary vertices, in spacings."""

SMOOTHINGS: Final = 24
"""Rounds in which inner vertices go to the mean of their neighbours."""

NEWTON_STEPS: Final = 8
"""Steps of Newton's method for the parameters of a place; a bilinear map needs five."""

FLAT: Final = 1e-9
"""Area of a triangle over the square of the spacing that counts as none."""


@dataclass(frozen=True, eq=False)
class DomainMesh:
    """Triangles over a domain.

    Parameters
    ----------
    patches : (m,) int
        That each inner vertex lies in; inner vertices come behind those of the boundary.
    parameters : (m, 2) float
        u and v there.
    triangles : (t, 3) int
        Counter-clockwise.
    """

    patches: Index
    parameters: Array
    triangles: Index


@remembered(limit=200, key=lambda domain, ring: domain.key + ring.tobytes())
def mesh_over(domain: Domain, ring: Array) -> DomainMesh:
    """Return triangles between boundary vertices and inner ones.

    Parameters
    ----------
    domain : Domain
        Of the loop.
    ring : (b, 2) float
        Places of the boundary vertices, counter-clockwise.
    """
    spacing = float(np.linalg.norm(ring - np.roll(ring, -1, axis=0), axis=1).mean())
    for finer in (1.0, 0.7, 0.5):
        inside = _even_places(domain, ring, finer * spacing)
        triangles = _between(domain, np.concatenate((ring, inside)), spacing)
        inside = _smoothed(ring, inside, triangles)
        triangles = _between(domain, np.concatenate((ring, inside)), spacing)
        if _fits(triangles, len(ring), len(ring) + len(inside)):
            patches, parameters = parameters_of(domain, inside)
            return DomainMesh(patches, parameters, triangles)
    flat = triangulate(ring)
    return DomainMesh(np.empty(0, np.intp), np.empty((0, 2)), np.asarray(flat.triangles, np.intp))


def parameters_of(domain: Domain, places: Array) -> tuple[Index, Array]:
    """Return the patch of each place, and its parameters u and v there."""
    quads = domain.quads
    sides = np.roll(quads, -1, axis=1) - quads
    room = cross(sides[None], places[:, None, None] - quads[None]).min(axis=2)
    patch = np.argmax(room, axis=1)
    a, b, c, d = (quads[patch, corner] for corner in range(4))
    at = np.full((len(places), 2), 0.5)
    for _ in range(NEWTON_STEPS):
        u, v = at[:, :1], at[:, 1:]
        off = (1 - u) * (1 - v) * a + u * (1 - v) * b + u * v * c + (1 - u) * v * d - places
        by_u = (1 - v) * (b - a) + v * (c - d)
        by_v = (1 - u) * (d - a) + u * (c - b)
        area = cross(by_u, by_v)
        area = np.where(np.abs(area) > 1e-12, area, 1e-12)
        step = np.column_stack((cross(off, by_v), cross(by_u, off))) / area[:, None]
        at = np.clip(at - step, 0.0, 1.0)
    return patch, at


def _inside(domain: Domain, places: Array) -> Flags:
    """Whether places are in the domain."""
    quads = domain.quads
    sides = np.roll(quads, -1, axis=1) - quads
    room = cross(sides[None], places[:, None, None] - quads[None])
    return np.asarray((room.min(axis=2) >= -1e-12).any(axis=1))


def _even_places(domain: Domain, ring: Array, spacing: float) -> Array:
    """Return places of a triangular grid that are inside and clear of the boundary."""
    from scipy.spatial import cKDTree

    low, high = ring.min(axis=0), ring.max(axis=0)
    centre = domain.centre
    step = spacing * np.array((1.0, np.sqrt(0.75)))
    counts = np.ceil((high - low) / step).astype(int) + 1
    i, j = np.meshgrid(*(np.arange(-count, count + 1) for count in counts), indexing="ij")
    places = centre + np.column_stack(((i + 0.5 * (j % 2)).ravel(), j.ravel())) * step
    places = places[((places > low) & (places < high)).all(axis=1)]
    places = places[_inside(domain, places)]
    if not len(places):
        return centre[None].copy()
    distance, _ = cKDTree(ring).query(places)
    return np.asarray(places[distance > CLEAR * spacing])


def _between(domain: Domain, places: Array, spacing: float) -> Index:
    """Return the Delaunay triangles of places that are inside the domain."""
    from scipy.spatial import Delaunay

    triangles = np.asarray(Delaunay(places).simplices, np.intp)
    a, b, c = (places[triangles[:, corner]] for corner in range(3))
    area = cross(b - a, c - a)
    triangles[area < 0] = triangles[area < 0][:, [0, 2, 1]]
    kept = (np.abs(area) > FLAT * spacing**2) & _inside(domain, (a + b + c) / 3.0)
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


def _fits(triangles: Index, border: int, count: int) -> bool:
    """Whether triangles use all vertices and have the boundary, and nothing else, for border."""
    sides = np.concatenate([triangles[:, [k, (k + 1) % 3]] for k in range(3)])
    keys = sides[:, 0] * count + sides[:, 1]
    back = sides[:, 1] * count + sides[:, 0]
    open_keys = np.sort(keys[~np.isin(keys, back)])
    ring = np.arange(border)
    wanted = np.sort(ring * count + (ring + 1) % border)
    return bool(
        len(np.unique(triangles)) == count
        and len(np.unique(keys)) == len(keys)
        and np.array_equal(open_keys, wanted)
    )
