"""Curves of a file that go on over one another: each was drawn a little into the other.

Both would be joined wherever they touch, and slivers between them would be surfaces. Both end where
a third curve passes, for there they were to meet; else one is cut where the other begins. What a
hand drew too far may lie beside the other curve, as long as nothing else ends there and a third
curve passes.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np

from bozzetto.geometry import Spline
from bozzetto_product.hand_over.point_joints import met
from bozzetto_product.projection.spline_basis import chord_length

TAIL: Final = 0.25
"""Longest stretch that two curves share, as share of the length of either."""

LOOKS: Final = 9
"""Places of a stretch that are looked at."""

SHORTEST: Final = 1.5
"""Length of a stretch, in its width, below which the ends just meet."""

BESIDE: Final = 1e-2
"""Largest width of a stretch at the ends of which nothing else ends, as share of the diagonal: what
crosses so near is joined."""

ALONG: Final = float(np.cos(np.radians(15.0)))
"""Cosine of the largest angle between curves that go the same way."""


def without_overlaps(splines: Sequence[Spline], tolerance: float, size: float) -> list[Spline]:
    """Return curves without the stretch at an end that another curve goes over as well.

    Parameters
    ----------
    splines : sequence of Spline
        In space, mm.
    tolerance : float
        Distance up to which curves lie on one another, mm.
    size : float
        Diagonal of the network, mm.

    Returns
    -------
    list of Spline
        In their order. Two curves that go on over one another are cut where a third one crosses
        them there; where none does the longer one is cut, where the other begins.
    """
    made = list(splines)
    lengths = [chord_length(spline) for spline in splines]
    order = sorted(
        (number for number, spline in enumerate(splines) if not spline.closed),
        key=lambda number: (-lengths[number], *splines[number].control_points[0].tolist()),
    )
    rank = {number: place for place, number in enumerate(order)}
    lone = _lone_ends(splines, tolerance)
    wide = max(tolerance, BESIDE * size)
    for longer, shorter in sorted(
        _near(splines, order, lengths), key=lambda pair: (rank[pair[0]], rank[pair[1]])
    ):
        reach = TAIL * lengths[shorter]
        for last in (True, False):
            width = wide if (longer, last) in lone else tolerance
            found = _shared_from(made[longer], made[shorter], last, reach, tolerance, width)
            if found is None or (found.width > tolerance and (shorter, found.last) not in lone):
                continue
            others = [one for k, one in enumerate(splines) if k not in (longer, shorter)]
            near = wide if found.width > tolerance else tolerance
            middle = _crossed_at(made[longer], found.begin, last, others, near)
            if middle is None and found.width > tolerance:
                continue
            if middle is not None:
                place = made[longer].value([middle])
                made[shorter] = _longest_part(made[shorter], *made[shorter].foot_points(place))
            made[longer] = _longest_part(made[longer], found.begin if middle is None else middle)
    return made


def _lone_ends(splines: Sequence[Spline], tolerance: float) -> set[tuple[int, bool]]:
    """Return the curves, and whether the last of their ends is meant, where no other one ends."""
    from scipy.spatial import cKDTree

    rows = [
        (number, last, spline.control_points[-1 if last else 0])
        for number, spline in enumerate(splines)
        if not spline.closed
        for last in (False, True)
    ]
    if not rows:
        return set()
    ends = np.array([place for _, _, place in rows])
    near = cKDTree(ends).query_ball_point(ends, tolerance, return_length=True)
    return {(number, last) for (number, last, _), count in zip(rows, near, strict=True)
            if count == 1}  # fmt: skip


def _near(
    splines: Sequence[Spline], order: Sequence[int], lengths: Sequence[float]
) -> set[tuple[int, int]]:
    """Return pairs of curves, the first of them earlier, of which ends are near one another."""
    from scipy.spatial import cKDTree

    if not order:
        return set()
    ends = np.concatenate([splines[number].control_points[[0, -1]] for number in order])
    reach = TAIL * np.repeat([lengths[number] for number in order], 2)
    return {
        (order[one // 2], order[other // 2])
        for one, row in enumerate(cKDTree(ends).query_ball_point(ends, reach))
        for other in row
        if one // 2 < other // 2
    }


def _longest_part(spline: Spline, at: float) -> Spline:
    """Return the longer part of a curve that is cut at a parameter; all of it if that is an end."""
    begin, end = spline.range
    if not begin < at < end:
        return spline
    return max(spline.split(at), key=chord_length)


def _crossed_at(
    one: Spline, share: float, last: bool, others: Sequence[Spline], tolerance: float
) -> float | None:
    """Return where on a curve, from a parameter to its end, another one crosses it; None if none.

    The place nearest to the middle of that stretch; one end of it for what passes just beside it.
    """
    stretch = np.linspace(share, one.range[1 if last else 0], LOOKS)
    points = one.value(stretch)
    found = []
    for other in others:
        box = other.control_points
        if (points.max(0) + tolerance < box.min(0)).any() or (
            box.max(0) + tolerance < points.min(0)
        ).any():
            continue
        nearest = points[int(np.argmin(other.least_distances(points)))]
        at, _, beyond, there = met(one, other, nearest)
        at = min(max(at, stretch.min()), stretch.max())
        here, way, across = (
            one.value([at])[0],
            one.derivative([at])[0],
            other.derivative([beyond])[0],
        )
        is_along = abs(way @ across) > ALONG * np.linalg.norm(way) * np.linalg.norm(across)
        if np.linalg.norm(here - there) <= tolerance and not is_along:
            found.append(at)
    return min(found, key=lambda at: abs(at - stretch.mean()), default=None)


class _Shared(NamedTuple):
    """A stretch at the end of a curve that another one goes over as well.

    Where it begins on the first curve, how far apart they are, mm, and whether it is at the last
    end of the other one.
    """

    begin: float
    width: float
    last: bool


def _shared_from(
    one: Spline, other: Spline, last: bool, reach: float, tolerance: float, widest: float
) -> _Shared | None:
    """Return the stretch up to an end of a curve that another one goes over; None if there is none.

    It may be as wide as `widest`, if it is long for that.
    """
    end = one.control_points[-1 if last else 0]
    low, high = other.control_points.min(axis=0), other.control_points.max(axis=0)
    if (end < low - widest).any() or (end > high + widest).any():
        return None
    for beginning in (0, -1):
        first = other.control_points[beginning]
        if not SHORTEST * tolerance < np.linalg.norm(end - first) <= reach:
            continue
        at = float(one.foot_points(first[None])[0])
        stretch = np.linspace(at, one.range[1 if last else 0], LOOKS)
        points = one.value(stretch)
        length = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
        if length > reach:
            continue
        feet = other.foot_points(points)
        width = float(np.linalg.norm(other.value(feet) - points, axis=1).max())
        if width > tolerance and width > min(widest, length / SHORTEST):
            continue
        ways, others = one.derivative(stretch), other.derivative(feet)
        sense = (1.0 if last else -1.0) * (1.0 if beginning == 0 else -1.0)
        cosines = sense * (ways * others).sum(axis=1)
        if (cosines > ALONG * np.linalg.norm(ways, axis=1) * np.linalg.norm(others, axis=1)).all():
            return _Shared(at, width, beginning == -1)
    return None
