"""Cubic B-spline curves in the plane and in space: evaluation, foot points, exact pieces."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array, frozen
from bozzetto.cached_properties import cached_property
from bozzetto.geometry.curve import Color, Curve
from bozzetto.geometry.refinement import refined

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

DEGREE: Final = 3
"""Cubic: the least degree whose curvature is continuous, and what CAD programs expect."""

ROUNDING: Final = 1e-12
"""Share of the parameter range by which a parameter and a knot that is meant may differ."""

SAMPLES_PER_SPAN: Final = 24
"""Places tried on every span in the search for foot points. The arc between two places is
so flat then that Newton's method starts in the right valley."""

STARTS: Final = 4
"""Places that a search for a foot point starts from: near a tie the nearest one can lie in
the wrong valley."""

FOOT_STEPS: Final = 20
"""Most Newton steps to a foot point; from a start in the right valley five are enough."""

FOOT_TOLERANCE: Final = 1e-12
"""Share of the parameter range below which a Newton step counts as none."""

GAUSS_POINTS: Final = 16
"""Nodes of the quadrature on every piece of a span."""

LENGTH_PIECES: Final = 4
"""Pieces of a span for the quadrature: near a cusp the speed is no smooth function."""


@dataclass(frozen=True, eq=False)
class Spline:
    """A cubic B-spline curve.

    Parameters
    ----------
    knots : (m + 4,) float64
        Full knot vector, not decreasing. The curve runs from ``knots[3]`` to ``knots[-4]``.
    control_points : (m, d) float64
        ``d`` is 2 or 3.
    closed : bool
        The curve returns to its start. Parameters beyond the range then run round again.
        Knots and control points are repeated beyond the seam: a closed curve is evaluated
        like an open one.

    Raises
    ------
    ValueError
        If knots and control points do not belong together or are not finite.
    """

    knots: Array
    control_points: Array
    closed: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "knots", frozen(self.knots, np.float64))
        object.__setattr__(self, "control_points", frozen(self.control_points, np.float64))
        object.__setattr__(self, "closed", bool(self.closed))  # numpy's own is no bool
        points, knots = self.control_points, self.knots
        if points.ndim != 2 or points.shape[1] not in (2, 3) or len(points) <= DEGREE:
            raise ValueError("a cubic spline needs four control points of two or three numbers")
        if knots.shape != (len(points) + DEGREE + 1,) or (np.diff(knots) < 0).any():
            raise ValueError("a spline's knots must not decrease and must fit its control points")
        if not knots[DEGREE] < knots[-DEGREE - 1]:
            raise ValueError("a spline needs a parameter range")

    @classmethod
    def uniform(cls, control_points: ArrayLike, *, closed: bool = False) -> Spline:
        """Return a spline over the range 0 … 1 with knots at equal steps.

        Parameters
        ----------
        control_points : (k, d) array_like
            ``k >= 4``. An open curve begins and ends in its first and last control point.
            Those of a closed curve go round once and are not repeated.
        closed : bool
            Whether the curve is periodic.
        """
        points = np.asarray(control_points, float)
        return cls(
            uniform_knots(len(points), closed),
            np.vstack((points, points[:DEGREE])) if closed else points,
            closed,
        )

    @property
    def range(self) -> tuple[float, float]:
        """First and last parameter."""
        return float(self.knots[DEGREE]), float(self.knots[-DEGREE - 1])

    # -- evaluation ------------------------------------------------------------------------

    def value(self, parameters: ArrayLike) -> Array:
        """Return places on the curve.

        Parameters
        ----------
        parameters : (n,) array_like
            Taken into the range: clipped, or run round on a closed curve.

        Returns
        -------
        (n, d) float
        """
        return self.derivative(parameters, 0)

    def derivative(self, parameters: ArrayLike, order: int = 1) -> Array:
        """Return derivatives by the parameter, shape (n, d); parameters as in `value`."""
        from scipy.interpolate import BSpline

        knots, points, degree = self.knots, self.control_points, DEGREE
        for _ in range(order):
            points = derived_points(knots, points, degree)
            knots, degree = knots[1:-1], degree - 1
        at = self.within(parameters)
        return np.asarray(BSpline.construct_fast(knots, points, degree)(at))

    def within(self, parameters: ArrayLike) -> Array:
        """Return parameters clamped to, or wrapped into, the range."""
        at = np.asarray(parameters, float)
        begin, end = self.range
        if self.closed:
            at = begin + np.mod(at - begin, end - begin)
        return np.asarray(np.clip(at, begin, end))

    def sampled(self, count: int) -> Array:
        """Return places at `count` equal steps of the parameter, both ends included, (count, d)."""
        begin, end = self.range
        return self.value(np.linspace(begin, end, count))

    @property
    def length(self) -> float:
        """Arc length, by Gauss quadrature on each span."""
        nodes, weights = np.polynomial.legendre.leggauss(GAUSS_POINTS)
        breaks = np.unique(self.knots[DEGREE:-DEGREE])
        pieces = np.arange(LENGTH_PIECES + 1) / LENGTH_PIECES
        cuts = breaks[:-1, None] + np.diff(breaks)[:, None] * pieces
        low, half = cuts[:, :-1].ravel(), 0.5 * np.diff(cuts, axis=1).ravel()
        at = low[:, None] + half[:, None] * (1.0 + nodes)
        speed = np.linalg.norm(self.derivative(at.ravel()), axis=1).reshape(at.shape)
        return float((speed @ weights) @ half)

    # -- foot points -----------------------------------------------------------------------

    def foot_points(
        self, points: ArrayLike, near: ArrayLike | None = None, *, steps: int = FOOT_STEPS
    ) -> Array:
        """Find parameters of the places of the curve that are closest to given points.

        Newton's method on the squared distance (Hoschek 1988, intrinsic parametrisation); a
        step that leads away from the point is halved, so a start is never made worse.

        Parameters
        ----------
        points : (n, d) array_like
            Places near the curve, in its units.
        near : (n,) array_like, optional
            Where to start from. The nearest place close by is found then, which keeps the
            branches of a loop apart; without it the nearest place of the whole curve.
        steps : int
            Most Newton steps.

        Returns
        -------
        (n,) float
            Parameters within the range.
        """
        place = np.asarray(points, float)
        if near is None:
            return self._nearest(place, steps)
        at = self.within(near)
        begin, end = self.range
        reach = (end - begin) / max(1, len(self.control_points) - DEGREE)
        offset = self.value(at) - place
        distance = (offset**2).sum(axis=1)
        damp = np.ones(len(place))
        for _ in range(steps):
            first, second = self.derivative(at), self.derivative(at, 2)
            slope = (offset * first).sum(axis=1)
            speed = (first**2).sum(axis=1)
            bend = speed + (offset * second).sum(axis=1)
            bend = np.where(bend > 0.1 * speed, bend, speed)
            step = np.zeros(len(at))
            np.divide(-slope, bend, out=step, where=bend > 0)
            tried = self.within(at + damp * np.clip(step, -reach, reach))
            offset_there = self.value(tried) - place
            distance_there = (offset_there**2).sum(axis=1)
            better = distance_there <= distance
            moved = np.where(better, np.abs(tried - at), damp * np.abs(step))
            at = np.where(better, tried, at)
            offset = np.where(better[:, None], offset_there, offset)
            distance = np.where(better, distance_there, distance)
            damp = np.where(better, 1.0, 0.25 * damp)
            if moved.max(initial=0.0) <= FOOT_TOLERANCE * (end - begin):
                break
        return at

    def _nearest(self, place: Array, steps: int) -> Array:
        """Return foot points from the nearest few places of a chain through the curve."""
        at, tree = self._chain
        _, nearest = tree.query(place, k=STARTS)
        feet = self.foot_points(np.repeat(place, STARTS, axis=0), at[nearest].ravel(), steps=steps)
        offset = self.value(feet).reshape(len(place), STARTS, -1) - place[:, None]
        distance = np.linalg.norm(offset, axis=2)
        best = np.argmin(distance, axis=1)
        return np.asarray(feet.reshape(len(place), STARTS)[np.arange(len(place)), best])

    def least_distances(self, points: ArrayLike) -> Array:
        """Return lower bounds of the distances of places from the curve, in its units.

        No foot point is searched: the arc between two neighbours of a chain through the curve
        is no longer than the greatest speed allows. The bounds are short of the distances by
        no more than that arc, about a hundredth of a curve of one span.

        Parameters
        ----------
        points : (n, d) array_like
            Places, in the curve's units.

        Returns
        -------
        (n,) float
        """
        away, _ = self._chain[1].query(np.asarray(points, float))
        return np.asarray(np.maximum(away - self._half_step, 0.0))

    @cached_property
    def _half_step(self) -> float:
        """Half of the longest arc that there can be between neighbours of the chain."""
        hodograph = derived_points(self.knots, self.control_points, DEGREE)
        speed = float(np.linalg.norm(hodograph, axis=1).max())
        return 0.5 * speed * float(np.diff(self._chain[0]).max())

    @cached_property
    def _chain(self) -> tuple[Array, cKDTree]:
        """Parameters of places along the curve, and those places."""
        from scipy.spatial import cKDTree

        begin, end = self.range
        count = SAMPLES_PER_SPAN * (len(self.control_points) - DEGREE) + 1
        corners = self.knots[(self.knots >= begin) & (self.knots <= end)]
        at = np.union1d(np.linspace(begin, end, count), corners)
        return at, cKDTree(self.value(at))

    # -- other forms of the same curve -----------------------------------------------------

    def reversed(self) -> Spline:
        """Return the same places in the opposite sense, over the same range."""
        begin, end = self.range
        return Spline((begin + end) - self.knots[::-1], self.control_points[::-1], self.closed)

    def mirrored(self, normal: ArrayLike, offset: float = 0.0) -> Spline:
        """Return the mirror image about the plane (in 2D: the line) ``normal · x = offset``.

        For a normal along an axis and no offset the coordinate only changes its sign: the
        image is exact to the last bit.

        Parameters
        ----------
        normal : (d,) array_like
            Normal of the plane, of any length.
        offset : float
            Distance of the plane from the origin along the unit normal.
        """
        direction = np.asarray(normal, float)
        direction = direction / np.linalg.norm(direction)
        height = self.control_points @ direction - offset
        image = self.control_points - 2.0 * height[:, None] * direction
        return Spline(self.knots, image, self.closed)

    def refined(self, parameters: ArrayLike) -> Spline:
        """Return the same curve with more knots, so that it can be changed in places.

        Parameters
        ----------
        parameters : (k,) array_like
            Where knots are added, once each; those of a closed curve run round into its
            range. Places at knots, and at or beyond the ends of an open curve, add none.
        """
        begin, end = self.range
        fresh = np.unique(self.within(np.ravel(np.asarray(parameters, float))))
        fresh = fresh[(fresh > begin) & (fresh < end) & ~np.isin(fresh, self.knots)]
        if not len(fresh):
            return self
        if not self.closed:
            knots = np.sort(np.concatenate((self.knots, fresh)))
            return Spline(knots, _refined_points(self, knots))
        once = np.sort(np.concatenate((self.knots[DEGREE : -DEGREE - 1], fresh)))
        period = end - begin
        knots = np.concatenate((once[-DEGREE:] - period, once, once[: DEGREE + 1] + period))
        # The second of two rounds, where every span has its own polynomial.
        points = _refined_points(self._unrolled(), knots[: len(once) + DEGREE + 1] + period)
        return Spline(knots, np.vstack((points, points[:DEGREE])), closed=True)

    def split(self, *parameters: float) -> tuple[Spline, ...]:
        """Return exact pieces of the curve, each with its own part of the parameter range.

        Parameters
        ----------
        *parameters : float
            Where to cut; what is only a rounding off a knot is that knot. Places outside the
            inside of an open curve's range cut nothing.

        Returns
        -------
        tuple of Spline
            Open curves with clamped ends, one more than there are cuts. A closed curve gives
            as many pieces as cuts; the last one runs over the seam.
        """
        begin, end = self.range
        if self.closed:
            cuts = sorted({self._at_knot(float(cut)) for cut in self.within(parameters)} or {begin})
            if len(cuts) > 1 and cuts[-1] == end:  # the seam, twice
                cuts = sorted({begin, *cuts[:-1]})
            cuts.append(cuts[0] + end - begin)
        else:
            inner = {self._at_knot(float(cut)) for cut in parameters if begin < cut < end}
            cuts = [begin, *sorted(inner - {begin, end}), end]
        unrolled = self._unrolled() if self.closed else self
        pairs = itertools.pairwise(cuts)
        return tuple(_between(unrolled, low, high) for low, high in pairs)

    def _at_knot(self, parameter: float) -> float:
        """Return the knot that a parameter is off by rounding only, else the parameter."""
        begin, end = self.range
        nearest = float(self.knots[np.abs(self.knots - parameter).argmin()])
        return nearest if abs(nearest - parameter) <= ROUNDING * (end - begin) else parameter

    def beziers(self) -> Array:
        """Return the curve as exact cubic Bezier pieces.

        Returns
        -------
        (k, 4, d) float
            One piece for each span; the last point of a piece is the first of the next.
        """
        begin, end = self.range
        inner = self.knots[(self.knots >= begin) & (self.knots <= end)]
        breaks, counts = np.unique(inner, return_counts=True)
        counts = np.maximum(counts, DEGREE)
        counts[[0, -1]] = DEGREE + 1
        points = _refined_points(self, np.repeat(breaks, counts))
        starts = np.concatenate(([0], np.cumsum(counts[1:-1])))
        return points[starts[:, None] + np.arange(DEGREE + 1)]

    def to_curve(self, name: str = "curve", color: Color | None = None) -> Curve:
        """Return the curve for export: clamped ends, space coordinates (z = 0 in a plane)."""
        begin, end = self.range
        clamped = self.knots[0] == begin and self.knots[-1] == end
        whole = self if clamped else _between(self, begin, end)
        points = whole.control_points
        space = np.zeros((len(points), 3))
        space[:, : points.shape[1]] = points
        return Curve(DEGREE, whole.knots, space, closed=self.closed, name=name, color=color)

    def _unrolled(self) -> Spline:
        """Return two rounds of a closed curve as an open one."""
        begin, end = self.range
        inner = self.knots[DEGREE : -DEGREE - 1]
        knots = np.concatenate((self.knots[:DEGREE], inner, self.knots[DEGREE:] + (end - begin)))
        return Spline(knots, np.vstack((self.control_points[:-DEGREE], self.control_points)))


