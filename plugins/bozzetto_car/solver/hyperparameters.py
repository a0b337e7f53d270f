"""Estimate how far a car is from its template, and which marks are wrong.

The cost of `prior` assumes how much cars differ from the template. With it alone, a car that
*is* the template follows the noise of the hand, and a wrong mark distorts the shape. The evidence
of the marks tells both apart (MacKay, *Bayesian interpolation*, 1992). If a car differs by a
share t of what the cost expects and the hand is s times as unsteady, the marks lie about their
places in the template, to first order, with the covariance

    C = s² I + t² A Σ Aᵀ ,

where A is their derivative by the car and Σ the covariance of cars; the unknown motions of the
cameras have been projected out of all three. One symmetric eigenvalue problem serves every t and
s. From C⁻¹ follows how probable a mark is given the others (Sundararajan & Keerthi, *Predictive
approaches for choosing hyperparameters in Gaussian processes*, 2001). A mark that is less
probable than a mark at a random place is set aside.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags
from bozzetto_car.camera.marked_view import MarkedView, Reprojection
from bozzetto_car.solver.prior import Cost, Prior
from bozzetto_car.template.model import Template

SPREADS: Final = np.geomspace(0.03, 1.5, 12)
"""Shares t of the deviations that the cost expects; all are equally likely a priori."""

HANDS: Final = np.geomspace(0.7, 10.0, 9)
"""Factors s by which a hand is less steady than the cost assumes. Less than the least counts as
exact: nobody wants to hear that a mark disagrees by 5 px."""

STEADY: Final = 1.6
"""Factor by which hands differ (one standard deviation of the logarithm)."""

MISTAKE: Final = 16.0
"""Price of setting a mark aside, as a natural logarithm: a mark at a random place in the picture
costs 12, and one mark in fifty is such a mistake."""

MISTAKE_PER_MARK: Final = 0.2
"""Addition to this price for every mark of the sketch. Cars differ in single places more than the
cost expects, such as a pillar 15 cm farther back, and many marks show many places."""

RETURN_DISCOUNT: Final = 6.0
"""Discount for a mark that was aside already while marks are dragged, so that no mark comes and
goes with the noise of the hand."""

FEWEST_LEFT: Final = 6
"""Number of marks of a sketch that always count: so few marks fit any car."""

MOST_ASIDE: Final = 0.25
"""Largest share of the marks of a sketch that is set aside: beyond it, nothing tells which marks
are right."""


UNRELATED: Final = replace(Cost.balanced(), kinship=0.0)
"""The cost for cars that differ from their template in dimensions and by chance only."""

DETERMINED: Final = 1e-12
"""Least determinant of a mark's block, of 1: below, the mark alone determines the camera."""


NO_CHANGE: Final = (0.0, 0, 0)
"""Gain, sketch and mark where none can be set aside or taken back."""


@dataclass(frozen=True, eq=False)
class Weighed:
    """The estimated spread of the car, and which marks count.

    Attributes
    ----------
    spread : float
        How far the car is from the template, as a share of the deviations that the cost expects.
    hand : float
        How much less steady the hand is than the cost assumes, as a factor; 1 at least.
    related : float
        Probability that the car differs from the template toward other templates, too.
    counted : tuple of (k,) bool
        Which marks of each sketch count; the others are set aside.
    """

    spread: float
    hand: float
    related: float
    counted: tuple[Flags, ...]


