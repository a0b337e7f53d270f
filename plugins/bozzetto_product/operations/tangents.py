"""Directions of curves at their ends, and curves that run into one another without a kink."""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.geometry import Spline
from bozzetto_product.model.joints import Meeting
from bozzetto_product.model.state import ProductState
from bozzetto_product.operations.meetings import curve_of, is_end, joint_of, splines_of
from bozzetto_product.operations.settling import settled_state
from bozzetto_product.projection.planes import mirror_image

NO_LENGTH: Final = 1e-12
"""Length, as a share of the size of a curve, that gives no direction."""


SQUARE: Final = 15.0
"""Angle between the end of a curve and the normal of the symmetry plane, degrees, up to which the
curve is meant to run smoothly into its mirror image: twice what a hand is off."""


RUN_ON: Final = 10.0
"""Angle at which two curves that end in one joint meet, degrees, up to which one is meant to run on
into the other: as that at which a side of a surface ends."""


def end_direction(spline: Spline, at: float) -> Array:
    """Return the unit vector from an end of an open curve into it.

    Raises
    ------
    UserError
        If the curve has no direction there.
    """
    points = spline.control_points if at == 0.0 else spline.control_points[::-1]
    size = float(np.ptp(points, axis=0).max())
    for point in points[1:]:
        way = point - points[0]
        length = float(np.linalg.norm(way))
        if length > NO_LENGTH * size:
            return np.asarray(way / length)
    raise UserError("The curve has no direction at this end. Draw it anew.")


def with_end_direction(spline: Spline, at: float, direction: Array) -> Spline:
    """Return an open curve with another direction at an end; the end itself stays.

    The control point beside the end is turned, as far away as it was.

    Parameters
    ----------
    spline : Spline
        In space, mm.
    at : {0, 1}
        Which end.
    direction : (3,) float
        Unit vector from the end into the curve.
    """
    points = np.array(spline.control_points)
    end, beside = (0, 1) if at == 0.0 else (-1, -2)
    reach = float(np.linalg.norm(points[beside] - points[end]))
    points[beside] = points[end] + reach * direction
    return Spline(spline.knots, points)


def match_tangents(
    state: ProductState, joint_id: str, first: str, second: str, *, lead: str = ""
) -> ProductState:
    """Return the network with two curves that run into one another at a joint without a kink.

    Parameters
    ----------
    state : ProductState
        The network, in the frame of the model.
    joint_id : str
        Id of the joint.
    first, second : str
        Ids of the curves, which end there.
    lead : str
        Id of the one that keeps its direction; default both give way.

    Raises
    ------
    UserError
        If the curves do not both end there, or run back over one another.
    """
    joint, splines = joint_of(state, joint_id), splines_of(state)
    ends = {
        meet.curve: meet
        for meet in joint.meetings
        if meet.curve in (first, second) and meet.curve in splines and is_end(splines, meet)
    }
    if len(ends) < 2:
        raise UserError("Two curves that end in one joint can be matched. Choose two of them.")
    ways = {}
    for name, meet in ends.items():
        way = end_direction(splines[name], meet.at)
        ways[name] = _across(way, state) if meet.mirrored else way
    one, other = ways[first], ways[second]
    if float(one @ other) > 0.999:
        raise UserError("These curves run back over one another. Move one of them first.")
    along = one - other
    along = along / np.linalg.norm(along)
    if lead == first:
        along = one
    elif lead == second:
        along = -other
    new = {}
    for name, way in ((first, along), (second, -along)):
        if name == lead:
            continue
        inward = _across(way, state) if ends[name].mirrored else way
        curve = curve_of(state, name)
        if curve.plane is not None:
            normal = np.asarray(curve.plane.normal)
            inward = inward - (inward @ normal) * normal
            length = float(np.linalg.norm(inward))
            if not length > NO_LENGTH:
                raise UserError("One curve stays in its plane, and the other runs across it.")
            inward = inward / length
        new[name] = with_end_direction(splines[name], ends[name].at, inward)
    return settled_state(state, new)


