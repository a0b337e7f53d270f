"""Bend a cubic edge until it is seen where a stroke runs.

Kara & Shimada (2008) lift two points of the stroke, those for the parameters 1/3 and 2/3, to the
places on their view rays that are nearest to the old edge, and take the cubic through them and
the two ends. Between these four points it may leave the stroke. Here that cubic is a start only:
the inner control points are then refined by Gauss–Newton steps on the distances of all samples of
the stroke from the edge as it is seen, with the foot points found again at each step (Hoschek
1988). A handle changes its length and moves across the edge at a right angle to the rays: what a
view does not show stays.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array, Index, cross_product
from bozzetto.geometry.patches import bernstein
from bozzetto.ink import FARTHEST, arc_length, distinct, is_on_sheet, lift_curve
from bozzetto.plugin import cached_property
from bozzetto.view import Camera
from bozzetto_car.camera.rational_projection import (
    TINY,
    Pass,
    Pictured,
    camera_matrix,
    places_of,
    slopes_at,
)

INNER: Final = bernstein(np.array([1.0, 2.0]) / 3.0)
"""Shares of the Bézier points in the inner points that the cubic of the paper goes through."""

MOST_SAMPLES: Final = 96
"""Most samples of a stroke that a fit uses: a cubic has no finer detail."""

RESOLVED: Final = 1e-3
"""Distance, px, within which a stroke runs where the edge is seen already: samples are kept to
some 1e-4 px. The edge stays as it is then, and tracing it again and again does not change it."""

WORTH: Final = 20.0
"""Number of independent places, each known to a pixel, that a stroke along an edge counts as. A
hand errs in long waves, so that more samples tell no more."""

LEEWAY: Final = 0.1
"""Movement of a control point, per chord of the edge, that costs as much as a distance of a pixel.
It matters only where the stroke leaves a direction open: elsewhere it shifts an edge by less than
a hundredth of a pixel."""

UNSEEN: Final = 0.17
"""Sine of the angle to the view rays, ten degrees, below which a direction is not seen: a pixel
of the hand would be more than six of depth."""

FORESHORTENED: Final = 0.35
"""Sine of the angle to the view rays, twenty degrees, below which handles do not move along their
tangents: they would go too far into the depth."""

STEPS: Final = 40
"""Most Gauss–Newton steps. Five to ten are usual."""

HALVINGS: Final = 8
"""Most halvings of a step that does not help."""

SETTLED: Final = 2e-5
"""Longest step of a control point, per chord of the edge, at which the iteration ends."""

FOOT_PLACES: Final = 24
"""Places on an edge among which the search for foot points begins."""

FOOT_STEPS: Final = 8
"""Most Gauss–Newton steps to a foot point."""

FOOT_SETTLED: Final = 1e-6
"""Longest step of the parameter at which they end."""

LONGEST_SHIFT: Final = 1.0 / FOOT_PLACES
"""Longest step of the parameter."""

NEARER: Final = 1e-6
"""Share of the cost by which foot points on other parts of an edge must lower it to count."""


@dataclass(frozen=True, eq=False)
class Sighting:
    """A part of a stroke that tells how an edge looks.

    Attributes
    ----------
    points : (k, 2) float
        Samples of the stroke, px.
    camera : Camera
    flip : (3,) float
        Factors of the coordinates of the edge before it is looked at: ones, or `MIRROR` where
        the stroke shows the edge's image on the other side of the car.
    """

    points: Array
    camera: Camera
    flip: Array


def project_points(camera: Camera, points: Array) -> Array:
    """Return where points (n, 3), mm, are seen, (n, 2) px; infinite for points behind the eye."""
    pixels = camera.project(points)[0]
    return np.where(np.isfinite(pixels), pixels, np.inf)


def edge_pictures(camera: Camera, control_points: Array, pieces: int) -> Array:
    """Return the pictures of edges (m, 4, 3) as polylines, (m, pieces + 1, 2) px."""
    matrix = camera_matrix(camera)
    seen = bernstein(np.linspace(0.0, 1.0, pieces + 1)) @ (
        control_points @ matrix[:, :3].T + matrix[:, 3]
    )
    return places_of(seen)


def four_point_cubic(points: ArrayLike) -> Array:
    """Return the Bézier points of the cubic that goes through four points at 0, 1/3, 2/3 and 1.

    Parameters
    ----------
    points : (4, 3) array_like
        The four points.

    Returns
    -------
    (4, 3) float
        The ends are those given, bit for bit.
    """
    p = np.asarray(points, float)
    first = (-5.0 * p[0] + 18.0 * p[1] - 9.0 * p[2] + 2.0 * p[3]) / 6.0
    second = (2.0 * p[0] - 9.0 * p[1] + 18.0 * p[2] - 5.0 * p[3]) / 6.0
    return np.stack((p[0], first, second, p[3]))


def paper_cubic(control_points: ArrayLike, stroke: ArrayLike, camera: Camera) -> Array:
    """Return the edge as the paper traces it: through two points lifted from the stroke.

    The points of the stroke are those at the shares of its length at which the old edge, as it
    is seen, has its parameters 1/3 and 2/3.

    Parameters
    ----------
    control_points : (4, 3) array_like
        Bézier points of the old edge, mm, in front of the eye.
    stroke : (k, 2) array_like
        The stroke from near the start of the edge to near its end, px.
    camera : Camera
        The view that the stroke was drawn in.

    Returns
    -------
    (4, 3) float
    """
    old = np.asarray(control_points, float)
    length = arc_length(Pictured.of(camera_matrix(camera), old).laid_out(3 * FOOT_PLACES))
    share = length[[FOOT_PLACES, 2 * FOOT_PLACES]] / max(length[-1], np.finfo(float).tiny)
    places = np.asarray(stroke, float)
    along = arc_length(places)
    goal = [np.interp(share * along[-1], along, places[:, axis]) for axis in (0, 1)]
    inner = lift_curve(INNER @ old, camera, np.column_stack(goal))
    return four_point_cubic((old[0], *inner, old[3]))


def fit_edge(
    control_points: ArrayLike,
    sightings: Sequence[Sighting],
    directions: tuple[Array, Array],
    start: ArrayLike | None = None,
) -> Array:
    """Return the edge that is seen along all strokes, as near to an old one as they allow.

    Parameters
    ----------
    control_points : (4, 3) array_like
        Bézier points of the old edge, mm. They are returned if a part is behind an eye.
    sightings : sequence of Sighting
        The strokes.
    directions : ((3, a), (3, b)) float
        Unit vectors, as columns, along which the first and the second handle may move; a
        handle that may not move has none.
    start : (4, 3) array_like, optional
        Bézier points to start from if the strokes are nearer to them than to the old edge.

    Returns
    -------
    (4, 3) float
        The first and the last are those of the old edge, bit for bit.
    """
    old = np.asarray(control_points, float)
    chord = float(np.linalg.norm(old[3] - old[0]))
    data = [_Samples.of(sighting) for sighting in sightings]
    moves = _moves(old, data, directions)
    if not moves.shape[2] or not chord > 0.0:
        return old.copy()
    problem = _Problem(old, data, moves, 1.0 / (LEEWAY * chord) ** 2)
    best = problem.at(np.zeros(moves.shape[2]))
    if best.is_met:
        return old.copy()
    if start is not None:
        offset = (np.asarray(start, float) - old)[1:3]
        best = min(best, problem.at(np.einsum("ikq,ik->q", moves, offset)), key=_price)
    if not np.isfinite(best.price):  # a part of the edge is behind the eye
        return old.copy()
    for _ in range(STEPS):
        step = problem.step(best)
        if np.abs(step).max() < SETTLED * chord:
            last = problem.at(best.by + step)
            is_nearer = last.price < (1.0 - NEARER) * best.price
            best = min(best, last, key=_price)
            if is_nearer:
                continue  # other parts of the edge have come nearer to some samples
            break
        for _ in range(HALVINGS):
            tried = problem.at(best.by + step, best)
            if tried.price < best.price:
                break
            step = 0.5 * step
        else:
            break
        best = tried
    return best.curve


@dataclass(frozen=True, eq=False)
class _Samples:
    """A sighting with its samples thinned out and weighted by the length they stand for.

    Attributes
    ----------
    points : (k, 2) float
    weights : (k,) float
    matrix : (3, 4) float
        Of the camera, with the flip of the sighting.
    """

    points: Array
    weights: Array
    matrix: Array

    @classmethod
    def of(cls, sighting: Sighting) -> _Samples:
        points = sighting.points[distinct(sighting.points)]
        if len(points) > MOST_SAMPLES:
            points = points[np.linspace(0, len(points) - 1, MOST_SAMPLES).round().astype(int)]
        lengths = np.hypot(*np.diff(points, axis=0).T)
        share = np.zeros(len(points))
        share[:-1] += lengths
        share[1:] += lengths
        whole = share.sum()
        weights = share / whole if whole > 0.0 else np.full(len(points), 1.0 / len(points))
        matrix = camera_matrix(sighting.camera) * np.append(sighting.flip, 1.0)
        return cls(points, WORTH * weights, matrix)

    @cached_property
    def targets(self) -> Array:
        """The coordinates of the samples, (2 k,) px: first all across, then all down."""
        return self.points.T.ravel()

    def feet(self, curve: Array, near: Array | None) -> tuple[Pass, Array] | None:
        """Return the picture of an edge at the foot points of the samples, and the ways there.

        Parameters
        ----------
        curve : (4, 3) float
            Bézier points of the edge, mm.
        near : (k,) float or None
            Parameters to search near to; None for the nearest places of the whole edge.

        Returns
        -------
        (Pass, (2 k,) float) or None
            The ways lead from the samples to their foot points, px. None if a part of the edge is
            behind the eye, or far beyond the sheet.
        """
        pictured = Pictured.of(self.matrix, curve)
        if near is None or not pictured.is_within(FARTHEST):
            path = pictured.laid_out(FOOT_PLACES)
            if not is_on_sheet(path):
                return None
            near = self._nearest(path) if near is None else near
        at, targets = pictured.passed(near), self.targets
        count = len(near)
        places, speeds, t = at.places, at.speeds, at.t
        ways, squares, products = np.empty((3, 2 * count))
        pace, shift, feet = np.empty((3, count))
        for _ in range(FOOT_STEPS):
            np.subtract(places, targets, out=ways)
            np.multiply(speeds, speeds, out=squares)
            np.add(squares[:count], squares[count:], out=pace)
            np.maximum(pace, TINY, out=pace)
            np.multiply(ways, speeds, out=products)
            np.add(products[:count], products[count:], out=shift)
            np.divide(shift, pace, out=shift)
            np.maximum(shift, -LONGEST_SHIFT, out=shift)
            np.minimum(shift, LONGEST_SHIFT, out=shift)
            np.subtract(t, shift, out=feet)
            np.maximum(feet, 0.0, out=feet)
            np.minimum(feet, 1.0, out=feet)
            np.subtract(feet, t, out=shift)
            np.absolute(shift, out=shift)
            if shift[shift.argmax()] < FOOT_SETTLED:
                return at, ways
            at.go(feet)
        return at, np.subtract(places, targets, out=ways)

    def _nearest(self, path: Array) -> Array:
        """Return parameters of the places on the picture of an edge that are nearest, (k,)."""
        begin, piece = path[:-1], np.diff(path, axis=0)
        squares = np.maximum((piece**2).sum(axis=1), TINY)
        along = self.points @ piece.T - (begin * piece).sum(axis=1)
        share = np.clip(along / squares, 0.0, 1.0)
        # Squared distances, without the term that is equal for all pieces.
        away = (begin**2).sum(axis=1) - 2.0 * self.points @ begin.T
        away += share * (share * squares - 2.0 * along)
        which = np.argmin(away, axis=1)
        return np.asarray((which + share[np.arange(len(which)), which]) / FOOT_PLACES)


def _moves(old: Array, data: Sequence[_Samples], directions: tuple[Array, Array]) -> Array:
    """Return the visible moves of both handles, (2, 3, q): each column moves one of them."""
    found = []
    for number, allowed in enumerate(directions):
        if not allowed.shape[1]:
            continue
        rows = np.concatenate([slopes_at(own.matrix, old[number + 1]) for own in data])
        _, sizes, ways = np.linalg.svd(rows @ allowed, full_matrices=False)
        is_free = allowed.shape[1] == 3
        largest = float((sizes if is_free else np.linalg.svd(rows, compute_uv=False))[0])
        kept = allowed @ ways[sizes > UNSEEN * largest].T
        if is_free and kept.shape[1] == 2:
            leg = old[2 * number + 1] - old[2 * number]
            kept = _along_and_across(leg, rows, largest, kept)
        column = np.zeros((2, 3, kept.shape[1]))
        column[number] = kept
        found.append(column)
    return np.concatenate(found, axis=2) if found else np.zeros((2, 3, 0))


def _along_and_across(leg: Array, rows: Array, largest: float, seen_ways: Array) -> Array:
    """Return the moves of a free handle in one view: along its tangent, and across it and the ray.

    Where a stroke is nearly the edge's own picture, it hardly tells how long a handle is. Moving
    the handle in a plane across the ray would then push an edge that runs into the depth off its
    line; moving it along its tangent does not.
    """
    length = float(np.linalg.norm(leg))
    if not length > 0.0 or np.linalg.norm(rows @ leg) < FORESHORTENED * largest * length:
        return seen_ways
    along = leg / length
    across = cross_product(cross_product(seen_ways[:, 0], seen_ways[:, 1]), along)
    return np.stack((along, across / np.linalg.norm(across)), axis=1)


@dataclass(frozen=True, eq=False)
class _Try:
    """Handles moved by some amount, with the cost of that and what a step needs.

    Attributes
    ----------
    by : (q,) float
    curve : (4, 3) float
    feet : sequence of (Pass, (2 k,) float)
        The picture at the foot points of each sighting, and the ways there from the samples, px;
        none where it cannot be seen.
    price : float
    """

    by: Array
    curve: Array
    feet: Sequence[tuple[Pass, Array]]
    price: float

    @property
    def is_met(self) -> bool:
        """Whether all samples lie on the picture of the edge, as far as samples can tell."""
        if not np.isfinite(self.price):
            return False
        apart = (np.abs(_dotted(at.normals, ways)).max() for at, ways in self.feet)
        return all(px <= RESOLVED for px in apart)


def _dotted(one: Array, other: Array) -> Array:
    """Return the inner products (n,) of vectors (2 n,): first all across, then all down."""
    products, count = one * other, len(one) // 2
    return np.asarray(products[:count] + products[count:])


def _price(tried: _Try) -> float:
    return tried.price


@dataclass(frozen=True, eq=False)
class _Problem:
    """Distances of all samples from an edge, weighed with how far its handles have moved."""

    old: Array
    data: Sequence[_Samples]
    moves: Array
    ease: float

    @cached_property
    def handle(self) -> Index:
        """The handle, 0 or 1, that each move moves, (q,)."""
        return np.asarray(np.abs(self.moves).sum(axis=1).argmax(axis=0))

    @cached_property
    def seen_moves(self) -> tuple[Array, ...]:
        """The moves as (u w, v w, w) of each sighting, (q, 3)."""
        columns = self.moves.sum(axis=0).T
        return tuple(columns @ own.matrix[:, :3].T for own in self.data)

    def at(self, by: Array, near: _Try | None = None) -> _Try:
        """Return the cost of moves; foot points are searched for near those of another try."""
        curve = self.old.copy()
        curve[1:3] += self.moves @ by
        feet, far = [], self.ease * float(by @ by)
        for number, own in enumerate(self.data):
            found = own.feet(curve, None if near is None else near.feet[number][0].t)
            if found is None:
                return _Try(by, curve, (), np.inf)
            feet.append(found)
            far += float(own.weights @ _dotted(found[1], found[1]))
        return _Try(by, curve, feet, far)

    def step(self, now: _Try) -> Array:
        """Return the Gauss–Newton step on the distances across the edge."""
        form, slope = self.ease * np.eye(len(now.by)), self.ease * now.by
        for own, seen, (at, ways) in zip(self.data, self.seen_moves, now.feet, strict=True):
            normals = at.normals
            rows = (seen @ at.across(normals)) * at.led(self.handle)
            weighted = rows * own.weights
            form += weighted @ rows.T
            slope = slope + weighted @ _dotted(normals, ways)
        return np.asarray(-np.linalg.solve(form, slope))
