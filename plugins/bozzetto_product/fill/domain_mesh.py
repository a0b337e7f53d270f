"""Triangles over a domain: boundary vertices where the edges were sampled, even ones inside."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto.geometry import triangulate
from bozzetto.plugin import remembered
from bozzetto_product.fill.domain import Domain, cross
from bozzetto_product.fill.ring_triangles import even_triangles

NEWTON_STEPS: Final = 8
"""Steps of Newton's method for the parameters of a place; a bilinear map needs five."""


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
    made = even_triangles((ring,), spacing, domain.centre, lambda places: _inside(domain, places))
    if made is not None:
        inside, triangles = made
        return DomainMesh(*parameters_of(domain, inside), triangles)
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
