"""Exact shapes of every kind, with their volumes and areas in closed form."""

from __future__ import annotations

from dataclasses import dataclass
from math import hypot, pi

import numpy as np

from bozzetto.geometry import (
    Brep,
    BSplineSurface,
    Curve,
    cylinder,
    plane_face,
    sewn,
    surface_of_revolution,
)

HALF = 2**-0.5
UP = (0.0, 0.0, 1.0)
ZERO = (0.0, 0.0, 0.0)


def polyline(corners):
    corners = np.asarray(corners, float)
    inner = np.arange(len(corners), dtype=float)
    return Curve(1, np.concatenate((inner[:1], inner, inner[-1:])), corners)


def half_circle(radius, middle=ZERO):
    """From the lowest to the highest point in the plane y = 0."""
    flat = np.array([(0, -1), (1, -1), (1, 0), (1, 1), (0, 1)], float) * radius
    points = np.column_stack((flat[:, 0], np.zeros(5), flat[:, 1])) + middle
    return Curve(2, (0, 0, 0, 1, 1, 2, 2, 2), points, (1, HALF, 1, HALF, 1))


def circle(radius, middle=ZERO):
    """Counter-clockwise in the plane y = 0 seen from below it, its start furthest out."""
    flat = np.array(
        [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0)], float
    )
    points = np.column_stack((flat[:, 0], np.zeros(9), flat[:, 1])) * radius + middle
    weights = (1, HALF, 1, HALF, 1, HALF, 1, HALF, 1)
    return Curve(2, (0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4), points, weights, closed=True)


def box(size=(7.0, 5.0, 3.0), name="box"):
    corners = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]) * size
    faces = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    return sewn([plane_face([corners[list(face)]]) for face in faces], name)


def bent_net(seed, size=20.0, height=4.0):
    """A rational surface of degrees three and two, bent at random, and nowhere folded."""
    rng = np.random.default_rng(seed)
    x, y = np.meshgrid(np.linspace(0, size, 6), np.linspace(0, size, 4), indexing="ij")
    net = np.stack((x, y, height * rng.normal(size=x.shape)), axis=-1)
    knots_u, knots_v = (0, 0, 0, 0, 0.3, 0.7, 1, 1, 1, 1), (0, 0, 0, 1, 2, 2, 2)
    return BSplineSurface((3, 2), knots_u, knots_v, net, rng.uniform(0.7, 1.4, x.shape))


@dataclass(frozen=True)
class Known:
    """A closed brep, with its volume and area."""

    brep: Brep
    volume: float
    area: float
    genus: int = 0


def known():
    """Return solids whose volume and area are known in closed form (Pappus for the torus)."""
    tube = polyline([(3, 0, 0), (4, 0, 0), (4, 0, 9), (3, 0, 9), (3, 0, 0)])
    made = {
        "sphere": Known(
            surface_of_revolution(half_circle(5.0), ZERO, UP), 4 / 3 * pi * 125, 4 * pi * 25
        ),
        "cylinder": Known(cylinder(ZERO, (0, 0, 10), 3.0), 90 * pi, 2 * pi * 3 * 13),
        "cone": Known(
            surface_of_revolution(polyline([(0, 0, 0), (4, 0, 0), (0, 0, 9)]), ZERO, UP),
            48 * pi,
            pi * 4 * (4 + hypot(4, 9)),
        ),
        "torus": Known(
            surface_of_revolution(circle(2.0, (8, 0, 0)), ZERO, UP),
            2 * pi**2 * 8 * 4,
            4 * pi**2 * 8 * 2,
            genus=1,
        ),
        "tube": Known(
            surface_of_revolution(tube, ZERO, UP),
            pi * 7 * 9,
            2 * pi * 7 * 9 + 2 * pi * 7,
            genus=1,
        ),
        "box": Known(box(), 105.0, 142.0),
    }
    return made


KNOWN = known()
