"""Ruled surfaces: straight lines between places of equal parameter on two curves."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Final

import numpy as np

from bozzetto.errors import UserError
from bozzetto.geometry.basis import lifted, lowered
from bozzetto.geometry.brep.brep import Brep, gap_tolerance, refuse_far
from bozzetto.geometry.brep.sewing import sewn
from bozzetto.geometry.brep.surface import BSplineSurface
from bozzetto.geometry.refinement import elevated, refined

if TYPE_CHECKING:
    from bozzetto.arrays import Array
    from bozzetto.geometry.curve import Color, Curve

SAME_KNOT: Final = 1e-12
"""Difference of knots over the range 0 … 1 that counts as none."""


def ruled_surface(
    first: Curve, second: Curve, *, name: str = "brep", color: Color | None = None
) -> Brep:
    """Return the surface of straight lines between two curves.

    Both get the higher of their degrees, the range 0 … 1 and all knots of either, and stay what
    they are.

    Parameters
    ----------
    first, second : Curve
        Where v is 0, and where it is 1; mm. Normals look along (tangent of the first) × (from
        the first to the second).
    name : str
        What the shape is called.
    color : (r, g, b), optional
        sRGB.

    Returns
    -------
    Brep
        One face, or two halves if both curves are closed. Ends in common make a pole.

    Raises
    ------
    UserError
        If the curves are the same, both are points, or reach too far.
    """
    for curve in (first, second):
        refuse_far(curve.control_points)
    degree, knots, (one, two) = alike((first, second))
    if np.array_equal(one, two):
        raise UserError("A surface cannot be spanned between a curve and itself.")
    if not any(np.ptp(curve.control_points, axis=0).any() for curve in (first, second)):
        raise UserError("A surface cannot be spanned between two points. Draw a curve.")
    rows = np.stack((one, two), axis=1)
    parts = []
    for low, high in pairwise(_cuts(rows)):
        inner = knots[(knots > low) & (knots < high)]
        own = np.concatenate((np.full(degree + 1, low), inner, np.full(degree + 1, high)))
        flat = refined(degree, knots, rows.reshape(len(rows), -1), own)
        net, weights = lowered(flat.reshape(-1, 2, 4))
        surface = BSplineSurface((degree, 1), own, np.array((0.0, 0.0, 1.0, 1.0)), net, weights)
        parts.append(Brep.of_surface(surface))
    return sewn(parts, name, color)


def _cuts(rows: Array) -> tuple[float, ...]:
    """Return where a surface is cut: in the middle if both of its curves come round."""
    ends = lowered(rows[[0, -1]])[0]
    comes_round = np.abs(ends[0] - ends[1]).max() <= gap_tolerance([lowered(rows)[0]])
    return (0.0, 0.5, 1.0) if comes_round else (0.0, 1.0)


def alike(curves: Sequence[Curve]) -> tuple[int, Array, list[Array]]:
    """Return curves over one knot vector from 0 to 1, each exactly as it was.

    Parameters
    ----------
    curves : sequence of Curve
        At least one, mm.

    Returns
    -------
    degree : int
        The highest of theirs.
    knots : (m + degree + 1,) float
        All inner knots of any of them.
    points : list of (m, 4) float
        Homogeneous control points of each: (x w, y w, z w, w).
    """
    degree = max(curve.degree for curve in curves)
    rows = [_raised(curve.clamped(), degree) for curve in curves]
    places = np.unique(np.concatenate([knots for knots, _ in rows]))
    places = places[np.append(True, np.diff(places) > SAME_KNOT)]
    times = np.zeros(len(places), np.intp)
    snapped = []
    for knots, points in rows:
        which = np.clip(np.searchsorted(places, knots + SAME_KNOT, "right") - 1, 0, None)
        times = np.maximum(times, np.bincount(which, minlength=len(places)))
        snapped.append((places[which], points))
    whole = np.repeat(places, times)
    return degree, whole, [refined(degree, knots, points, whole) for knots, points in snapped]


def _raised(curve: Curve, degree: int) -> tuple[Array, Array]:
    """Return knots over 0 … 1 and homogeneous control points of a curve of a higher degree."""
    begin, end = curve.range
    knots = (curve.knots - begin) / (end - begin)
    points = lifted(curve.control_points, curve.weights)
    for own in range(curve.degree, degree):
        knots, points = elevated(own, knots, points)
    return knots, points