def smooth_over_plane(state: ProductState, meetings: Iterable[Meeting]) -> ProductState:
    """Return the network with curves that run on into their mirror images without a kink.

    Both meet at twice the angle that an end is off the normal of the symmetry plane, so that every
    surface beside has a kink there, too. Ends that are nearly square to the plane are set square.

    Parameters
    ----------
    state : ProductState
        The network, in the frame of the model.
    meetings : iterable of Meeting
        Ends of curves in the symmetry plane; those that are not square by far stay.
    """
    splines = splines_of(state)
    normal = np.asarray(state.symmetry.normal)
    new: dict[str, Spline] = {}
    for meet in meetings:
        spline = new.get(meet.curve, splines[meet.curve])
        curve = curve_of(state, meet.curve)
        if not curve.mirrored or curve.plane is not None or not is_end(splines, meet):
            continue
        way = end_direction(spline, meet.at)
        upright = float(way @ normal)
        if abs(upright) >= np.cos(np.radians(SQUARE)):
            new[meet.curve] = with_end_direction(spline, meet.at, np.sign(upright) * normal)
    return settled_state(state, new) if new else state


def smooth_over_joints(state: ProductState, joints: Iterable[str]) -> ProductState:
    """Return the network with curves that nearly run on into one another doing so.

    Two that were drawn as one line in two goes meet at some degrees, and the surfaces beside have a
    corner there that CAD cuts them at. Both give way, but a curve that stays in a plane. Both ends
    of one curve are two such: a ring is drawn so, and does not close to the last degree.

    Parameters
    ----------
    state : ProductState
        The network, in the frame of the model.
    joints : iterable of str
        Ids of joints; at those in the symmetry plane curves run on into their mirror images.
    """
    for name in joints:
        joint, splines = joint_of(state, name), splines_of(state)
        ends = []
        for meet in joint.meetings:
            if meet.curve in splines and is_end(splines, meet) and _has_length(splines[meet.curve]):
                way = end_direction(splines[meet.curve], meet.at)
                ends.append((meet, _across(way, state) if meet.mirrored else way))
        pairs = [
            (one, other)
            for (one, way), (other, back) in itertools.combinations(ends, 2)
            if float(way @ back) <= -np.cos(np.radians(RUN_ON))
        ]
        used = [meet for pair in pairs for meet in pair]
        for one, other in pairs:
            if used.count(one) + used.count(other) > 2:
                continue
            if one.curve == other.curve:
                if not (joint.in_plane and curve_of(state, one.curve).mirrored):
                    state = _closed_smoothly(state, one.curve)
                continue
            pair = one.curve, other.curve
            flat = [each for each in pair if curve_of(state, each).plane is not None]
            if len(flat) < 2 and not joint.in_plane:
                state = match_tangents(state, name, *pair, lead="".join(flat))
    return state


def _closed_smoothly(state: ProductState, name: str) -> ProductState:
    """Return the network with a curve that ends where it begins, and has no corner there.

    Each end gives way by half; a curve that stays in a plane has both directions in it already.
    """
    spline = splines_of(state)[name]
    along = end_direction(spline, 0.0) - end_direction(spline, 1.0)
    along = along / np.linalg.norm(along)
    turned = with_end_direction(with_end_direction(spline, 0.0, along), 1.0, -along)
    return settled_state(state, {name: turned})


def _has_length(spline: Spline) -> bool:
    points = spline.control_points
    return bool(np.isfinite(points).all() and np.ptp(points, axis=0).max() > 0.0)


def _across(direction: Array, state: ProductState) -> Array:
    """Return the mirror image of a direction."""
    point = np.asarray(state.symmetry.point)
    return np.asarray(mirror_image(point + direction, state.symmetry) - point)
