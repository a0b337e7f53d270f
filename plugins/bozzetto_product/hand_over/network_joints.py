"""Curves of files joined: where they meet exactly, where a hand left gaps, and where they cross."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Final

import numpy as np

from bozzetto.geometry import Spline
from bozzetto_product.hand_over.overlaps import TAIL
from bozzetto_product.hand_over.point_joints import joints_of
from bozzetto_product.loops.finding import find_loops
from bozzetto_product.model.curves import Curve
from bozzetto_product.model.joints import Joint, Meeting
from bozzetto_product.model.state import ProductState
from bozzetto_product.operations.crossings import Crossing
from bozzetto_product.operations.meetings import (
    is_end,
    meeting_place,
    splines_of,
    unused_joint_ids,
)
from bozzetto_product.operations.settling import settled_state
from bozzetto_product.operations.trim import crossings_joined, ends_joined
from bozzetto_product.solve.solver import net_of_state

WIDTHS: Final = (1e-3, 3e-3, 1e-2, 2e-2)
"""Gaps that are closed, one after the other, as shares of the diagonal: what nearly meets is joined
before what is farther apart, so that narrow strips stay strips."""

PLACED: Final = 3e-3
"""Gaps up to which ends that meet exactly are joined to the inside of a curve, as share of the
diagonal: what is farther from it is a narrow strip that is meant."""

EXACT: Final = 10.0
"""Tolerance, in that of exact points, up to which ends are known to meet exactly: where points
tremble they do not tell a narrow strip from their own noise."""

CROSSING: Final = 1e-2
"""Largest distance, as share of the diagonal, of curves that cross."""

NEAR: Final = 2.0
"""Distance of two joints, in gaps, at which curves that have both of them only pass one another."""

MOST_DOUBTFUL: Final = 40
"""Joints that are tried one by one: each costs a search for all loops."""


def joined_state(
    curves: Sequence[Curve],
    size: float,
    exactly: float,
    cut: Collection[tuple[str, float]] = (),
) -> ProductState:
    """Return a network of curves, joined where they meet or nearly do.

    What has surfaces on both sides already, as the body of a pot and its handle that goes into it,
    is joined only if all surfaces together are better for it. Curves that nearly cross pass one
    another if each meets others close by, as on both sides of a thin plate.

    Parameters
    ----------
    curves : sequence of Curve
        Of the ids n1, n2 …; all are drawn.
    size : float
        Diagonal of the network, mm.
    exactly : float
        The same to a tolerance of one, by which `joints_of` knows what meets, mm.
    cut : collection of (str, float)
        Ids of curves that are shorter than in the file, with the share, 0 or 1, of the end: that it
        meets others there exactly is no sign that it was meant to.
    """
    splines = [curve.spline for curve in curves if curve.spline is not None]
    drawn = ProductState(nodes=tuple(curves))
    # Curves meet within the tolerance of their fit so far; settled, they meet exactly.
    alone, every = (joints_of(splines, exactly, crossing=crossing) for crossing in (False, True))
    state = settled_state(replace(drawn, joints=alone), {})
    if every != alone:
        state = _unless_worse(state, settled_state(replace(drawn, joints=every), {}))
    told = exactly < EXACT * size
    exact = {
        joint.id
        for joint in state.joints
        if told and sum((meet.curve, meet.at) not in cut for meet in joint.meetings) > 1
    }
    for width in WIDTHS:
        closed, _ = ends_joined(state, width * size, placed=exact if width > PLACED else ())
        state = _unless_worse(state, closed)
        state = _unless_worse(state, _as_one(state, width * size, exact))
        if width == CROSSING:
            reach = NEAR * width * size
            closed, _ = crossings_joined(
                state, width * size, passing=partial(_is_between_joints, state, reach)
            )
            state = _unless_worse(state, closed)
    return state


def _as_one(state: ProductState, reach: float, placed: Collection[str]) -> ProductState:
    """Return a network in which joints that are close to one another are one.

    Of four curves that a hand drew to one place two pairs may meet beside one another, or a third
    one a little before the end of the others. Where an edge goes from one joint to the other, both
    are meant, and so they are where ends meet exactly in both; the tail of a curve, up to a quarter
    of it, is no edge.

    Parameters
    ----------
    state : ProductState
        A network of curves without mirror images.
    reach : float
        Farthest that two joints are one, mm.
    placed : collection of str
        Ids of joints that are where they are meant.
    """
    from scipy.spatial import cKDTree

    if len(state.joints) < 2:
        return state
    splines = splines_of(state)
    places = np.array(
        [meeting_place(splines, one.meetings[0], state.symmetry) for one in state.joints]
    )
    pairs = sorted(
        cKDTree(places).query_pairs(reach),
        key=lambda pair: (float(np.linalg.norm(places[pair[0]] - places[pair[1]])), pair),
    )
    for pair in pairs:
        one, other = (state.joints[number] for number in pair)
        if one.id in placed and other.id in placed:
            continue
        own = {meet.curve: meet for meet in one.meetings}
        common = [(own[meet.curve], meet) for meet in other.meetings if meet.curve in own]
        if all(_is_tail(splines, *pair) for pair in common):
            return _as_one(_merged(state, one, other), reach, placed)
    return state


def _is_tail(splines: Mapping[str, Spline], one: Meeting, other: Meeting) -> bool:
    """Whether a curve between two of its meetings is its tail: up to its end, and short."""
    ends = is_end(splines, one) != is_end(splines, other)
    return ends and abs(one.at - other.at) <= TAIL


def _merged(state: ProductState, one: Joint, other: Joint) -> ProductState:
    """Return a network with one joint in the place of two, half-way between them.

    Of a curve that is in both its end is.
    """
    splines = splines_of(state)
    both = (*one.meetings, *other.meetings)
    ends = {meet.curve for meet in both if is_end(splines, meet)}
    kept = tuple(meet for meet in both if is_end(splines, meet) or meet.curve not in ends)
    larger = replace(one, meetings=kept)
    joints = [larger if joint is one else joint for joint in state.joints if joint is not other]
    places = [meeting_place(splines, each.meetings[0], state.symmetry) for each in (one, other)]
    pins = {one.id: np.mean(places, axis=0)}
    return settled_state(replace(state, joints=tuple(joints)), {}, pins)


def _unless_worse(before: ProductState, after: ProductState) -> ProductState:
    """Return a network after more joints, without those that surfaces are better without.

    Only joints of curves that have surfaces on both sides already are in doubt.
    """
    known = {joint.meetings for joint in before.joints}
    fresh = [joint for joint in after.joints if joint.meetings not in known]
    if not fresh:
        return before
    full = _surfaced(before)
    doubtful = [
        joint for joint in fresh if len({meet.curve for meet in joint.meetings} & full) > 1
    ][:MOST_DOUBTFUL]
    if not doubtful:
        return after
    best = _gain(after)
    worse = [joint for joint in doubtful if _gain(_without(before, after, [joint])) > best]
    result = _without(before, after, worse) if worse else after
    alone = _without(before, after, doubtful)
    return alone if _gain(alone) > _gain(result) else result


def _surfaced(state: ProductState) -> set[str]:
    """Return the curves that have surfaces on both sides somewhere."""
    net = net_of_state(state)
    used = Counter(edge for loop in find_loops(net).loops for edge, _ in loop)
    return {net.edges[edge].curve for edge, count in used.items() if count > 1}


def _gain(state: ProductState) -> float:
    """Return how much speaks for the surfaces of a network, all together."""
    return -find_loops(net_of_state(state)).total


def _without(before: ProductState, after: ProductState, gone: Sequence[Joint]) -> ProductState:
    """Return a network after more joints, without some that are as they were before."""
    splines = splines_of(after)
    joints = [joint for joint in after.joints if joint not in gone]
    pins = {joint.id: meeting_place(splines, joint.meetings[0], after.symmetry) for joint in joints}
    taken = {meet for joint in joints for meet in joint.meetings}
    lost = [joint for joint in before.joints if not taken & set(joint.meetings)]
    names = unused_joint_ids(joints, len(lost))
    joints += [replace(joint, id=name) for joint, name in zip(lost, names, strict=True)]
    return settled_state(replace(before, joints=tuple(joints)), {}, pins)


def _is_between_joints(state: ProductState, reach: float, found: Crossing) -> bool:
    """Whether both curves that cross have joints near by, and no common one."""
    splines = splines_of(state)
    first, second = (meet.curve for meet in found.meetings)
    beside: set[str] = set()
    for joint in state.joints:
        there = {meet.curve for meet in joint.meetings} & {first, second}
        if there:
            place = meeting_place(splines, joint.meetings[0], state.symmetry)
            if np.linalg.norm(place - found.place) <= reach:
                beside |= there
    return len(beside) == 2
