"""Surfaces of revolution, exact: what a lathe turns out, cylinders among them."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from math import pi
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.errors import UserError
from bozzetto.geometry.basis import lifted, lowered, span_parameters
from bozzetto.geometry.brep.brep import FURTHEST, GAP, Brep, refuse_far
from bozzetto.geometry.brep.planes import LINE_KNOTS, plane_face
from bozzetto.geometry.brep.sewing import sewn
from bozzetto.geometry.brep.surface import BSplineSurface
from bozzetto.geometry.curve import Color, Curve
from bozzetto.geometry.refinement import refined

if TYPE_CHECKING:
    from bozzetto.arrays import Array

FULL: Final = 2.0 * pi

LEAST_ANGLE: Final = 1e-6
"""Least turn, radians: less is a line."""

SAME_ANGLE: Final = 1e-9
"""What a full turn may lack, radians, and be one."""

CORNER: Final = 1e-6
"""Sine of the angle by which a profile must turn at once to have a corner; a new face begins."""

SQUARE: Final = 1e-12
"""Departure of a straight piece from its place square to the axis that counts as none, as share
of its length and distance."""

SAMPLES: Final = 24
"""Places on every span of a profile at which its distance from the axis is looked at."""


def surface_of_revolution(
    profile: Curve,
    axis_point: ArrayLike,
    axis_direction: ArrayLike,
    angle: float = FULL,
    *,
    name: str = "brep",
    color: Color | None = None,
) -> Brep:
    """Return what a profile sweeps as it turns about an axis, as exact rational surfaces.

    The profile is cut at its corners, with a face for each smooth piece. More than half a turn,
    and what comes round to itself, is made of two halves: CAD programs differ in how they take
    a face that meets itself. Straight pieces square to the axis become plane discs and rings in
    a full turn. An end on the axis becomes a pole, or closes a disc.

    Parameters
    ----------
    profile : Curve
        mm. It may touch the axis and must not cross it.
    axis_point : (3,) array_like
        Any point of the axis, mm.
    axis_direction : (3,) array_like
        Of any length; the profile turns counter-clockwise about it.
    angle : float
        Radians, from `LEAST_ANGLE` up to a full turn. A part of a turn is left open at its two
        sides.
    name : str
        What the shape is called.
    color : (r, g, b), optional
        sRGB.

    Returns
    -------
    Brep
        Closed, looking outward, if the turn is full and the profile is closed or begins and ends
        on the axis. Otherwise normals look to the right of the profile, seen with the axis
        upward and the profile to its right.

    Raises
    ------
    UserError
        If the axis has no direction, the angle is out of range, or the profile crosses the axis
        or lies on it.
    """
    origin, axis = _axis(axis_point, axis_direction)
    if not LEAST_ANGLE <= angle <= FULL:
        raise UserError("The angle of a turn must be above 0° and at most 360°.")
    refuse_far(profile.control_points)
    profile = _onto_axis(profile.clamped(), origin, axis)
    full = FULL - angle <= SAME_ANGLE
    angle = FULL if full else angle
    _refuse_crossing(profile, origin, axis)
    ends = profile.control_points[[0, -1]]
    closes = bool((ends[0] == ends[1]).all()) or not _radii(ends, origin, axis).any()
    if full and closes and _swept(profile, origin, axis) < 0:
        profile = profile.reversed()
    turns = (0.0, 0.5 * angle, angle) if angle > pi else (0.0, angle)
    parts = []
    for piece in smooth_pieces(profile):
        radii = _radii(piece.control_points, origin, axis)
        if not radii.any():
            continue  # a straight piece along the axis sweeps nothing
        if full and _is_square(piece, origin, axis):
            parts.append(_disc(piece, origin, axis))
        else:
            for start, end in pairwise(turns):
                parts.append(Brep.of_surface(revolved(piece, origin, axis, end - start, start)))
    if not parts:
        raise UserError("The profile lies on the axis, or is a point. Draw it beside the axis.")
    return sewn(parts, name, color)


def cylinder(
    start: ArrayLike,
    end: ArrayLike,
    radius: float,
    *,
    name: str = "brep",
    color: Color | None = None,
) -> Brep:
    """Return a solid cylinder between the middles of its two discs.

    Parameters
    ----------
    start, end : (3,) array_like
        mm, apart.
    radius : float
        mm, above 0.
    name : str
        What the shape is called.
    color : (r, g, b), optional
        sRGB.

    Raises
    ------
    UserError
        If it has no height or no radius.
    """
    first, last = np.asarray(start, float), np.asarray(end, float)
    refuse_far(np.concatenate((first, last)))
    if not 0.0 < radius < FURTHEST:
        raise UserError("The radius of a cylinder must be above zero, and not endless.")
    _, axis = _axis(first, last - first)
    aside = radius * _square_to(axis)
    corners = np.array((first, first + aside, last + aside, last))
    profile = Curve(1, np.array((0.0, 0.0, 1.0, 2.0, 3.0, 3.0)), corners)
    return surface_of_revolution(profile, first, axis, name=name, color=color)


def revolved(
    profile: Curve,
    axis_point: ArrayLike,
    axis_direction: ArrayLike,
    angle: float,
    start: float = 0.0,
) -> BSplineSurface:
    """Return the surface that a profile sweeps in half a turn or less, untrimmed.

    The arc is one rational cubic: the quadratic one (Piegl & Tiller 1997, "The NURBS book", 7.3)
    of a degree more, in which half a turn has no point at infinity. So the surface is smooth in
    its parameters, too. Three knots are put in, for programs that integrate span by span.

    Parameters
    ----------
    profile : Curve
        Clamped, mm.
    axis_point, axis_direction
        As in `surface_of_revolution`.
    angle : float
        Radians, above 0, at most π.
    start : float
        Angle from the profile to where the surface begins, radians.

    Returns
    -------
    BSplineSurface
        u runs from `start` over `angle`, and is the angle at both ends and in the middle; v is
        the profile's parameter.
    """
    origin, axis = _axis(axis_point, axis_direction)
    foot = origin + ((profile.control_points - origin) @ axis)[:, None] * axis
    out = profile.control_points - foot
    first, middle, last = _directions(start + angle * np.array((0.0, 0.5, 1.0)))
    inner = 1.0 + 2.0 * float(_directions(np.array((0.5 * angle,)))[0, 0])
    arc = np.stack((first, (first + 2.0 * middle) / inner, (2.0 * middle + last) / inner, last))
    bezier = np.repeat((start, start + angle), 4)
    knots = np.insert(bezier, 4, start + 0.25 * angle * np.arange(1, 4))
    corners = lifted(arc, np.array((1.0, inner / 3.0, inner / 3.0, 1.0)))
    arc, arc_weights = lowered(refined(3, bezier, corners, knots))
    if arc_weights is None:  # an angle so small that its arc is straight
        arc_weights = np.ones(len(arc))
    net = foot + arc[:, :1, None] * out + arc[:, 1:, None] * np.cross(axis, out)
    along = np.ones(len(out)) if profile.weights is None else profile.weights
    weights = arc_weights[:, None] * along
    return BSplineSurface((3, profile.degree), knots, profile.knots, net, weights)


def smooth_pieces(curve: Curve) -> list[Curve]:
    """Return the pieces of a clamped curve between its corners, none of them closed or a point."""
    degree, knots = curve.degree, curve.knots
    begin, end = curve.range
    places, first, times = np.unique(knots, return_index=True, return_counts=True)
    cuts = [begin]
    for place, start, count in zip(places.tolist(), first.tolist(), times.tolist(), strict=True):
        if begin < place < end and count >= degree:
            if count > degree:
                raise UserError("The profile has a gap. Join its pieces first.")
            if _turns(curve.control_points, start - 1):
                cuts.append(place)
    cuts.append(end)
    pieces = [_between(curve, low, high) for low, high in pairwise(cuts)]
    pieces = [piece for piece in pieces if np.ptp(piece.control_points, axis=0).any()]
    return [part for piece in pieces for part in _unclosed(piece)]


def _unclosed(curve: Curve) -> list[Curve]:
    """Return a clamped curve, in halves if it ends where it begins."""
    if (curve.control_points[0] != curve.control_points[-1]).any():
        return [curve]
    begin, end = curve.range
    middle = 0.5 * (begin + end)
    places, times = np.unique(curve.knots, return_counts=True)
    joints = places[(times == curve.degree) & (np.abs(places - middle) < 0.25 * (end - begin))]
    if len(joints):  # where it can be cut without new numbers
        middle = float(joints[np.argmin(np.abs(joints - middle))])
    return [_between(curve, begin, middle), _between(curve, middle, end)]


def _turns(points: Array, number: int) -> bool:
    """Whether a curve has a corner at one of its control points that it passes."""
    apart = np.flatnonzero((points != points[number]).any(axis=1))
    earlier, later = apart[apart < number], apart[apart > number]
    if not len(earlier) or not len(later):
        return False
    before, after = points[number] - points[earlier[-1]], points[later[0]] - points[number]
    sine = float(np.linalg.norm(np.cross(before, after)))
    scale = float(np.linalg.norm(before) * np.linalg.norm(after))
    return sine > CORNER * scale or float(before @ after) < 0.0


def _between(curve: Curve, low: float, high: float) -> Curve:
    """Return the piece of a clamped curve between two parameters at which it has full knots."""
    inner = curve.knots[(curve.knots > low) & (curve.knots < high)]
    ends = np.ones(curve.degree + 1)
    return curve.with_knots(np.concatenate((low * ends, inner, high * ends)))


def _axis(point: ArrayLike, direction: ArrayLike) -> tuple[Array, Array]:
    origin, axis = np.asarray(point, float), np.asarray(direction, float)
    with np.errstate(over="ignore", invalid="ignore"):
        length = float(np.linalg.norm(axis))
    if origin.shape != (3,) or axis.shape != (3,) or not np.isfinite(origin).all():
        raise UserError("An axis needs a point and a direction in space.")
    if not 0.0 < length < np.inf:
        raise UserError("The axis has no direction. Draw it longer.")
    return origin, axis / length


def _onto_axis(profile: Curve, origin: Array, axis: Array) -> Curve:
    """Return the profile with control points that nearly lie on the axis put there; ends joined."""
    points = profile.control_points.copy()
    near = GAP * float(np.linalg.norm(np.ptp(np.vstack((points, origin)), axis=0)))
    foot = origin + ((points - origin) @ axis)[:, None] * axis
    on_axis = np.linalg.norm(points - foot, axis=1) <= near
    points[on_axis] = foot[on_axis]
    if np.linalg.norm(points[0] - points[-1]) <= near:
        points[-1] = points[0]
    return replace(profile, control_points=points)


def _radii(points: Array, origin: Array, axis: Array) -> Array:
    """Return distances from the axis, with 0 for rounding, (n,)."""
    out = (points - origin) - ((points - origin) @ axis)[:, None] * axis
    radii = np.linalg.norm(out, axis=1)
    scale = np.abs(points - origin).max() + np.abs(origin).max()
    return np.where(radii <= 1e-14 * scale, 0.0, radii)


def _refuse_crossing(profile: Curve, origin: Array, axis: Array) -> None:
    """Refuse a profile that crosses the axis; it may touch it."""
    points = profile.value(span_parameters(profile.degree, profile.knots, SAMPLES))
    beside = _radii(points, origin, axis) > 0.0  # on the axis, the side is rounding
    out = (points - origin)[beside]
    out -= (out @ axis)[:, None] * axis
    crosses = np.einsum("nk,nk->n", out[:-1], out[1:]) < 0.0
    if crosses.any():
        raise UserError("The profile crosses the axis. Draw it on one side of the axis.")


def _swept(profile: Curve, origin: Array, axis: Array) -> float:
    """Return the sign of the volume that a closed profile sweeps: that of ∫ r² dz."""
    points = profile.value(span_parameters(profile.degree, profile.knots, SAMPLES)) - origin
    heights = points @ axis
    squares = np.einsum("nk,nk->n", points, points) - heights**2
    return float(0.5 * (squares[:-1] + squares[1:]) @ np.diff(heights))


def _is_square(piece: Curve, origin: Array, axis: Array) -> bool:
    """Whether a piece is a straight line that meets an axis, or would, at a right angle."""
    points = piece.control_points - piece.control_points[0]
    length = float(np.linalg.norm(points[-1]))
    if not length > 0.0:
        return False
    along = points[-1] / length
    out = piece.control_points[[0, -1]] - origin
    out -= (out @ axis)[:, None] * axis
    aside = [points - (points @ along)[:, None] * along, out - (out @ along)[:, None] * along]
    furthest = max(float(np.abs(values).max()) for values in (*aside, points @ axis))
    return furthest <= SQUARE * (length + float(np.abs(out).max()))


def _disc(piece: Curve, origin: Array, axis: Array) -> Brep:
    """Return the plane disc or ring that a straight piece square to the axis sweeps."""
    ends = piece.control_points[[0, -1]]
    radii = _radii(ends, origin, axis)
    order = np.argsort(-radii)
    circles = [_circle(ends[i], origin, axis) for i in order if radii[i] > 0.0]
    return plane_face(circles, normal=axis if radii[1] < radii[0] else -axis)


def _circle(point: Array, origin: Array, axis: Array) -> list[Curve]:
    """Return the half circles that a point runs, as the border of revolved surfaces has them."""
    stub = Curve(1, LINE_KNOTS, np.stack((point, point + axis)))
    halves = [revolved(stub, origin, axis, pi, start) for start in (0.0, pi)]
    return [
        Curve(3, half.knots_u, half.control_points[:, 0], half.weights[:, 0])
        for half in halves
        if half.weights is not None
    ]


def _directions(turns: Array) -> Array:
    """Return cosines and sines of angles, exact at quarter turns, (n, 2)."""
    quarters = turns / (0.5 * pi)
    whole = np.abs(quarters - np.rint(quarters)) < SQUARE
    found = np.stack((np.cos(turns), np.sin(turns)), axis=1)
    return np.where(whole[:, None], np.rint(found), found)


def _square_to(axis: Array) -> Array:
    """Return a unit vector square to another, along a coordinate axis where it can be."""
    other = np.eye(3)[np.argmin(np.abs(axis))]
    aside = other - (other @ axis) * axis
    return np.asarray(aside / np.linalg.norm(aside))
