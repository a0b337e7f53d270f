"""Weights of the skeleton segments, so that the surface passes through the outline.

Non-negative least squares on samples of the outline, with rows that ask for the right
height above the skeleton (the paper leaves the height free) and rows that hold the
weights near 1, so that no limb vanishes and the answer is unique.
"""

from __future__ import annotations

import numpy as np

from bozzetto.arrays import Array
from bozzetto_silhouette.implicit.kernel_sums import Summation
from bozzetto_silhouette.outline.medial_axis import Skeleton

LOWEST = 0.2
"""No weight is smaller: a limb must not vanish."""

HEIGHTS = 1.5
"""Importance of all height rows together, relative to the outline's: the outline is made
exact afterwards, the heights are not."""

EVEN = 0.05
"""Pull of neighbouring weights towards each other, relative to the iso-value."""

HOLD = 4e-2
"""Pull of the weights towards 1, relative to the iso-value."""


def fit_weights(skeleton: Skeleton, summation: Summation, samples: Array) -> Array:
    """Solve for one weight per segment.

    Parameters
    ----------
    skeleton : Skeleton
        Its nodes give the height rows.
    summation : Summation
        Along the same skeleton.
    samples : (n, 2) float array
        Points on the outline, spread evenly over all rings.

    Returns
    -------
    (s,) float array
        Each at least `LOWEST`.
    """
    middles = skeleton.nodes[skeleton.edges].mean(axis=1)
    tops = np.concatenate([skeleton.nodes, middles])
    tops, radii = tops[:, :2], tops[:, 2]
    # Between two nodes the union has the ball of their mean radius, too.
    heights = np.maximum(skeleton.heights(tops), radii)
    rows = np.vstack([samples, tops])
    matrix = summation.over(rows).shares(np.concatenate([np.zeros(len(samples)), heights**2]))
    importance = np.concatenate([
        np.ones(len(samples)), np.full(len(tops), HEIGHTS * np.sqrt(len(samples) / len(tops)))
    ])  # fmt: skip
    hold = HOLD * np.sqrt(len(samples))
    count = len(skeleton.edges)
    # Substituting weight = LOWEST + more turns the lower bound into non-negativity.
    weighted = matrix * importance[:, None]
    even = (EVEN / HOLD * hold) ** 2 * _unevenness(skeleton)
    normal = weighted.T @ weighted + hold**2 * np.eye(count) + even
    right = weighted.T @ importance + hold**2
    return LOWEST + non_negative_least_squares(normal, right - LOWEST * normal.sum(axis=1))


def _unevenness(skeleton: Skeleton) -> Array:
    """Return the quadratic form (s, s) of squared differences of neighbouring weights in a limb."""
    ends = skeleton.edges.ravel()
    order = np.argsort(ends, kind="stable")
    first = np.searchsorted(ends[order], np.flatnonzero(skeleton.degrees == 2))
    a, b = order[first] // 2, order[first + 1] // 2
    form = np.zeros((len(skeleton.edges), len(skeleton.edges)))
    for one, other, sign in ((a, a, 1.0), (b, b, 1.0), (a, b, -1.0), (b, a, -1.0)):
        np.add.at(form, (one, other), sign)
    return form


def non_negative_least_squares(normal: Array, right: Array) -> Array:
    """Minimise ``x' normal x / 2 - right' x`` over x >= 0.

    Block principal pivoting (Portugal, Judice and Vicente, 1994), which exchanges many
    variables at a time: ten solves where the classic active-set method needs one for each
    segment of the skeleton. That method takes over if the exchange should cycle.

    Parameters
    ----------
    normal : (n, n) float array
        Symmetric positive definite.
    right : (n,) float array
        The linear term.
    """
    free = np.ones(len(right), dtype=bool)
    x = np.zeros(len(right))
    tolerance = 1e-10 * float(np.abs(right).max(initial=1.0))
    fewest, patience = len(right) + 1, 3
    for _ in range(60):
        x = np.zeros(len(right))
        x[free] = np.linalg.solve(normal[np.ix_(free, free)], right[free])
        dual = normal @ x - right
        wrong = (free & (x < 0.0)) | (~free & (dual < -tolerance))
        count = int(wrong.sum())
        if count == 0:
            return x
        if count < fewest:
            fewest, patience = count, 3
        elif patience > 0:
            patience -= 1
        else:
            # Exchange one variable only: slow but certain to end.
            wrong = np.arange(len(right)) == np.flatnonzero(wrong)[-1]
        free ^= wrong
    from scipy.linalg import cholesky, solve_triangular
    from scipy.optimize import nnls

    upper = cholesky(normal)
    result: Array
    result, _ = nnls(upper, solve_triangular(upper, right, trans="T"), maxiter=50 * len(right))
    return result
