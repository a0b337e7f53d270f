"""Circles of triangles in the plane, and how much of one circle another covers."""

from __future__ import annotations

import numpy as np

from bozzetto.arrays import Array


def side_lengths(corners: Array) -> Array:
    """Return the lengths (t, 3) of the sides opposite to each corner of triangles (t, 3, 2)."""
    opposite = np.roll(corners, -2, axis=1) - np.roll(corners, -1, axis=1)
    return np.asarray(np.hypot(opposite[..., 0], opposite[..., 1]), np.float64)


def circumcircles(corners: Array) -> tuple[Array, Array]:
    """Return the centres (t, 2) and radii (t,) of the circles through the corners (t, 3, 2).

    A triangle without area has an infinite radius, around its first corner.
    """
    a = corners[:, 0]
    (ux, uy), (vx, vy) = (corners[:, 1] - a).T, (corners[:, 2] - a).T
    twice = 2.0 * (ux * vy - uy * vx)
    flat = twice == 0.0
    u2, v2 = ux * ux + uy * uy, vx * vx + vy * vy
    offset = np.stack([vy * u2 - uy * v2, ux * v2 - vx * u2], axis=1)
    offset = np.where(flat[:, None], 0.0, offset / np.where(flat, 1.0, twice)[:, None])
    return a + offset, np.where(flat, np.inf, np.hypot(*offset.T))


def incircles(corners: Array) -> tuple[Array, Array]:
    """Return the centres (t, 2) and radii (t,) of the circles that touch the three sides."""
    side = side_lengths(corners)
    perimeter = np.maximum(side.sum(axis=1), 1e-300)
    centre = (side[..., None] * corners).sum(axis=1) / perimeter[:, None]
    u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    return centre, np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]) / perimeter


def covered_share(gap: Array, radius: Array, other: Array) -> Array:
    """Return the share of discs that discs of another radius cover, `gap` apart; all (n,)."""
    small, large = np.minimum(radius, other), np.maximum(radius, other)
    gap = np.clip(gap, large - small, large + small)
    with np.errstate(divide="ignore", invalid="ignore"):
        one = np.clip((gap**2 + radius**2 - other**2) / (2.0 * gap * radius), -1.0, 1.0)
        two = np.clip((gap**2 + other**2 - radius**2) / (2.0 * gap * other), -1.0, 1.0)
        kite = np.sqrt(
            np.maximum(
                (radius + other - gap) * (gap + radius - other)
                * (gap + other - radius) * (gap + radius + other), 0.0
            )
        )  # fmt: skip
        lens = radius**2 * np.arccos(one) + other**2 * np.arccos(two) - 0.5 * kite
        share = lens / (np.pi * radius**2)
    inside = np.minimum(1.0, np.square(other / np.maximum(radius, 1e-300)))
    return np.asarray(np.where(gap <= large - small, inside, share), np.float64)
