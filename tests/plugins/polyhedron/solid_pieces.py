"""Boxes and other solids that meet one another, SI units, and how long they are watched."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from manifold3d import Manifold

from bozzetto.geometry import Mesh
from bozzetto_polyhedron.mechanism.assembly import Assembly, Colliding, Ground, Motion
from bozzetto_polyhedron.mechanism.convex_parts import Polytope, convex_parts, polytope_of
from bozzetto_polyhedron.mechanism.masses import solid_masses

DENSITY = 600.0


def mesh_of(body: Manifold) -> Mesh:
    """Return the triangles of a body."""
    made = body.to_mesh()
    return Mesh(np.array(made.vert_properties), np.array(made.tri_verts, np.int32))


def chair() -> Manifold:
    """A chair of 40 × 40 × 84, mm, that stands on four legs."""
    made = Manifold.cube((40, 40, 4)).translate((0, 0, 40))
    for x in (0, 36):
        for y in (0, 36):
            made += Manifold.cube((4, 4, 40)).translate((x, y, 0))
    return made + Manifold.cube((4, 40, 40)).translate((0, 0, 44))


def box(size: Sequence[float]) -> Manifold:
    """A box about its middle, mm."""
    return Manifold.cube(tuple(size), True)


def dropped(
    bodies: Sequence[Manifold],
    places: Sequence[Sequence[float]],
    turns: Sequence[np.ndarray] | None = None,
    *,
    friction: float = 0.5,
    ground: bool = True,
) -> tuple[Assembly, Motion]:
    """Return bodies (mm) with their centres of mass at places (m) over the ground."""
    masses, inertias, parts, owners, corners, standing = [], [], [], [], [], []
    for number, body in enumerate(bodies):
        mesh = mesh_of(body)
        points = np.asarray(mesh.vertices, float) / 1e3
        rings = tuple((tuple(face),) for face in mesh.faces.tolist())
        where, mass = solid_masses(points, rings, DENSITY)
        middle = mass @ where / mass.sum()
        arms = where - middle
        masses.append(mass.sum())
        square = (mass * (arms**2).sum(axis=1)).sum()
        inertias.append(square * np.eye(3) - np.einsum("k,ki,kj->ij", mass, arms, arms))
        for part in convex_parts(mesh):
            parts.append(part.scaled(1e-3, -middle * 1e3))
            owners.append(number)
        corners.append(points - middle)
        standing.append(np.full(len(points), number))
    assembly = Assembly(
        np.array(masses),
        np.array(inertias),
        ground=Ground(np.concatenate(standing), np.concatenate(corners), 0.0) if ground else None,
        colliding=Colliding(np.array(owners), tuple(parts)),
        friction=friction,
    )
    motion = Motion.at_rest(np.array(places, float))
    if turns is None:
        return assembly, motion
    return assembly, Motion(motion.places, np.array(turns), motion.velocities, motion.momenta)


def random_polytope(rng: np.random.Generator) -> Polytope:
    """A polytope of six to twelve corners, about 0.1 m large."""
    made = polytope_of(rng.normal(size=(int(rng.integers(6, 13)), 3)) * 0.04)
    assert made is not None
    return made
