"""Corners between two curves, rounded by a radius."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any, Final, NamedTuple

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.geometry import Spline
from bozzetto.ink import Strokes
from bozzetto_product.model.joints import Boundary, Joint, Meeting, Run
from bozzetto_product.model.patches import Patch
from bozzetto_product.model.state import ProductState
from bozzetto_product.operations.boundaries import (
    joined_runs,
    outlines_of_boundary,
    turned_run,
    with_boundaries,
)
from bozzetto_product.operations.corners import from_corner, is_corner, lies_in
from bozzetto_product.operations.fillet_arc import Side, arc_between, sides_of, touching
from bozzetto_product.operations.largest_radius import radius_refused
from bozzetto_product.operations.meetings import (
    curve_of,
    is_end,
    joint_of,
    meeting_place,
    place_at,
    share_at,
    spline_of,
    splines_of,
    unused_joint_ids,
)
from bozzetto_product.operations.pieces import (
    delete_curves,
    split_curve,
    without_idle_joints,
)
from bozzetto_product.operations.settling import settled_state
from bozzetto_product.projection.planes import in_plane, mirror_image

NO_CORNER: Final = (
    "A corner of two curves that meet in one place can be rounded, if one of them ends there; in "
    "the symmetry plane one of them must lie in it. Choose such a corner."
)

HALVINGS: Final = 14
"""Steps in which the largest radius is found."""

LOOKS: Final = 257
"""Places of an arc and of a curve of which the nearest are found."""


def fillet(
    state: ProductState,
    joint_id: str,
    first: str,
    second: str,
    radius: float,
    ways: tuple[int, int] = (0, 0),
) -> tuple[ProductState, str]:
    """Round the corner between two curves that end in one joint.

    Both curves are cut where a circle of the radius touches them, seen along the
    corner's normal; an arc that joins them there is a curve of its own. What else meets in the
    joint meets on the arc from then on: one curve where it comes nearest to the arc, several where
    the arc is nearest to the corner. A curve that runs through the corner, or in the symmetry plane
    on to another one, stays whole, and the arc ends inside it.

    Parameters
    ----------
    state : ProductState
        The network, in the frame of the model.
    joint_id : str
        Id of the joint at the corner.
    first, second : str
        Ids of the curves.
    radius : float
        mm.
    ways : (int, int)
        Of a curve that runs through the corner, whether the arc ends on what is behind the corner
        along it (1) or before it (−1); 0 of one that ends there.

    Returns
    -------
    state : ProductState
        The network, in the frame of the model.
    name : str
        Id of the arc.

    Raises
    ------
    UserError
        If the curves make no corner there, or the radius is too large.
    """
    joint, splines = joint_of(state, joint_id), splines_of(state)
    meetings = [meet for meet in joint.meetings if meet.curve in splines]
    named = {meet.curve: meet for meet in meetings}
    if first == second or not {first, second} <= named.keys() or len(named) < len(meetings):
        raise UserError(NO_CORNER)
    ends = [named[first], named[second]]
    through = [not is_end(splines, meet) for meet in ends]
    flat = [lies_in(splines[meet.curve], state.symmetry) for meet in ends]
    if (
        any(meet.mirrored for meet in ends)
        or any((way == 0) == passes for way, passes in zip(ways, through, strict=True))
        or not is_corner(joint, through, flat)
    ):
        raise UserError(NO_CORNER)
    if not (np.isfinite(radius) and radius > 0.0):
        raise UserError("A radius is a length above 0.")
    inward = [from_corner(splines[m.curve], m.at, way) for m, way in zip(ends, ways, strict=True)]
    sides = sides_of(inward[0], inward[1])
    reached = partial(_cuts_at, state, sides, ends, ways)
    cuts = reached(radius)
    if cuts is None:
        reason = f"A radius of {radius:.4g} mm is too large for these curves"
        raise radius_refused(reason, radius, lambda size: reached(size) is not None, HALVINGS)
    arc = arc_between(sides, cuts.at, radius)
    whole = [
        passes or (joint.in_plane and flat[k] and not flat[1 - k] and len(meetings) > 2)
        for k, passes in enumerate(through)
    ]
    inside = [joint.in_plane and one for one in flat]
    return _put_together(state, joint, ends, cuts.shares, arc, whole, inside)


class _Cuts(NamedTuple):
    """Where an arc ends on both curves: parameters from the corner on, and shares of the curves."""

    at: Array
    shares: list[float]


def _cuts_at(
    state: ProductState,
    sides: list[Side],
    ends: Sequence[Meeting],
    ways: Sequence[int],
    radius: float,
) -> _Cuts | None:
    """Return where an arc ends on both curves; None where these end, or meet others, before."""
    at = touching(sides, radius)
    if at is None:
        return None
    shares = []
    for k, side in enumerate(sides):
        share, begin = share_at(side.spline, at[k]), ends[k].at
        onward = ways[k] > 0 or (ways[k] == 0 and begin == 0.0)
        shares.append(begin + share * (1.0 - begin) if onward else begin - share * begin)
    if any(_is_met_before(state, meet, cut) for meet, cut in zip(ends, shares, strict=True)):
        return None
    return _Cuts(at, shares)


def _is_met_before(state: ProductState, meet: Meeting, cut: float) -> bool:
    """Whether something else meets the part of a curve that is cut off."""
    return any(
        other.curve == meet.curve
        and other.at != meet.at
        and 0.0 < (other.at - meet.at) / (cut - meet.at) < 1.0
        for joint in state.joints
        for other in joint.meetings
    )


def _put_together(
    state: ProductState,
    joint: Joint,
    ends: Sequence[Meeting],
    cuts: Sequence[float],
    arc: Spline,
    whole: Sequence[bool],
    in_symmetry: Sequence[bool],
) -> tuple[ProductState, str]:
    """Return the network with curves cut back that do not stay whole, and the arc between them.

    Parameters
    ----------
    state : ProductState
        The network, in the frame of the model.
    joint : Joint
        The corner.
    ends : sequence of Meeting
        Of both curves.
    cuts : sequence of float
        Shares at which the arc ends on them.
    arc : Spline
        From the first to the second.
    whole : sequence of bool
        Which of them stay whole.
    in_symmetry : sequence of bool
        Which of them lie in the symmetry plane, as does the corner.
    """
    first, second = (curve_of(state, meet.curve) for meet in ends)
    points = np.array(arc.control_points)
    if all(in_symmetry):
        points = in_plane(points, state.symmetry)
    corners, waste = [], []
    for k, (meet, cut) in enumerate(zip(ends, cuts, strict=True)):
        if whole[k]:
            (corner,) = unused_joint_ids(state.joints, 1)
            added = Joint(corner, (Meeting(meet.curve, cut),))
            state = replace(state, joints=(*state.joints, added))
        else:
            state, goes, corner = _cut_back(state, meet, cut)
            waste.append(goes)
        corners.append(corner)
        place = place_at(spline_of(state, meet.curve), cut if whole[k] else meet.at)
        points[-k] = in_plane(place, state.symmetry) if in_symmetry[k] else place
    name = state.unused_id()
    fresh = replace(
        first, id=name, name=state.unused_name("Curve"), spline=Spline(arc.knots, points),
        strokes=Strokes(), laid=None, plane=first.plane if first.plane == second.plane else None,
        mirrored=first.mirrored or second.mirrored, stretches=(), told=(),
    )  # fmt: skip
    gone = {meet.curve for meet, stays in zip(ends, whole, strict=True) if not stays}
    others = tuple(meet for meet in joint.meetings if meet.curve not in gone)
    assert fresh.spline is not None
    on_arc = bool(others) and not any(whole)
    share = _share_for(state, joint, others, fresh.spline) if on_arc else 0.0
    joints = []
    for one in state.joints:
        if one.id in corners:
            end = corners.index(one.id)
            meetings = (*one.meetings, Meeting(name, float(end)))
            joints.append(replace(one, meetings=meetings, in_plane=in_symmetry[end]))
        elif one.id != joint.id:
            joints.append(one)
        elif others:
            meetings = (*others, Meeting(name, share)) if on_arc else others
            joints.append(replace(one, meetings=meetings))
    state = replace(state.with_node(fresh), joints=tuple(joints))

    def change(boundary: Boundary) -> Boundary:
        if any(whole):
            k = whole.index(True)
            onward = cuts[k] > ends[k].at
            run = Run(name, corners[1 - k], corners[k], forward=k == 1)
            return _round_beside(boundary, waste[0], run, ends[k].curve, joint.id, onward)
        return _round_the_corner(boundary, waste, corners, name)

    state = without_idle_joints(delete_curves(with_boundaries(state, change), *waste))
    pins = {joint.id: place_at(fresh.spline, share)} if on_arc else {}
    return settled_state(state, {}, pins), name


def _cut_back(state: ProductState, meet: Meeting, cut: float) -> tuple[ProductState, str, str]:
    """Return the network with a curve cut, the id of the part that goes, and of the joint there.

    The part that stays keeps the id.
    """
    state, names = split_curve(state, meet.curve, [cut])
    goes = names[1] if meet.at == 1.0 else names[0]
    if meet.at == 0.0:
        state = _exchanged(state, *names)
        goes = names[1]
    corner = next(
        one.id for one in state.joints if {m.curve for m in one.meetings} >= {meet.curve, goes}
    )
    return state, goes, corner


def _share_for(
    state: ProductState, joint: Joint, others: tuple[Meeting, ...], arc: Spline
) -> float:
    """Return the share of the arc at which the other curves of a corner end from then on."""
    from scipy.spatial import cKDTree

    places = arc.sampled(LOOKS)
    if len(others) == 1:
        beside = spline_of(state, others[0].curve).sampled(LOOKS)
        beside = mirror_image(beside, state.symmetry) if others[0].mirrored else beside
    else:
        beside = meeting_place(splines_of(state), joint.meetings[0], state.symmetry)[None]
    away = cKDTree(beside).query(places[1:-1])[0]
    return float((1 + int(np.argmin(away))) / (LOOKS - 1))


def _exchanged(state: ProductState, one: str, other: str) -> ProductState:
    """Return the network with the ids and the names of two curves exchanged."""
    swap = {one: other, other: one}
    names = {curve_id: curve_of(state, curve_id).name for curve_id in swap}
    nodes: list[Any] = []
    for node in state.nodes:
        if isinstance(node, Patch):
            runs = tuple(
                replace(run, curve=swap.get(run.curve, run.curve)) for run in node.boundary
            )
            nodes.append(replace(node, boundary=runs))
        else:
            known = swap.get(node.id, node.id)
            nodes.append(replace(node, id=known, name=names.get(known, node.name)))
    joints = tuple(
        replace(
            joint,
            meetings=tuple(replace(m, curve=swap.get(m.curve, m.curve)) for m in joint.meetings),
        )
        for joint in state.joints
    )
    rejected = tuple(
        tuple(replace(run, curve=swap.get(run.curve, run.curve)) for run in boundary)
        for boundary in state.rejected
    )
    return replace(state, nodes=tuple(nodes), joints=joints, rejected=rejected)


def _round_the_corner(
    boundary: Boundary, waste: list[str], corners: list[str], arc: str
) -> Boundary:
    """Return a boundary in which the two parts at a corner are the arc, and one is its half."""
    rows = [
        (outline[number - 1], run, outline[(number + 1) % len(outline)])
        for outline in outlines_of_boundary(boundary)
        for number, run in enumerate(outline)
    ]
    runs: list[Run] = []
    for before, run, after in rows:
        if run.curve not in waste:
            runs.append(run)
        elif before.curve in waste and run.curve != before.curve:
            forward = before.curve == waste[0]
            start, end = (corners[0], corners[1]) if forward else (corners[1], corners[0])
            runs.append(Run(arc, start, end, forward, run.mirrored))
        elif after.curve not in waste or run.curve == after.curve:
            forward = (run.start == corners[0]) or (run.end == corners[1])
            runs.append(Run(arc, run.start, run.end, forward, run.mirrored))
    return tuple(runs)


def _round_beside(
    boundary: Boundary, waste: str, arc: Run, whole: str, joint: str, onward: bool
) -> Boundary:
    """Return a boundary in which the part of a curve at a corner is an arc on to a whole curve.

    Parameters
    ----------
    boundary : Boundary
        To be changed.
    waste : str
        Id of the part that goes.
    arc : Run
        From what stays of it to the whole curve.
    whole, joint : str
        Ids of the whole curve, and of the corner.
    onward : bool
        Whether the arc ends on what is behind the corner along the whole curve.
    """
    runs: list[Run] = []
    for run in boundary:
        if run.curve != waste:
            runs.append(run)
            continue
        there = replace(arc, mirrored=run.mirrored)
        back = Run(whole, arc.end, joint, forward=not onward, mirrored=run.mirrored)
        if run.end == joint:
            runs += [there, back]
        else:
            runs += [turned_run(back), turned_run(there)]
    turned = [
        run
        for outline in outlines_of_boundary(tuple(runs))
        for run in _without_way_back(outline, arc.end, joint)
    ]
    return joined_runs(tuple(turned), whole, joint)


def _without_way_back(outline: Boundary, end: str, joint: str) -> Boundary:
    """Return an outline that does not go from an end to a joint and on along the same curve."""
    runs = list(outline)
    for number, run in enumerate(runs):
        after = (number + 1) % len(runs)
        following = runs[after]
        if (
            run.end == following.start == joint
            and run.curve == following.curve
            and run.forward != following.forward
        ):
            # The longer one of both is what is left, from the end of the arc on.
            runs[number] = (
                replace(following, start=end) if run.start == end else replace(run, end=end)
            )
            del runs[after]
            break
    return tuple(runs)
