"""The cost of a deformation: marks that are missed, deviations, and differences along edges.

Kara & Shimada (2008) balance how far the projected nodes are from the marks against how far
the nodes have moved, H = α Σ |r| / D2 + β Σ |d| / D3, with D2 and D3 the extents of the marks
and of the template. It has two disadvantages: it has no derivative where a node has not
moved, which costs hundreds of iterations, and a node without a mark does not move at all. So by
default the norms are squared, which makes them variances: of the hand, of a node about its place
in the template, and of the difference between the two ends of an edge, which moves unmarked nodes
along. Length, width and height as a whole may vary at a lower price, for cars differ most in
them. The paper's cost is available as a mode, smoothed a little.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final, Self

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto.errors import UserError
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

DEVIATION: Final = 180.0
"""Standard deviation of a node from its place in the template, mm."""

COUPLING: Final = 100.0
"""Standard deviation of the difference between the deviations of both ends of an edge, mm."""

PROPORTION: Final = 0.05
"""Standard deviation of length, width and height as a whole, as a share: sedans are 4.5 to
4.9 m long, 1.76 to 1.86 m wide and 1.40 to 1.46 m high."""

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
    coupling : float
        Standard deviation of the difference along an edge, per coordinate, mm; infinite: none.
    proportion : float
        Standard deviation of length, width and height as a whole, as a share; 0: none of its own.
    """

    hand: float
    stray: float
    deviation: float
    stiff: float
    coupling: float
    proportion: float

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
        return cls(hand, stray, DEVIATION, np.inf, COUPLING, PROPORTION)

    def within(self, spread: float) -> Self:
        """Return the cost for cars that differ by a share of what this cost expects."""
        return replace(
            self,
            deviation=self.deviation * spread,
            coupling=self.coupling * spread,
            proportion=self.proportion * spread,
        )

    @classmethod
    def paper(cls, template: Template) -> Self:
        """Return the cost H of Kara & Shimada with α = β = 0.5."""
        # σ and the threshold c for which σ² c (√(c² + s²)) is the paper's norm, smoothed.
        spread = float(np.sqrt(PAPER_SMOOTHING / PAPER_SHARE))
        bend = float(np.sqrt(PAPER_SMOOTHING * PAPER_SHARE))
        return cls(spread, bend, spread * extent(template), bend, np.inf, 0.0)


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
    cost : Cost
    """

    def __init__(self, template: Template, cost: Cost) -> None:
        self.variables = template.variables
        self._basis = template.basis
        self._cost = cost
        coupled = np.zeros((len(self.variables), len(self.variables)))
        if np.isfinite(cost.coupling):
            ends = _links(template)
            difference = np.zeros((len(ends), len(template.names)))
            each = np.arange(len(ends))
            difference[each, ends[:, 0]], difference[each, ends[:, 1]] = 1.0, -1.0
            along = np.kron(difference, np.eye(3)) @ template.basis
            coupled = along.T @ along / cost.coupling**2
        self._coupled = coupled
        self._squared = coupled + self._basis.T @ self._basis / cost.deviation**2
        if cost.proportion > 0.0:
            self._squared = _with_proportions(self._squared, template, cost.proportion)

    def value(self, variables: Array) -> float:
        """Return the cost of a car (q,); that of the template is 0."""
        offset = variables - self.variables
        if not np.isfinite(self._cost.stiff):
            return float(offset @ self._squared @ offset)
        bent = robust_weights(self._squares(offset), self._cost.stiff)[1]
        return float(offset @ self._coupled @ offset) + bent

    def form(self, variables: Array) -> Array:
        """Return half the second derivative at a car (q,) for re-weighted least squares, (q, q)."""
        if not np.isfinite(self._cost.stiff):
            return self._squared
        squares = self._squares(variables - self.variables)
        weights = robust_weights(squares, self._cost.stiff)[0]
        weighted = np.repeat(weights, 3)[:, None] * self._basis
        return np.asarray(self._coupled + self._basis.T @ weighted / self._cost.deviation**2)

    def _squares(self, offset: Array) -> Array:
        moved = (self._basis @ offset).reshape(-1, 3) / self._cost.deviation
        return np.asarray((moved**2).sum(axis=1))


def _links(template: Template) -> Index:
    """Return the edges, and two links for each wheel to the sill around it, (m, 2).

    No edge ends in a wheel, so it is tied to the nearest nodes before and behind it on the rim
    of the body, of which the edges belong to one patch only.
    """
    links = template.edges.tolist()
    places = template.positions
    numbers = [~edge if edge < 0 else edge for patch in template.patches for edge in patch.edges]
    rim = np.flatnonzero(np.bincount(numbers, minlength=len(links)) == 1)
    body = np.setdiff1d(np.unique(template.edges[rim]), template.centre)
    for wheel in template.wheels.ravel():
        side = body[places[body, 1] * places[wheel, 1] > 0.0]
        for sign in (-1.0, 1.0):
            beyond = side[sign * (places[side, 0] - places[wheel, 0]) > 0.0]
            away = np.linalg.norm(places[beyond] - places[wheel], axis=1)
            if len(beyond):
                links.append([int(wheel), int(beyond[np.argmin(away)])])
    return np.array(links, np.intp)


def _with_proportions(form: Array, template: Template, spread: float) -> Array:
    """Return the form after whole proportions have been given a variance of their own.

    The covariance gains spread² m mᵀ for each direction m in which length, width or height
    change by their own size; by Woodbury's identity the form loses what follows.
    """
    places = template.positions - [template.positions[:, 0].mean(), 0.0, 0.0]
    modes = np.stack([template.reduced(places * axis) for axis in np.eye(3)], axis=1)
    pushed = form @ modes
    inner = np.eye(3) / spread**2 + modes.T @ pushed
    return np.asarray(form - pushed @ np.linalg.solve(inner, pushed.T))
