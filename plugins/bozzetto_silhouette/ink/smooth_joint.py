"""A smooth joint of two lines: ink on both sides tells one direction, and both share the miss.

Short gaps get a cubic through the ink of both, which blends into it; long ones an arch. Lengths are
shares of the drawing's longest side.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.polynomial import polynomial

from bozzetto.arrays import Array
from bozzetto.ink import arc_length, points_along

NARROW, WIDE = 0.018, 0.15
"""Least and greatest length of ink at each end that a smooth joint is fitted to."""

SHARE, SHARE_OF_SHORT = 0.2, 0.4
"""The same as a share of the shorter line, and of a stroke between others that is so short that
this would be too little."""

REACH: Final = 2.5
"""That length in widths of the gap."""

CORNER: Final = np.deg2rad(50.0)
"""A joint at which the ink turns by more, and more than it bends on that way, is a corner."""

MOST_TURN: Final = np.deg2rad(110.0)
"""Turn beyond which no smooth joint leads over a gap: it would be no function of the chord."""

LANDING: Final = 0.15
"""Ink right at an end, as a share of the length that is fitted: where the pen lands and lifts it
tells the place, and no direction."""

ROUGH: Final = 0.06
"""Deviation of ink from a parabola, as a share of the length that is fitted, from which on it
holds a corner or a hook of its own."""

LEAST_INK: Final = 4
"""Samples that each end must have in the length that is fitted: fewer are vertices of a polygon."""

SAMPLES: Final = 24
"""Points on each side of a smooth joint."""

LONG_GAP: Final = 0.1
"""A gap beyond this is bridged by an arch; what is fitted over it would leave the ink."""

WIDEST_GAP: Final = 0.35
"""A gap beyond this is closed straight: nothing says how it was meant."""

ARCHED: Final = np.cos(np.deg2rad(65.0))
"""The ink on both sides of an arch heads over the gap, up to this angle."""

SPACING: Final = 0.006
"""Distance of the points of an arch."""


class Joint(NamedTuple):
    """Two lines that meet.

    Parameters
    ----------
    before, after : (n, 2), (m, 2) float
        What is kept of them.
    between : (k, 2) float
        Points that lead from one to the other.
    """

    before: Array
    after: Array
    between: Array


def smooth_joint(a: Array, b: Array, *, halves: bool) -> Joint | None:
    """Join two lines smoothly, if that is what their ink says; the miss is shared by both."""
    gap = gap_between(a, b)
    back, arc_a, arc_b = a[::-1], arc_length(a[::-1]), arc_length(b)
    shorter = float(min(arc_a[-1], arc_b[-1]))
    longest = SHARE * shorter
    if not halves:
        longest = max(longest, min(3.0 * NARROW, SHARE_OF_SHORT * shorter))
    long_gap = gap > LONG_GAP
    length = min(LONG_GAP if long_gap else max(REACH * gap, 3.0 * NARROW), WIDE, longest)
    while length >= (NARROW if long_gap else max(NARROW, 1.2 * gap)):
        if min(np.searchsorted(arc_a, length), np.searchsorted(arc_b, length)) < LEAST_INK:
            return None
        end, start = fitted_parabola(back, arc_a, length), fitted_parabola(b, arc_b, length)
        if end is not None and start is not None:
            made = (_arch if long_gap else _fitted)(a, b, end, start, length)
            if made is not None:
                return made
        length *= 0.7
    return None


def fitted_parabola(line: Array, arc: Array, length: float) -> Array | None:
    """Fit the ink at the start of a line.

    Returns
    -------
    (3, 2) float or None
        Coefficients of the arc length; None where the ink holds a corner.
    """
    at = np.linspace(LANDING * length, 2.0 * length, 2 * SAMPLES)
    ink = points_along(line, arc, at)
    fit = polynomial.polyfit(at, ink, 2)
    away = ink - polynomial.polyval(at, fit).T
    rough = float(np.sqrt(np.einsum("ij,ij->", away, away) / len(at)))
    return None if rough > ROUGH * length else np.asarray(fit, float)


def _fitted(a: Array, b: Array, end: Array, start: Array, length: float) -> Joint | None:
    """Lead over a short gap by a cubic through the ink on both sides, which blends into it.

    None where the ink turns too much, and the joint is a corner.
    """
    leave, arrive = -end[1], start[1]
    turn = np.arctan2(leave[0] * arrive[1] - leave[1] * arrive[0], leave @ arrive)
    told = 0.5 * (bend(start) - bend(end)) * float(np.hypot(*(b[0] - a[-1])))
    if not min(0.0, told) - CORNER < turn < max(0.0, told) + CORNER or abs(turn) > MOST_TURN:
        return None
    along = leave / np.hypot(*leave) + arrive / np.hypot(*arrive)
    along /= np.hypot(*along)
    frame = np.column_stack((along, (-along[1], along[0])))
    middle = 0.5 * (a[-1] + b[0])
    at = np.linspace(0.0, length, SAMPLES)
    back = a[::-1]
    before = (points_along(back, arc_length(back), at)[::-1] - middle) @ frame
    after = (points_along(b, arc_length(b), at) - middle) @ frame
    half = float(min(-before[0, 0], after[-1, 0]))
    if half < 0.5 * length:
        return None
    x, y = np.concatenate((before, after)).T
    share = np.abs(x) / half
    fit = polynomial.polyfit(x / half, y, 3, w=0.1 + 0.9 * np.clip((share - 0.1) / 0.4, 0.0, 1.0))
    grid = np.linspace(before[0, 0], after[-1, 0], 2 * SAMPLES + 1)
    one, other = before[np.argsort(before[:, 0])], after[np.argsort(after[:, 0])]
    ink = np.where(
        grid < 0.0, np.interp(grid, one[:, 0], one[:, 1]), np.interp(grid, other[:, 0], other[:, 1])
    )
    outward = np.where(grid < 0.0, grid / grid[0], grid / grid[-1])
    t = np.clip(2.0 * outward - 1.0, 0.0, 1.0)
    blend = t * t * (3.0 - 2.0 * t)
    height = polynomial.polyval(grid / half, fit) * (1.0 - blend) + ink * blend
    between = middle + np.column_stack((grid, height)) @ frame.T
    return _cut(a, b, length, between)


def bend(parabola: Array) -> float:
    """Return the curvature at the start of a parabola, to the left positive."""
    (dx, dy), (ddx, ddy) = parabola[1], 2.0 * parabola[2]
    return float((dx * ddy - dy * ddx) / max(np.hypot(dx, dy) ** 3, 1e-12))


def _arch(a: Array, b: Array, end: Array, start: Array, length: float) -> Joint | None:
    """Lead over a long gap by a cubic in the directions of the ink on both sides.

    None where that is not roughly where it has to go.
    """
    if gap_between(a, b) > WIDEST_GAP:
        return None
    cut = 2.0 * LANDING * length
    (begin, leave), (finish, arrive) = _at(end, cut), _at(start, cut)
    leave = -leave
    chord = finish - begin
    gap = float(np.hypot(chord[0], chord[1]))
    if min(leave @ chord, arrive @ chord) < ARCHED * gap:
        return None
    t = np.linspace(0.0, 1.0, int(np.ceil(gap / SPACING)) + 2)[:, None]
    between = (
        (1 + 2 * t) * (1 - t) ** 2 * begin
        + t * (1 - t) ** 2 * gap * leave
        + t**2 * (3 - 2 * t) * finish
        - t**2 * (1 - t) * gap * arrive
    )
    return _cut(a, b, cut, between)


def _at(parabola: Array, along: float) -> tuple[Array, Array]:
    """Return the place and the unit direction of a parabola at an arc length."""
    place = parabola[0] + along * (parabola[1] + along * parabola[2])
    way = parabola[1] + 2.0 * along * parabola[2]
    return place, way / np.linalg.norm(way)


def _cut(a: Array, b: Array, length: float, between: Array) -> Joint:
    """Return the joint with ink of a length cut off at both ends."""
    arc_a, arc_b = arc_length(a), arc_length(b)
    before = a[: max(int(np.searchsorted(arc_a, arc_a[-1] - length)), 1)]
    return Joint(before, b[int(np.searchsorted(arc_b, length, side="right")) :], between)


def gap_between(before: Array, after: Array) -> float:
    """Return the distance from the end of one line to the start of the next."""
    return float(np.hypot(*(after[0] - before[-1])))