def judge_marks(
    template: Template, views: Sequence[MarkedView], aside: Sequence[Flags] | None = None
) -> Weighed:
    """Weigh the marks of all sketches of a car against the template and each other.

    Parameters
    ----------
    template : Template
        The template of the car.
    views : sequence of MarkedView
        The sketches with all marks, and with cameras near enough for first derivatives, such as
        those from the template. All marked nodes are in front of the cameras.
    aside : sequence of (k,) bool, optional
        For each sketch the marks that were aside before one of them was dragged.

    Notes
    -----
    Marks are set aside one at a time, always the one that raises the probability of all most, until
    none does, and then taken back in the same way. The probability grows each time, so this ends.
    """
    kinds = [_linear(template, views, cost) for cost in (Cost.balanced(), UNRELATED)]
    before = [np.zeros(len(view.nodes), bool) for view in views] if aside is None else aside
    counted = [~flags for flags in before]
    prices = [
        np.where(flags, -RETURN_DISCOUNT, 0.0) + MISTAKE + MISTAKE_PER_MARK * len(flags)
        for flags in before
    ]
    found = [Evidence(sketches, counted) for sketches in kinds]
    sketches = kinds[0] if found[0].total >= found[1].total else kinds[1]
    while True:
        now = Evidence(sketches, counted)
        best = max(_losses(now, counted, prices), default=NO_CHANGE)
        if best[0] <= 0.0:
            best = max(_returns(sketches, counted, prices), default=NO_CHANGE)
        gain, sketch, mark = best
        if gain <= 0.0:
            break
        counted[sketch][mark] = not counted[sketch][mark]
    one, other = (Evidence(sketches, counted) for sketches in kinds)
    related = 1.0 / (1.0 + np.exp(min(other.total - one.total, 500.0)))
    spread, hand = (
        related * getattr(one, what) + (1.0 - related) * getattr(other, what)
        for what in ("log_spread", "log_hand")
    )
    return Weighed(
        float(np.exp(spread)), float(np.exp(max(hand, 0.0))), float(related), tuple(counted)
    )


def evidence_of(template: Template, view: MarkedView) -> Evidence:
    """Return how probable the marks of one sketch are, all of them together.

    Parameters
    ----------
    template : Template
        The template of the car.
    view : MarkedView
        The sketch, as for `judge_marks`.
    """
    return Evidence(_linear(template, [view], Cost.balanced()), [np.ones(len(view.nodes), bool)])


def _losses(
    now: Evidence, counted: list[Flags], prices: list[Array]
) -> Iterator[tuple[float, int, int]]:
    """Return the gain of setting the best mark of each sketch aside, the sketch, and the mark."""
    for number, (flags, price) in enumerate(zip(counted, prices, strict=True)):
        most = min(len(flags) - FEWEST_LEFT, int(MOST_ASIDE * len(flags)))
        if len(flags) - flags.sum() < most:
            there = np.flatnonzero(flags)
            gains = now.improbable[number] - price[there]
            yield float(gains.max()), number, int(there[gains.argmax()])


def _returns(
    sketches: list[_Linear], counted: list[Flags], prices: list[Array]
) -> Iterator[tuple[float, int, int]]:
    """Return the gain of taking each mark back that is aside, the sketch, and the mark."""
    for number, flags in enumerate(counted):
        for mark in np.flatnonzero(~flags).tolist():
            more = flags.copy()
            more[mark] = True
            with_it = Evidence(sketches, [*counted[:number], more, *counted[number + 1 :]])
            rank = int(more[:mark].sum())
            yield float(prices[number][mark] - with_it.improbable[number][rank]), number, mark


@dataclass(frozen=True, eq=False)
class _Linear:
    """A sketch to first order about the template, in standard deviations of the hand.

    Attributes
    ----------
    missed : (k, 2) float
    by_car : (k, 2, q) float
        Derivative by the car, in numbers that have the covariance 1.
    by_camera : (k, 2, c) float
    """

    missed: Array
    by_car: Array
    by_camera: Array


def _linear(template: Template, views: Sequence[MarkedView], cost: Cost) -> list[_Linear]:
    prior = Prior(template, cost)
    root = np.linalg.inv(np.linalg.cholesky(prior.form(prior.variables))).T
    follow = (template.basis @ root).reshape(-1, 3, len(root))
    made = []
    for view in views:
        sight, pose = Reprojection.of(template, view, held=False)
        seen = sight.residuals(pose, template.positions)
        if seen is None:
            raise ValueError("a marked node is not before its camera")
        by_car = seen.by_nodes @ follow[view.nodes]
        made.append(_Linear(*(part / cost.hand for part in (seen.missed, by_car, seen.by_camera))))
    return made


