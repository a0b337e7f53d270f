"""Splines through rows of points, within a tolerance."""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto.arrays import Array, cross_product
from bozzetto.geometry import DEGREE, Spline

COUNTS: Final = (4, 5, 6, 7, 8, 10, 12, 16, 20, 26, 34, 44, 60)
"""Numbers of control points that are tried, one after the other: a curve of few spans is fairer,
and its surfaces are quicker."""

CORRECTIONS: Final = 5
"""Rounds in which the parameters of the points are corrected (Hoschek 1988)."""

FOOT_STEPS: Final = 3
"""Newton steps to the foot of each point, which is near where it was in the round before."""

SPARE: Final = 0.6
"""Control points by points up to which a curve is fitted: more would follow each of them, and turn
as they like between."""

MOST_THROUGH: Final = 40
"""Most points that a curve goes through where they are few and foretell one another."""

STRAIGHT: Final = 1e-6
"""Least turn at the middle one of three points, radians, that tells an arc."""

TURNED_BACK: Final = np.radians(120.0)
"""Turn there from which on they are no arc: it would be two thirds of a circle and more."""

MOST_ON_ARC: Final = 8
"""Most points that are looked at whether they lie on one arc: more tell their course themselves."""

ARC_PLACES: Final = 33
"""Places by which an arc is known."""

SLIGHT: Final = 1e-7
"""Weight of the second differences of control points: of the curves that fit few points, the one in
which they are least is taken."""

HOPELESS: Final = 6.0
"""Distance, in tolerances, from which no correction of parameters helps enough."""


def spline_through(points: Array, tolerance: float, fine: float | None = None) -> Spline:
    """Fit a clamped cubic spline to a row of points: its ends are the first and last, exactly.

    The fewest control points of `COUNTS` that keep to the fine tolerance are taken; else the fewest
    that keep to the other. Where the points are too few to tell so many, a fit may have hooks
    between them, so the spline goes through all, as where every second one of few foretells the
    others. Three points, and some more that lie on one arc, become that arc.

    Parameters
    ----------
    points : (n, 3) float
        At least two, no two neighbours the same, mm.
    tolerance : float
        Greatest distance of a point from the curve, mm.
    fine : float, optional
        The same where the points are smooth enough, mm.
    """
    if len(points) == 2:
        share = np.linspace(0.0, 1.0, DEGREE + 1)[:, None]
        straight = (1.0 - share) * points[0] + share * points[1]
        return _with_ends(Spline.uniform(straight), points)
    finer = tolerance if fine is None else fine
    if len(points) <= MOST_ON_ARC:
        points = _on_arc(points, finer)
    along = _shares(points)
    kept: Spline | None = None
    for count in COUNTS:
        if count > max(DEGREE + 1, SPARE * len(points)):
            break
        spline, worst = _fitted(points, along, count, finer)
        if worst <= finer:
            return spline
        if worst <= tolerance and kept is None:
            kept = spline
    through = _interpolated(points, along)
    if kept is None or (finer < tolerance and _foretold(points, along, tolerance)):
        return through
    return kept


def smoothed_spline(points: Array, tolerance: float) -> Spline:
    """Fit a clamped cubic spline to points that tremble: its ends are the first and last, exactly.

    Of all numbers of control points that one is taken by which the other points would foretell each
    best: generalized cross-validation (Craven & Wahba 1979).

    Parameters
    ----------
    points : (n, 3) float
        At least two, no two neighbours the same, mm.
    tolerance : float
        Below it no distance of a point from the curve counts, mm.
    """
    most = SPARE * len(points)
    if most < DEGREE + 1:
        return spline_through(points, tolerance)
    along = _shares(points)
    best: tuple[float, Spline] | None = None
    for count in COUNTS:
        if count > most:
            break
        spline, _ = _fitted(points, along, count, tolerance)
        feet = spline.foot_points(points, along, steps=FOOT_STEPS)
        off = ((spline.value(feet) - points) ** 2).sum()
        score = max(float(off), tolerance**2) / (1.0 - count / len(points)) ** 2
        if best is None or score < best[0]:
            best = score, spline
    assert best is not None
    return best[1]


