"""Trim: ends of curves that nearly meet are joined, and joints are kept.

Kara & Shimada, book chapter, section 13.2.2, merge ends that are close to one another. Here an end
may also be joined to the inside of a curve, which then carries it, and to the mirror plane. The
outcome does not depend on the order of the curves. What is farther apart is proposed, not done.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto_product.model.joints import Joint
from bozzetto_product.model.state import ProductState
from bozzetto_product.operations.cluster_joints import (
    joints_of_cluster,
    laid_together,
    without_overlaps,
)
from bozzetto_product.operations.clusters import clusters_of
from bozzetto_product.operations.crossings import Crossing, crossings_of
from bozzetto_product.operations.free_ends import network_ends
from bozzetto_product.operations.meetings import (
    splines_of,
    unused_joint_ids,
)
from bozzetto_product.operations.proposals import Proposal, proposals_of
from bozzetto_product.operations.settling import settled_state
from bozzetto_product.operations.tangents import smooth_over_joints, smooth_over_plane

GAP: Final = 0.02
"""Largest gap that is closed, as a share of the diagonal of all curves."""

FARTHEST: Final = 3.0
"""Farthest that closing gaps may move a curve anywhere, in gaps that are closed. Curves that end on
one another, and cross besides, would draw each other away without an end."""

AS_FAR: Final = 0.9
"""Share of the farthest move from which on a curve is held to be moved as far."""

LOOKS: Final = 33
"""Places of a curve at which it is looked how far it moved."""


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
        made.extend(joints_of_cluster(cluster, ends, state, old, placed))
    made = laid_together(without_overlaps(made, state), state, width)
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


def default_gap(state: ProductState) -> float:
    """Return the gap that is closed by default, mm; 0 without curves."""
    splines = splines_of(state)
    if not splines:
        return 0.0
    points = np.vstack([spline.sampled(33) for spline in splines.values()])
    return GAP * float(np.linalg.norm(np.ptp(points, axis=0)))
