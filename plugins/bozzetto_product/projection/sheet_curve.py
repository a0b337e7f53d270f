"""Strokes of one curve, in any order and direction, as one spline on the sheet.

Kara & Shimada, book chapter, section 13.2.1, order the samples along their principal direction
and ask people to draw hooks and loops in pieces. The shared ink tools order any ink; the
principal direction is kept as a choice.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.geometry import DEGREE, Spline
from bozzetto.ink import (
    Stroke,
    arc_length,
    carried_places,
    distances_to_polyline,
    fit_spline,
    is_one_view,
    merge_strokes,
    places_on_sheet,
    spline_weights,
    stroke_weights,
)
from bozzetto.view import Camera
from bozzetto_product.projection.spline_basis import with_controls

FEWEST_CONTROLS: Final = 4
"""A cubic needs four control points."""

SHOWN: Final = 400
"""Places by which a curve on the sheet is compared with its ink."""

REFITS: Final = 30
"""Rounds in which the places of the ink on the spline are sought anew. The error of a hook with
seven control points still falls in the tenth."""

FOOT_STEPS: Final = 4
"""Newton steps to the foot points in a round: the next round goes on from there."""

SETTLED: Final = 0.02
"""Change of the distance from round to round, px, at which a curve is settled."""

GOOD: Final = 3.0
"""Distance, px, at which no other parametrization is tried."""

END: Final = 0.1
"""Weight of an end, as a share of all points."""

LOOKS: Final = 161
"""Places of a spline, and of the ink in order, that are compared."""

FAR: Final = 6.0
"""Distance, px, of the ink from its curve that is worth a warning."""

SAME_VIEW: Final = 1e-6
"""Difference of two cameras, as a share of the distance to the target, that nobody sees."""


@dataclass(frozen=True, eq=False)
class SheetCurve:
    """A curve on the sheet.

    Attributes
    ----------
    spline : Spline
        Over 0 … 1, px.
    camera : Camera
        The one through which all strokes are seen.
    worst : float
        Largest distance between the ordered ink and the spline, px.
    sure : bool
        Whether the ink is near its curve everywhere.
    """

    spline: Spline
    camera: Camera
    worst: float
    sure: bool


def curve_on_sheet(
    strokes: Sequence[Stroke], *, controls: int = 7, order: Literal["drawn", "principal"] = "drawn"
) -> SheetCurve:
    """Fit one cubic B-spline to the strokes of one curve.

    Parameters
    ----------
    strokes : sequence of Stroke
        Any number, in any order and direction, drawn in one view. Firm ones and late ones count
        for more.
    controls : int
        Control points, at least 4.
    order : {"drawn", "principal"}
        How the ink is put in order: along the strokes, or along its principal direction.

    Returns
    -------
    SheetCurve

    Raises
    ------
    UserError
        If there is no ink, it is a dot, it leaves the sheet, or it was drawn in several views.
    """
    if not strokes:
        raise UserError("There is no ink. Draw a curve.")
    camera = strokes[0].camera
    ink = [_on_canvas(stroke, camera) for stroke in strokes]
    weights = stroke_weights(strokes)
    count = max(FEWEST_CONTROLS, int(controls))
    if order == "principal":
        return _along_principal(ink, weights, count, camera)
    merged = merge_strokes(ink, weights)
    spline = _along_ink(_refitted(merged.points, count, merged.closed), ink)
    apart = distances_to_polyline(merged.points, spline.sampled(SHOWN + 1))
    return SheetCurve(spline, camera, float(apart.max()), merged.sure)


def _along_ink(spline: Spline, ink: Sequence[Array]) -> Spline:
    """Return a spline that runs as most of the ink was drawn."""
    ahead = 0.0
    for points in ink:
        middle = 0.5 * (points[1:] + points[:-1])
        tangents = spline.derivative(spline.foot_points(middle))
        ahead += float(np.einsum("nk,nk->", tangents, np.diff(points, axis=0)))
    return spline.reversed() if ahead < 0.0 else spline


def _on_canvas(stroke: Stroke, camera: Camera) -> Array:
    """Return the places of a stroke on the canvas of the first one, px."""
    points = places_on_sheet(stroke.points, "stroke")
    if stroke.camera == camera:
        return points
    if not is_one_view(stroke.camera, camera, SAME_VIEW):
        raise UserError("These strokes were drawn in different views. Draw a curve in one view.")
    return carried_places(points, stroke.camera, camera)


def _refitted(points: Array, count: int, closed: bool) -> Spline:
    """Return the spline of a number of control points nearest to ordered points.

    The places on the spline are sought anew from round to round (Hoschek 1988), and in each round
    the spline of least squares is taken. That can end in a spline with a bulge where no ink is, so
    it is tried from several parametrizations, and the distance is measured both ways.
    """
    count = max(count, DEGREE + 2) if closed else count
    fit = fit_spline(points, controls=count, closed=closed)
    line = points[np.linspace(0, len(points) - 1, min(len(points), LOOKS)).round().astype(int)]
    along = arc_length(line)
    lap = along[-1] + (np.linalg.norm(line[-1] - line[0]) if closed else 0.0)
    even = np.arange(len(line)) / (len(line) - (not closed))
    starts = (fit.spline.foot_points(line, along / lap), along / lap, even)
    splines = [fit.spline, *(_least_squares(fit.spline, line, at) for at in starts[1:])]
    best, least = fit.spline, np.inf
    for spline, start in zip(splines, starts, strict=True):
        at, here = start, spline
        before = np.inf
        for _ in range(REFITS):
            at = here.foot_points(line, at, steps=FOOT_STEPS)
            error = _both_ways(here, line, at)
            if error < least:
                best, least = here, error
            if abs(before - error) < SETTLED:
                break
            before = error
            here = _least_squares(here, line, at)
        if least <= GOOD:
            break
    return best


def _least_squares(spline: Spline, line: Array, at: Array) -> Spline:
    """Return the spline over the same knots nearest to points at given parameters."""
    say = np.ones(len(line))
    if not spline.closed:  # the ends are drawn: each counts like a stretch of the curve
        say[[0, -1]] = END * len(line)
    rows = say[:, None] * spline_weights(spline, at)
    controls = np.linalg.lstsq(rows, say[:, None] * line, rcond=None)[0]
    return with_controls(spline, np.asarray(controls, float))


def _both_ways(spline: Spline, line: Array, at: Array) -> float:
    """Return the distance of points from a spline, and of the spline from the points, px."""
    there = np.linalg.norm(spline.value(at) - line, axis=1)
    back = distances_to_polyline(spline.sampled(LOOKS), line)
    return float(np.sqrt(np.mean(there**2)) + 0.5 * max(there.max(), back.max()))


def _along_principal(
    ink: Sequence[Array], weights: Array, count: int, camera: Camera
) -> SheetCurve:
    """Fit the samples in the order of their projections on the principal direction."""
    points = np.vstack(ink)
    weight = np.repeat(weights, [len(one) for one in ink])
    offset = points - np.average(points, axis=0, weights=weight)
    along = offset @ np.linalg.eigh((offset * weight[:, None]).T @ offset)[1][:, -1]
    extent = float(np.ptp(along))
    if not extent > 0.0:
        raise UserError("The ink is a dot: draw a curve.")
    spline = Spline.uniform(np.zeros((count, 2)))
    say = np.sqrt(weight)[:, None]
    rows = spline_weights(spline, (along - along.min()) / extent)
    controls = np.linalg.lstsq(say * rows, say * points, rcond=None)[0]
    spline = Spline.uniform(controls)
    worst = float(distances_to_polyline(points, spline.sampled(SHOWN + 1)).max())
    return SheetCurve(spline, camera, worst, worst <= FAR)
