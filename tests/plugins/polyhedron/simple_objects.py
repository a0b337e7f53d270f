"""A few polyhedra with flat faces, and views of them in general position."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bozzetto.arrays import Array

Ring = tuple[int, ...]
Rings = tuple[Ring, ...]


@dataclass(frozen=True, eq=False)
class Polyhedron:
    """Vertices (n, 3), edges as pairs of vertices, faces as rings."""

    vertices: Array
    edges: tuple[tuple[int, int], ...]
    faces: tuple[Rings, ...]


def edges_of(faces: tuple[Rings, ...]) -> tuple[tuple[int, int], ...]:
    pairs = {
        (min(a, b), max(a, b))
        for rings in faces
        for ring in rings
        for a, b in zip(ring, ring[1:] + ring[:1], strict=True)
    }
    return tuple(sorted(pairs))


def prism(outline: list[tuple[float, float]], height: float, top: float = 1.0) -> Polyhedron:
    """Extrude an outline; the upper one is `top` times as large."""
    base = np.array(outline)
    n = len(base)
    vertices = np.vstack([np.c_[base, np.zeros(n)], np.c_[base * top, np.full(n, height)]])
    sides = tuple((((i, (i + 1) % n, n + (i + 1) % n, n + i)),) for i in range(n))
    faces = ((tuple(range(n))[::-1],), (tuple(range(n, 2 * n)),), *sides)
    return Polyhedron(vertices, edges_of(faces), faces)


def notch() -> Polyhedron:
    """Return a cube without one corner."""
    vertices = np.array(
        [
            *[(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (0, 0, 2), (2, 0, 2), (0, 2, 2)],
            *[(2, 1, 2), (1, 1, 2), (1, 2, 2), (2, 2, 1), (2, 1, 1), (1, 1, 1), (1, 2, 1)],
        ],
        float,
    )
    outer = (
        *[(0, 3, 2, 1), (0, 1, 5, 4), (0, 4, 6, 3), (1, 2, 10, 11, 7, 5), (2, 3, 6, 9, 13, 10)],
        *[(4, 5, 7, 8, 9, 6), (7, 11, 12, 8), (8, 12, 13, 9), (11, 10, 13, 12)],
    )
    faces = tuple((ring,) for ring in outer)
    return Polyhedron(vertices, edges_of(faces), faces)


def through_hole() -> Polyhedron:
    """Return a block with a square hole through it: two parts of one line drawing."""
    block = prism([(0, 0), (3, 0), (3, 3), (0, 3)], 2.0)
    hole = prism([(1, 0.8), (2.1, 0.8), (2.1, 2), (1, 2)], 2.0)
    inner = [tuple(tuple(i + 8 for i in ring[::-1]) for ring in rings) for rings in hole.faces]
    caps = tuple((block.faces[k][0], inner[k][0]) for k in (0, 1))
    faces = (*caps, *block.faces[2:], *inner[2:])
    return Polyhedron(np.vstack([block.vertices, hole.vertices]), edges_of(faces), faces)


def three_bars() -> Polyhedron:
    """Return bars along three axes from one cube: six edges meet at its corner between them."""
    x, y, z = 3.0, 2.6, 3.3
    vertices = np.array(
        [
            *[(0, 0, 0), (1, 1, 1), (1, 1, 0), (1, 0, 1), (0, 1, 1)],
            *[(x, 0, 0), (x, 1, 0), (x, 1, 1), (x, 0, 1)],
            *[(0, y, 0), (1, y, 0), (1, y, 1), (0, y, 1)],
            *[(0, 0, z), (1, 0, z), (1, 1, z), (0, 1, z)],
        ],
        float,
    )
    outer = (
        *[(5, 6, 7, 8), (9, 12, 11, 10), (13, 14, 15, 16)],
        *[(0, 9, 10, 2, 6, 5), (0, 5, 8, 3, 14, 13), (0, 13, 16, 4, 12, 9)],
        *[
            (2, 1, 7, 6),
            (3, 8, 7, 1),
            (2, 10, 11, 1),
            (4, 1, 11, 12),
            (3, 1, 15, 14),
            (4, 16, 15, 1),
        ],
    )
    faces = tuple((ring,) for ring in outer)
    return Polyhedron(vertices, edges_of(faces), faces)


def hexagon() -> list[tuple[float, float]]:
    return [(float(np.cos(a)), float(np.sin(a))) for a in np.arange(6) * np.pi / 3]


OBJECTS: dict[str, Polyhedron] = {
    "box": prism([(0, 0), (1.2, 0), (1.2, 1), (0, 1)], 1.4),
    "wedge": prism([(0, 0), (2, 0), (0, 1.2)], 1.5),
    "L": prism([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)], 1.3),
    "three stairs": prism([(0, 0), (3, 0), (3, 1), (2, 1), (2, 2), (1, 2), (1, 3), (0, 3)], 2.0),
    "U": prism([(0, 0), (3, 0), (3, 2), (2, 2), (2, 1), (1, 1), (1, 2), (0, 2)], 1.6),
    "T": prism([(1, 0), (2, 0), (2, 1.5), (3, 1.5), (3, 2.5), (0, 2.5), (0, 1.5), (1, 1.5)], 1.2),
    "house": prism([(0, 0), (2, 0), (2, 1.2), (1, 2), (0, 1.2)], 2.6),
    "frustum": prism([(1, 1), (-1, 1), (-1, -1), (1, -1)], 0.85, top=0.5),
    "notch": notch(),
    "wedge and step": prism([(0, 0), (3, 0), (3, 1), (2, 1), (1, 2), (0, 2)], 1.5),
    "hexagonal prism": prism(hexagon(), 1.5),
    "plus": prism(
        [
            *[(1, 0), (2, 0), (2, 1), (3, 1), (3, 2), (2, 2)],
            *[(2, 3), (1, 3), (1, 2), (0, 2), (0, 1), (1, 1)],
        ],
        1.2,
    ),
    "five stairs": prism(
        [
            *[(0, 0), (5, 0), (5, 1), (4, 1), (4, 2), (3, 2)],
            *[(3, 3), (2, 3), (2, 4), (1, 4), (1, 5), (0, 5)],
        ],
        3.0,
    ),
    "through-hole": through_hole(),
}


def turned(azimuth: float, elevation: float, roll: float) -> Array:
    """Return the rotation whose rows are right, up and away from the eye (radians)."""
    ca, sa, ce, se = np.cos(azimuth), np.sin(azimuth), np.cos(elevation), np.sin(elevation)
    cr, sr = np.cos(roll), np.sin(roll)
    about_up = np.array([[ca, -sa, 0], [sa, ca, 0], [0, 0, 1]])
    tilt = np.array([[1, 0, 0], [0, -se, ce], [0, -ce, -se]])
    return np.array([[cr, -sr, 0], [sr, cr, 0], [0, 0, 1]]) @ tilt @ about_up


def is_general(places: Array, edges: tuple[tuple[int, int], ...]) -> bool:
    """Whether corners are 3 % of the diagonal apart, and 1.2 % from lines of others."""
    apart = np.linalg.norm(places[:, None] - places, axis=2) + np.eye(len(places))
    a, b = places[np.array(edges)].transpose(1, 0, 2)
    along = ((places[:, None] - a) * (b - a)).sum(2) / ((b - a) ** 2).sum(1)
    feet = a + np.clip(along, 0, 1)[..., None] * (b - a)
    away = np.linalg.norm(places[:, None] - feet, axis=2)
    for line, ends in enumerate(edges):
        away[list(ends), line] = 1.0
    return bool(apart.min() > 0.03 and away.min() > 0.012)


def view(body: Polyhedron, seed: int, distance: float | None = None) -> Array | None:
    """Project a body in general position; the diagonal of the drawing is 1.

    Parameters
    ----------
    distance : float, optional
        Of the eye, in sizes of the body; a parallel projection without.
    """
    rng = np.random.default_rng(seed)
    for _ in range(200):
        solid = (body.vertices - body.vertices.mean(0))[:, rng.permutation(3)]
        azimuth, elevation = np.radians([rng.uniform(20, 70), rng.uniform(18, 45)])
        seen = solid @ turned(azimuth, elevation, rng.normal(0, np.radians(3))).T
        places = seen[:, :2].copy()
        if distance is not None:
            depth = distance * np.linalg.norm(np.ptp(solid, axis=0))
            places *= (depth / (depth + seen[:, 2]))[:, None]
        places /= np.linalg.norm(np.ptp(places, axis=0))
        if is_general(places, body.edges):
            return places
    return None
