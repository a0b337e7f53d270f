"""Point masses with the mass, the centre and the moments of plates, solids and bars."""

from __future__ import annotations

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto_polyhedron.reconstruction.answer import Rings

LEAST = 1e-9
"""Mass, kg, below which a shape has no extent to speak of."""


def plate_masses(
    points: Array, rings: Rings, thickness: float, density: float
) -> tuple[Array, Array]:
    """Return point masses with the mass, centre and moments of a plate, m and kg.

    A triangle has those of a third of its mass at the middle of each side; a polygon is the sum
    of triangles about a corner, some of them negative where it is not convex or has a hole.
    """
    where, masses = [], []
    outer = points[list(rings[0])]
    normal = _area_vector(outer)
    normal = normal / max(float(np.linalg.norm(normal)), 1e-300)
    for one, other in _sides(points, rings):
        area = 0.5 * float(np.cross(one - outer[0], other - outer[0]) @ normal)
        where += [0.5 * (outer[0] + one), 0.5 * (one + other), 0.5 * (other + outer[0])]
        masses += [area * thickness * density / 3.0] * 3
    found = np.array(masses)
    if found.sum() < LEAST:
        return outer, np.full(len(outer), LEAST)
    return np.array(where), found


def solid_masses(points: Array, faces: tuple[Rings, ...], density: float) -> tuple[Array, Array]:
    """Return point masses with the mass, centre and moments of what faces enclose, m and kg.

    A tetrahedron has those of a twentieth of its mass at each corner and the rest at its middle;
    a solid is the sum of tetrahedra over the triangles of its faces, some of them negative.
    """
    triangles = [
        (rings[0][0], begin, end)
        for rings in faces
        for ring in rings
        for begin, end in zip(ring, (*ring[1:], *ring[:1]), strict=True)
    ]
    return triangle_masses(points, np.reshape(np.array(triangles, np.intp), (-1, 3)), density)


def triangle_masses(points: Array, triangles: Index, density: float) -> tuple[Array, Array]:
    """Return the same of what triangles (t, 3) enclose."""
    apex = points.mean(axis=0)
    first, one, other = (points[triangles[:, k]] for k in range(3))
    volumes = np.einsum("ij,ij->i", first - apex, np.cross(one - apex, other - apex)) / 6.0
    corners = np.stack((np.broadcast_to(apex, first.shape), first, one, other), axis=1)
    where = np.concatenate((corners, corners.mean(axis=1, keepdims=True)), axis=1)
    shares = np.array([0.05, 0.05, 0.05, 0.05, 0.8])
    found = (density * volumes[:, None] * shares).ravel()
    total = float(found.sum())
    if abs(total) < LEAST:
        return points, np.full(len(points), LEAST)
    return where.reshape(-1, 3), found * np.sign(total)


def sheet_masses(
    points: Array, triangles: Index, thickness: float, density: float
) -> tuple[Array, Array]:
    """Return point masses with the mass, centre and moments of thin triangles (t, 3), m and kg."""
    first, one, other = (points[triangles[:, k]] for k in range(3))
    areas = 0.5 * np.linalg.norm(np.cross(one - first, other - first), axis=1)
    where = 0.5 * np.stack((first + one, one + other, other + first), axis=1)
    masses = np.repeat(areas * thickness * density / 3.0, 3)
    return where.reshape(-1, 3), masses + LEAST / max(len(masses), 1)


def bar_masses(begin: Array, end: Array, thickness: float, density: float) -> tuple[Array, Array]:
    """Return point masses with the mass, centre and moments of a slender bar, m and kg."""
    mass = max(density * thickness**2 * float(np.linalg.norm(end - begin)), LEAST)
    where = np.stack((begin, 0.5 * (begin + end), end))
    return where, mass * np.array([1.0, 4.0, 1.0]) / 6.0


def _sides(points: Array, rings: Rings) -> list[tuple[Array, Array]]:
    """Return the sides of all rings, as they run."""
    return [
        (points[begin], points[end])
        for ring in rings
        for begin, end in zip(ring, (*ring[1:], *ring[:1]), strict=True)
    ]


def _area_vector(ring: Array) -> Array:
    return np.asarray(0.5 * np.cross(ring, np.roll(ring, -1, axis=0)).sum(axis=0))
