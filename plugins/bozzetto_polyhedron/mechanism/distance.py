"""How far two convex polytopes are apart, by their corners alone.

Separating axes ask every pair of directions of edges, of which round bodies have thousands. The
point of least norm of the set of differences of corners (Wolfe, *Finding the nearest point in a
polytope*, 1976) needs the farthest corner in some twenty directions.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto.arrays import Array

ROUNDS: Final = 200
"""Corners that are looked at, at most; twenty are usual."""

SETTLED: Final = 1e-8
"""Share of the squared distance by which no other corner is nearer."""

TOUCHING: Final = 1e-12
"""Distance, by the size of the bodies, below which they have met."""


def distance_between(one: Array, other: Array) -> float:
    """Return the distance of two hulls, m; 0 where they meet.

    Parameters
    ----------
    one, other : (n, 3) and (m, 3) float64
        Their corners, m.
    """
    size = float(np.abs(one).max() + np.abs(other).max())
    points = (one[0] - other[0])[None]
    shares = np.ones(1)
    for _ in range(ROUNDS):
        nearest = shares @ points
        square = float(nearest @ nearest)
        if square <= (TOUCHING * size) ** 2:
            return 0.0
        corner = one[int((one @ nearest).argmin())] - other[int((other @ nearest).argmax())]
        if square - float(corner @ nearest) <= SETTLED * square:
            break
        points, shares = _nearest(np.vstack((points, corner)), np.append(shares, 0.0))
    return float(np.sqrt(square))


def _nearest(points: Array, shares: Array) -> tuple[Array, Array]:
    """Return the points whose hull has the place of least norm inside, and its shares of them."""
    while True:
        count = len(points)
        rows = np.ones((count + 1, count + 1))
        rows[0, 0] = 0.0
        rows[1:, 1:] = points @ points.T
        wanted = np.zeros(count + 1)
        wanted[0] = 1.0
        try:
            flat = np.linalg.solve(rows, wanted)[1:]
        except np.linalg.LinAlgError:  # the new corner lies in the plane of the others
            flat = np.linalg.lstsq(rows, wanted, rcond=None)[0][1:]
        if (flat > 0.0).all():
            return points, flat / flat.sum()
        falling = flat <= 0.0
        way = shares[falling] / np.maximum(shares[falling] - flat[falling], 1e-300)
        share = float(way.min())
        shares = (1.0 - share) * shares + share * flat
        kept = shares > 1e-15
        kept[np.flatnonzero(falling)[int(way.argmin())]] = False
        points, shares = points[kept], shares[kept] / shares[kept].sum()