def _on_arc(points: Array, tolerance: float) -> Array:
    """Return places on the arc that few points lie on, as any three do; the ends are theirs.

    The points themselves where there is none, or they turn back more than an arc is meant to.
    """
    first, middle, last = points[[0, len(points) // 2, -1]]
    into, out, chord = middle - first, last - middle, last - first
    upright = cross_product(into, out)
    turn = float(np.arctan2(np.linalg.norm(upright), into @ out))
    if not STRAIGHT < turn < TURNED_BACK:
        return points
    axis = upright / np.linalg.norm(upright)
    way = cross_product((into @ into) * chord - (chord @ chord) * into, upright)
    away = -way / (2.0 * (upright @ upright))  # from the centre to the first point
    beside = cross_product(axis, away)
    rows = points - (first - away)
    angles = np.mod(np.arctan2(rows @ beside, rows @ away), 2.0 * np.pi)
    angles[0] = 0.0
    off = rows - np.cos(angles[:, None]) * away - np.sin(angles[:, None]) * beside
    if np.linalg.norm(off, axis=1).max() > tolerance or not (np.diff(angles) > 0.0).all():
        return points
    at = np.linspace(0.0, 2.0 * turn, ARC_PLACES)[1:-1, None]  # chords turn by half of their arc
    inner = first - away + np.cos(at) * away + np.sin(at) * beside
    return np.vstack((first, inner, last))


def _fitted(points: Array, along: Array, count: int, wanted: float) -> tuple[Spline, float]:
    """Return a spline of so many control points, and how far it is from the points."""
    at = along
    for _ in range(CORRECTIONS):
        spline = _least_squares(points, at, count)
        feet = spline.foot_points(points, at, steps=FOOT_STEPS)
        worst = float(np.linalg.norm(spline.value(feet) - points, axis=1).max())
        if worst <= wanted or worst > HOPELESS * wanted:
            break
        at = _ordered(feet, at)
    return spline, worst


def _foretold(points: Array, along: Array, tolerance: float) -> bool:
    """Whether the spline through every second point goes by the others as well."""
    if not 2 * DEGREE + 1 <= len(points) <= MOST_THROUGH:
        return False
    kept = np.union1d(np.arange(0, len(points), 2), [len(points) - 1])
    spline = _interpolated(points[kept], along[kept])
    feet = spline.foot_points(points, along, steps=FOOT_STEPS)
    return bool(np.linalg.norm(spline.value(feet) - points, axis=1).max() <= tolerance)


def closed_spline_through(points: Array, tolerance: float, fine: float | None = None) -> Spline:
    """Fit a closed cubic spline to points round a ring, the first one not repeated.

    As `spline_through`; at least four points.
    """
    ring = np.vstack((points, points[:1]))
    along = _shares(ring)[:-1]
    finer = tolerance if fine is None else fine
    kept: Spline | None = None
    for count in COUNTS:
        if not 6 <= count <= max(6, SPARE * len(points)):
            continue
        at, knots = along, _closed_knots(along, count)
        second = SLIGHT * np.diff(np.eye(count)[np.arange(count + 2) % count], 2, axis=0)
        for _ in range(CORRECTIONS):
            rows = np.vstack((_closed_basis(at, knots), second))
            wanted = np.vstack((points, np.zeros((count, 3))))
            found, *_ = np.linalg.lstsq(rows, wanted, rcond=None)
            spline = Spline(knots, np.vstack((found, found[:DEGREE])), closed=True)
            feet = spline.foot_points(points, at, steps=FOOT_STEPS)
            worst = float(np.linalg.norm(spline.value(feet) - points, axis=1).max())
            at = _ordered_round(feet, at)
            if worst <= finer:
                return spline
            if worst <= tolerance and kept is None:
                kept = spline
            if worst > HOPELESS * finer:
                break
    return _closed_interpolated(points, along) if kept is None else kept


def _shares(points: Array) -> Array:
    """Return the length up to each point as share of the whole."""
    run = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))))
    return np.asarray(run / run[-1])