class Evidence:
    """The probability of marks, for all spreads and hands together.

    Attributes
    ----------
    total : float
        Natural logarithm of the probability of all marks, up to a constant that depends only on
        their number.
    log_spread, log_hand : float
        See `Weighed`; the means of the logarithms.
    improbable : list of (k,) float
        For each sketch, the gain in probability of the rest without each mark, as a logarithm.
    """

    @property
    def spread(self) -> float:
        """How far the car is from the template, as a share of what the cost expects."""
        return float(np.exp(self.log_spread))

    def __init__(self, sketches: Sequence[_Linear], counted: Sequence[Flags]) -> None:
        spreads, hands = (grid.ravel() for grid in np.meshgrid(SPREADS, HANDS))
        ratio = (spreads / hands) ** 2
        missed, by_car, blocks, rank = _without_cameras(sketches, counted)
        sizes, axes = np.linalg.eigh(by_car.T @ by_car)
        sizes = np.maximum(sizes, 0.0)[:, None]
        by_car = by_car @ axes
        pulled = by_car.T @ missed
        damped = ratio / (1.0 + sizes * ratio)
        misfit = (missed @ missed - pulled**2 @ damped) / hands**2
        logs = -0.5 * (np.log1p(sizes * ratio).sum(axis=0) + 2.0 * rank * np.log(hands) + misfit)
        logs -= 0.5 * (np.log(hands) / np.log(STEADY)) ** 2
        self.total = float(_sum_of_logs(logs))
        logs -= self.total
        self.log_spread, self.log_hand = (
            float(np.exp(logs) @ np.log(grid)) for grid in (spreads, hands)
        )
        # The inverse of C, times s²: its 2 × 2 blocks for each mark, and its product with the
        # residuals.
        across, down = by_car[::2], by_car[1::2]
        xx = blocks[:, 0, :1] - across**2 @ damped
        yy = blocks[:, 1, 1:] - down**2 @ damped
        xy = blocks[:, 0, 1:] - (across * down) @ damped
        left = missed[:, None] - by_car @ (damped * pulled[:, None])
        x, y = left[::2], left[1::2]
        size = np.maximum(xx * yy - xy**2, DETERMINED)
        squared = (yy * x**2 - 2.0 * xy * x * y + xx * y**2) / size / hands**2
        alone = 0.5 * np.log(size) - 2.0 * np.log(hands) - np.log(2.0 * np.pi) - 0.5 * squared
        ends = np.cumsum([flags.sum() for flags in counted])[:-1]
        self.improbable = np.split(_sum_of_logs(logs - alone), ends)


def _without_cameras(
    sketches: Sequence[_Linear], counted: Sequence[Flags]
) -> tuple[Array, Array, Array, int]:
    """Project out the motions of the cameras.

    Returns
    -------
    missed : (m,) float
    by_car : (m, q) float
    blocks : (m / 2, 2, 2) float
        Diagonal blocks of the projection, for each mark.
    rank : int
        Dimensions that are left.
    """
    missed, by_car, blocks, rank = [], [], [], 0
    for sketch, flags in zip(sketches, counted, strict=True):
        off, follow = sketch.missed[flags].ravel(), _tall(sketch.by_car[flags])
        base, _ = np.linalg.qr(_tall(sketch.by_camera[flags]))
        missed.append(off - base @ (base.T @ off))
        by_car.append(follow - base @ (base.T @ follow))
        pairs = base.reshape(-1, 2, base.shape[1])
        blocks.append(np.eye(2) - pairs @ np.swapaxes(pairs, 1, 2))
        rank += base.shape[0] - base.shape[1]
    return np.concatenate(missed), np.vstack(by_car), np.concatenate(blocks), rank


def _tall(pairs: Array) -> Array:
    """Return two rows for each mark, (2 k, n), from (k, 2, n)."""
    return pairs.reshape(-1, pairs.shape[2])


def _sum_of_logs(logs: Array) -> Array:
    """Return the logarithm of the sum of exponentials along the last axis."""
    top = logs.max(axis=-1, keepdims=True)
    return np.asarray(np.log(np.exp(logs - top).sum(axis=-1)) + top[..., 0])
