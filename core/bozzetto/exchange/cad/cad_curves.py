"""Curves as every reader takes them: clamped, whole inside, with parameters of common size.

A `Curve` may begin between its control points, as periodic fits do, or break in the middle.
The standards allow the first; readers differ. Here both are rewritten exactly: the shape stays
what it was, and control points that need no change stay bit for bit.
"""

from __future__ import annotations

import re
from dataclasses import replace
from itertools import pairwise
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto.errors import UserError
from bozzetto.exchange.limits import MAX_CONTROL_POINTS, MAX_COORDINATE
from bozzetto.geometry.shapes import Curve, Shapes

RESOLUTION: Final = 1e-6
"""Distance that the files declare to be none, mm: far above rounding, far below any machine."""

MAX_DEGREE: Final = 25
"""Highest degree written: the limit of the OpenCASCADE kernel, the lowest of the kernels known."""

SHARES_OF_SPAN: Final = np.linspace(0.0, 1.0, 9)[:, None, None, None]
"""Places on a span by which a curve is framed, as shares of the span."""
SHARES_OF_SPAN.flags.writeable = False

SAME_KNOT: Final = 8
"""Knots are one if they are at most so many of the largest knot's last binary places apart.
Readers refuse knots that differ by less than they can tell."""

COMMON_RANGE: Final = (1e-3, 1e6)
"""Least and largest size of half the range of the parameter, and of the largest weight, that are
written as they are; others are scaled to about one. Kernels compare with fixed tolerances."""

MAX_WEIGHT_RATIO: Final = 1e12
"""Largest over least weight: beyond it, points vanish in the rounding of others."""

CORNER: Final = 1.0
"""Degrees by which a curve must turn at once to have a corner."""

UNSPEAKABLE: Final = re.compile("[\x00-\x1f\x7f-\x9f\ud800-\udfff]")
"""Control characters, at which some readers stop, and halves of surrogate pairs."""


def checked_curves(shapes: Shapes, *, corners: bool = True) -> tuple[Curve, ...]:
    """Return the curves of shapes as they can be written.

    Parameters
    ----------
    shapes : Shapes
        Shapes with curves, mm.
    corners : bool
        Whether a curve may have corners. Otherwise it ends there, and another one of its name
        begins; polylines stay whole.

    Returns
    -------
    tuple of Curve
        Clamped at both ends, each knot inside at most `degree` times; weights only where they
        differ; no control characters in names. One that breaks in the middle is as many curves
        of the same name.

    Raises
    ------
    UserError
        If there is none, they have too many control points together, or one has no length,
        too high a degree, or numbers that are not finite or too large.
    """
    if not shapes.curves:
        raise UserError("There are no curves to write. Draw some first.")
    count = sum(len(curve.control_points) for curve in shapes.curves)
    if count > MAX_CONTROL_POINTS:
        raise UserError(
            f"The curves have {count:,} control points together, more than the "
            f"{MAX_CONTROL_POINTS:,} that can be written. Export fewer objects at once."
        )
    return tuple(piece for curve in shapes.curves for piece in _pieces(curve, corners))


def readable(name: str) -> str:
    """Return a name without control characters and halves of surrogate pairs."""
    return UNSPEAKABLE.sub(" ", name).strip()


def bezier_pieces(curve: Curve) -> Array:
    """Return the Bézier control points of every span of a clamped curve.

    They are the blossom of the span's polynomial at its two ends (Ramshaw 1989, "Blossoms are
    polar forms"), all by interpolation inside the span's knots.

    Parameters
    ----------
    curve : Curve
        As `checked_curves` gives it.

    Returns
    -------
    (k, degree + 1, 4) float64
        Homogeneous: (x w, y w, z w, w), mm.
    """
    degree, knots = curve.degree, curve.knots
    weights = np.ones(len(curve.control_points)) if curve.weights is None else curve.weights
    lifted = np.column_stack((curve.control_points * weights[:, None], weights))
    spans = np.flatnonzero(np.diff(knots) > 0)
    begin, end = knots[spans], knots[spans + 1]
    found = np.empty((len(spans), degree + 1, 4))
    for ends in range(degree + 1):  # so many of the arguments are the span's end
        row = [lifted[spans - degree + j] for j in range(degree + 1)]
        for level in range(1, degree + 1):
            u = end if level > degree - ends else begin
            for j in range(degree, level - 1, -1):
                low, high = knots[spans - degree + j], knots[spans + 1 + j - level]
                share = ((u - low) / (high - low))[:, None]
                rest = ((high - u) / (high - low))[:, None]
                row[j] = rest * row[j - 1] + share * row[j]
        found[:, ends] = row[degree]
    return found


def points_on(curve: Curve) -> Array:
    """Return points (n, 3) of every span of a curve, its ends among them, mm; to frame it by."""
    found = []
    for piece in checked_curves(Shapes(curves=(curve,))):
        row = bezier_pieces(piece)[None]
        while row.shape[2] > 1:  # de Casteljau, for all spans and shares at once
            row = row[:, :, :-1] + SHARES_OF_SPAN * (row[:, :, 1:] - row[:, :, :-1])
        found.append(row.reshape(-1, 4))
    homogeneous = np.concatenate(found)
    return np.asarray(homogeneous[:, :3] / homogeneous[:, 3:])


# -- from one curve to its pieces --------------------------------------------------------------


