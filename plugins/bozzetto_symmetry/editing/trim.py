"""Stretches of curves in space, exact to rounding; in the frame of the plane (y = 0), mm."""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto.errors import UserError
from bozzetto.geometry import Spline
from bozzetto_symmetry.fitting.half_curve import halves_of, symmetrize
from bozzetto_symmetry.fitting.space_curve import SpaceCurve

SHORTEST: Final = 1e-3
"""Least share of a curve that is kept: less is a dot."""

SLIVER: Final = 1e-11
"""Distance of a cut from a knot, as a share of the range, that counts as rounding."""


def trim(curve: SpaceCurve, begin: float, end: float) -> SpaceCurve:
    """Return a stretch of a curve.

    Shares of a curve across the plane count on its half, from the plane outwards (of a ring
    from one crossing to the other). A stretch that begins on the plane stays a curve across
    it; one that does not is one of a pair.

    Parameters
    ----------
    curve : SpaceCurve
        In the frame of the plane.
    begin, end : float
        Shares of the parameter range. On a closed curve that does not cross the plane
        `end` may be above 1: the stretch runs over the seam.

    Raises
    ------
    UserError
        If nothing would be left.
    """
    low, high = begin, end
    if curve.reading == "self" or not curve.closed:
        low, high = max(begin, 0.0), min(end, 1.0)
    if not SHORTEST <= high - low < float("inf"):
        raise UserError("Nothing would be left of the curve. Delete it instead.")
    spline = curve.spline
    if curve.reading != "self":
        first, last = spline.range
        if high - low >= 1.0 and not curve.closed:
            return curve
        reach = last - first
        high = min(high, low + 1.0)
        return SpaceCurve(curve.reading, piece(spline, first + low * reach, first + high * reach))
    halves = halves_of(spline)
    near = halves.middle + low * halves.span
    far = halves.middle + high * halves.span
    if low == 0.0 and high == 1.0:
        return curve
    if low == 0.0:
        kept = piece(spline, 2.0 * halves.middle - far, far)
        return SpaceCurve("self", symmetrize(kept))
    if halves.ring and high == 1.0:
        # About the other crossing; turned round, so that the half that counts comes second.
        kept = piece(spline, near, 2.0 * halves.end - near).reversed()
        return SpaceCurve("self", symmetrize(kept))
    return SpaceCurve("pair", piece(spline, near, far))


def piece(spline: Spline, low: float, high: float) -> Spline:
    """Return the open piece of a spline between two parameters; of a closed one it may run on."""
    low, high = _at_knot(spline, low), _at_knot(spline, high)
    if not spline.closed:
        begin, end = spline.range
        pieces = spline.split(low, high)
        return pieces[1] if low > begin and len(pieces) > 1 else pieces[0]
    begin, end = spline.range
    if high - low >= (end - begin) * (1.0 - 1e-12):
        return spline.split(low)[0]
    first, last = (float(u) for u in spline.within([low, high]))
    pieces = spline.split(first, last)
    return pieces[0] if first < last else pieces[-1]


def _at_knot(spline: Spline, at: float) -> float:
    """Return a parameter, or the knot beside it: a span of no width would have no direction."""
    begin, end = spline.range
    inside = float(spline.within([at])[0])
    knot = float(spline.knots[np.argmin(np.abs(spline.knots - inside))])
    return at + knot - inside if abs(knot - inside) <= SLIVER * (end - begin) else at


def share_of(curve: SpaceCurve, parameter: float) -> float:
    """Return the share, as `trim` takes it, of a parameter of a curve's spline."""
    if curve.reading == "self":
        halves = halves_of(curve.spline)
        away, _ = halves.folded([parameter])
        return float(away[0] / halves.span)
    begin, end = curve.spline.range
    return float((curve.spline.within([parameter])[0] - begin) / (end - begin))
