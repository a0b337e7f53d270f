"""Changes of one curve: straight, in a plane, symmetric; and joints that are moved."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.errors import UserError
from bozzetto.geometry import Spline
from bozzetto_product.model.curves import Curve
from bozzetto_product.model.joints import Joint, Meeting
from bozzetto_product.model.planes import Plane
from bozzetto_product.model.state import ProductState
from bozzetto_product.network.meetings import image_place
from bozzetto_product.network.reflection import Reflection
from bozzetto_product.operations.meetings import (
    curve_of,
    is_end,
    joint_of,
    laid_anew,
    spline_of,
    splines_of,
    unused_joint_ids,
)
from bozzetto_product.operations.pieces import delete_curves, split_curve
from bozzetto_product.operations.plane_crossings import lies_in, plane_crossings
from bozzetto_product.operations.settling import settled_state
from bozzetto_product.projection.planes import fitted_plane, heights, in_plane, mirror_image
from bozzetto_product.projection.spline_basis import bent, chord_length, greville

LOOKS: Final = 257
"""Places of a curve through which a plane is laid."""

NEAR: Final = 0.02
"""Distance of an end from the symmetry plane, as a share of the curve's length, within which it
is meant to lie in it."""


def straighten(state: ProductState, curve_id: str) -> ProductState:
    """Return the network with a curve made the straight line between its ends.

    Raises
    ------
    UserError
        If the curve is closed.
    """
    spline = spline_of(state, curve_id)
    if spline.closed:
        raise UserError("A closed curve cannot be straight. Split it first.")
    first, last = spline.control_points[0], spline.control_points[-1]
    points = first + greville(spline)[:, None] * (last - first)
    points[0], points[-1] = first, last
    return settled_state(laid_anew(state, curve_id), {curve_id: Spline(spline.knots, points)})


def make_planar(state: ProductState, curve_id: str, plane: Plane | None = None) -> ProductState:
    """Return the network with a curve laid in a plane, in which it stays from then on.

    Parameters
    ----------
    state : ProductState
        The network, in the frame of the model.
    curve_id : str
        Id of the curve.
    plane : Plane, optional
        Default the nearest one, through both ends of an open curve.

    Raises
    ------
    UserError
        If the curve is straight, and no plane is given.
    """
    curve, spline = curve_of(state, curve_id), spline_of(state, curve_id)
    points = spline.control_points
    ends = None if spline.closed else points[[0, -1]]
    own = plane is None
    flat_in = fitted_plane(spline.sampled(LOOKS), ends) if plane is None else plane
    flat = in_plane(points, flat_in)
    if own and not spline.closed:
        flat[0], flat[-1] = points[0], points[-1]
    made = Spline(spline.knots, flat, spline.closed)
    node = replace(curve, spline=made, plane=flat_in, told=())
    nodes = tuple(node if one.id == curve_id else one for one in state.nodes)
    return settled_state(replace(state, nodes=nodes), {curve_id: made})


def make_symmetric(state: ProductState, curve_id: str) -> ProductState:
    """Return the network with a curve that has its exact mirror image.

    Of a curve that crosses the plane the longer half is kept. Ends near the plane come to lie
    in it.

    Raises
    ------
    UserError
        If the curve is closed and crosses the plane not just twice.
    """
    spline = spline_of(state, curve_id)
    crossings = plane_crossings(spline, state.symmetry)
    name = curve_id
    if spline.closed and len(crossings) not in (0, 2):
        raise UserError("The curve crosses the symmetry plane in many places. Split it first.")
    if crossings:
        state, names = split_curve(state, curve_id, crossings)
        lengths = [chord_length(splines_of(state)[one]) for one in names]
        name = names[int(np.argmax(lengths))]
        state = delete_curves(state, *(one for one in names if one != name))
    state = state.with_node(replace(curve_of(state, name), mirrored=True))
    return state if spline_of(state, name).closed else _with_ends_in_plane(state, name)


def make_in_plane(state: ProductState, curve_id: str) -> ProductState:
    """Return the network with a curve laid in the symmetry plane, in which it stays."""
    curve = curve_of(state, curve_id)
    state = make_planar(state, curve_id, state.symmetry)
    state = state.with_node(replace(curve_of(state, curve_id), mirrored=False))
    joints = tuple(
        replace(joint, in_plane=True)
        if any(meet.curve == curve.id for meet in joint.meetings)
        else joint
        for joint in state.joints
    )
    return settled_state(_cut_at_plane(replace(state, joints=joints)), {})


def move_joint(state: ProductState, joint_id: str, place: ArrayLike) -> ProductState:
    """Return the network with a joint somewhere else; all curves that meet there go along.

    A curve that is its own mirror image stays so where the joint has a mirror image: its other half
    goes along.

    Parameters
    ----------
    state : ProductState
        The network, in the frame of the model.
    joint_id : str
        Id of the joint.
    place : (3,) array_like
        mm; of a joint in the symmetry plane the nearest place in it.

    Raises
    ------
    UserError
        If there is no such joint, or the place is not finite.
    """
    joint = joint_of(state, joint_id)
    point = np.asarray(place, float)
    if point.shape != (3,) or not np.isfinite(point).all():
        raise UserError("A joint needs a place. Drag it somewhere else.")
    for curve in state.of_kind(Curve):
        held = any(meet.curve == curve.id for meet in joint.meetings)
        if held and curve.plane is not None:
            point = in_plane(point, curve.plane)
    if joint.in_plane:
        point = in_plane(point, state.symmetry)
    pins, joints = {joint_id: point}, state.joints
    images = _images_on_own_curves(state, joint)
    if images:
        (name,) = unused_joint_ids(joints, 1)
        pins[name] = mirror_image(point, state.symmetry)
        joints = (*joints, Joint(name, images))
    moved = settled_state(replace(state, joints=joints), {}, pins)
    return replace(moved, joints=state.joints)


def _images_on_own_curves(state: ProductState, joint: Joint) -> tuple[Meeting, ...]:
    """Return where curves that are their own mirror images have the image of a joint."""
    curves = {meet.curve: curve_of(state, meet.curve) for meet in joint.meetings}
    if joint.in_plane or not any(curve.mirrored for curve in curves.values()):
        return ()
    reflection = Reflection(state.symmetry)
    found = []
    for meet in joint.meetings:
        spline = spline_of(state, meet.curve)
        if not curves[meet.curve].mirrored and reflection.keeps(spline):
            found.append(Meeting(meet.curve, image_place(spline, meet.at, reflection)))
    return tuple(found)


def _with_ends_in_plane(state: ProductState, curve_id: str) -> ProductState:
    """Return the network with ends of a curve that are near the symmetry plane joined to it."""
    spline = splines_of(state)[curve_id]
    ends = spline.control_points[[0, -1]]
    near = np.abs(heights(ends, state.symmetry)) <= NEAR * chord_length(spline)
    flat = np.where(near[:, None], in_plane(ends, state.symmetry), ends)
    joints = list(state.joints)
    for at, meant in ((0.0, near[0]), (1.0, near[1])):
        if not meant:
            continue
        known = [
            k
            for k, joint in enumerate(joints)
            if any(meet.curve == curve_id and meet.at == at for meet in joint.meetings)
        ]
        for k in known:
            joints[k] = replace(joints[k], in_plane=True)
        if not known:
            (name,) = unused_joint_ids(joints, 1)
            joints.append(Joint(name, (Meeting(curve_id, at),), True))
    state = _cut_at_plane(replace(state, joints=tuple(joints)))
    return settled_state(state, {curve_id: bent(spline, flat[0], flat[1])})


def _cut_at_plane(state: ProductState) -> ProductState:
    """Return the network with curves cut where they cross the symmetry plane in a joint.

    Only the ends of a curve can be in the plane to the last bit.
    """
    crossing = {
        (meet.curve, meet.at)
        for joint in state.joints
        if joint.in_plane
        for meet in joint.meetings
        if not is_end(splines_of(state), meet)
        and not lies_in(curve_of(state, meet.curve), state.symmetry)
    }
    shares: dict[str, list[float]] = {}
    for name, share in sorted(crossing):
        shares.setdefault(name, []).append(share)
    for name, cuts in shares.items():
        state, _ = split_curve(state, name, cuts)
    return state
