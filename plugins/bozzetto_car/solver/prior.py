"""The cost of a deformation: marks that are missed, and how far a car is from its template.

Kara & Shimada (2008) balance how far the projected nodes are from the marks against how far
the nodes have moved, H = α Σ |r| / D2 + β Σ |d| / D3, with D2 and D3 the extents of the marks
and of the template. It has two disadvantages: it has no derivative where a node has not
moved, which costs hundreds of iterations, and a node without a mark does not move at all. So by
default the norms are squared, which makes them variances, and nodes vary together: as the outer
dimensions of real cars do, toward the other templates, and smoothly (`proportions`). The size of a
car is no part of this: no sketch tells it, and where it could be had for less, a car would shrink
to be nearer to its template. The paper's cost is available as a mode, smoothed a little.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Final, Self

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto_car.solver.proportions import KNOWN, kin_directions, outer_directions
from bozzetto_car.state import TRACE
from bozzetto_car.template.model import Template

HAND: Final = (0.02, 0.0005)
"""Standard deviation of a mark, in diagonals of all marks, where the balance is 0 and where it
is 1: from a rough idea of a car to half a pixel. Below that the marks are met no better, and
the template would no longer determine the shape where the marks leave it open."""

STRAY: Final = (4.0, 0.008)
"""Distance from which a mark counts as a mistake and pulls with a constant force only: the larger
of a number of standard deviations and a share of the diagonal of all marks. A person who traces to
the last tenth of a pixel makes mistakes as large as others."""

DEVIATION: Final = 40.0
"""Standard deviation of a node by itself from its place in the template, mm."""

SMOOTH: Final = 60.0
"""Standard deviation of what a node's deviation has in common with its neighbours', mm."""

REACH: Final = 700.0
"""Distance at which that has fallen to e^(-1/2), mm."""

KINSHIP: Final = 0.2
"""Standard deviation of the way toward each other template, as a share of the whole way."""

DEVIATIONS: Final = ("deviation", "smooth", "proportion", "kinship", "bend")
"""The standard deviations of a cost but for that of a mark."""

HELD: Final = 1e-4
"""Standard deviation of the size of a car whose size is held, as a share."""

FREE: Final = 1.0
"""The same where something else tells the size: next to nothing."""

COSTS: Final = 16
"""Number of pairs of a template and a cost whose covariance is remembered: a solve asks for that
of its cost for every size of the car."""

PAPER_SHARE: Final = 0.5
"""The weights α and β of the paper's cost."""

PAPER_SMOOTHING: Final = 1e-3
"""Length, in extents, below which the paper's norms are squares: with it the cost has a
derivative everywhere, and the optimum is the same to the eye."""


@dataclass(frozen=True)
class Cost:
    """Weights of a deformation, as standard deviations.

    Attributes
    ----------
    hand : float
        Standard deviation of a mark, per coordinate, in diagonals of the marks of its sketch.
    stray : float
        Number of standard deviations from which a mark counts by its distance, not the square.
    deviation : float
        Standard deviation of a node, per coordinate, mm.
    stiff : float
        As `stray`, for the deviation of a node; infinite: always the square.
    smooth : float
        Standard deviation of what the deviations of neighbours have in common, mm; 0: nothing.
    proportion : float
        Deviation of outer dimensions, relative to that of cars that were built; 0: none.
    kinship : float
        Standard deviation of the way toward other templates, as a share of it; 0: none.
    bend : float
        Standard deviation by which the hand bends a drawing as a whole, in diagonals of the marks;
        0: not at all.
    """

    hand: float
    stray: float
    deviation: float
    stiff: float
    smooth: float
    proportion: float
    kinship: float
    bend: float = 0.0

    @classmethod
    def balanced(cls, trace: float = TRACE) -> Self:
        """Return the default cost.

        Parameters
        ----------
        trace : float
            Balance: 0 stays plausible, 1 traces exactly.

        Raises
        ------
        UserError
            If it is not from 0 to 1.
        """
        if not 0.0 <= trace <= 1.0:
            raise UserError("The balance is a number from 0 (stay plausible) to 1 (trace exactly).")
        loose, tight = HAND
        hand = loose * (tight / loose) ** trace
        stray = max(STRAY[0], STRAY[1] / hand)
        return cls(hand, stray, DEVIATION, np.inf, SMOOTH, 1.0, KINSHIP)

    def toward(self, other: Self, share: float) -> Self:
        """Return the cost a share of the way to another one, in squares; the hand stays."""
        pairs = ((getattr(self, name), getattr(other, name)) for name in DEVIATIONS)
        mixed = [((1.0 - share) * own**2 + share * its**2) ** 0.5 for own, its in pairs]
        return replace(self, **dict(zip(DEVIATIONS, mixed, strict=True)))

    def unsteady(self, factor: float) -> Self:
        """Return the cost for a hand that is less steady by a factor."""
        hand = self.hand * factor
        return replace(self, hand=hand, stray=max(STRAY[0], STRAY[1] / hand))

    @classmethod
    def paper(cls, template: Template) -> Self:
        """Return the cost H of Kara & Shimada with α = β = 0.5."""
        # σ and the threshold c for which σ² c (√(c² + s²)) is the paper's norm, smoothed.
        spread = float(np.sqrt(PAPER_SMOOTHING / PAPER_SHARE))
        bend = float(np.sqrt(PAPER_SMOOTHING * PAPER_SHARE))
        return cls(spread, bend, spread * extent(template), bend, 0.0, 0.0, 0.0)


