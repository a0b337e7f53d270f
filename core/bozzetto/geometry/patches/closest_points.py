"""Closest points on patches to points in space."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.geometry.patches.patch import Places, grid, points_at

if TYPE_CHECKING:
    from bozzetto.arrays import Array

SEEDS: Final = 10
"""Places tried along u and along v of each patch; even, for each quarter gives its best one."""

STARTS: Final = 6
"""Quarters of patches that a search starts in: near an edge the closest seed may lie on the
wrong side, and a bent patch has several valleys."""

FOOT_STEPS: Final = 40
"""Most steps to a foot point; five to ten are usual."""

FOOT_TOLERANCE: Final = 1e-12
"""Step in u and v that counts as none."""

LEAST_CURVATURE: Final = 0.01
"""Share of the Gauss–Newton curvature below which that of the whole squared distance is not
trusted: far from the surface it need not be a valley at all."""

DAMPING: Final = 1e-3
"""First damping after a step that led away, per unit of the mean curvature."""


def foot_points(nets: ArrayLike, points: ArrayLike, near: Places | None = None) -> Places:
    """Find the closest points on patches to given points.

    Newton's method on the squared distance within the unit square of each patch, damped where
    a step leads away (Levenberg 1944); parameters that would leave the square stay on its
    border. On patches as bent as those of a body the nearest place of all is found; one that
    winds several times may have a nearer one.

    Parameters
    ----------
    nets : (k, 4, 4, 3) array_like
        ``k >= 1``.
    points : (n, 3) array_like
        Places, mm.
    near : Places, optional
        Where to start from, and the patches to stay on: for places that follow a small change.

    Returns
    -------
    Places
        One for each point.
    """
    nets, points = np.asarray(nets, float), np.asarray(points, float).reshape(-1, 3)
    if near is not None:
        return _descended(nets, points, near)
    seeds, half = np.linspace(0.0, 1.0, SEEDS), SEEDS // 2
    places = grid(nets, seeds, seeds).reshape(-1, 2, half, 2, half, 3)
    quarters = places.transpose(0, 1, 3, 2, 4, 5).reshape(-1, half * half, 3)
    squared = _squared_distances(points, quarters.reshape(-1, 3))
    squared = squared.reshape(-1, *quarters.shape[:2])
    best = squared.argmin(axis=2)
    least = np.take_along_axis(squared, best[..., None], axis=2)[..., 0]
    starts = min(STARTS, len(quarters))
    chosen = np.argpartition(least, starts - 1, axis=1)[:, :starts]
    i, j = np.divmod(np.take_along_axis(best, chosen, axis=1), half)
    patch, quarter = np.divmod(chosen, 4)
    at = np.stack((seeds[i + half * (quarter // 2)], seeds[j + half * (quarter % 2)]), axis=-1)
    begun = Places(patch.ravel(), at.reshape(-1, 2))
    feet = _descended(nets, np.repeat(points, starts, axis=0), begun)
    away = points_at(nets, feet).reshape(len(points), starts, 3) - points[:, None]
    nearest = (away * away).sum(axis=2).argmin(axis=1)
    return feet[np.arange(len(points)) * starts + nearest]


def _squared_distances(points: Array, places: Array) -> Array:
    """Return squared distances, (n, s), up to rounding; they only choose where to start."""
    squares = (points * points).sum(axis=1)[:, None] + (places * places).sum(axis=1)
    return np.asarray(squares - 2.0 * points @ places.T)


def _descended(nets: Array, points: Array, start: Places) -> Places:
    """Minimise the squared distance from each start, within the valley that it lies in."""
    at = np.clip(start.parameters, 0.0, 1.0)
    offset = points_at(nets, Places(start.patches, at)) - points
    damping = np.zeros(len(points))
    open_ = np.arange(len(points))
    for _ in range(FOOT_STEPS):
        here = Places(start.patches[open_], at[open_])
        step = _step(nets, here, offset[open_], damping[open_])
        tried = np.clip(here.parameters + step, 0.0, 1.0)
        there = points_at(nets, Places(here.patches, tried)) - points[open_]
        better = (there**2).sum(axis=1) <= (offset[open_] ** 2).sum(axis=1)
        moved = np.abs(tried - here.parameters).max(axis=1)
        at[open_[better]], offset[open_[better]] = tried[better], there[better]
        damping[open_] = np.where(
            better, 0.1 * damping[open_], np.maximum(DAMPING, 10.0 * damping[open_])
        )
        open_ = open_[moved > FOOT_TOLERANCE]
        if not len(open_):
            break
    return Places(start.patches, at)


def _step(nets: Array, here: Places, offset: Array, damping: Array) -> Array:
    """Return a damped Newton step in u and v, (n, 2), along the border where it would lead out."""
    xu, xv = points_at(nets, here, du=1), points_at(nets, here, dv=1)
    slope = np.stack(((xu * offset).sum(1), (xv * offset).sum(1)), axis=1)
    at = here.parameters
    bound = ((at <= 0.0) & (slope > 0.0)) | ((at >= 1.0) & (slope < 0.0))
    flat = np.stack(((xu * xu).sum(1), (xu * xv).sum(1), (xv * xv).sum(1)), axis=1)
    bends = [points_at(nets, here, du=2 - j, dv=j) for j in range(3)]
    bent = flat + np.stack([(bend * offset).sum(1) for bend in bends], axis=1)
    for curved in (flat, bent):  # what is bound has no say
        curved[:, 1] = np.where(bound.any(axis=1), 0.0, curved[:, 1])
        curved[:, [0, 2]] = np.where(bound, flat[:, [0, 2]], curved[:, [0, 2]])
    trusted = (bent[:, [0, 2]] > LEAST_CURVATURE * flat[:, [0, 2]]).all(axis=1)
    trusted &= _determinant(bent) > LEAST_CURVATURE * np.maximum(_determinant(flat), 0.0)
    curved = np.where(trusted[:, None], bent, flat)
    curved[:, [0, 2]] += (damping * (0.5 * (flat[:, 0] + flat[:, 2])))[:, None]
    slope = np.where(bound, 0.0, slope)
    whole = _determinant(curved)
    sure = whole > 1e-12 * curved[:, 0] * curved[:, 2]
    step, alone = np.zeros_like(slope), np.zeros_like(slope)
    joint = curved[:, [1]] * slope[:, ::-1] - curved[:, [2, 0]] * slope
    np.divide(joint, whole[:, None], out=step, where=sure[:, None])
    # Where both directions are one, each for itself.
    np.divide(-0.5 * slope, curved[:, [0, 2]], out=alone, where=curved[:, [0, 2]] > 0.0)
    return np.where(sure[:, None], step, alone)


def _determinant(matrix: Array) -> Array:
    """Return determinants of symmetric 2 × 2 matrices given by their three numbers, (n, 3)."""
    return np.asarray(matrix[:, 0] * matrix[:, 2] - matrix[:, 1] ** 2)