def _pieces(curve: Curve, corners: bool) -> list[Curve]:
    _refuse_unwritable(curve)
    curve = replace(
        curve,
        name=readable(curve.name),
        knots=_common_knots(curve),
        weights=_common_weights(curve.weights),
    )
    degree, count = curve.degree, len(curve.control_points)
    begin, end = curve.knots[degree], curve.knots[count]
    for knot in (begin, end):
        while np.count_nonzero(curve.knots == knot) < degree:
            curve = _with_knot(curve, float(knot))
    knots = curve.knots
    places, first, times = np.unique(knots, return_index=True, return_counts=True)
    inside = (places >= begin) & (places <= end)
    ends = (times > degree) | (places == begin) | (places == end)
    if not corners and degree > 1:
        ends |= (times == degree) & _turns(curve.control_points, first)
    breaks = np.flatnonzero(inside & ends)
    found = []
    for left, right in pairwise(breaks):
        last, after = first[left] + times[left] - 1, first[right]  # its knots lie between
        own = slice(last - degree, after)
        full = np.repeat(places[[left, right]], degree + 1)
        points = curve.control_points[own]
        if np.ptp(points, axis=0).max() <= RESOLUTION:
            continue
        found.append(
            replace(
                curve,
                knots=np.insert(full, degree + 1, knots[last + 1 : after]),
                control_points=points,
                weights=None if curve.weights is None else curve.weights[own],
                closed=curve.closed and len(breaks) == 2,
            )
        )
    if not found:
        raise UserError(f"The curve “{curve.name}” has no length. Delete it, then export.")
    return found


def _turns(points: Array, first: Index) -> Flags:
    """Whether a curve has a corner at its control point before each of these numbers, (k,)."""
    at = np.clip(first - 1, 1, len(points) - 2)
    before, after = points[at] - points[at - 1], points[at + 1] - points[at]
    sine = np.linalg.norm(np.cross(before, after), axis=1)
    return np.asarray(np.degrees(np.arctan2(sine, (before * after).sum(axis=1))) > CORNER)


def _refuse_unwritable(curve: Curve) -> None:
    numbers = [curve.knots, curve.control_points]
    if curve.weights is not None:
        numbers.append(curve.weights)
    if not all(np.isfinite(values).all() for values in numbers):
        raise UserError(
            f"The curve “{curve.name}” holds a number that is not finite. Draw it again."
        )
    if np.abs(curve.control_points).max() > MAX_COORDINATE:
        raise UserError(
            f"The curve “{curve.name}” reaches further than {MAX_COORDINATE:.0g} mm. "
            "Make its object smaller or move it nearer."
        )
    if curve.weights is not None and not (
        0 < curve.weights.max() / MAX_WEIGHT_RATIO <= curve.weights.min()
    ):
        raise UserError(
            f"The weights of the curve “{curve.name}” are too far apart. Draw it again."
        )
    if curve.degree > MAX_DEGREE:
        raise UserError(
            f"The curve “{curve.name}” is of degree {curve.degree}; other programs read up to "
            f"{MAX_DEGREE}. Fit it again with a lower degree."
        )


def _common_weights(weights: Array | None) -> Array | None:
    """Return the weights, scaled by a power of two if of odd size; None where all are equal."""
    if weights is None or (weights == weights[0]).all():
        return None
    largest = float(weights.max())
    if COMMON_RANGE[0] <= largest <= COMMON_RANGE[1]:
        return weights
    return np.asarray(np.ldexp(weights, -int(np.frexp(largest)[1])))


def _common_knots(curve: Curve) -> Array:
    """Return the knots over a range of common size, with those that nearly agree made one."""
    knots = curve.knots
    close = SAME_KNOT * np.spacing(np.abs(knots).max())
    apart = np.append(True, np.diff(knots / 2) > close / 2)  # halved, so as not to overflow
    knots = np.maximum.accumulate(np.where(apart, knots, -np.inf))
    begin, end = knots[curve.degree], knots[len(curve.control_points)]
    if not end > begin:
        raise UserError(f"The curve “{curve.name}” has no length. Delete it, then export.")
    half = end / 2 - begin / 2
    if COMMON_RANGE[0] <= half <= COMMON_RANGE[1]:
        return np.asarray(knots)
    return np.asarray((knots / 2 - begin / 2) / half)


def _with_knot(curve: Curve, knot: float) -> Curve:
    """Return the same curve with one more knot (Boehm 1980), by convex combinations.

    Both shares are divided out alike: of a curve that mirrors itself, both ends round alike.
    """
    degree, knots, points = curve.degree, curve.knots, curve.control_points
    after = int(np.searchsorted(knots, knot, "right"))
    times = after - int(np.searchsorted(knots, knot, "left"))
    changed = np.arange(after - degree, after - times)
    low, high = knots[changed], knots[changed + degree]
    share = ((knot - low) / (high - low))[:, None]
    rest = ((high - knot) / (high - low))[:, None]
    weights = None
    if curve.weights is not None:
        column = curve.weights[:, None]
        share, rest = share * column[changed], rest * column[changed - 1]
        new = share + rest
        weights = np.insert(curve.weights, changed[0], 0.0)
        weights[changed] = new[:, 0]
        share, rest = share / new, rest / new
    made = np.insert(points, changed[0], 0.0, axis=0)
    made[changed] = rest * points[changed - 1] + share * points[changed]
    return replace(
        curve,
        knots=np.insert(knots, after, knot),
        control_points=made,
        weights=weights,
    )
