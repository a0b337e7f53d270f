"""Folded sheets: faces that bound no volume."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tests.plugins.polyhedron.objects import Polyhedron
from tests.plugins.polyhedron.write_samples import edges_of


def strip(path: Sequence[tuple[float, float]], depth: float, name: str) -> Polyhedron:
    """Return a strip that is folded along a path in x and z."""
    count = len(path)
    corners = [(x, y, z) for y in (0.0, depth) for x, z in path]
    faces = tuple(((k, k + 1, count + k + 1, count + k),) for k in range(count - 1))
    return Polyhedron(np.array(corners, float), edges_of(faces), faces, name)


def sheets(seed: int) -> list[Polyhedron]:
    """Return sheets with dimensions by chance that right angles determine."""
    a, b, c, d = np.random.default_rng((77, seed)).uniform(0.8, 1.6, 4)
    corner = (((0, 1, 2, 3),), ((0, 1, 5, 4),), ((0, 3, 6, 4),))
    places = [(0, 0, 0), (a, 0, 0), (a, b, 0), (0, b, 0), (0, 0, c), (a, 0, c), (0, b, c)]
    return [
        strip([(0, b), (0, 0), (a, 0)], d, "angle"),
        strip([(0, b), (0, 0), (a, 0), (a, c)], d, "channel"),
        strip([(-c, b), (0, b), (0, 0), (a, 0)], d, "step"),
        strip([(-c, b), (0, b), (0, 0), (a, 0), (a, b), (a + c, b)], d, "hat"),
        Polyhedron(np.array(places, float), edges_of(corner), corner, "corner"),
    ]
