"""Point masses with the mass, the centre and the moments of plates, solids and bars."""

from __future__ import annotations

import numpy as np

from bozzetto.arrays import Array
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
    where, masses = [], []
    apex = points.mean(axis=0)
    for rings in faces:
        first = points[rings[0][0]]
        for one, other in _sides(points, rings):
            volume = float((first - apex) @ np.cross(one - apex, other - apex)) / 6.0
            corners = np.stack((apex, first, one, other))
            where += [*corners, corners.mean(axis=0)]
            masses += [0.05 * volume * density] * 4 + [0.8 * volume * density]
    found = np.array(masses)
    total = float(found.sum())
    if abs(total) < LEAST:
        return points, np.full(len(points), LEAST)
    return np.array(where), found * np.sign(total)


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
