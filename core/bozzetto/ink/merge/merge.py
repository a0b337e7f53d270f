"""Choice among several orderings of the ink, by a score that needs no ground truth."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array
from bozzetto.geometry.spline import DEGREE, Spline
from bozzetto.ink.curves.least_squares import (
    ENOUGH,
    MORE,
    MOST,
    NOISE_FACTOR,
    approximate,
    approximate_adaptively,
)
from bozzetto.ink.curves.resample import arc_length, points_along
from bozzetto.ink.merge.order_by_longest import order_by_longest
from bozzetto.ink.merge.order_by_mst import order_by_mst
from bozzetto.ink.merge.order_by_parameter import order_by_parameter
from bozzetto.ink.merge.order_by_pca import order_by_pca
from bozzetto.ink.merge.resample_all import Ordering, ResampledInk, resample_all

Strategy = Literal["principal", "spanning", "following", "strip"]
Way = Callable[[ResampledInk], Ordering | None]

GOOD: Final = 3.0
"""Score (pixels) of a quick strategy that makes the strip, which is slow, superfluous."""

HONEST: Final = 2.0
"""Score, in widths of the ink, that is as good: the ink itself is spread that much."""

UNSURE: Final = 5.0
"""Score (pixels) above which the curve is shown as not sure. On 418 real clusters this marks
62 % of the curves that are wrong and 6 % of those that are right."""

BROAD: Final = 0.02
"""`UNSURE` as a share of the diagonal of the curve's box: a large scribble may be wider, as
long as its score is no worse than its own width explains (`HONEST`)."""

FINAL: Final = 2
"""Strategies, the best ones, that are fitted in detail."""

DETAIL: Final = 3.0
"""Least distance of control points, in widths of the ink: what is finer is not meant."""

MOST_VAIN: Final = 2
"""Times that more control points may help nothing before no more are tried."""

WORTH: Final = 0.98
"""Share of the score that may be left for more control points, or less say, to be worth it."""

CALMING: Final = 2
"""Rounds of reweighting ink by its distance from the curve."""

FOOT_STEPS: Final = 3
"""Newton steps to the foot points in each of them."""

NEAR_END: Final = 10.0
"""Gap of the ends that may be closed, in spacings of the ink."""

ROUND: Final = 20.0
"""Least length of a closed curve, in spacings of the ink."""

SAME_WAY: Final = 0.5
"""Least cosine of the turn where a curve goes on into its own start."""

CLOSED_PRICE: Final = 1.1
"""Factor by which closing may make the score worse."""

BIN: Final = 4.0
"""Length over which the noise of the ink is measured, in spacings."""

PER_BIN: Final = 4
"""Fewest points that such a length holds on average: fewer would follow the noise."""

ROUGHLY: Final = 65
"""Places on a curve that tell its length well enough to space the polyline."""

SHOWN: Final = 400
"""Most points of the settled polyline."""


@dataclass(frozen=True, eq=False)
class MergedStrokes:
    """One curve from many strokes.

    Attributes
    ----------
    points : (m, 2) float
        The curve as a polyline, about 1 px apart where that is possible.
    spline : Spline
        The same, exact.
    closed : bool
    score : float
        Root mean square distance of the ink from the curve plus the 95th percentile of the
        distance of the curve from the ink, in units of the points.
    strategy : {"principal", "spanning", "following", "strip"}
        Which ordering was taken.
    sure : bool
        Whether the score is at most 5 px, or on a large curve no more than the width of the
        ink explains; if not, the person should be asked to draw again.
    """

    points: Array
    spline: Spline
    closed: bool
    score: float
    strategy: Strategy
    sure: bool


def merge_strokes(
    strokes: Sequence[ArrayLike], weights: ArrayLike | None = None, *, pixel: float = 1.0
) -> MergedStrokes:
    """Make one curve of strokes drawn over one another, in any order and direction.

    Parameters
    ----------
    strokes : sequence of (n, 2) array_like
        Their samples, canvas pixels.
    weights : (strokes,) array_like, optional
        What each stroke counts (`stroke_weights`); not negative.
    pixel : float
        Length of a pixel in the units of the points.

    Returns
    -------
    MergedStrokes
        The result with the least score.

    Raises
    ------
    UserError
        If there is no ink, or it is a dot, or not finite.
    ValueError
        If there is not one weight for each stroke.
    """
    weight = np.ones(len(strokes)) if weights is None else np.asarray(weights, float)
    if weight.shape != (len(strokes),) or not np.isfinite(weight).all() or (weight < 0).any():
        raise ValueError("every stroke needs a weight that is not negative")
    judge = _Judge(resample_all(strokes, weight, pixel))
    found = [made for way in QUICK if (made := judge.tried(*way))]
    good = GOOD * pixel
    for way in SLOW:
        if min(made.curve.score for made in found) > good and (made := judge.tried(*way)):
            found.append(made)
            good = max(good, HONEST * min(made.noise for made in found))
    found.sort(key=lambda made: made.curve.score)
    return min((judge.detailed(made) for made in found[:FINAL]), key=lambda made: made.score)


QUICK: Final[tuple[tuple[Strategy, Way], ...]] = (
    ("principal", order_by_pca),
    ("spanning", order_by_mst),
)

SLOW: Final[tuple[tuple[Strategy, Way], ...]] = (
    ("following", order_by_longest),
    ("strip", order_by_parameter),
)


@dataclass(frozen=True, eq=False)
class _Tried:
    """Result of one strategy: its ordering, the scatter of the ink about it, and the curve."""

    order: Ordering
    noise: float
    curve: MergedStrokes


class _Judge:
    """Fits orderings of one ink and scores them."""

    def __init__(self, ink: ResampledInk) -> None:
        from scipy.spatial import cKDTree

        self.ink = ink
        self.dense = np.vstack([_refined(ink.points[n], ink) for n in ink.pieces])
        self.tree = cKDTree(self.dense)
        self.weights = ink.weights / ink.weights.sum()

    def tried(self, name: Strategy, way: Way) -> _Tried | None:
        """Fit the curve of one strategy, closed where its ends meet; None where it finds none."""
        order = way(self.ink)
        if order is None:
            return None
        made = self._fitted(name, order)
        lap = 0.0 if order.closed else self._lap(made.curve)
        if not lap:
            return made
        around = Ordering(order.numbers, np.mod(order.parameters / lap, 1.0), closed=True)
        ring = self._fitted(name, around)
        return ring if ring.curve.score <= CLOSED_PRICE * made.curve.score else made

    def _fitted(self, name: Strategy, order: Ordering) -> _Tried:
        ink = self.ink
        points, weights = ink.points[order.numbers], ink.weights[order.numbers]
        noise = _scatter(points, order, ink.spacing)
        enough = max(ENOUGH * ink.pixel, NOISE_FACTOR * noise)
        made = approximate_adaptively(
            points, weights, order.parameters, enough, closed=order.closed
        )
        return _Tried(order, noise, self._settled(name, order, noise, made.spline))

    def detailed(self, tried: _Tried) -> MergedStrokes:
        """Refine a result with more control points, where they bring the curve nearer to the ink.

        The scatter of wide scribbles hides small curls from the first fit. Control points
        are never closer than the ink is wide, or the curve would run to and fro between
        strokes side by side.
        """
        ink, order, best = self.ink, tried.order, tried.curve
        points, weights = ink.points[order.numbers], ink.weights[order.numbers]
        count = len(best.spline.control_points) - (DEGREE if order.closed else 0)
        least = max(DETAIL * tried.noise, ink.spacing)
        most = min(MOST, len(points), DEGREE + int(arc_length(best.points)[-1] / least))
        vain = 0
        while best.score > GOOD * ink.pixel and count + MORE <= most and vain < MOST_VAIN:
            count += MORE
            made = approximate(points, weights, order.parameters, count, closed=order.closed)
            finer = self._settled(best.strategy, order, tried.noise, made.spline)
            vain = 0 if finer.score < WORTH * best.score else vain + 1
            best = best if vain else finer
        return best if best.score <= GOOD * ink.pixel else self._calmed(tried, best)

    def _calmed(self, tried: _Tried, best: MergedStrokes) -> MergedStrokes:
        """Refine a result with less weight for ink far off, where that brings the curve nearer.

        Reweighted least squares with Cauchy's weights: the curve runs along most strokes
        instead of between them and one that strayed.
        """
        ink, order = self.ink, tried.order
        points, weights = ink.points[order.numbers], ink.weights[order.numbers]
        count = len(best.spline.control_points) - (DEGREE if order.closed else 0)
        spline, feet = best.spline, order.parameters
        for _ in range(CALMING):
            feet = spline.foot_points(points, feet, steps=FOOT_STEPS)
            apart = np.linalg.norm(spline.value(feet) - points, axis=1)
            say = weights / (1.0 + (apart / max(tried.noise, ink.pixel)) ** 2)
            spline = approximate(points, say, feet, count, closed=order.closed).spline
        calmed = self._settled(best.strategy, order, tried.noise, spline)
        return calmed if calmed.score < WORTH * best.score else best

    def _settled(
        self, name: Strategy, order: Ordering, noise: float, spline: Spline
    ) -> MergedStrokes:
        line, pixel = self._polyline(spline), self.ink.pixel
        score = self._score(line)
        broad = min(BROAD * float(np.linalg.norm(np.ptp(line, axis=0))), HONEST * noise)
        sure = score <= max(UNSURE * pixel, broad)
        return MergedStrokes(line, spline, order.closed, score, name, sure)

    def _polyline(self, spline: Spline) -> Array:
        length = float(arc_length(spline.sampled(ROUGHLY))[-1])
        return spline.sampled(int(np.clip(np.ceil(length / self.ink.pixel), 32, SHOWN)) + 1)

    def _score(self, line: Array) -> float:
        from scipy.spatial import cKDTree

        fine = _refined(line, self.ink)
        to_curve = cKDTree(fine).query(self.ink.points)[0]
        to_ink = self.tree.query(fine)[0]
        return float(np.sqrt(self.weights @ to_curve**2) + np.percentile(to_ink, 95))

    def _lap(self, made: MergedStrokes) -> float:
        """Return the parameter at which an open curve passes its start again; 0 where it does not.

        Above 1 where there is a gap between the ends, below 1 where the ends overlap.
        """
        line, spacing = made.points, self.ink.spacing
        along = arc_length(line)
        tangents = made.spline.derivative(np.linspace(*made.spline.range, len(line)))
        tangents /= np.maximum(np.linalg.norm(tangents, axis=1, keepdims=True), 1e-300)
        gap = line[0] - line
        distance = np.linalg.norm(gap, axis=1)
        meets = (distance < NEAR_END * spacing) & (along > ROUND * spacing)
        there = np.flatnonzero(meets & (tangents @ tangents[0] > SAME_WAY))
        if not len(there):
            return 0.0
        first = there[: np.flatnonzero(np.diff(there, append=there[-1] + 2) > 1)[0] + 1]
        at = int(first[np.argmin(distance[first])])
        ahead = max(0.0, float(gap[at] @ tangents[at]))
        return at / (len(line) - 1) * (1.0 + ahead / float(along[at]))


def _refined(points: Array, ink: ResampledInk) -> Array:
    """Return points on a polyline no farther apart than a third of the spacing of the ink."""
    along = arc_length(points)
    count = int(np.ceil(3.0 * along[-1] / ink.spacing)) + 1
    return points_along(points, along, np.linspace(0.0, along[-1], count))


def _scatter(points: Array, order: Ordering, spacing: float) -> float:
    """Return the standard deviation of the ink about its running mean along the ordering."""
    squares = np.unique(np.round(points / (BIN * spacing)).astype(np.int64), axis=0)
    bins = int(np.clip(len(squares), 8, max(8, len(points) // PER_BIN)))
    home = np.minimum((order.parameters * bins).astype(np.intp), bins - 1)
    counts = np.bincount(home, minlength=bins)
    full = counts > 0
    middle = np.bincount(home, order.parameters, bins)[full] / counts[full]
    offset = points.copy()
    for axis, column in enumerate(points.T):
        mean = np.bincount(home, column, bins)[full] / counts[full]
        offset[:, axis] -= np.interp(order.parameters, middle, mean)
    return float(1.4826 * np.median(np.linalg.norm(offset, axis=1)))
