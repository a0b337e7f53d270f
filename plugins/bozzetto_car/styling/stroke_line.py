"""The smooth line that a person meant by strokes on the sheet.

Kara & Shimada (CAD 2008) smooth styling strokes in the image before they project them, by the
filter of Savitzky and Golay (1964): each place moves to the cubic that fits its neighbourhood
best, so bends keep their form where a mean would flatten them. The ends of the stroke stay.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.ink import (
    Stroke,
    arc_length,
    close_stroke,
    distinct,
    end_gap,
    is_closed_gesture,
    merge_strokes,
    places_on_sheet,
    resample,
    stroke_weights,
)

STEP: Final = 6.0
"""Distance of the places of a line, px."""

FINE: Final = 1.0
"""Distance of the places on which a stroke is smoothed, px."""

MOST: Final = 6000
"""Most places on which a stroke is smoothed; on a longer stroke they are farther apart."""

MOST_PLACES: Final = 1000
"""Most places of a line: enough for two widths of the sheet."""

DEGREE: Final = 3
"""Degree of the polynomials that smooth."""

SHARE: Final = 0.07
"""Half width of the smoothing window, per length of the stroke."""

WINDOW: Final = (8.0, 40.0)
"""Least and greatest half width of the window, px."""

PASSES: Final = 2
"""Passes of the filter: the second removes the ripples that the first leaves of a tremor, and with
them half of the knots of the curve in space."""

CLOSING: Final = 0.06
"""Widest gap of a closed loop, as a share of the diagonal of its box. An arch over 95 % of a turn
has 0.11, and it is open."""

SHORTEST: Final = 6.0
"""Length, px, below which a stroke is a dot."""

DOT: Final = "The stroke is a dot. Draw the whole line on the body."


def one_stroke(strokes: Sequence[Stroke]) -> Array:
    """Return the strokes of a gesture as one; several are merged, older ones count less.

    Parameters
    ----------
    strokes : sequence of Stroke
        Strokes of one view, at least one.

    Returns
    -------
    (n, 2) float
        Places, px, in the direction of the first stroke that is no dot.
    """
    ink = [stroke for stroke in strokes if arc_length(stroke.points)[-1] >= SHORTEST]
    if len(ink) < 2:
        return np.asarray((ink or strokes)[0].points, float)
    line = merge_strokes([stroke.points for stroke in ink], stroke_weights(ink)).points
    first = ink[0].points
    against = (first[-1] - first[0]) @ (line[-1] - line[0]) < 0.0
    return np.asarray(line[::-1] if against else line)


def smooth_line(points: ArrayLike) -> Array:
    """Return a stroke without the tremor of the hand; a loop is closed.

    The window is a share of the arc length, whatever the sampling rate. Beyond its ends an
    open stroke is continued by its point reflection, which keeps the ends where they are.

    Parameters
    ----------
    points : (n, 2) array_like
        Samples of the stroke, px.

    Returns
    -------
    (m, 2) float
        Places at equal steps of about `STEP`, px. A loop ends in its first place.

    Raises
    ------
    UserError
        If the stroke is a dot or leaves the sheet beyond all bounds.
    """
    place = places_on_sheet(points, "stroke")
    place = place[distinct(place)]
    length = float(arc_length(place)[-1])
    if length < SHORTEST:
        raise UserError(DOT)
    ring = _ring(place)
    spacing = max(FINE, length / MOST)
    fine = resample(place, spacing=spacing) if ring is None else _closed(ring, spacing)
    step = float(arc_length(fine)[-1]) / (len(fine) - 1)
    half = min(round(float(np.clip(SHARE * length, *WINDOW)) / step), len(fine) - 1)
    if 2 * half > DEGREE:
        weights = _weights(half)
        for _ in range(PASSES):
            before, after = fine[-half - 1 : -1], fine[1 : half + 1]
            if ring is None:
                before, after = 2.0 * fine[0] - after[::-1], 2.0 * fine[-1] - before[::-1]
            whole = np.vstack((before, fine, after))
            fine = np.column_stack([np.convolve(c, weights, "valid") for c in whole.T])
    smooth = resample(fine, spacing=max(STEP, length / MOST_PLACES))
    if float(arc_length(smooth)[-1]) < SHORTEST:  # a loop of a few pixels, back where it began
        raise UserError(DOT)
    return smooth


def _ring(points: Array) -> Array | None:
    """Return the loop that a stroke closes, without its first place again; None if it is open."""
    if not is_closed_gesture(points):
        return None
    ring = close_stroke(points)
    return ring if end_gap(ring) <= CLOSING else None


def _closed(ring: Array, spacing: float) -> Array:
    """Return places at equal steps around a loop, with the first one again at the end."""
    places = resample(ring, spacing=spacing, closed=True)
    return np.vstack((places, places[:1]))


def _weights(half: int) -> Array:
    """Return the weights of a window for the middle value of its cubic, (2 half + 1,)."""
    powers = np.vander(np.linspace(-1.0, 1.0, 2 * half + 1), DEGREE + 1, increasing=True)
    return np.asarray(np.linalg.pinv(powers)[0])