def _between(spline: Spline, low: float, high: float) -> Spline:
    """Return a piece of an open curve, with clamped ends."""
    inner = spline.knots[(spline.knots > low) & (spline.knots < high)]
    ends = np.ones(DEGREE + 1)
    knots = np.concatenate((low * ends, inner, high * ends))
    return Spline(knots, _refined_points(spline, knots))


def _refined_points(spline: Spline, knots: Array) -> Array:
    """Return control points of the same curve over more knots."""
    return refined(DEGREE, spline.knots, spline.control_points, knots)


def uniform_knots(count: int, closed: bool) -> Array:
    """Return knots at equal steps over 0 … 1 for `count` control points that differ."""
    if closed:
        return np.asarray(np.arange(-DEGREE, count + DEGREE + 1) / count)
    inner = np.linspace(0.0, 1.0, count - DEGREE + 1)
    return np.concatenate((np.zeros(DEGREE), inner, np.ones(DEGREE)))


def derived_points(knots: Array, points: Array, degree: int) -> Array:
    """Return control points of the derivative; 0 where knots of full multiplicity leave no span."""
    width = knots[degree + 1 : -1] - knots[1 : -degree - 1]
    made = np.zeros((len(points) - 1, points.shape[1]))
    np.divide(degree * np.diff(points, axis=0), width[:, None], out=made, where=width[:, None] > 0)
    return made
