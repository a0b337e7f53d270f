"""How a thing lies on a table: the placement that puts its steadiest face down."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bozzetto.geometry.placement import Placement

if TYPE_CHECKING:
    from bozzetto.arrays import Array

SAME_FACE: Final = np.cos(np.radians(1.0))
"""Cosine of the angle up to which neighbouring faces of a hull are one face."""

SAME_AREA: Final = 0.98
"""Share of the largest face that is as good; of those, the one that needs the least turn."""


def lying_flat(points: ArrayLike) -> Placement:
    """Return the placement that lays points on the largest face of their hull that holds them.

    A face holds them if the hull's centre of mass is above it. The lowest point is at z = 0
    then, the middle of the box at x = y = 0.

    Parameters
    ----------
    points : (n, 3) array_like
        mm. Where they lie in one plane, or are fewer than four, they are only moved.
    """
    from scipy.spatial import ConvexHull, QhullError

    places = np.unique(np.asarray(points, float).reshape(-1, 3), axis=0)
    turn = np.eye(3)
    if len(places) > 3:
        try:
            hull = ConvexHull(places)
        except QhullError:  # all in one plane
            turn = _flat_turn(places)
        else:
            turn = _down(_steadiest(places, hull.simplices, hull.equations[:, :3]))
    if not len(places):
        return Placement()
    turned = places @ turn.T
    low, high = turned.min(axis=0), turned.max(axis=0)
    middle = 0.5 * (low + high)
    offset = (-float(middle[0]), -float(middle[1]), -float(low[2]))
    return Placement(tuple(turn.ravel().tolist()), 1.0, offset)


def _flat_turn(places: Array) -> Array:
    """Return the turn that lays points of one plane on it."""
    _, sizes, axes = np.linalg.svd(places - places.mean(axis=0))
    if sizes[1] <= 1e-9 * sizes[0]:
        return np.eye(3)
    normal = axes[2]
    return _down(-normal if normal[2] > 0 else normal)


def _steadiest(places: Array, simplices: NDArray[Any], normals: Array) -> Array:
    """Return the outward normal of the face of a hull to lie on."""
    corners = places[simplices]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = 0.5 * np.linalg.norm(across, axis=1)
    inside = places.mean(axis=0)
    volumes = areas * np.einsum("ij,ij->i", corners[:, 0] - inside, normals) / 3.0
    centres = (corners.sum(axis=1) + inside) / 4.0
    mass = (volumes[:, None] * centres).sum(axis=0) / volumes.sum()
    order = np.argsort(-areas, kind="stable")
    taken = np.zeros(len(areas), bool)
    faces: list[tuple[float, float, Array]] = []
    for first in order:
        if taken[first]:
            continue
        own = (normals @ normals[first] >= SAME_FACE) & ~taken
        taken |= own
        if _holds(corners[own], normals[first], mass):
            faces.append((float(areas[own].sum()), float(normals[first, 2]), normals[first]))
    if not faces:  # as with a ball, where each face is a point
        return np.array([0.0, 0.0, -1.0])
    most = max(area for area, _, _ in faces)
    return min((f for f in faces if f[0] >= SAME_AREA * most), key=lambda f: f[1])[2]


def _holds(triangles: Array, normal: Array, mass: Array) -> bool:
    """Whether a point is above one of the triangles of a face."""
    for a, b, c in triangles:
        sides = [np.dot(np.cross(q - p, mass - p), normal) for p, q in ((a, b), (b, c), (c, a))]
        area = np.dot(np.cross(b - a, c - a), normal)
        if min(np.sign(area) * np.array(sides)) >= -1e-9 * abs(area):
            return True
    return False


def _down(normal: Array) -> Array:
    """Return the shortest turn of a direction to straight down (Rodrigues)."""
    down = np.array([0.0, 0.0, -1.0])
    cosine = float(normal @ down)
    if cosine < -1.0 + 1e-12:
        return np.diag([1.0, -1.0, -1.0])
    axis = np.cross(normal, down)
    skew = np.array([[0.0, -axis[2], axis[1]], [axis[2], 0.0, -axis[0]], [-axis[1], axis[0], 0.0]])
    return np.asarray(np.eye(3) + skew + skew @ skew / (1.0 + cosine))
