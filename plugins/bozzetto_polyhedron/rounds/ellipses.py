"""Ellipses through ink, and whether it is an ellipse rather than a polygon.

The first fit is the direct one of Halíř and Flusser (*Numerically stable direct least squares
fitting of ellipses*, 1998); steps of Gauss and Newton with first-order distances (Sampson 1982)
follow.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.ink import resample
from bozzetto_polyhedron.graph.segments import line_costs

SAMPLES: Final = 96
"""Points of ink that an ellipse is fitted to."""

ROUNDS: Final = 4
"""Steps of Gauss and Newton."""

CORNERS: Final = 48
"""Points of ink among which the corners of a polygon are sought."""

STEP: Final = 1e-4
"""Of the derivatives, in mean radii."""

TURN: Final = 2.0 * np.pi
"""Radians."""

BINS: Final = 36
"""Sectors of an ellipse that ink is counted in."""

ALL_ROUND: Final = 0.85
"""Share of the sectors that an ellipse drawn whole has ink in."""

ROUND: Final = {"clear": 0.085, "all": 0.16}
"""Largest root mean square distance of ink from an ellipse, in mean radii, by how much evidence is
asked: a square is off by 10 %, and 2 % of a drawing are 16 % of a radius of an eighth of it."""

FOUR, SIX = 1.0, 1.5
"""Distance from the ellipse, in distances from four and from six straight lines, up to which ink is
round: a regular hexagon is off by 4 %, and six lines are off a circle by 2 %."""

FLATTEST: Final = 0.08
"""Least ratio of the axes: flatter ellipses are lines that were drawn to and fro."""


@dataclass(frozen=True, eq=False)
class Ellipse:
    """An ellipse on the sheet.

    Parameters
    ----------
    center : (2,) float64
        px.
    axes : (2, 2) float64
        Rows are half of the longer axis, and of the shorter one, px.
    """

    center: Array
    axes: Array

    @property
    def lengths(self) -> Array:
        """Halves of the longer and of the shorter axis, (2,), px."""
        return np.asarray(np.linalg.norm(self.axes, axis=1))

    @property
    def radius(self) -> float:
        """Geometric mean of both, px."""
        return float(np.sqrt(np.prod(self.lengths)))

    def at(self, angles: Array) -> Array:
        """Return points at angles, radians from the longer axis, (n, 2) px."""
        return np.asarray(
            self.center + np.column_stack((np.cos(angles), np.sin(angles))) @ self.axes
        )

    def unit(self, points: Array) -> Array:
        """Return points, (n, 2), where the ellipse is the unit circle."""
        scaled = self.axes / (self.lengths**2)[:, None]
        return np.asarray((points - self.center) @ scaled.T)

    def distances(self, points: Array) -> Array:
        """Return how far outside points, (n, 2), lie, to first order, (n,) px."""
        at = self.unit(points)
        away = np.maximum(np.linalg.norm(at, axis=1), 1e-9)
        slope = np.linalg.norm((at / away[:, None]) / self.lengths, axis=1)
        return np.asarray((away - 1.0) / np.maximum(slope, 1e-12))

    def moved(self, shift: Array) -> Ellipse:
        """Return the same ellipse elsewhere."""
        return Ellipse(self.center + shift, self.axes)

    def covered(self, points: Array) -> float:
        """Return the share of its sectors that points, (n, 2), lie in."""
        x, y = self.unit(points).T
        sectors = np.floor(np.arctan2(y, x) / TURN * BINS).astype(int) % BINS
        return len(np.unique(sectors)) / BINS


def even_samples(paths: list[Array], count: int = SAMPLES) -> Array:
    """Return points at even steps along paths, (n, 2), as many on each as it is long."""
    lengths = [float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum()) for path in paths]
    whole = sum(lengths)
    return np.concatenate(
        [
            np.asarray(resample(path, count=max(4, round(count * length / whole))))
            for path, length in zip(paths, lengths, strict=True)
            if length > 0.0
        ]
    )


def ellipse_through(points: Array) -> Ellipse | None:
    """Return the ellipse nearest to points, (n, 2); None where there is none."""
    middle = points.mean(axis=0)
    scale = float(np.sqrt(((points - middle) ** 2).sum(axis=1).mean()))
    if not scale > 0.0 or len(points) < 6:
        return None
    found = _direct((points - middle) / scale)
    if found is None:
        return None
    for _ in range(ROUNDS):
        found = _nearer(found, (points - middle) / scale)
        if found is None:
            return None
    center, form = found
    values, vectors = np.linalg.eigh(form)
    lengths = 1.0 / values
    return Ellipse(middle + scale * center, scale * lengths[:, None] * vectors.T)


def _direct(points: Array) -> tuple[Array, Array] | None:
    """Return the centre and the symmetric matrix that makes the ellipse the unit circle."""
    x, y = points.T
    first = np.column_stack((x * x, x * y, y * y))
    second = np.column_stack((x, y, np.ones(len(x))))
    s1, s2, s3 = first.T @ first, first.T @ second, second.T @ second
    if np.linalg.cond(s3) > 1e12:
        return None
    rest = -np.linalg.solve(s3, s2.T)
    reduced = s1 + s2 @ rest
    reduced = np.array((reduced[2] / 2.0, -reduced[1], reduced[0] / 2.0))
    _, vectors = np.linalg.eig(reduced)
    vectors = vectors.real
    sign = 4.0 * vectors[0] * vectors[2] - vectors[1] ** 2
    if not (sign > 0.0).any():
        return None
    a, b, c = vectors[:, int(sign.argmax())]
    d, e, f = rest @ (a, b, c)
    square = np.array(((a, b / 2.0), (b / 2.0, c)))
    center = -0.5 * np.linalg.solve(square, (d, e))
    level = float(center @ square @ center) - f
    values, vectors = np.linalg.eigh(square / level)
    if not values.min() > 0.0:
        return None
    return center, np.asarray((vectors * np.sqrt(values)) @ vectors.T)


def _off(center: Array, form: Array, points: Array) -> Array:
    at = (points - center) @ form
    away = np.maximum(np.linalg.norm(at, axis=1), 1e-9)
    slope = np.linalg.norm((at / away[:, None]) @ form, axis=1)
    return np.asarray((away - 1.0) / np.maximum(slope, 1e-12))


def _nearer(found: tuple[Array, Array], points: Array) -> tuple[Array, Array] | None:
    """Return an ellipse after one step of Gauss and Newton."""

    def parts(values: Array) -> tuple[Array, Array]:
        return values[:2], np.array(((values[2], values[3]), (values[3], values[4])))

    center, form = found
    values = np.array((*center, form[0, 0], form[0, 1], form[1, 1]))
    here = _off(*parts(values), points)
    slopes = np.column_stack(
        [(_off(*parts(values + STEP * unit), points) - here) / STEP for unit in np.eye(5)]
    )
    step = np.linalg.lstsq(slopes, here, rcond=None)[0]
    center, form = parts(values - step)
    if not np.isfinite(form).all() or not np.linalg.eigvalsh(form).min() > 0.0:
        return None
    return center, form


def whole_ellipse(paths: list[Array], evidence: str) -> Ellipse | None:
    """Return the ellipse that strokes draw all round; None where they are no ellipse.

    Parameters
    ----------
    paths : list of (n, 2) float64
        One or more strokes, px.
    evidence : {"clear", "all"}
        How much is asked: what may as well be a polygon is none by the first.
    """
    points = even_samples(paths)
    found = ellipse_through(points)
    if found is None or found.lengths[1] < FLATTEST * found.lengths[0]:
        return None
    off = float(np.sqrt((found.distances(points) ** 2).mean()))
    if off > ROUND[evidence] * found.radius or found.covered(points) < ALL_ROUND:
        return None
    if evidence == "clear":
        four, six = (polygon_distance(paths, found, count) for count in (4, 6))
        if off > FOUR * four or off > SIX * six:
            return None
    return found


def polygon_distance(paths: list[Array], around: Ellipse, count: int) -> float:
    """Return how far ink is from the nearest closed polygon, root mean square, px.

    Parameters
    ----------
    paths : list of (n, 2) float64
        px.
    around : Ellipse
        Round which the ink goes.
    count : int
        Of corners; the best ones are found by dynamic programming, from each first corner.
    """
    points = even_samples(paths, CORNERS)
    x, y = around.unit(points).T
    points = points[np.argsort(np.arctan2(y, x), kind="stable")]
    best = np.inf
    for first in range(len(points) // count):
        round_about = np.roll(points, -first, axis=0)
        cost = line_costs(np.concatenate((round_about, round_about[:1])))
        least = cost[0]
        for _ in range(count - 1):
            least = (least[:, None] + cost).min(axis=0)
        best = min(best, float(least[-1]))
    return float(np.sqrt(best / len(points)))
