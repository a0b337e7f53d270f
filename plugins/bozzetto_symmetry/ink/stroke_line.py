"""One stroke as an evenly spaced line, smoothed no more than its own noise requires."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.ink import (
    END_SHARE,
    Stroke,
    arc_length,
    close_stroke,
    distances_to_polyline,
    distinct,
    end_gap,
    is_closed_gesture,
    prepare_curve,
    resample,
)
from bozzetto_symmetry.ink.polyline import interpolate, length_of

DECIMALS: Final = 6
"""Decimals of a place on the sheet, px: finer steps are no ink but rounding."""

SPACING: Final = 2.0
"""Distance of the points of a line, px."""

MOST: Final = 600
"""Most points of a line."""

FEWEST: Final = 33
"""Fewest points of a line: a short stroke is spaced more finely."""

GRID: Final = (1.0, 4.0)
"""Least and greatest spacing on which a stroke is smoothed, px; between them that of its samples.
Sparser samples are taken as they are: what lies between them cannot be separated from noise."""

MOST_SAMPLES: Final = 10_000
"""Most samples of one stroke: a hand that draws for a minute gives fewer."""

LIFT: Final = 0.05
"""Share of the greatest pressure below which the pen is leaving the sheet."""

DEGREE: Final = 3
"""Degree of the polynomials that smooth: a bend of radius 20 px moves by 0.01 px under the widest
window that is taken at such a bend, where a Gaussian of 4 px would move it by 0.4 px."""

WIDTHS: Final = (5.0, 7.0, 10.0, 14.0, 20.0)
"""Half widths of the smoothing window that are tried, px."""

PROBE: Final = 3
"""Half width of the window, in steps, about which the noise of single samples is measured."""

STILL: Final = 0.03
"""Noise, px, below which a stroke is taken as it is: sheets have no finer marks."""

TOLERANCE: Final = 2.0
"""How much more a wider window may change than noise of single samples explains, before it is
too wide. Noise of samples that are averaged on a grid is no longer quite independent."""

PIECES: Final = 16
"""Parts of a line, each with a noise of its own."""

CALM: Final = 0.1
"""Share of these parts that are the calmest."""

HAND_DEGREE: Final = 5
"""Degree of the polynomials that separate the slow wavering of the hand from the form."""

HAND_SHARE: Final = 0.12
"""Half width of the window that separates the hand from the form, as a share of the length."""

HAND_WIDTH: Final = (20.0, 60.0)
"""Least and greatest of that half width, px."""

CLOSING: Final = 0.06
"""Widest gap of a closed stroke as a share of the diagonal of its bounding box. Of an arch that
makes 95 % of a turn it is 0.11, and that is open."""

SMALL: Final = (6.0, 0.1)
"""Gap, px, by which a hand misses where it began, however small the loop is, and the share of the
diagonal that it may be even then."""

OVERLAP: Final = 0.06
"""Share of a stroke that closing may cut off, wherever it goes: a hook of the pen is no longer."""


@dataclass(frozen=True, eq=False)
class Line:
    """A stroke as an evenly spaced line.

    Attributes
    ----------
    pixels : (n, 2) float
        Evenly spaced in the sense drawn; a closed line does not repeat its first point.
    closed : bool
    noise : float
        Standard deviation of the hand across the line, px.
    """

    pixels: Array
    closed: bool
    noise: float


def pen_down(stroke: Stroke) -> Array:
    """Return the places of a stroke without the tail that the lifted pen left, (n, 2) px."""
    points = np.round(stroke.points, DECIMALS)
    if stroke.has_pressure:
        firm = np.flatnonzero(stroke.pressure >= LIFT * stroke.pressure.max())
        points = points[: firm[-1] + 1]
    return thin_out(points[distinct(points)])


def thin_out(points: Array) -> Array:
    """Return the samples of a line without those that no hand can have meant, (m, 2) px.

    A pen gives some hundred samples in a second. Of denser samples the first in each of
    `MOST_SAMPLES` equal steps is kept, and the last of all.
    """
    if len(points) <= MOST_SAMPLES:
        return points
    along = arc_length(points)
    step = np.floor(along * (MOST_SAMPLES / max(float(along[-1]), 1e-300)))
    kept = np.append(np.diff(step) > 0, True)
    kept[0] = True
    return np.asarray(points[kept])


def smooth_line(points: Array) -> Line:
    """Smooth and space one stroke.

    Local cubic polynomials are fitted along the arc length of the ink. Their window is the
    widest that leaves no more than the noise of the samples, so that ink without noise keeps
    its form, whatever the sampling rate.

    Parameters
    ----------
    points : (n, 2) float
        As drawn, px.

    Raises
    ------
    UserError
        If the stroke is a dot.
    """
    points = np.round(points, DECIMALS)
    points = thin_out(points[distinct(points)])
    if len(points) < 2:
        raise UserError("The stroke is a dot. Draw the whole curve.")
    loop = _loop(points)
    closed = loop is not None
    place = points if loop is None else loop
    along = _lengths(place, closed)
    fine = _on_grid(place, along, closed, GRID[0])
    spacing = float(along[-1]) / len(place)
    step = max(spacing, GRID[0])
    noise = _residual(_on_grid(place, along, closed, step), PROBE, DEGREE, closed)
    if noise < STILL or spacing > GRID[1]:
        return Line(space_evenly(fine, closed=closed), closed, hand_noise(fine, closed=closed))
    # The length of noisy ink grows with the sampling rate, that of smoothed ink does not.
    rough = _on_grid(place, _smoothed_lengths(place, closed), closed, step)
    soft = _smoothed(rough, closed)
    fine = _on_grid(soft, _lengths(soft, closed), closed, GRID[0])
    return Line(space_evenly(fine, closed=closed), closed, hand_noise(rough, closed=closed))


def space_evenly(points: Array, *, closed: bool = False) -> Array:
    """Return points about `SPACING` apart along a polyline, (n, 2) px."""
    ring = np.vstack((points, points[:1])) if closed else points
    length = length_of(ring)
    count = int(np.clip(round(length / SPACING), FEWEST - 1, MOST - 1))
    return resample(points, count=count if closed else count + 1, closed=closed)


def hand_noise(points: Array, *, closed: bool = False) -> float:
    """Return the standard deviation across the line of what is no form, px.

    What polynomials of degree five over a quarter of the line do not follow counts as
    the hand. Slower wavering cannot be separated from the form, so the figure is a lower bound;
    it is 0 where the stroke is too short.

    Parameters
    ----------
    points : (n, 2) float
        Equally spaced.
    closed : bool
        The line is a ring; its first point is not repeated.
    """
    return _residual(points, _hand_window(points, closed), HAND_DEGREE, closed)


def calmest_noise(points: Array, *, closed: bool = False) -> float:
    """Return the standard deviation of what is no form where the line is calmest, px.

    As `hand_noise`, over the calmest tenth of the line: corners are no form of a low degree
    either, but never all of a line. Of ink that a program made or filtered it is a few thousandths
    of a pixel; of a hand, even one whose tremor is slow, a hundredth and more.

    Parameters
    ----------
    points : (n, 2) float
        Equally spaced.
    closed : bool
        The line is a ring; its first point is not repeated.
    """
    window = _hand_window(points, closed)
    if 2 * window <= HAND_DEGREE or 2 * window + 1 > len(points):
        return 0.0
    soft = _local_polynomial(points, window, HAND_DEGREE, closed)
    pieces = np.array_split(_across(points - soft, soft) ** 2, PIECES)
    calm = np.quantile([piece.mean() for piece in pieces], CALM)
    return float(np.sqrt(calm / (1.0 - _hat(window, HAND_DEGREE)[window, window])))


def _hand_window(points: Array, closed: bool) -> int:
    """Return half the window, in steps, about which the noise of the hand is measured."""
    ring = np.vstack((points, points[:1])) if closed else points
    length = length_of(ring)
    step = length / max(1, len(ring) - 1)
    half = float(np.clip(HAND_SHARE * length, *HAND_WIDTH))
    return min(round(half / step), (len(points) - 1) // 2)


def _loop(points: Array) -> Array | None:
    """Return the ring that a stroke closes, or None if it is open."""
    gap, size = points[-1] - points[0], float(np.hypot(*np.ptp(points, axis=0)))
    missed, most = SMALL
    closing = max(CLOSING, min(missed / size, most))
    within = 2.0 * END_SHARE * length_of(points) + closing * size
    if float(np.hypot(*gap)) > within or not is_closed_gesture(points):
        return None  # cutting the ends back cannot bring them together, or does not
    ring = close_stroke(points)
    if end_gap(ring) > closing or _winds_on(points, ring):
        return None
    return ring


def _winds_on(points: Array, ring: Array) -> bool:
    """Return whether an end that closing cuts off leaves the ring, as that of a spiral does."""
    whole = np.vstack((ring, ring[:1]))
    if length_of(points) - length_of(ring) < OVERLAP * length_of(points):
        return False
    away = float(distances_to_polyline(points, whole).max())
    return away > CLOSING * float(np.hypot(*np.ptp(points, axis=0)))


def _lengths(points: Array, closed: bool) -> Array:
    """Return the arc length up to each point, and on a ring up to the first again."""
    return arc_length(np.vstack((points, points[:1])) if closed else points)


def _smoothed_lengths(points: Array, closed: bool) -> Array:
    """Return the same as `_lengths`, measured on the smoothed line."""
    made = prepare_curve(points, np.ones(len(points)), pixel=1.0, closed=closed)
    along = np.append(made.along, 1.0) if closed else made.along
    return np.asarray(np.maximum.accumulate(along) * _lengths(made.points, closed)[-1])


def _on_grid(points: Array, along: Array, closed: bool, step: float) -> Array:
    """Return points at equal steps along the ink, on smooth curves between sparse samples."""
    from scipy.interpolate import Akima1DInterpolator

    ring = np.vstack((points, points[:1])) if closed else points
    length = float(along[-1])
    count = int(np.clip(round(length / step), FEWEST - 1, 2 * MOST))
    knots, values = _averaged(along, ring, length / count)
    stations = np.linspace(0.0, length, count + 1)
    if len(knots) < 3:
        fine = interpolate(stations, knots, values)
    else:
        if closed:  # a few samples beyond either end, so that it goes on smoothly
            reach = min(3, len(knots) - 1)
            before, after = slice(-1 - reach, -1), slice(1, 1 + reach)
            knots = np.concatenate((knots[before] - length, knots, knots[after] + length))
            values = np.vstack((values[before], values, values[after]))
        fine = np.asarray(Akima1DInterpolator(knots, values)(stations))
    return fine[:-1] if closed else fine


def _averaged(along: Array, points: Array, step: float) -> tuple[Array, Array]:
    """Return means of the samples in each cell of a grid; the first and the last sample stay."""
    cell = np.floor(along / step).astype(np.intp)
    fresh = np.append(True, np.diff(cell) > 0)
    fresh[[1, -1]] = True
    home = np.cumsum(fresh) - 1
    sizes = np.bincount(home)
    at, x, y = (np.bincount(home, column) / sizes for column in (along, points[:, 0], points[:, 1]))
    apart = np.append(True, np.diff(at) > 1e-6 * step)
    apart[-2] &= at[-1] - at[-2] > 1e-6 * step
    apart[[0, -1]] = True
    return at[apart], np.column_stack((x, y))[apart]


def _smoothed(points: Array, closed: bool) -> Array:
    """Return the line under the widest window that changes it no more than noise explains."""
    noise = _residual(points, PROBE, DEGREE, closed)
    step = float(_lengths(points, closed)[-1]) / len(points)
    soft, before = points, np.array([1.0])
    for width in WIDTHS:
        half = round(width / step)
        if half < PROBE or 2 * half + 1 > len(points):
            continue
        wider = _local_polynomial(points, half, DEGREE, closed)
        weights = _hat(half, DEGREE)[half]
        change = weights.copy()
        middle = len(before) // 2
        change[half - middle : half + middle + 1] -= before
        explained = noise * float(np.linalg.norm(change))
        if float(np.sqrt(np.mean(_across(wider - soft, wider) ** 2))) > TOLERANCE * explained:
            break
        soft, before = wider, weights
    return soft


def _across(offsets: Array, points: Array) -> Array:
    """Return the part of offsets at right angles to a line, (n,)."""
    tangent = np.gradient(points, axis=0)
    length = np.maximum(np.linalg.norm(tangent, axis=1), 1e-300)
    return np.asarray((tangent[:, 0] * offsets[:, 1] - tangent[:, 1] * offsets[:, 0]) / length)


def _residual(points: Array, half: int, degree: int, closed: bool) -> float:
    """Return the standard deviation across local polynomials, without the fit's own share."""
    if 2 * half <= degree or 2 * half + 1 > len(points):
        return 0.0
    soft = _local_polynomial(points, half, degree, closed)
    aside = np.abs(_across(points - soft, soft))
    if not closed and len(points) > 4 * half:
        aside = aside[half:-half]  # at the ends the polynomials follow the ink too well
    own = _hat(half, degree)[half, half]
    return float(1.4826 * np.median(aside) / np.sqrt(1.0 - own))


def _local_polynomial(points: Array, half: int, degree: int, closed: bool) -> Array:
    """Return values at equally spaced points of least squares polynomials about each.

    Savitzky & Golay 1964; near the ends of an open line the first and the last whole
    window are used.
    """
    hat = _hat(half, degree)
    if closed:
        index = np.arange(-half, len(points) + half) % len(points)
        return _convolved(points[index], hat[half])
    width = 2 * half + 1
    middle = _convolved(points, hat[half])
    return np.vstack((hat[:half] @ points[:width], middle, hat[half + 1 :] @ points[-width:]))


def _convolved(points: Array, weights: Array) -> Array:
    return np.column_stack([np.convolve(column, weights[::-1], "valid") for column in points.T])


def _hat(half: int, degree: int) -> Array:
    """Return the matrix that turns the values in a window into those of their polynomial."""
    basis, _ = np.linalg.qr(np.vander(np.linspace(-1.0, 1.0, 2 * half + 1), degree + 1))
    return np.asarray(basis @ basis.T)
