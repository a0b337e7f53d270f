"""Robust least squares for many cameras at once: from starts to the poses that fit the marks.

Every start, and every camera without one of the marks, is a row of one batch. A problem of
nine unknowns and some dozens of marks is so small that numpy spends its time on the way to
the numbers; forty problems cost little more than one.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto.view.calibration.pose import NEAREST, PARAMETERS, PERSPECTIVITIES, Poses, Seen

HAND: Final = 0.002
"""Standard deviation of a mark set by hand, per coordinate, in diagonals of the picture: 3 px
in a sketch of 1200 × 800."""

STRAY: Final = 0.003
"""Distance, in diagonals, from which a mark is taken for one that went astray rather than for
a noisy one: beyond, it pulls with a constant force."""

CROPPED: Final = 0.2
"""Standard deviation of the principal point of a cropped picture from its middle, in
diagonals: a quarter of the width of a sketch of 3 : 2."""

SETTLED: Final = 1e-6
"""Longest step, radians and diagonals, at which a pose has arrived, by default. Steps shrink
to a hundredth or less each time here, so what is left is less than a thousandth of a pixel."""

LEAST_DAMPING: Final = 1e-9
"""Damping below which the equations are those of Gauss and Newton for all we can tell."""

MOST_DAMPING: Final = 1e8
"""Damping at which no step downhill is left that a number could hold."""

VAGUE: Final = np.array([1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.2, 0.2])
"""Standard deviations of the parameters of a camera of which nothing is known, in their own
units, so that a covariance exists whatever the marks are."""

OTHERWISE: Final = 4
"""How many further readings of the noise `HAND` what is known of hands is worth. So few marks
that fit by chance do not pass for marks without noise."""


@dataclass(frozen=True, eq=False)
class Adjusted:
    """Poses that have been adjusted to marks.

    Attributes
    ----------
    poses : Poses
    costs : (b,) float
        Sum of the robust losses, squared diagonals; infinite where a start has points at or
        behind its eye.
    residuals : (b, n, 2) float
        Mark minus place, diagonals.
    """

    poses: Poses
    costs: Array
    residuals: Array

    def __getitem__(self, rows: Index | list[int] | slice) -> Adjusted:
        """Return some of the rows."""
        return Adjusted(self.poses[rows], self.costs[rows], self.residuals[rows])


def freedom(poses: Poses, cropped: bool) -> Flags:
    """Return which parameters of each pose are free, (b, 9).

    An orthographic pose has neither perspectivity nor principal point.
    """
    free = np.ones((len(poses), PARAMETERS), bool)
    perspective = poses.perspectivity > 0.0
    free[:, 6] = perspective
    free[:, 7:] = (perspective & cropped)[:, None]
    return free


def robust_weights(residuals: Array) -> Array:
    """Return the weight of each mark, 0 … 1, shape of `residuals` without its last axis."""
    squares = residuals[..., 0] ** 2 + residuals[..., 1] ** 2
    return np.asarray(1.0 / np.sqrt(1.0 + squares / STRAY**2))


def variance(cost: float, count: int, unknowns: int) -> float:
    """Return the variance of a coordinate of a mark, squared diagonals, from the cost of a fit."""
    freely = max(0, 2 * count - unknowns)
    return (OTHERWISE * HAND**2 + cost) / (OTHERWISE + freely)


def covariance(
    fit: Adjusted, points: Array, counted: Array, noise: float, *, cropped: bool
) -> Array:
    """Return the covariance (9, 9) of the parameters of one row; 0 where they are not free.

    Parameters
    ----------
    fit : Adjusted
        A fit of one row.
    points : (n, 3) float
        In the units of `Framing`.
    counted : (n,) float
        1 for marks that count.
    noise : float
        Variance of a coordinate of a mark, squared diagonals.
    cropped : bool
        Whether the principal point is free.
    """
    slopes = fit.poses.slopes(fit.poses.see(points))[0].reshape(PARAMETERS, -1)
    weights = np.tile(counted * robust_weights(fit.residuals[0]), 2)
    free = np.flatnonzero(freedom(fit.poses, cropped)[0])
    normal = (slopes * weights) @ slopes.T / noise + np.diag(1.0 / VAGUE**2)
    made = np.zeros((PARAMETERS, PARAMETERS))
    made[np.ix_(free, free)] = np.linalg.inv(normal[np.ix_(free, free)])
    return made


def fit_poses(
    points: Array,
    marks: Array,
    starts: Poses,
    counted: Array,
    *,
    cropped: bool,
    steps: int,
    settled: float = SETTLED,
) -> Adjusted:
    """Adjust poses to marks by Levenberg and Marquardt's method, each row by itself.

    The loss is "soft L1" of a mark's distance r: 2 c² (√(1 + r²/c²) − 1), r² for small
    distances and 2 c r for large ones. It is convex, so its own second derivative takes the
    place of the weights of iterated least squares, which creep where many marks stray.

    Parameters
    ----------
    points : (n, 3) float
        In the units of `Framing`.
    marks : (n, 2) float
        Marks in the picture, in the units of `Framing`.
    starts : Poses
        Orthographic poses stay so, and so do perspective ones.
    counted : (b, n) float
        1 for marks that count in that row and 0 for the others.
    cropped : bool
        Whether the principal point is free, with `CROPPED` as what is known of it.
    steps : int
        Most steps.
    settled : float
        Longest step of a row that has arrived; the batch goes on until all have.
    """
    poses, free = starts, freedom(starts, cropped)
    hold = np.zeros(PARAMETERS)
    hold[7:] = (HAND / CROPPED) ** 2
    seen = poses.see(points)
    residuals, costs = _judged(seen, marks, poses, counted, hold)
    damping = np.full(len(poses), 1e-3)
    going = np.isfinite(costs)
    diagonal = np.arange(PARAMETERS)
    for _ in range(steps):
        if not going.any():
            break
        slopes = poses.slopes(seen)
        first = robust_weights(residuals)
        bend = first**3 / STRAY**2  # how much less steep the loss is along the residual
        x, y = residuals[:, None, :, 0], residuals[:, None, :, 1]
        along = slopes[:, :, 0] * x + slopes[:, :, 1] * y
        weights = (counted * first)[:, None]
        rows = slopes.reshape(len(poses), PARAMETERS, -1)
        normal = rows @ np.swapaxes(rows * np.tile(weights, 2), 1, 2)
        normal -= along @ np.swapaxes(along * (counted * bend)[:, None], 1, 2)
        pull = np.sum(along * weights, axis=2)
        pull[:, 7:] -= hold[7:] * poses.principal
        normal[:, diagonal, diagonal] += hold
        moving = free & ~_against_bounds(poses, pull)
        normal *= moving[:, :, None] & moving[:, None, :]
        size = normal[:, diagonal, diagonal]
        size = np.where(moving, size + 1e-12 * size.max(axis=1, keepdims=True) + 1e-300, 1.0)
        normal[:, diagonal, diagonal] = size * (1.0 + damping[:, None])
        step = np.linalg.solve(normal, (pull * moving)[:, :, None])[:, :, 0]
        step *= np.minimum(1.0, 1.0 / np.maximum(np.abs(step).max(axis=1), 1e-300))[:, None]
        tried = poses.moved(step)
        tried_seen = tried.see(points)
        new_residuals, new_costs = _judged(tried_seen, marks, tried, counted, hold)
        better = going & (new_costs <= costs)
        if better.all():
            poses, seen, residuals, costs = tried, tried_seen, new_residuals, new_costs
        elif better.any():
            poses = tried.where(better, poses)
            seen = poses.see(points)
            residuals = np.where(better[:, None, None], new_residuals, residuals)
            costs = np.where(better, new_costs, costs)
        damping = np.where(better, np.maximum(0.05 * damping, LEAST_DAMPING), 8.0 * damping)
        going &= (np.abs(step).max(axis=1) > settled) & (damping < MOST_DAMPING)
    return Adjusted(poses, costs, residuals)


def _judged(
    seen: Seen, marks: Array, poses: Poses, counted: Array, hold: Array
) -> tuple[Array, Array]:
    """Return residuals and their cost; infinite where a point that counts is not in front."""
    residuals = marks - seen.places
    squares = residuals[:, :, 0] ** 2 + residuals[:, :, 1] ** 2
    # 2 c² (√(1 + q) − 1), written so that small residuals keep their digits
    losses = 2.0 * squares / (1.0 + np.sqrt(1.0 + squares / STRAY**2))
    costs = np.sum(counted * losses, axis=1) + poses.principal**2 @ hold[7:]
    behind = ((seen.depth <= NEAREST) & (counted > 0.0)).any(axis=1)
    return residuals, np.where(behind, np.inf, costs)


def _against_bounds(poses: Poses, pull: Array) -> Flags:
    """Return parameters at a bound that they are pulled against, (b, 9)."""
    against = np.zeros(pull.shape, bool)
    low, high = PERSPECTIVITIES
    strength, force = poses.perspectivity, pull[:, 6]
    against[:, 6] = ((strength <= low) & (force < 0.0)) | ((strength >= high) & (force > 0.0))
    return against
