"""Outliers: every mark judged by the others, by its leave-one-out residual.

A residual says little about a mark, for the camera leans towards it; with few marks it leans
all the way. What counts is where the mark would be expected by the camera of all the others.
That camera is solved for every mark, all of them as one batch, which begins where the common
one has arrived.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.view.calibration.levenberg_marquardt import (
    HAND,
    Adjusted,
    covariance,
    fit_poses,
    freedom,
    variance,
)

ALARM: Final = 50.0
"""Squared leave-one-out residual, in its own variances, from which a mark is set aside: seven
standard deviations. Three would do for hands; but where the points themselves are not quite
those of the picture, the robust variance is too small by half and more."""

FAR: Final = 5.0
"""Least leave-one-out residual, in standard deviations `HAND`, of a mark that is set aside:
about 15 px of 1200. Nobody wants to hear of less."""

REMAINING: Final = 6
"""Marks that are kept in any case."""

CLOSE: Final = 5e-4
"""Longest step, radians and diagonals, at which a camera that lost a mark has arrived. What is
left is some hundredths of a pixel, and nobody reads these residuals so finely."""

STEPS: Final = 8
"""Most steps of a camera that loses one mark. Where the mark had drawn it far off, the last
digits are not worth waiting for."""


@dataclass(frozen=True, eq=False)
class Scrutiny:
    """A camera whose marks have been judged.

    Attributes
    ----------
    fit : Adjusted
        One row: the camera of the marks that count.
    counted : (n,) float
        1 for marks that count, 0 for those set aside.
    aside : tuple of int
        The marks set aside, the worst first.
    leave_one_out : (n, 2) float
        Mark minus its place by the camera of the other marks that count, diagonals; infinite
        where that camera has the point at or behind its eye.
    """

    fit: Adjusted
    counted: Array
    aside: tuple[int, ...]
    leave_one_out: Array


def set_outliers_aside(
    points: Array, marks: Array, fit: Adjusted, aside: tuple[int, ...] = (), *, cropped: bool
) -> Scrutiny:
    """Judge all marks of a fit of one row, and set aside those that disagree, one by one.

    The marks in `aside` have no part in the fit already.

    The mark to set aside is the one without which the others fit best, and not that with the
    largest residual: among few marks a wrong one draws the camera to itself, and it is its
    neighbours that seem to be off.
    """
    count = len(points)
    unknowns = int(freedom(fit.poses, cropped).sum())
    counted = np.ones(count)
    counted[list(aside)] = 0.0
    each = np.arange(count)
    while True:
        weights = counted * (1.0 - np.eye(count))
        starts = fit.poses[np.zeros(count, np.intp)]
        others = fit_poses(
            points, marks, starts, weights, cropped=cropped, steps=STEPS, settled=CLOSE
        )
        left = others.residuals[each, each]
        left[~others.poses.before_eye(points)[each, each]] = np.inf
        worst = int(np.argmin(np.where(counted > 0.0, others.costs, np.inf)))
        kept = int(counted.sum()) - 1
        rest = others[[worst]]
        noise = variance(float(rest.costs[0]), kept, unknowns)
        sure = covariance(rest, points, weights[worst], noise, cropped=cropped)
        slopes = rest.poses.slopes(rest.poses.see(points[[worst]]))[0, :, :, 0]
        expected = slopes.T @ sure @ slopes + noise * np.eye(2)
        off = left[worst]
        wrong = np.linalg.norm(off) > FAR * HAND and (
            not np.isfinite(off).all() or off @ np.linalg.solve(expected, off) > ALARM
        )
        if kept < REMAINING or not wrong:
            return Scrutiny(fit, counted, aside, left)
        counted = weights[worst]
        aside = (*aside, worst)
        fit = fit_poses(
            points, marks, others.poses[[worst]], counted[None], cropped=cropped, steps=4 * STEPS
        )
