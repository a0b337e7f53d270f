"""Ends of curves that belong together: union-find, with mirror images counted once.

An end of a curve that has a mirror image stands for two ends. Two ends are joined as they are, or
one with the mirror image of the other; union-find keeps for each member on which side of the
plane it is, seen from the first. Where a circle of such relations ends on the other side, all of
it lies in the plane.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto_product.model.planes import Plane
from bozzetto_product.projection.planes import heights, mirror_image

LOOP: Final = 6.0
"""Least length, in gaps, of a curve whose own ends are joined to one another."""


@dataclass(frozen=True, eq=False)
class End:
    """An end of a curve, or a joint that is there already.

    Parameters
    ----------
    place : (3,) float
        mm.
    gap : float
        Largest distance, mm, over which it is joined.
    weight : float
        Length of its curve, mm.
    image : bool
        It has a mirror image.
    flat : bool
        It lies in the symmetry plane.
    curve, at
        Id of the curve, and 0 or 1; "" for a joint.
    joint : str
        Id of the joint; "" for a free end.
    held : tuple of (str, float)
        Curves that meet in the joint, and at which share of their range.
    """

    place: Array
    gap: float
    weight: float
    image: bool
    flat: bool = False
    curve: str = ""
    at: float = 0.0
    joint: str = ""
    held: tuple[tuple[str, float], ...] = ()


@dataclass(eq=False)
class Cluster:
    """Ends that belong together.

    Attributes
    ----------
    members : list of (int, bool)
        Number of the end, and whether it is on the other side of the plane than the first.
    flat : bool
        All of it lies in the symmetry plane.
    """

    members: list[tuple[int, bool]] = field(default_factory=list)
    flat: bool = False


def clusters_of(ends: Sequence[End], symmetry: Plane) -> list[Cluster]:
    """Return the groups of ends that nearly meet, each end in one.

    Nearer ones are joined first. Two joints that are there already are never made one, nor are both
    ends of a curve that is short, nor a joint and the tail of a curve that runs past it.

    Parameters
    ----------
    ends : sequence of End
        In an order that does not depend on how the curves are listed: ties go by it.
    symmetry : Plane
        In which mirror images are.
    """
    clusters = [Cluster([(number, False)], end.flat) for number, end in enumerate(ends)]
    home = list(range(len(ends)))
    for _, one, other, across in sorted(_near_pairs(ends, symmetry)):
        _join(clusters, home, ends, one, other, across)
    for number, end in enumerate(ends):
        if end.image and abs(float(heights(end.place, symmetry))) <= end.gap:
            clusters[home[number]].flat = True
    return [clusters[number] for number in sorted(set(home))]


def is_tail(end: End, joint: End) -> bool:
    """Whether a free end is that of a curve that runs a little past a joint that it meets in.

    A short stretch of a curve cannot begin and end in one place: such a tail stays free.
    """
    return any(
        curve == end.curve and abs(share - end.at) * end.weight < LOOP * end.gap
        for curve, share in joint.held
    )


def target_of(cluster: Cluster, ends: Sequence[End], symmetry: Plane) -> Array:
    """Return where a cluster meets, mm, on the side of its first member.

    The mean, weighted by the lengths of the curves; the place of a joint that is there already.
    """
    places = [
        mirror_image(ends[number].place, symmetry) if across else ends[number].place
        for number, across in cluster.members
    ]
    for place, (number, _) in zip(places, cluster.members, strict=True):
        if ends[number].joint:
            return np.asarray(place)
    weights = np.array([max(ends[number].weight, 1e-300) for number, _ in cluster.members])
    middle = places[0]
    offset = np.array(places) - middle
    return np.asarray(middle + weights @ offset / weights.sum())


def _near_pairs(ends: Sequence[End], symmetry: Plane) -> list[tuple[float, int, int, bool]]:
    """Return distance, two ends, and whether one is met by the mirror image of the other."""
    from scipy.spatial import cKDTree

    if len(ends) < 2:
        return []
    places = np.array([end.place for end in ends])
    widest = max(end.gap for end in ends)
    pairs: list[tuple[float, int, int, bool]] = []
    for across, others in ((False, places), (True, mirror_image(places, symmetry))):
        for one, found in enumerate(cKDTree(others).query_ball_point(places, widest)):
            for other in found:
                if other <= one or (across and not (ends[one].image or ends[other].image)):
                    continue
                # From the lower number, so that the distance is the same however it is met.
                distance = float(np.linalg.norm(places[one] - others[other]))
                if distance <= min(ends[one].gap, ends[other].gap):
                    pairs.append((distance, one, other, across))
    return pairs


def _join(
    clusters: list[Cluster],
    home: list[int],
    ends: Sequence[End],
    one: int,
    other: int,
    across: bool,
) -> None:
    first, second = home[one], home[other]
    side = _side(clusters[first], one) ^ _side(clusters[second], other) ^ across
    if first == second:
        clusters[first].flat |= side
        return
    first, second = min(first, second), max(first, second)
    kept, taken = clusters[first], clusters[second]
    numbers = [number for number, _ in (*kept.members, *taken.members)]
    if len({ends[number].joint for number in numbers if ends[number].joint}) > 1:
        return
    seen: dict[str, int] = {}
    for number in numbers:
        end = ends[number]
        if end.curve and end.curve in seen and end.weight < LOOP * end.gap:
            return
        if any(is_tail(end, ends[joint]) for joint in numbers):
            return
        seen[end.curve] = number
    kept.members.extend((number, away ^ side) for number, away in taken.members)
    kept.flat |= taken.flat
    for number, _ in taken.members:
        home[number] = first


def _side(cluster: Cluster, number: int) -> bool:
    return next(across for member, across in cluster.members if member == number)
