"""How far a car is from its template, and which marks are wrong, as the marks have it.

The cost of `prior` takes for granted how much cars differ from the template. Then a car
that *is* the template follows every tremor of the hand, and a mark that went astray takes the
shape along. What is probable tells both apart (MacKay, *Bayesian interpolation*, 1992). Of a car
that differs by a share t of what the cost expects, marked by a hand s times as unsteady, the
marks lie about their places in the template, to first order, with the covariance

    C = s² I + t² A Σ Aᵀ ,

where A is their derivative by the car and Σ the covariance of cars; what moves with the cameras,
of which nothing is known, has been projected out of all three. One symmetric eigenvalue problem
serves every t and s. From C⁻¹ follows how probable a mark is beside the others (Sundararajan &
Keerthi, *Predictive approaches for choosing hyperparameters in Gaussian processes*, 2001). One
that is less so than a mark that may lie anywhere is set aside.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto_car.array_types import Array, Flags
from bozzetto_car.camera.marked_view import MarkedView, Sight
from bozzetto_car.solver.prior import Cost, Prior
from bozzetto_car.template.model import Template

SPREADS: Final = np.geomspace(0.03, 1.5, 12)
"""Shares t of the deviations that the cost expects; all of them as likely beforehand."""

HANDS: Final = np.geomspace(0.7, 3.0, 6)
"""How much less steady a hand is than the cost has it by default. What is below counts as exact:
nobody wants to hear that a mark disagrees by 5 px."""

STEADY: Final = 1.6
"""Factor by which hands differ (one standard deviation of the logarithm)."""

ASTRAY: Final = 16.0
"""Price of setting a mark aside, as a natural logarithm: it may lie anywhere in the picture, which
is worth 12, and that happens to one mark in fifty."""

SINGLE: Final = 0.2
"""What is added to it for every mark of the sketch. Cars differ in single places more than the cost
has it, as with a pillar that stands 15 cm farther back, and many marks show many places."""

RETURNING: Final = 6.0
"""By how much that is cheaper for a mark that was aside already while marks are dragged, so
that none comes and goes with every tremor."""

FEWEST_LEFT: Final = 6
"""Marks of a sketch that count in any case: so few fit whatever they are told."""

MOST_ASIDE: Final = 0.25
"""Most marks of a sketch that are set aside, as a share. Of more, none tells which are right."""


TOLD: Final = 1e-12
"""Least determinant of a mark's block, of 1: below, the mark alone determines the camera."""


NO_CHANGE: Final = (0.0, 0, 0)
"""Gain, sketch and mark where none can be set aside or taken back."""


@dataclass(frozen=True, eq=False)
class Weighed:
    """What the marks say of the car and of each other.

    Attributes
    ----------
    spread : float
        How far the car is from the template, as a share of the deviations that the cost expects.
    counted : tuple of (k,) bool
        For each sketch which marks count; the others are set aside.
    """

    spread: float
    counted: tuple[Flags, ...]


def weighed(
    template: Template, views: Sequence[MarkedView], aside: Sequence[Flags] | None = None
) -> Weighed:
    """Weigh the marks of all sketches of a car against the template and each other.

    Parameters
    ----------
    template : Template
    views : sequence of MarkedView
        With all marks, and cameras near enough for first derivatives, as those from the template
        are. All marked nodes are before them.
    aside : sequence of (k,) bool, optional
        For each sketch the marks that were aside before one of them was dragged.

    Notes
    -----
    Marks are set aside one at a time, always the one by which the probability of all gains most,
    until none gains, and then taken back likewise. It grows with each, so there is an end.
    """
    sketches = _linear(template, views)
    before = [np.zeros(len(view.nodes), bool) for view in views] if aside is None else aside
    counted = [~flags for flags in before]
    prices = [np.where(flags, -RETURNING, 0.0) + ASTRAY + SINGLE * len(flags) for flags in before]
    while True:
        now = Evidence(sketches, counted)
        best = max(_losses(now, counted, prices), default=NO_CHANGE)
        if best[0] <= 0.0:
            best = max(_returns(sketches, counted, prices), default=NO_CHANGE)
        gain, sketch, mark = best
        if gain <= 0.0:
            return Weighed(now.spread, tuple(counted))
        counted[sketch][mark] = not counted[sketch][mark]


