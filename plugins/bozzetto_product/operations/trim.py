"""Trim: ends of curves that nearly meet are joined, and joints are kept.

Kara & Shimada, book chapter, section 13.2.2, merge ends that are close to one another. Here an end
may also be joined to the inside of a curve, which then carries it, and to the mirror plane. The
outcome does not depend on the order of the curves. What is farther apart is proposed, not done.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto_product.model.curves import Curve
from bozzetto_product.model.joints import Joint, Meeting
from bozzetto_product.model.planes import Point
from bozzetto_product.model.state import ProductState
from bozzetto_product.operations.clusters import Cluster, End, clusters_of, is_tail, target_of
from bozzetto_product.operations.crossings import Crossing, crossings_of
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
from bozzetto_product.operations.tangents import smooth_over_joints, smooth_over_plane
from bozzetto_product.projection.planes import heights, in_plane, mirror_image
from bozzetto_product.projection.spline_basis import chord_length

GAP: Final = 0.02
"""Largest gap that is closed, as a share of the diagonal of all curves."""

SHORT: Final = 0.25
"""Largest gap as a share of the length of the curve, or of its stretch up to the next joint:
details are smaller than the model, and the tail of a curve drawn too far ends where it does."""

TAIL: Final = 0.5
"""Share of a curve beyond its last joint below which that is the tail of one drawn too far."""

ASKED: Final = 3.0
"""Largest gap, in gaps that are closed, that is proposed."""

FARTHEST: Final = 3.0
"""Farthest that closing gaps may move a curve anywhere, in gaps that are closed. Curves that end on
one another, and cross besides, would draw each other away without an end."""

AS_FAR: Final = 0.9
"""Share of the farthest move from which on a curve is held to be moved as far."""

LOOKS: Final = 33
"""Places of a curve at which it is looked how far it moved."""


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


@dataclass(frozen=True)
class Trimmed:
    """A network after ends were joined.

    Attributes
    ----------
    state : ProductState
        The same object where nothing was joined.
    joined : tuple of str
        Ids of joints that are new or have become larger.
    proposals : tuple of Proposal
        Wider gaps, nearest first.
    """

    state: ProductState
    joined: tuple[str, ...] = ()
    proposals: tuple[Proposal, ...] = ()


def trim(
    state: ProductState, *, gap: float | None = None, only: Collection[str] | None = None
) -> Trimmed:
    """Join the free ends of curves to what they nearly meet, and curves where they cross.

    Parameters
    ----------
    state : ProductState
        The network, in the frame of the model.
    gap : float, optional
        Largest gap that is closed, mm; of short curves a quarter of their length. Default 2 % of
        the diagonal of all curves.
    only : collection of str, optional
        Ids of curves: only joints that have to do with one of them are made.

    Returns
    -------
    Trimmed
    """
    splines = splines_of(state)
    width = default_gap(state) if gap is None else gap
    if not splines or not np.isfinite(width) or not width > 0.0:
        return Trimmed(state)
    ended, joined = ends_joined(state, width, only)
    crossed, more = crossings_joined(ended, width, only)
    moved = {name for name, own in splines_of(crossed).items() if own is not splines[name]}
    at = [
        joint.id
        for joint in crossed.joints
        if joint.id in joined or any(meet.curve in moved for meet in joint.meetings)
    ]
    flat = [
        meet
        for joint in crossed.joints
        for meet in joint.meetings
        if joint.in_plane and meet.curve in moved
    ]
    smooth = smooth_over_plane(smooth_over_joints(crossed, at), flat)
    return Trimmed(smooth, (*joined, *more), proposals_of(smooth, width, only))


def ends_joined(
    state: ProductState,
    width: float,
    only: Collection[str] | None = None,
    placed: Collection[str] = (),
) -> tuple[ProductState, tuple[str, ...]]:
    """Return the network with free ends joined, and the ids of the joints.

    Parameters
    ----------
    state, width, only
        See `trim`; the gap is `width`, mm.
    placed : collection of str
        Ids of joints that are where they are meant: free ends are joined to them, but they are not
        joined to the inside of a curve.
    """
    ends = network_ends(state, width)
    made: list[tuple[Joint, Array | None]] = []
    old = {joint.id: joint for joint in state.joints}
    for cluster in clusters_of(ends, state.symmetry):
        made.extend(_joints_of(cluster, ends, state, old, placed))
    made = _laid_together(_without_overlaps(made, state), state, width)
    if only is not None:
        made = [one for one in made if any(meet.curve in only for meet in one[0].meetings)]
    if not made:
        return state, ()
    fresh = iter(unused_joint_ids(state.joints, len(made)))
    named = [(joint if joint.id else replace(joint, id=next(fresh)), at) for joint, at in made]
    known = {(joint.id, meet) for joint in state.joints for meet in joint.meetings}
    while named:
        changed = {joint.id: joint for joint, _ in named}
        flat = [
            meet
            for joint in changed.values()
            for meet in joint.meetings
            if joint.in_plane and (joint.id, meet) not in known
        ]
        joints = [changed.pop(joint.id, joint) for joint in state.joints]
        whole = replace(state, joints=(*joints, *changed.values()))
        pins = {joint.id: place for joint, place in named if place is not None}
        joined = settled_state(whole, {}, pins)
        drawn = _drawn_away(state, joined, [joint for joint, _ in named], FARTHEST * width)
        if not drawn:
            return smooth_over_plane(joined, flat), tuple(joint.id for joint, _ in named)
        named = [one for one in named if one[0].id not in drawn]
    return state, ()


def _drawn_away(
    before: ProductState, after: ProductState, fresh: Sequence[Joint], reach: float
) -> set[str]:
    """Return the ids of joints that are new and draw curves farther away than they may.

    Those of the curves that move farthest; all, where these are only carried along.
    """
    old, new = splines_of(before), splines_of(after)
    ways = {
        name: float(np.linalg.norm(new[name].sampled(LOOKS) - own.sampled(LOOKS), axis=1).max())
        for name, own in old.items()
        if new[name] is not own
    }
    for far in (AS_FAR * max(ways.values(), default=0.0), reach):
        if max(ways.values(), default=0.0) <= reach:
            return set()
        moved = {name for name, way in ways.items() if way >= far}
        drawn = {one.id for one in fresh if any(meet.curve in moved for meet in one.meetings)}
        if drawn:
            return drawn
    return {one.id for one in fresh}


def crossings_joined(
    state: ProductState,
    width: float,
    only: Collection[str] | None = None,
    *,
    passing: Callable[[Crossing], bool] = lambda _: False,
) -> tuple[ProductState, tuple[str, ...]]:
    """Return the network with curves joined where their insides cross, and the ids of the joints.

    Parameters
    ----------
    state, width, only
        See `trim`; the gap is `width`, mm.
    passing : callable
        Of a crossing: whether the curves only pass one another there.
    """
    found = [one for one in crossings_of(state, width, only) if not passing(one)]
    if not found:
        return state, ()
    names = unused_joint_ids(state.joints, len(found))
    fresh = [Joint(name, one.meetings) for name, one in zip(names, found, strict=True)]
    pins = {name: one.place for name, one in zip(names, found, strict=True)}
    while fresh:
        crossed = settled_state(replace(state, joints=(*state.joints, *fresh)), {}, pins)
        drawn = _drawn_away(state, crossed, fresh, FARTHEST * width)
        if not drawn:
            return crossed, tuple(joint.id for joint in fresh)
        fresh = [joint for joint in fresh if joint.id not in drawn]
        pins = {joint.id: pins[joint.id] for joint in fresh}
    return state, ()


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
    in_it = flat or (_is_symmetric(state) and lies_in(curve_of(state, first.curve), state.symmetry))
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


def default_gap(state: ProductState) -> float:
    """Return the gap that is closed by default, mm; 0 without curves."""
    splines = splines_of(state)
    if not splines:
        return 0.0
    points = np.vstack([spline.sampled(33) for spline in splines.values()])
    return GAP * float(np.linalg.norm(np.ptp(points, axis=0)))


def network_ends(state: ProductState, gap: float) -> list[End]:
    """Return the free ends of all curves and the joints, in an order that names do not change."""
    splines = splines_of(state)
    curves = {curve.id: curve for curve in state.of_kind(Curve)}
    symmetric = _is_symmetric(state)
    found: list[End] = []
    joined = {(meet.curve, meet.at) for joint in state.joints for meet in joint.meetings}
    for name, spline in splines.items():
        if spline.closed:
            continue
        length = chord_length(spline)
        inner = [share for curve, share in joined if curve == name]
        for at in (0.0, 1.0):
            if (name, at) in joined:
                continue
            free = min((abs(share - at) for share in inner), default=1.0) * length
            place = np.array(spline.control_points[0 if at == 0.0 else -1])
            flat = symmetric and lies_in(curves[name], state.symmetry)
            image = curves[name].mirrored
            found.append(End(place, min(gap, SHORT * free), length, image, flat, name, at))
    for joint in state.joints:
        meetings = [meet for meet in joint.meetings if meet.curve in splines]
        if meetings:
            place = meeting_place(splines, meetings[0], state.symmetry)
            lengths = [chord_length(splines[meet.curve]) for meet in meetings]
            image = all(curves[meet.curve].mirrored for meet in meetings) and not joint.in_plane
            width = min(gap, SHORT * min(lengths))
            weight = float(np.sum(lengths))
            held = tuple((meet.curve, meet.at) for meet in meetings)
            flat = joint.in_plane
            found.append(End(place, width, weight, image, flat, joint=joint.id, held=held))
    return sorted(found, key=lambda end: (*end.place.tolist(), end.weight, end.at))


def _is_symmetric(state: ProductState) -> bool:
    """Whether the symmetry plane counts: without mirror images it is a plane like any other."""
    return state.mirror or any(curve.mirrored for curve in state.of_kind(Curve))


def _joints_of(
    cluster: Cluster,
    ends: Sequence[End],
    state: ProductState,
    old: dict[str, Joint],
    placed: Collection[str],
) -> list[tuple[Joint, Array | None]]:
    """Return the joints that a cluster makes, and where they are; None where a curve tells."""
    known = next((ends[k].joint for k, _ in cluster.members if ends[k].joint), "")
    target = target_of(cluster, ends, state.symmetry)
    free = [(number, across) for number, across in cluster.members if not ends[number].joint]
    busy = {ends[number].curve for number, _ in free}
    width = min((ends[number].gap for number, _ in cluster.members), default=0.0)
    joint = old.get(known)
    if joint is not None:
        busy |= {meet.curve for meet in joint.meetings}
    for number, _ in free:
        busy |= _beside_tail(state, ends[number])
    carried = known in placed or (
        joint is not None and any(not is_end(splines_of(state), m) for m in joint.meetings)
    )
    carrier = None if carried else nearest_inside(state, target, width, busy, cluster.flat)
    at_plane = cluster.flat and any(ends[number].image for number, _ in free)
    if carrier is None and not at_plane and len(cluster.members) < 2:
        return []
    if joint is not None and not free and carrier is None:
        return []
    side = next((across for k, across in cluster.members if ends[k].joint), False)
    if cluster.flat:
        meetings = tuple(Meeting(ends[k].curve, ends[k].at) for k, _ in free)
        base = joint or Joint("", (), True)
        more = () if carrier is None else (carrier[0],)
        place = in_plane(target, state.symmetry) if carrier is None and joint is None else None
        return [(replace(base, meetings=(*base.meetings, *meetings, *more), in_plane=True), place)]
    return _sided(free, ends, state, target, joint, side, carrier)


def _without_overlaps(
    made: list[tuple[Joint, Array | None]], state: ProductState
) -> list[tuple[Joint, Array | None]]:
    """Return joints without one of each two by which the ends of two curves lie on one another.

    A ring drawn in two strokes that overlap meets once: the tail of one of them stays free, for
    between two joints there would be a sliver. The joint of more curves is kept, else the one with
    the shorter tail.
    """
    splines = splines_of(state)
    held = {joint.id: set(joint.meetings) for joint in state.joints}
    laid: dict[frozenset[str], list[tuple[int, Meeting, Meeting]]] = {}
    for number, (joint, _) in enumerate(made):
        inner = [meet for meet in joint.meetings if not is_end(splines, meet)]
        for end in joint.meetings:
            if is_end(splines, end) and end not in held.get(joint.id, ()):
                for meet in inner:
                    both = frozenset((end.curve, meet.curve))
                    laid.setdefault(both, []).append((number, end, meet))

    def worth(one: tuple[int, Meeting, Meeting]) -> tuple[int, float, list[list[float]]]:
        number, end, meet = one
        beyond = min(meet.at, 1.0 - meet.at) * chord_length(splines[meet.curve])
        points: list[list[float]] = splines[end.curve].control_points.tolist()
        return -len(made[number][0].meetings), beyond, points

    gone: dict[int, set[Meeting]] = {}
    pairs = (itertools.combinations(rows, 2) for rows in laid.values())
    for one, other in itertools.chain.from_iterable(pairs):
        ends = ((one[1], other[2]), (other[1], one[2]))
        if one[0] != other[0] and all(
            end.curve == meet.curve and abs(end.at - meet.at) < TAIL for end, meet in ends
        ):
            number, end, _ = max(one, other, key=worth)
            gone.setdefault(number, set()).add(end)
    kept = []
    for number, (joint, place) in enumerate(made):
        meetings = tuple(meet for meet in joint.meetings if meet not in gone.get(number, ()))
        if len(meetings) > 1 or number not in gone:
            kept.append((replace(joint, meetings=meetings), place))
    return kept


def _laid_together(
    made: list[tuple[Joint, Array | None]], state: ProductState, width: float
) -> list[tuple[Joint, Array | None]]:
    """Return joints where a curve that runs past a joint of another one's end is joined to that.

    Its end, which lies farther on along the other one, is a tail then and stays free.
    """
    splines = splines_of(state)
    held = {joint.id: set(joint.meetings) for joint in state.joints}
    changed = {joint.id for joint, _ in made}
    known = [joint for joint in state.joints if joint.id not in changed]
    pool: list[tuple[Joint, Array | None]] = [*made, *((joint, None) for joint in known)]
    larger: set[int] = set()
    for number, (joint, _) in enumerate(made):
        fresh = [meet for meet in joint.meetings if meet not in held.get(joint.id, ())]
        inner = [meet for meet in joint.meetings if not is_end(splines, meet)]
        for end in (meet for meet in fresh if is_end(splines, meet)):
            for meet in inner:
                near = Meeting(meet.curve, float(round(meet.at)), meet.mirrored)
                which = next((k for k, one in enumerate(pool) if near in one[0].meetings), number)
                other = pool[which][0]
                if which == number or any(one.curve == end.curve for one in other.meetings):
                    continue
                place = meeting_place(splines, near, state.symmetry)
                others = set(splines) - {end.curve}
                found = nearest_inside(state, place, ASKED * width, others, False)
                if found is None or found[0].mirrored != end.mirrored:
                    continue
                if abs(found[0].at - end.at) < TAIL:
                    rest = tuple(one for one in pool[number][0].meetings if one != end)
                    pool[number] = replace(pool[number][0], meetings=rest), pool[number][1]
                    more = replace(other, meetings=(*other.meetings, found[0]))
                    pool[which] = more, place
                    larger |= {number, which}
    return [
        one
        for number, one in enumerate(pool)
        if (number < len(made) or number in larger) and len(one[0].meetings) > 1 - one[0].in_plane
    ]


def _beside_tail(state: ProductState, end: End) -> set[str]:
    """Return the curves that meet in the joint behind which a free end is the tail of a curve.

    A tail may run along one of them for a while; joined to it, it would bound a sliver.
    """
    behind = [
        (abs(meet.at - end.at), joint)
        for joint in state.joints
        for meet in joint.meetings
        if meet.curve == end.curve and 0.0 < meet.at < 1.0 and abs(meet.at - end.at) < TAIL
    ]
    if not behind:
        return set()
    _, nearest = min(behind, key=lambda one: (one[0], one[1].id))
    return {meet.curve for meet in nearest.meetings}


def _sided(
    free: Sequence[tuple[int, bool]],
    ends: Sequence[End],
    state: ProductState,
    target: Array,
    joint: Joint | None,
    side: bool,
    carrier: tuple[Meeting, float] | None,
) -> list[tuple[Joint, Array | None]]:
    """Return the joints of a cluster beside the symmetry plane: one, or one on each side.

    A curve without a mirror image meets on its own side only. Where there are such curves on both
    sides, both joints are kept.
    """
    lone = {across for number, across in free if not ends[number].image}
    sides = sorted(lone) if lone else [side]
    if joint is not None:
        sides = [side, *(one for one in sides if one != side)]
    made: list[tuple[Joint, Array | None]] = []
    for here in sides:
        meetings = tuple(
            Meeting(ends[number].curve, ends[number].at, across != here)
            for number, across in free
            if across == here or ends[number].image
        )
        base = joint if joint is not None and here == side else Joint("", ())
        more: tuple[Meeting, ...] = ()
        if carrier is not None:
            meet = carrier[0]
            more = (replace(meet, mirrored=meet.mirrored ^ here),)
        place = mirror_image(target, state.symmetry) if here else target
        pinned = None if carrier is not None or base.id else place
        made.append((replace(base, meetings=(*base.meetings, *meetings, *more)), pinned))
    return made


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
    busy = {end.curve} | _beside_tail(state, end)
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
