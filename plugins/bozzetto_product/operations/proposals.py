"""Gaps that are too wide to be closed without asking."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from bozzetto.arrays import Array
from bozzetto_product.model.joints import Joint, Meeting
from bozzetto_product.model.planes import Point
from bozzetto_product.model.state import ProductState
from bozzetto_product.operations.clusters import End, is_tail
from bozzetto_product.operations.free_ends import (
    ASKED,
    beside_tail,
    is_symmetric,
    network_ends,
)
from bozzetto_product.operations.meetings import (
    curve_of,
    is_end,
    meeting_place,
    splines_of,
    unused_joint_ids,
)
from bozzetto_product.operations.nearest_meetings import nearest_inside
from bozzetto_product.operations.plane_crossings import lies_in
from bozzetto_product.operations.settling import settled_state
from bozzetto_product.projection.planes import heights, in_plane, mirror_image


@dataclass(frozen=True)
class Proposal:
    """A gap that is too wide to be closed without asking.

    Attributes
    ----------
    meetings : tuple of Meeting
        What would be joined: the free end first, and what it would meet; nothing else for the
        mirror plane.
    place : (x, y, z)
        Where they would meet, mm.
    distance : float
        Width of the gap, mm.
    """

    meetings: tuple[Meeting, ...]
    place: Point
    distance: float


def accept(state: ProductState, proposal: Proposal) -> ProductState:
    """Join what was proposed; the same state if one of its curves is gone or joined by now."""
    splines = splines_of(state)
    first = proposal.meetings[0]
    taken = {(meet.curve, meet.at) for joint in state.joints for meet in joint.meetings}
    if any(meet.curve not in splines for meet in proposal.meetings):
        return state
    if (first.curve, first.at) in taken:
        return state
    flat = len(proposal.meetings) == 1
    in_it = flat or (is_symmetric(state) and lies_in(curve_of(state, first.curve), state.symmetry))
    for joint in state.joints:
        known = [(meet.curve, meet.at) for meet in joint.meetings]
        if not flat and (proposal.meetings[1].curve, proposal.meetings[1].at) in known:
            other = next(
                meet
                for meet in joint.meetings
                if (meet.curve, meet.at) == (proposal.meetings[1].curve, proposal.meetings[1].at)
            )
            across = other.mirrored ^ proposal.meetings[1].mirrored
            added = replace(first, mirrored=across)
            larger = replace(joint, meetings=(*joint.meetings, added))
            joints = tuple(larger if one.id == joint.id else one for one in state.joints)
            return settled_state(replace(state, joints=joints), {})
    (name,) = unused_joint_ids(state.joints, 1)
    fresh = Joint(name, proposal.meetings, in_it)
    place = np.asarray(proposal.place)
    carried = not flat and not is_end(splines, proposal.meetings[1])
    pins = {} if carried else {name: in_plane(place, state.symmetry) if flat else place}
    return settled_state(replace(state, joints=(*state.joints, fresh)), {}, pins)


def proposals_of(
    state: ProductState, gap: float, only: Collection[str] | None = None
) -> tuple[Proposal, ...]:
    """Return gaps that are wider than those that are closed, nearest first."""
    found: dict[tuple[tuple[str, float], ...], Proposal] = {}
    ends = network_ends(state, ASKED * gap)
    for end in ends:
        if end.joint or (only is not None and end.curve not in only):
            continue
        proposal = nearest_gap(end, ends, state)
        if proposal is not None:
            key = tuple(sorted((meet.curve, meet.at) for meet in proposal.meetings))
            found.setdefault(key, proposal)
    return tuple(sorted(found.values(), key=lambda one: (one.distance, one.place)))


def nearest_gap(end: End, ends: Sequence[End], state: ProductState) -> Proposal | None:
    """Return the nearest place to which a free end could be joined."""
    splines = splines_of(state)
    mine = Meeting(end.curve, end.at)
    found: list[tuple[float, tuple[Meeting, ...], Array]] = []
    places = np.array([other.place for other in ends])
    reaches = np.minimum([other.gap for other in ends], end.gap)
    ways = [
        np.linalg.norm(own - end.place, axis=1)
        for own in (places, mirror_image(places, state.symmetry))
    ]
    for number in np.flatnonzero(np.minimum(*ways) <= reaches):
        other = ends[int(number)]
        if other is end or is_tail(end, other):
            continue
        for mirrored in (False, True) if end.image or other.image else (False,):
            place = mirror_image(other.place, state.symmetry) if mirrored else other.place
            distance = float(ways[mirrored][number])
            if distance > reaches[number]:
                continue
            if other.joint:
                joint = next(one for one in state.joints if one.id == other.joint)
                known = next(meet for meet in joint.meetings if meet.curve in splines)
                meet = replace(known, mirrored=known.mirrored ^ mirrored)
                found.append((distance, (mine, meet), place))
            else:
                meet = Meeting(other.curve, other.at, mirrored)
                share = other.weight / max(other.weight + end.weight, 1e-300)
                found.append((distance, (mine, meet), end.place + share * (place - end.place)))
    busy = {end.curve} | beside_tail(state, end)
    inside = nearest_inside(state, end.place, end.gap, busy, end.flat)
    if inside is not None:
        found.append(
            (inside[1], (mine, inside[0]), meeting_place(splines, inside[0], state.symmetry))
        )
    height = abs(float(heights(end.place, state.symmetry)))
    if end.image and height <= end.gap:
        found.append((height, (mine,), in_plane(end.place, state.symmetry)))
    if not found:
        return None
    distance, meetings, place = min(found, key=lambda one: (one[0], len(one[1])))
    x, y, z = (float(value) for value in place)
    return Proposal(meetings, (x, y, z), distance)
