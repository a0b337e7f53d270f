"""Curves and joints of a state: where curves meet, and what is at a place of a curve."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.geometry import Spline
from bozzetto_product.model.curves import Curve
from bozzetto_product.model.joints import Joint, Meeting
from bozzetto_product.model.planes import Plane
from bozzetto_product.model.state import ProductState
from bozzetto_product.projection.planes import mirror_image


def curve_of(state: ProductState, curve_id: str) -> Curve:
    """Return a curve by its id.

    Raises
    ------
    UserError
        If there is none, or it is not drawn.
    """
    for curve in state.of_kind(Curve):
        if curve.id == curve_id and curve.spline is not None:
            return curve
    raise UserError("This curve is not there any more. Choose another one.")


def spline_of(state: ProductState, curve_id: str) -> Spline:
    """Return the course of a curve by its id; errors as `curve_of`."""
    spline = curve_of(state, curve_id).spline
    assert spline is not None
    return spline


def splines_of(state: ProductState) -> dict[str, Spline]:
    """Return the splines of all curves that are drawn, by their ids."""
    curves = state.of_kind(Curve)
    return {curve.id: curve.spline for curve in curves if curve.spline is not None}


def with_splines(state: ProductState, splines: Mapping[str, Spline]) -> ProductState:
    """Return the state with other splines for some curves; the choice of a part stays."""
    nodes = tuple(
        replace(node, spline=splines[node.id])
        if isinstance(node, Curve) and splines.get(node.id, node.spline) is not node.spline
        else node
        for node in state.nodes
    )
    return replace(state, nodes=nodes)


def laid_anew(state: ProductState, *curve_ids: str) -> ProductState:
    """Return the state with nothing to tell of how some curves were drawn; the choice stays."""
    nodes = tuple(
        replace(node, told=()) if isinstance(node, Curve) and node.id in curve_ids else node
        for node in state.nodes
    )
    return replace(state, nodes=nodes)


def place_at(spline: Spline, share: float) -> Array:
    """Return the place at a share of the range, (3,) mm; ends of open curves are exact."""
    if not spline.closed and share <= 0.0:
        return np.array(spline.control_points[0])
    if not spline.closed and share >= 1.0:
        return np.array(spline.control_points[-1])
    return np.asarray(spline.value([parameter_at(spline, share)])[0])


def parameter_at(spline: Spline, share: float) -> float:
    """Return the parameter at a share of the range."""
    begin, end = spline.range
    return begin + share * (end - begin)


def share_at(spline: Spline, parameter: float) -> float:
    """Return the share of the range at a parameter."""
    begin, end = spline.range
    return (parameter - begin) / (end - begin)


def meeting_place(splines: Mapping[str, Spline], meeting: Meeting, symmetry: Plane) -> Array:
    """Return where a meeting is, (3,) mm: on the curve, or on its mirror image."""
    place = place_at(splines[meeting.curve], meeting.at)
    return mirror_image(place, symmetry) if meeting.mirrored else place


def is_end(splines: Mapping[str, Spline], meeting: Meeting) -> bool:
    """Whether a meeting is at an end of its curve; a closed curve has none."""
    return not splines[meeting.curve].closed and meeting.at in (0.0, 1.0)


def joint_of(state: ProductState, joint_id: str) -> Joint:
    """Return a joint by its id.

    Raises
    ------
    UserError
        If there is none.
    """
    for joint in state.joints:
        if joint.id == joint_id:
            return joint
    raise UserError("This joint is not there any more. Choose another one.")


def joint_at(state: ProductState, curve_id: str, share: float) -> Joint | None:
    """Return the joint at a place of a curve, if there is one."""
    for joint in state.joints:
        if any(meet.curve == curve_id and meet.at == share for meet in joint.meetings):
            return joint
    return None


def unused_joint_ids(joints: Iterable[Joint], count: int) -> list[str]:
    """Return ids that no joint has, such as j1."""
    taken = {joint.id for joint in joints}
    found: list[str] = []
    number = 1
    while len(found) < count:
        if f"j{number}" not in taken:
            found.append(f"j{number}")
        number += 1
    return found
