"""Curves of a file that go on over one another: each was drawn a little into the other.

Both would be joined wherever they touch, and slivers between them would be surfaces. One of them
is cut where the other begins.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from bozzetto.geometry import Spline
from bozzetto_product.projection.spline_basis import chord_length

TAIL: Final = 0.25
"""Longest stretch that two curves share, as share of the length of either."""

LOOKS: Final = 9
"""Places of a stretch that are looked at."""

SHORTEST: Final = 3.0
"""Length of a stretch, in tolerances, below which the ends just meet."""

ALONG: Final = float(np.cos(np.radians(15.0)))
"""Cosine of the largest angle between curves that go the same way."""


def without_overlaps(splines: Sequence[Spline], tolerance: float) -> list[Spline]:
    """Return curves without the stretch at an end that another curve goes over as well.

    Parameters
    ----------
    splines : sequence of Spline
        In space, mm.
    tolerance : float
        Distance up to which curves lie on one another, mm.

    Returns
    -------
    list of Spline
        In their order. Of two curves that go on over one another the longer one is cut, where the
        other begins.
    """
    made = list(splines)
    lengths = [chord_length(spline) for spline in splines]
    order = sorted(
        (number for number, spline in enumerate(splines) if not spline.closed),
        key=lambda number: (-lengths[number], *splines[number].control_points[0].tolist()),
    )
    for place, longer in enumerate(order):
        for shorter in order[place + 1 :]:
            reach = TAIL * lengths[shorter]
            for last in (True, False):
                share = _shared_from(made[longer], made[shorter], last, reach, tolerance)
                if share is not None:
                    made[longer] = made[longer].split(share)[0 if last else 1]
    return made


def _shared_from(
    one: Spline, other: Spline, last: bool, reach: float, tolerance: float
) -> float | None:
    """Return the parameter of a curve from which on, up to an end, another one goes over it.

    None where there is no such stretch.
    """
    end = one.control_points[-1 if last else 0]
    low, high = other.control_points.min(axis=0), other.control_points.max(axis=0)
    if (end < low - tolerance).any() or (end > high + tolerance).any():
        return None
    for beginning in (0, -1):
        first = other.control_points[beginning]
        if not SHORTEST * tolerance < np.linalg.norm(end - first) <= reach:
            continue
        at = float(one.foot_points(first[None])[0])
        stretch = np.linspace(at, one.range[1 if last else 0], LOOKS)
        points = one.value(stretch)
        if np.linalg.norm(np.diff(points, axis=0), axis=1).sum() > reach:
            continue
        feet = other.foot_points(points)
        if np.linalg.norm(other.value(feet) - points, axis=1).max() > tolerance:
            continue
        ways, others = one.derivative(stretch), other.derivative(feet)
        sense = (1.0 if last else -1.0) * (1.0 if beginning == 0 else -1.0)
        cosines = sense * (ways * others).sum(axis=1)
        if (cosines > ALONG * np.linalg.norm(ways, axis=1) * np.linalg.norm(others, axis=1)).all():
            return at
    return None
