"""Joins of curves in space; in the frame of the plane (y = 0), mm."""

from __future__ import annotations

from bozzetto.errors import UserError
from bozzetto.geometry import Spline
from bozzetto_symmetry.editing.bridge import bridge, chain, close_chain, close_with_bridge
from bozzetto_symmetry.editing.trim import piece
from bozzetto_symmetry.fitting.half_curve import halves_of, symmetrize
from bozzetto_symmetry.fitting.space_curve import SpaceCurve

_CLOSED = "A closed curve has no end to join. Split it first."


def join_curves(
    curve: SpaceCurve, end: int, other: SpaceCurve, other_end: int, *, mirrored: bool = False
) -> SpaceCurve:
    """Return two curves as one that runs smoothly over the place where they meet.

    Parameters
    ----------
    curve, other : SpaceCurve
        Of a pair and another pair comes a pair; of a curve across the plane and a pair,
        which goes on beyond its free ends, a longer one; of two curves across the plane a
        ring; of two in the plane one in the plane.
    end, other_end : {0, 1}
        Which ends meet; of a curve across the plane its one free end is 1.
    mirrored : bool
        The mirror image of the other curve is joined.

    Returns
    -------
    SpaceCurve
        In the sense of the first curve.

    Raises
    ------
    UserError
        If one is closed, or one lies in the plane and the other does not.
    """
    if curve.closed or other.closed:
        raise UserError(_CLOSED)
    if "plane" in (curve.reading, other.reading) and curve.reading != other.reading:
        raise UserError(
            "A curve in the centre plane and one beside it cannot be one curve. Snap their "
            "ends to one another instead."
        )
    if other.reading == "self" and curve.reading == "pair":
        return join_curves(other, 1, curve, end, mirrored=mirrored)
    added = _image(other.spline) if mirrored else other.spline
    added = added.reversed() if other_end == 1 or other.reading == "self" else added
    if curve.reading != "self":
        base = curve.spline if end == 1 else curve.spline.reversed()
        spline = bridge(base, added)
        return SpaceCurve(curve.reading, spline if end == 1 else spline.reversed())
    half = _half(curve.spline)
    if other.reading == "self":
        back = piece(added, added.range[0], halves_of(added).middle)
        return SpaceCurve("self", _ring(bridge(half, back)))
    return SpaceCurve("self", _unfolded(bridge(half, added)))


def join_across(curve: SpaceCurve, end: int) -> SpaceCurve:
    """Return a curve joined to its own mirror image, crossing the plane at a right angle.

    One of a pair becomes a curve across the plane; that becomes a ring.

    Parameters
    ----------
    curve : SpaceCurve
        One of a pair, or a curve across the plane.
    end : {0, 1}
        The end at the plane; of a curve across the plane its free end is taken.

    Raises
    ------
    UserError
        If the curve is closed, or lies in the plane.
    """
    if curve.closed:
        raise UserError(_CLOSED)
    if curve.reading == "plane":
        raise UserError("A curve in the centre plane is its own mirror image already.")
    if curve.reading == "pair":
        away = curve.spline if end == 0 else curve.spline.reversed()
        return SpaceCurve("self", symmetrize(bridge(_image(away).reversed(), away)))
    # From the new crossing back to the old one; a ring begins at the old one.
    ring = close_with_bridge(curve.spline.reversed())
    return SpaceCurve("self", _ring(piece(ring, 0.0, 0.5).reversed()))


def close_up(curve: SpaceCurve) -> SpaceCurve:
    """Return a curve whose two ends are joined to one another.

    Raises
    ------
    UserError
        If it is closed already.
    """
    if curve.reading == "self":
        return join_across(curve, 1)
    if curve.closed:
        raise UserError(_CLOSED)
    return SpaceCurve(curve.reading, close_with_bridge(curve.spline))


def _image(spline: Spline) -> Spline:
    return spline.mirrored((0.0, 1.0, 0.0))


def _half(spline: Spline) -> Spline:
    halves = halves_of(spline)
    return piece(spline, halves.middle, halves.end)


def _unfolded(half: Spline) -> Spline:
    """Return the curve across the plane from its half, leaving the plane at a right angle."""
    return symmetrize(chain([_image(half).reversed(), half]))


def _ring(half: Spline) -> Spline:
    """Return the closed curve across the plane whose half runs from the plane to the plane."""
    return symmetrize(close_chain(chain([half, _image(half).reversed()])))
