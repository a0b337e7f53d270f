"""Cubic B-splines through the points of one curve."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.geometry.spline import Spline
from bozzetto.ink.curves.least_squares import (
    ENOUGH,
    NOISE_FACTOR,
    approximate,
    approximate_adaptively,
)
from bozzetto.ink.curves.preprocess import PreparedCurve, checked_points, prepare_curve

FEWEST_CONTROLS: Final = 4
"""A cubic needs four control points."""


@dataclass(frozen=True, eq=False)
class SplineFit:
    """A spline and how well it follows the ink.

    Attributes
    ----------
    spline : Spline
    rms, worst : float
        Root mean square (weighted) and largest distance of the prepared ink from the curve,
        in the units of the points.
    parameters : (n,) float
        Where each of the given points belongs on the curve, not decreasing. On a closed curve
        they run round once from the first point's place, so they can be below 0 or above 1.
    """

    spline: Spline
    rms: float
    worst: float
    parameters: Array


def fit_spline(
    points: ArrayLike,
    *,
    weights: ArrayLike | None = None,
    controls: int | Literal["adaptive"] = 7,
    closed: bool = False,
    start_tangent: ArrayLike | None = None,
    end_tangent: ArrayLike | None = None,
    pixel: float = 1.0,
) -> SplineFit:
    """Fit a cubic B-spline to the points of a curve, in the order in which they were drawn.

    The points are smoothed over 4 px and spaced 3 px along the curve, so the result does not
    depend on how densely the pen was sampled; they get chord lengths as parameters and are
    then moved to their foot points (Hoschek 1988). The best curve met on the way is kept.

    Parameters
    ----------
    points : (n, 2) or (n, 3) array_like
        Pixels; see `pixel` for other units.
    weights : (n,) array_like, optional
        What each point counts; not negative.
    controls : int or "adaptive"
        Control points. "adaptive" takes 7, then 3 more until the rms distance is below
        1.2 px or 1.3 times the noise of the ink, at most 25.
    closed : bool
        Whether the last point is joined to the first: the spline is periodic.
    start_tangent, end_tangent : (d,) array_like, optional
        Directions along the curve that its ends have exactly. Not for closed curves.
    pixel : float
        Length of a pixel in the units of the points: for curves in space, which are in mm.

    Returns
    -------
    SplineFit

    Raises
    ------
    UserError
        If the points are not finite, or fewer than two of them differ.
    ValueError
        If weights, controls or tangents make no sense.
    """
    place = checked_points(points, pixel)
    weight = _checked_weights(weights, len(place))
    tangents = [_checked_tangent(t, place.shape[1], closed) for t in (start_tangent, end_tangent)]
    if controls != "adaptive" and controls < FEWEST_CONTROLS:
        raise ValueError("a cubic spline needs at least four control points")
    ready = prepare_curve(place, weight, pixel=pixel, closed=closed)
    if np.ptp(ready.points, axis=0).max() <= 0:
        raise UserError("The ink is a dot: draw a curve.")
    count = len(ready.points)
    at = np.arange(count) / (count if closed else count - 1)
    if controls == "adaptive":
        made = approximate_adaptively(
            ready.points, ready.weights, at, max(ENOUGH * pixel, NOISE_FACTOR * ready.noise),
            closed=closed, start_tangent=tangents[0], end_tangent=tangents[1],
        )  # fmt: skip
    else:
        made = approximate(
            ready.points, ready.weights, at, controls,
            closed=closed, start_tangent=tangents[0], end_tangent=tangents[1],
        )  # fmt: skip
    own = _own_parameters(ready, made.parameters, closed)
    return SplineFit(made.spline, made.rms, made.worst, own)


def _own_parameters(ready: PreparedCurve, feet: Array, closed: bool) -> Array:
    """Return parameters of the given points, from those of the prepared ones beside them."""
    if closed:
        feet = np.unwrap(np.append(feet, feet[0]), period=1.0)
    stations = np.linspace(0.0, 1.0, len(feet))
    return np.asarray(np.interp(ready.along, stations, np.maximum.accumulate(feet)))


def _checked_weights(weights: ArrayLike | None, count: int) -> Array:
    weight = np.ones(count) if weights is None else np.asarray(weights, float)
    if weight.shape != (count,) or not np.isfinite(weight).all() or (weight < 0).any():
        raise ValueError("every point needs a weight that is not negative")
    if not weight.max() > 0:
        raise ValueError("some weight must be above nought")
    return np.asarray(weight / weight.max())


def _checked_tangent(tangent: ArrayLike | None, size: int, closed: bool) -> Array | None:
    if tangent is None:
        return None
    direction = np.asarray(tangent, float)
    if closed or direction.shape != (size,) or not np.isfinite(direction).all():
        raise ValueError("an end tangent is a direction at the end of an open curve")
    if not np.abs(direction).max() > 0:
        raise ValueError("an end tangent needs a direction")
    return np.asarray(direction / np.abs(direction).max())