def extent(template: Template) -> float:
    """Return the diagonal of the box of the nodes, mm."""
    return float(np.linalg.norm(np.ptp(template.positions, axis=0)))


def robust_weights(squares: Array, threshold: float) -> tuple[Array, float]:
    """Return the weights of iteratively re-weighted least squares, and the whole cost.

    The cost of a squared length s² is 2 c² (√(1 + s²/c²) − 1): s² near zero, 2 c s far off
    (soft L1, the pseudo-Huber function).

    Parameters
    ----------
    squares : (k,) float
        Squared lengths in standard deviations.
    threshold : float
        c; may be infinite.
    """
    if not np.isfinite(threshold):
        return np.ones(len(squares)), float(squares.sum())
    root = np.sqrt(1.0 + squares / threshold**2)
    return 1.0 / root, float(2.0 * threshold**2 * (root - 1.0).sum())


class Prior:
    """The part of the cost that knows no sketch, over the variables of a symmetric car.

    Parameters
    ----------
    template : Template
        The template of the car.
    cost : Cost
        The weights.
    size : float, optional
        The size of the car relative to the template, where it is known. All lengths of the prior
        are multiplied by it, and size costs nothing else. By default it varies as in real cars.
    held : bool
        Whether the car has that size; else something else must tell it, such as a locked dimension.

    Attributes
    ----------
    variables : (q,) float
        The car that costs nothing.
    """

    def __init__(
        self, template: Template, cost: Cost, size: float | None = None, held: bool = True
    ) -> None:
        scale = 1.0 if size is None else size
        self.variables = scale * template.variables
        self._basis = template.basis
        self._cost = cost
        self._squared = _precision(template, cost) / scale**2
        if size is not None:
            larger = template.variables
            pushed = self._squared @ larger
            self._squared -= np.outer(pushed, pushed) / float(larger @ pushed)
            measure = size_measure(template) / (scale * (HELD if held else FREE))
            self._squared += np.outer(measure, measure)

    def value(self, variables: Array) -> float:
        """Return the cost of a car (q,); that of the template is 0."""
        offset = variables - self.variables
        if not np.isfinite(self._cost.stiff):
            return float(offset @ self._squared @ offset)
        return robust_weights(self._squares(offset), self._cost.stiff)[1]

    def form(self, variables: Array) -> Array:
        """Return half the second derivative at a car (q,) for re-weighted least squares, (q, q)."""
        if not np.isfinite(self._cost.stiff):
            return self._squared
        squares = self._squares(variables - self.variables)
        weights = robust_weights(squares, self._cost.stiff)[0]
        weighted = np.repeat(weights, 3)[:, None] * self._basis
        return np.asarray(self._basis.T @ weighted / self._cost.deviation**2, float)

    def _squares(self, offset: Array) -> Array:
        moved = (self._basis @ offset).reshape(-1, 3) / self._cost.deviation
        return np.asarray((moved**2).sum(axis=1))


def size_measure(template: Template) -> Array:
    """Return the row (q,) that gives the size of a car relative to its template.

    It is the factor of the template that lies nearest to the car, both about their centroids.
    """
    middle = template.positions - template.positions.mean(axis=0)
    return np.asarray(template.basis.T @ middle.ravel() / (middle**2).sum())


@lru_cache(maxsize=COSTS)
def _precision(template: Template, cost: Cost) -> Array:
    """Return the inverse of the covariance of the variables of a car, (q, q)."""
    return np.asarray(np.linalg.inv(_covariance(template, cost)))


def _covariance(template: Template, cost: Cost) -> Array:
    """Return the covariance (q, q) of the variables of a car, mm²."""
    covariance = cost.deviation**2 * _of_nodes(template, round(cost.smooth / cost.deviation, 9))
    if cost.proportion > 0.0:
        ways, together = outer_directions(template)
        covariance = covariance + cost.proportion**2 * ways @ together @ ways.T
    if cost.kinship > 0.0:
        ways = kin_directions(template)
        covariance = covariance + cost.kinship**2 * ways @ ways.T
    return np.asarray(covariance, float)


@lru_cache(maxsize=KNOWN)
def _of_nodes(template: Template, smooth: float) -> Array:
    """Return the covariance (q, q) of nodes that vary by themselves, and with their neighbours.

    It is relative to the variance of a node by itself; `smooth` is the deviation that neighbours
    have in common, in the same unit. A symmetric car is one whose sides are the same, so the
    covariance is the conditional one.
    """
    basis, places = template.basis, template.positions
    away = ((places[:, None] - places) ** 2).sum(axis=2)
    among = np.eye(len(places)) + smooth**2 * np.exp(-0.5 * away / REACH**2)
    inverse = np.kron(np.linalg.inv(among), np.eye(3))
    return np.asarray(np.linalg.inv(basis.T @ inverse @ basis))
