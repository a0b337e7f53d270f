"""The least of a convex quadratic function under linear inequalities.

Lawson & Hanson, *Solving Least Squares Problems* (1974), chapter 23: with a Cholesky factor of
the quadratic form the problem becomes that of the shortest vector that keeps the inequalities
(least distance programming), and that one is non-negative least squares in the dual. SciPy's
solver for the latter finds which inequalities hold with equality; the answer is then computed
from these by themselves, so that it does not inherit the tolerance of the search.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Index

CONTRADICTORY: Final = 1e-9
"""Length of the dual residual, of 1, below which no vector keeps all inequalities: it is the
share of the farthest-off inequality that is left when the others are combined against it."""

NEGLIGIBLE: Final = 1e-9
"""Length of a row, relative to the longest, that counts as zero. Such rows appear where locked
dimensions leave no freedom to change what the row measures."""

MOST_CHANGES: Final = 3
"""Most changes of the active set for each inequality; a usual search takes one for each that
ends up active."""

KEPT: Final = 1e-11
"""Shortfall of an inequality that is rounding, as a share of the largest bound."""


class Contradiction(ValueError):
    """No vector keeps all inequalities.

    Attributes
    ----------
    rows : (k,) int
        Indices of inequalities that contradict each other: a certificate by Farkas' lemma.
    """

    def __init__(self, rows: Index) -> None:
        super().__init__("the inequalities contradict each other")
        self.rows = rows


@dataclass(frozen=True, eq=False)
class Constrained:
    """The place where a quadratic function is least.

    Attributes
    ----------
    place : (n,) float
    active : (k,) int
        Indices of the inequalities that hold with equality.
    """

    place: Array
    active: Index


def constrained_minimum(form: Array, slope: Array, rows: Array, least: Array) -> Constrained:
    """Find the vector x with the least x·form·x / 2 + slope·x while rows·x ≥ least.

    Parameters
    ----------
    form : (n, n) float
        Symmetric, positive definite.
    slope : (n,) float
        The linear part of the function.
    rows : (m, n) float
        The left sides of the inequalities.
    least : (m,) float
        The right sides of the inequalities.

    Returns
    -------
    Constrained
        The inequalities hold to rounding.

    Raises
    ------
    Contradiction
        If no vector keeps the inequalities.
    numpy.linalg.LinAlgError
        If the form is not positive definite, or so badly scaled that rounding lets the search
        for the active inequalities go round in circles.
    """
    from scipy.linalg import cho_solve, solve_triangular
    from scipy.optimize import nnls

    factor = np.linalg.cholesky(form)
    free = -cho_solve((factor, True), slope)
    sizes = np.linalg.norm(rows, axis=1)
    silent = sizes <= NEGLIGIBLE * sizes.max(initial=0.0)
    impossible = silent & (least > KEPT * np.abs(least).max(initial=1.0))
    if impossible.any():
        raise Contradiction(np.flatnonzero(impossible))
    rows, least, numbers = rows[~silent], least[~silent], np.flatnonzero(~silent)
    lacking = least - rows @ free
    if not len(lacking) or lacking.max() <= 0.0:
        return Constrained(free, np.empty(0, np.intp))
    # In the metric of the form: the shortest y with turned·y ≥ lacking.
    turned = solve_triangular(factor, rows.T, lower=True)
    lengths = np.linalg.norm(turned, axis=0)
    turned /= lengths
    lacking = lacking / lengths
    worst = float(lacking.max())
    dual = np.vstack((turned, lacking / worst))
    goal = np.zeros(len(dual))
    goal[-1] = 1.0
    try:
        weights, residual = nnls(dual, goal, maxiter=MOST_CHANGES * dual.shape[1])
    except RuntimeError as problem:
        raise np.linalg.LinAlgError(
            "the search for the active inequalities goes round"
        ) from problem
    active = np.flatnonzero(weights)
    if residual < CONTRADICTORY:
        raise Contradiction(numbers[active])
    step = np.linalg.lstsq(turned[:, active].T, lacking[active], rcond=None)[0]
    if (turned.T @ step - lacking).min() < -KEPT * worst:
        # Active inequalities that depend on each other: the residual itself is the answer.
        gap = dual @ weights - goal
        step = -gap[:-1] / gap[-1] * worst
    return Constrained(
        free + solve_triangular(factor, step, lower=True, trans="T"), numbers[active]
    )