def _with_ends(spline: Spline, points: Array) -> Spline:
    """Return the spline with its ends set to the very numbers of the first and last point."""
    control = spline.control_points.copy()
    control[0], control[-1] = points[0], points[-1]
    return Spline(spline.knots, control)


def _least_squares(points: Array, at: Array, count: int) -> Spline:
    """Fit the inner control points; knots lie where the points do (Piegl & Tiller 1997, 9.68)."""
    from scipy.interpolate import BSpline

    step = (len(points)) / (count - DEGREE)
    places = step * np.arange(1, count - DEGREE)
    row = places.astype(int).clip(1, len(points) - 1)
    share = places - row
    inner = (1.0 - share) * at[row - 1] + share * at[row]
    knots = np.concatenate((np.zeros(4), np.sort(inner.clip(1e-6, 1.0 - 1e-6)), np.ones(4)))
    basis = BSpline.design_matrix(at.clip(0.0, 1.0), knots, DEGREE).toarray()
    rest = points - np.outer(basis[:, 0], points[0]) - np.outer(basis[:, -1], points[-1])
    second = np.diff(np.eye(count), 2, axis=0)
    small = SLIGHT * second
    fixed = np.outer(second[:, 0], points[0]) + np.outer(second[:, -1], points[-1])
    rows = np.vstack((basis[:, 1:-1], small[:, 1:-1]))
    found, *_ = np.linalg.lstsq(rows, np.vstack((rest, -SLIGHT * fixed)), rcond=None)
    return Spline(knots, np.vstack((points[:1], found, points[-1:])))


def _ordered(at: Array, before: Array) -> Array:
    """Return corrected parameters, or those of before where the order would be lost."""
    at = at.copy()
    at[0], at[-1] = 0.0, 1.0
    return at if (np.diff(at) > 0.0).all() else before


def _ordered_round(at: Array, before: Array) -> Array:
    """Return corrected parameters of a ring, or those of before where the order would be lost."""
    steps = np.mod(np.diff(at, append=at[:1]), 1.0)
    return at if steps.sum() < 1.5 and (steps > 0.0).all() else before


def _interpolated(points: Array, along: Array) -> Spline:
    from scipy.interpolate import make_interp_spline

    if len(points) == 3:
        first, middle, last = points
        share = along[1]
        bend = (middle - (1 - share) ** 2 * first - share**2 * last) / (2 * share * (1 - share))
        control = (first, (first + 2.0 * bend) / 3.0, (last + 2.0 * bend) / 3.0, last)
        return _with_ends(Spline.uniform(np.array(control)), points)
    made = make_interp_spline(along, points, DEGREE)
    return _with_ends(Spline(made.t, made.c), points)


def _closed_knots(along: Array, count: int) -> Array:
    """Return the knots of a closed curve of so many control points, which lie where points do."""
    around = np.append(along, 1.0)
    breaks = np.interp(np.arange(count) * len(along) / count, np.arange(len(around)), around)
    return np.concatenate((breaks[-DEGREE:] - 1.0, breaks, breaks[: DEGREE + 1] + 1.0))


def _closed_basis(at: Array, knots: Array) -> Array:
    """Return the values of the periodic basis functions at parameters, (n, count)."""
    from scipy.interpolate import BSpline

    count = len(knots) - 2 * DEGREE - 1
    rows = BSpline.design_matrix(np.mod(at, 1.0), knots, DEGREE).toarray()
    rows[:, :DEGREE] += rows[:, count:]
    return np.asarray(rows[:, :count])


def _closed_interpolated(points: Array, along: Array) -> Spline:
    from scipy.interpolate import make_interp_spline

    made = make_interp_spline(
        np.append(along, 1.0), np.vstack((points, points[:1])), DEGREE, bc_type="periodic"
    )
    return Spline(made.t, made.c, closed=True)
