"""Edges and planes of a body by where they are in the box around it: names that sizes keep."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto_polyhedron.solid.face_rings import edges_of
from bozzetto_polyhedron.solid.planar_body import PlanarBody

GONE: Final = 0.15
"""Distance of both ends, in boxes, beyond which an edge is no longer there."""

SAME: Final = 1e-9
"""Difference of normals, and of offsets as share of the size, below which planes are one."""


def shares_of(body: PlanarBody, points: ArrayLike) -> Array:
    """Return points (n, 3) as shares of the box around a body."""
    low, extent = _box(body)
    return np.asarray((np.asarray(points, float) - low) / extent)


def at_shares(body: PlanarBody, shares: ArrayLike) -> Array:
    """Return the points (n, 3), mm, at shares of the box around a body."""
    low, extent = _box(body)
    return np.asarray(low + np.asarray(shares, float) * extent)


def edge_named(body: PlanarBody, begin: ArrayLike, end: ArrayLike) -> tuple[int, int]:
    """Return the edge whose ends are nearest to two places, as numbers of vertices.

    Parameters
    ----------
    body : PlanarBody
        What is drawn on.
    begin, end : (3,) array_like
        Shares of its box.

    Raises
    ------
    UserError
        If there is none near.
    """
    edges = edges_of(body.faces)
    ends = shares_of(body, body.vertices)[edges]
    wanted = np.array((begin, end), float)
    away = [np.linalg.norm(ends - order, axis=2).max(axis=1) for order in (wanted, wanted[::-1])]
    best = np.minimum(*away)
    number = int(np.argmin(best))
    if not len(edges) or best[number] > GONE:
        raise UserError("Its edge is gone. Take this change away.")
    return int(edges[number, 0]), int(edges[number, 1])


def plane_named(body: PlanarBody, place: ArrayLike, normal: ArrayLike) -> tuple[Array, float]:
    """Return the plane through a place, as unit normal and offset; that of a face where it is one.

    Parameters
    ----------
    body : PlanarBody
        What is drawn on.
    place : (3,) array_like
        Share of its box.
    normal : (3,) array_like
        Of any length but 0.
    """
    across = np.asarray(normal, float)
    across = across / np.linalg.norm(across)
    offset = float(across @ at_shares(body, place))
    size = float(np.linalg.norm(np.ptp(body.vertices, axis=0)))
    for known, at in zip(body.normals, body.offsets, strict=True):
        side = 1.0 if known @ across > 0 else -1.0
        near = np.abs(known - side * across).max() < SAME
        if near and abs(float(at) - side * offset) < SAME * size:
            return known, float(at)
    return across, offset


def _box(body: PlanarBody) -> tuple[Array, Array]:
    low, extent = body.vertices.min(axis=0), np.ptp(body.vertices, axis=0)
    return low, np.where(extent > 0.0, extent, 1.0)
