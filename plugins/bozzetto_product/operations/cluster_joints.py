"""The joints that ends close to one another make."""

from __future__ import annotations

import itertools
from collections.abc import Collection, Sequence
from dataclasses import replace

from bozzetto.arrays import Array
from bozzetto_product.model.joints import Joint, Meeting
from bozzetto_product.model.state import ProductState
from bozzetto_product.operations.clusters import Cluster, End, target_of
from bozzetto_product.operations.free_ends import (
    ASKED,
    TAIL,
    beside_tail,
)
from bozzetto_product.operations.meetings import (
    is_end,
    meeting_place,
    splines_of,
)
from bozzetto_product.operations.nearest_meetings import nearest_inside
from bozzetto_product.projection.planes import in_plane, mirror_image
from bozzetto_product.projection.spline_basis import chord_length


def joints_of_cluster(
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
        busy |= beside_tail(state, ends[number])
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


def without_overlaps(
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


def laid_together(
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
