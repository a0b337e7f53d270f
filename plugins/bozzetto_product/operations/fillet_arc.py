"""Arcs that round a corner between two curves."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from bozzetto.arrays import Array, cross_product
from bozzetto.errors import UserError
from bozzetto.geometry import Spline
from bozzetto_product.operations.pieces import chained
from bozzetto_product.operations.tangents import end_direction
from bozzetto_product.projection.spline_basis import chord_length

PIECE: Final = np.pi / 6.0
"""Largest angle of an arc that is one cubic: it is off the circle by 2e-7 of the radius."""

NARROWEST: Final = 1e-3
"""Least angle, radians, between two directions that make a corner."""

EXACT: Final = 1e-9
"""Distance, as a share of the radius, between the centres over both curves that is none."""


class Side(NamedTuple):
    """A curve at a corner: its spline from the corner on, and the frame of the corner's plane."""

    spline: Spline
    origin: Array
    along: Array
    inward: Array


def sides_of(one: Spline, other: Spline) -> list[Side]:
    """Return both curves from the corner on, with the frame of the corner's plane."""
    ways = end_direction(one, 0.0), end_direction(other, 0.0)
    if np.linalg.norm(cross_product(*ways)) < np.sin(NARROWEST):
        raise UserError("These curves make no corner: they run on or back over one another.")
    sides = []
    for spline, way, toward in ((one, ways[0], ways[1]), (other, ways[1], ways[0])):
        inward = toward - (toward @ way) * way
        sides.append(Side(spline, one.control_points[0], way, inward / np.linalg.norm(inward)))
    return sides


def touching(sides: list[Side], radius: float) -> Array | None:
    """Return the parameters at which a circle touches both curves; None where it is too large.

    By least squares: over each curve lies the place at the radius across it; both places are one,
    the centre.
    """
    from scipy.optimize import least_squares

    frame = np.stack((sides[0].along, sides[0].inward))
    start, low, high = [], [], []
    cosine = float(sides[0].along @ sides[1].along)
    reach = radius * np.sqrt((1.0 + cosine) / max(1.0 - cosine, 1e-12))
    for side in sides:
        begin, end = side.spline.range
        share = min(0.9, reach / chord_length(side.spline))
        start.append(begin + share * (end - begin))
        low.append(begin)
        high.append(end)

    def apart(at: Array) -> Array:
        one, other = (_centre(side, frame, at[k], radius) for k, side in enumerate(sides))
        return np.asarray((one - other) / radius)

    found = least_squares(
        apart, start, bounds=(low, high), x_scale=np.subtract(high, low),
        xtol=1e-15, ftol=1e-15, gtol=1e-15,
    )  # fmt: skip
    inside = (found.x > low).all() and (found.x < high).all()
    if not inside or not np.linalg.norm(found.fun) <= EXACT:
        return None
    return np.asarray(found.x)


def _centre(side: Side, frame: Array, at: float, radius: float) -> Array:
    """Return the place at the radius across a curve, in the corner's plane, (2,)."""
    place = frame @ (side.spline.value([at])[0] - side.origin)
    way = frame @ side.spline.derivative([at])[0]
    way = way / np.linalg.norm(way)
    across = np.array((-way[1], way[0]))
    side_of = across if across @ (frame @ side.inward) > 0.0 else -across
    return np.asarray(place + radius * side_of)


def arc_between(sides: list[Side], at: Array, radius: float) -> Spline:
    """Return the arc between two curves, with their directions at its ends."""
    frame = np.stack((sides[0].along, sides[0].inward))
    upright = cross_product(*frame)
    origin = sides[0].origin
    ends = [side.spline.value([at[k]])[0] for k, side in enumerate(sides)]
    ways = [side.spline.derivative([at[k]])[0] for k, side in enumerate(sides)]
    ways = [-ways[0] / np.linalg.norm(ways[0]), ways[1] / np.linalg.norm(ways[1])]
    centre = _centre(sides[0], frame, at[0], radius)
    spokes = [frame @ (end - origin) - centre for end in ends]
    first = np.arctan2(spokes[0][1], spokes[0][0])
    across, same = np.linalg.det(np.stack(spokes)), float(spokes[0] @ spokes[1])
    turn = float(np.arctan2(across, same))
    count = max(1, int(np.ceil(abs(turn) / PIECE)))
    angles = first + turn * np.arange(count + 1) / count
    round_ = centre + radius * np.stack((np.cos(angles), np.sin(angles)), axis=1)
    tangent = np.sign(turn) * np.stack((-np.sin(angles), np.cos(angles)), axis=1)
    # Out of the corner's plane it rises steadily from one curve to the other.
    heights = np.array([float((end - origin) @ upright) for end in ends])
    slopes = np.array([float(way @ upright) / max(1e-9, np.hypot(*(frame @ way))) for way in ways])
    share = np.arange(count + 1) / count
    length = abs(turn) * radius
    height, slope = _hermite(share, heights, slopes * length)
    points = origin + round_ @ frame + height[:, None] * upright
    speeds = tangent @ frame + (slope / length)[:, None] * upright
    handle = 4.0 / 3.0 * np.tan(abs(turn) / count / 4.0) * radius
    points[0], points[-1] = ends
    pieces = [
        Spline.uniform(
            np.stack(
                (
                    points[k],
                    points[k] + handle * speeds[k],
                    points[k + 1] - handle * speeds[k + 1],
                    points[k + 1],
                )
            )
        )
        for k in range(count)
    ]
    return chained(pieces)[0]


def _hermite(share: Array, ends: Array, slopes: Array) -> tuple[Array, Array]:
    """Return values and slopes of the cubic with given ends and slopes over 0 … 1."""
    t = share
    value = (
        ends[0] * (1 + 2 * t) * (1 - t) ** 2
        + slopes[0] * t * (1 - t) ** 2
        + ends[1] * t**2 * (3 - 2 * t)
        - slopes[1] * t**2 * (1 - t)
    )
    slope = (
        6 * t * (1 - t) * (ends[1] - ends[0])
        + slopes[0] * (1 - t) * (1 - 3 * t)
        + slopes[1] * t * (3 * t - 2)
    )
    return value, slope
