"""Open splines in a row as one spline, joined by bridges of least bending.

The joined splines stay exactly what they are; only a stretch before each end may be cut back
where the bridge would bend too sharply. All in space, mm.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.geometry import DEGREE, Spline
from bozzetto.ink import arc_length
from bozzetto_symmetry.editing.trim import piece

CUT_BACK: Final = (0.0, *(float(share) for share in np.geomspace(0.002, 0.25, 15)))
"""Shares of the shorter curve that are tried to be cut back at both ends."""

CUTTING_PRICE: Final = 25.0
"""Price of cutting back against bending: a kink of half a radian is rounded over a
twentieth of the shorter curve."""

TOUCHING: Final = 1e-7
"""Gap, as a share of the shorter curve, and turn, radians, that count as none."""

SLOW: Final = 1e-3
"""Least speed, as a share of the greatest, that bending is divided by: near a cusp it has no
other bound."""

LOOKS: Final = 256
"""Places by which lengths and bending are measured."""


class _End(NamedTuple):
    """An end of a spline: its place, mm, its direction, and the speed of the parameter."""

    point: Array
    direction: Array
    speed: float


def bridge(first: Spline, second: Spline) -> Spline:
    """Return one spline along the first to its end, over a bridge, and along the second.

    The directions agree at both ends of the bridge, and so does the parameter's speed. The
    bridge, and how far the ends are cut back, are those of least bending (the integral of
    the squared curvature times the length of the shorter curve) and least price of what is
    cut back. Where the ends meet in one direction there is no bridge.

    Parameters
    ----------
    first, second : Spline
        Open, with clamped ends.

    Raises
    ------
    UserError
        If an end has no direction, or the ends coincide and point back at one another.
    """
    return chain(_with_bridge(first, second, loop=False))


def close_with_bridge(spline: Spline) -> Spline:
    """Return a closed spline over 0 … 1: along an open one, and over a bridge back to its start.

    It begins in the middle of the bridge. Ends are cut back as `bridge` does.

    Raises
    ------
    UserError
        As `bridge`.
    """
    return close_chain(chain(_with_bridge(spline, spline, loop=True)))


def _with_bridge(first: Spline, second: Spline, *, loop: bool) -> list[Spline]:
    """Return the pieces in a row. For a loop the halves of the bridge stand at both ends."""
    length = min(first.length, second.length)
    best: tuple[float, list[Spline]] | None = None
    for share in CUT_BACK:
        cut = share * length
        before = _shortened(first, cut if loop else 0.0, cut)
        after = before if loop else _shortened(second, cut, 0.0)
        here, there = _end(before, last=True), _end(after, last=False)
        gap = float(np.linalg.norm(there.point - here.point)) / length
        turn = float(np.linalg.norm(there.direction - here.direction))
        even = not loop or abs(here.speed - there.speed) <= TOUCHING * here.speed
        bridge: tuple[Spline, ...] = ()
        price = 2.0 * CUTTING_PRICE * share
        if gap > TOUCHING:
            bridge = (_bridge(here, there, paced=loop),)
            saved = _bending(first, last=True, cut=cut) + _bending(second, last=False, cut=cut)
            price += length * max(0.0, _bending(bridge[0]) - saved)
        elif turn > TOUCHING or not even:
            continue
        if best is None or price < best[0]:
            halves = bridge[0].split(0.5) if bridge else ()
            best = price, [*halves[1:], before, *halves[:1]] if loop else [before, *bridge, after]
    if best is None:
        raise UserError("These ends point back at one another. Join other ends.")
    return best[1]


def _end(spline: Spline, *, last: bool) -> _End:
    at = spline.range[1 if last else 0]
    velocity = spline.derivative([at])[0]
    speed = float(np.linalg.norm(velocity))
    if not speed > TOUCHING * float(np.ptp(spline.control_points, axis=0).max()):
        raise UserError("The curve has no direction at this end. Join another one.")
    return _End(spline.value([at])[0], velocity / speed, speed)


def _bridge(here: _End, there: _End, *, paced: bool) -> Spline:
    """Return the cubic between two ends that follows a circle where one touches both.

    Its speeds are chord / cos²(θ/4) for a turn of θ, those of a circle's arc; for a loop
    they are as different as the speeds of the curve's ends.
    """
    chord = float(np.linalg.norm(there.point - here.point))
    cosine = float(np.clip(here.direction @ there.direction, -1.0, 1.0))
    speed = chord / np.cos(0.25 * np.arccos(cosine)) ** 2
    pace = float(np.sqrt(here.speed / there.speed)) if paced else 1.0
    points = np.stack(
        (
            here.point,
            here.point + speed * pace / DEGREE * here.direction,
            there.point - speed / pace / DEGREE * there.direction,
            there.point,
        )
    )
    return Spline.uniform(points)


def _shortened(spline: Spline, start: float, end: float) -> Spline:
    """Return a spline without a stretch at its start and one at its end, both in mm."""
    if start == end == 0.0:
        return spline
    at, along = _along(spline)
    low, high = np.interp((start, along[-1] - end), along, at)
    return piece(spline, float(low), float(high))


def _along(spline: Spline) -> tuple[Array, Array]:
    at = np.linspace(*spline.range, LOOKS)
    return at, arc_length(spline.value(at))


def _bending(spline: Spline, *, last: bool = False, cut: float | None = None) -> float:
    """Return the integral of the squared curvature, 1/mm, along a spline or a stretch at its end.

    The stretch is `cut` mm long, and is the last one of the spline if `last`.
    """
    low, high = spline.range
    if cut is not None:
        at, along = _along(spline)
        if last:
            low = float(np.interp(along[-1] - cut, along, at))
        else:
            high = float(np.interp(cut, along, at))
    at = np.linspace(low, high, LOOKS)
    first, second = spline.derivative(at), spline.derivative(at, 2)
    speed = np.linalg.norm(first, axis=1)
    speed = np.maximum(speed, SLOW * max(1e-300, float(speed.max())))
    curved = np.linalg.norm(np.cross(first, second), axis=1)
    return float(np.trapezoid(curved**2 / speed**5, at))


def chain(parts: list[Spline]) -> Spline:
    """Return splines that meet in one direction as one spline of continuous speed.

    It begins with the parameters of the first.
    """
    whole = parts[0]
    for part in parts[1:]:
        meeting = whole.range[1]
        pace = _end(part, last=False).speed / _end(whole, last=True).speed
        later = meeting + pace * (part.knots[DEGREE + 1 :] - part.range[0])
        whole = Spline(
            np.concatenate((whole.knots[: -DEGREE - 1], (meeting, meeting), later)),
            np.vstack((whole.control_points[:-1], part.control_points[1:])),
        )
    return whole


def close_chain(spline: Spline) -> Spline:
    """Return an open spline whose ends meet with one velocity as a closed one over 0 … 1."""
    rounds = chain([spline, spline, spline])
    count = len(spline.control_points) - 2
    # The middle round, from the second of the two knots where it begins.
    first = len(spline.control_points) + 1 - DEGREE
    knots = rounds.knots[first : first + count + 2 * DEGREE + 1]
    begin, end = float(knots[DEGREE]), float(knots[-DEGREE - 1])
    points = rounds.control_points[first : first + count]
    knots = (knots - begin) / (end - begin)
    return Spline(knots, np.vstack((points, points[:DEGREE])), closed=True)
