"""Distances from points to polylines, and the curve that a stroke is meant for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.ink.checked_points import is_on_sheet, places_on_sheet
from bozzetto.ink.curves.resample import resample

if TYPE_CHECKING:
    from bozzetto.arrays import Array

SAMPLES: Final = 96
"""Places of the stroke, at equal steps, whose distances are averaged: enough that the mean
errs by a few per cent on a wavy stroke, few enough to ask hundreds of curves."""

PAIRS_AT_ONCE: Final = 200_000
"""Pairs of point and segment examined in one sweep; bounds the memory used."""


@dataclass(frozen=True)
class Nearest:
    """The curve that lies nearest to a stroke.

    Attributes
    ----------
    index : int
        Which of the curves.
    distance : float
        Mean distance of the stroke from it, px. It does not grow with the stroke's length.
    """

    index: int
    distance: float


def distances_to_polyline(points: ArrayLike, polyline: ArrayLike) -> Array:
    """Return the distance of each point from a polyline.

    Parameters
    ----------
    points : (n, d) array_like
        Places, in the units of the polyline.
    polyline : (m, d) array_like
        ``m >= 1``; a single point is a polyline too.

    Returns
    -------
    (n,) float
    """
    place, path = np.asarray(points, float), np.asarray(polyline, float)
    if len(path) == 1:
        return np.asarray(np.linalg.norm(place - path[0], axis=1), np.float64)
    begin, step = path[:-1], np.diff(path, axis=0)
    squares = np.einsum("ij,ij->i", step, step)
    squares[squares == 0] = 1.0
    best = np.full(len(place), np.inf)
    rows = max(1, PAIRS_AT_ONCE // len(begin))
    for first in range(0, len(place), rows):
        part = slice(first, first + rows)
        offset = place[part, None] - begin
        share = np.clip(np.einsum("nij,ij->ni", offset, step) / squares, 0.0, 1.0)
        offset -= share[..., None] * step
        best[part] = np.sqrt(np.einsum("nij,nij->ni", offset, offset).min(axis=1))
    return best


def nearest_curve(curves: Sequence[ArrayLike], stroke: ArrayLike) -> Nearest | None:
    """Find the curve that an oversketch is meant for.

    It is the one with the least mean distance from the stroke (Kara & Shimada, section
    13.2). Whether a lead over the second best is wide enough, and what a person chose by
    hand, is for the caller to weigh.

    Parameters
    ----------
    curves : sequence of (n, 2) array_like
        As seen on the sheet, px. Curves without points, or with a place that is not on the
        sheet (behind the eye), are left out.
    stroke : (m, 2) array_like
        px; ``m >= 1``.

    Returns
    -------
    Nearest or None
        None where there is no curve. The first of equals wins.

    Raises
    ------
    UserError
        If the stroke has no points, or a place that is not on the sheet.
    """
    ink = resample(places_on_sheet(stroke, "stroke"), count=SAMPLES)
    seen = [(k, np.asarray(curve, float)) for k, curve in enumerate(curves)]
    seen = [(k, curve) for k, curve in seen if len(curve) and is_on_sheet(curve)]
    # No curve is nearer than its box, so most need no closer look.
    bounds = sorted((_mean_box_distance(ink, curve), k, curve) for k, curve in seen)
    best: Nearest | None = None
    for bound, index, curve in bounds:
        if best is not None and bound > best.distance:
            break
        found = Nearest(index, float(distances_to_polyline(ink, curve).mean()))
        if best is None or (found.distance, index) < (best.distance, best.index):
            best = found
    return best


def _mean_box_distance(ink: Array, curve: Array) -> float:
    outside = np.maximum(curve.min(0) - ink, ink - curve.max(0))
    return float(np.linalg.norm(np.maximum(outside, 0.0), axis=1).mean())