def evidence_of(template: Template, view: MarkedView) -> Evidence:
    """How probable the marks of one sketch are, all of them.

    Parameters
    ----------
    template : Template
    view : MarkedView
        As for `weighed`.
    """
    return Evidence(_linear(template, [view]), [np.ones(len(view.nodes), bool)])


def _losses(
    now: Evidence, counted: list[Flags], prices: list[Array]
) -> Iterator[tuple[float, int, int]]:
    """What is gained by setting the best mark of each sketch aside, which sketch, and which."""
    for number, (flags, price) in enumerate(zip(counted, prices, strict=True)):
        most = min(len(flags) - FEWEST_LEFT, int(MOST_ASIDE * len(flags)))
        if len(flags) - flags.sum() < most:
            there = np.flatnonzero(flags)
            gains = now.improbable[number] - price[there]
            yield float(gains.max()), number, int(there[gains.argmax()])


def _returns(
    sketches: list[_Linear], counted: list[Flags], prices: list[Array]
) -> Iterator[tuple[float, int, int]]:
    """What is gained by taking each mark back that is aside, its sketch, and its number."""
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


def _linear(template: Template, views: Sequence[MarkedView]) -> list[_Linear]:
    cost = Cost.balanced()
    prior = Prior(template, cost)
    root = np.linalg.inv(np.linalg.cholesky(prior.form(prior.variables))).T
    follow = (template.basis @ root).reshape(-1, 3, len(root))
    made = []
    for view in views:
        sight, pose = Sight.of(template, view, held=False)
        seen = sight.residuals(pose, template.positions)
        if seen is None:
            raise ValueError("a marked node is not before its camera")
        by_car = seen.by_nodes @ follow[view.nodes]
        made.append(_Linear(*(part / cost.hand for part in (seen.missed, by_car, seen.by_camera))))
    return made


class Evidence:
    """How probable marks are, for all spreads and hands together.

    Attributes
    ----------
    total : float
        Natural logarithm of the probability of all marks, but for a constant that depends on
        their number alone.
    spread : float
        See `Weighed`; the mean of the logarithm, as a factor.
    improbable : list of (k,) float
        For each sketch: by how much the rest is more probable without each mark, as a logarithm.
    """

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
        self.spread = float(np.exp(np.exp(logs) @ np.log(spreads)))
        # The inverse of C, times s²: its blocks of two by two for each mark, and what it makes
        # of what is missed.
        across, down = by_car[::2], by_car[1::2]
        xx = blocks[:, 0, :1] - across**2 @ damped
        yy = blocks[:, 1, 1:] - down**2 @ damped
        xy = blocks[:, 0, 1:] - (across * down) @ damped
        left = missed[:, None] - by_car @ (damped * pulled[:, None])
        x, y = left[::2], left[1::2]
        size = np.maximum(xx * yy - xy**2, TOLD)
        squared = (yy * x**2 - 2.0 * xy * x * y + xx * y**2) / size / hands**2
        alone = 0.5 * np.log(size) - 2.0 * np.log(hands) - np.log(2.0 * np.pi) - 0.5 * squared
        ends = np.cumsum([flags.sum() for flags in counted])[:-1]
        self.improbable = np.split(_sum_of_logs(logs - alone), ends)


def _without_cameras(
    sketches: Sequence[_Linear], counted: Sequence[Flags]
) -> tuple[Array, Array, Array, int]:
    """Project out what moves with the cameras.

    Returns
    -------
    missed : (m,) float
    by_car : (m, q) float
    blocks : (m / 2, 2, 2) float
        Of the projection, for each mark.
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
    """Two rows for each mark, (2 k, n), of (k, 2, n)."""
    return pairs.reshape(-1, pairs.shape[2])


def _sum_of_logs(logs: Array) -> Array:
    """Logarithm of the sum of exponentials along the last axis."""
    top = logs.max(axis=-1, keepdims=True)
    return np.asarray(np.log(np.exp(logs - top).sum(axis=-1)) + top[..., 0])
