"""Joints of curves that come from a file: ends that coincide, ends on curves, crossings."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.geometry import Spline
from bozzetto_product.model.joints import Joint, Meeting
from bozzetto_product.operations.clusters import LOOP
from bozzetto_product.operations.own_crossings import own_crossings
from bozzetto_product.projection.spline_basis import chord_length

ENDS: Final = 1e-4
"""Distance within which ends are one, as share of the diagonal: that of the fit."""

ON_CURVE: Final = 3e-4
"""Distance within which an end lies on a curve, or curves cross, as share of the diagonal: the
fits of both are off by a third of it."""

NEAR_END: Final = 3e-3
"""Distance from an end below which a place on a curve is that end, as share of the diagonal."""

LOOKS: Final = 24
"""Places of a curve on each of its spans that are looked at for crossings."""

ROUNDS: Final = 30
"""Most steps from curve to curve towards the place where they cross."""

Place = tuple[int, float, Array]
"""Number of a curve, share of its range, and the place in space."""


def joints_of(
    splines: Sequence[Spline],
    size: float,
    prefix: str = "n",
    *,
    crossing: bool = True,
) -> tuple[Joint, ...]:
    """Return the joints at which curves meet.

    Parameters
    ----------
    splines : sequence of Spline
        In space, mm; the k-th of them, from 1, is the curve of the id ``prefix`` and k.
    size : float
        Diagonal of the network, mm.
    prefix : str
        Of the ids of the curves.
    crossing : bool
        Whether they meet where their insides cross.
    """
    crossed = _crossings(splines, size) if crossing else ()
    places = [*_ends(splines), *_on_curves(splines, size), *crossed]
    if not places:
        return ()
    groups = _clusters(np.array([place for _, _, place in places]), ENDS * size, places, size)
    joints: list[Joint] = []
    for group in groups:
        meetings = _distinct([places[number] for number in group], splines, size)
        if len(meetings) > 1:
            row = tuple(Meeting(f"{prefix}{curve + 1}", at) for curve, at in meetings)
            joints.append(Joint(f"j{len(joints) + 1}", row))
    return tuple(joints)


def _ends(splines: Sequence[Spline]) -> Iterator[Place]:
    for number, spline in enumerate(splines):
        if not spline.closed:
            first, last = spline.value(np.array(spline.range))
            yield number, 0.0, first
            yield number, 1.0, last


def _on_curves(splines: Sequence[Spline], size: float) -> Iterator[Place]:
    """Yield the feet of ends on the inside of other curves."""
    ends = list(_ends(splines))
    if not ends:
        return
    points = np.array([place for _, _, place in ends])
    for number, spline in enumerate(splines):
        box = spline.control_points
        slack = ON_CURVE * size
        inside = ((points >= box.min(0) - slack) & (points <= box.max(0) + slack)).all(axis=1)
        rows = np.flatnonzero(inside)
        if not len(rows):
            continue
        feet = spline.foot_points(points[rows])
        there = spline.value(feet)
        gaps = np.linalg.norm(there - points[rows], axis=1)
        for row, at, gap, place in zip(rows, feet, gaps, there, strict=True):
            if ends[row][0] == number or gap > slack:
                continue
            if not _is_at_end(spline, place, size):
                # The joint is found by the place of the end, which is the better known one.
                yield number, _share(spline, float(at)), points[row]


def _crossings(splines: Sequence[Spline], size: float) -> Iterator[Place]:
    """Yield the places at which the insides of curves cross, on both of them."""
    from scipy.spatial import cKDTree

    paths = [s.sampled(LOOKS * (len(s.control_points) - 3) + 1) for s in splines]
    slack = ON_CURVE * size
    for number, spline in enumerate(splines):
        for first, second, place in own_crossings(spline, slack):
            yield number, first, place
            yield number, second, place
    for one, two in itertools.combinations(range(len(splines)), 2):
        a, b = paths[one], paths[two]
        if (a.max(0) + slack < b.min(0)).any() or (b.max(0) + slack < a.min(0)).any():
            continue
        steps = max(np.linalg.norm(np.diff(path, axis=0), axis=1).max() for path in (a, b))
        distance: Array = np.atleast_1d(cKDTree(b).query(a)[0])
        dips = [k for k in range(len(a)) if distance[k] <= steps + slack
                and distance[k] == distance[max(0, k - 2) : k + 3].min()]  # fmt: skip
        seen: list[Array] = []
        for dip in dips:
            at, p, there, q = met(splines[one], splines[two], a[dip])
            middle = 0.5 * (p + q)
            known = any(np.linalg.norm(other - middle) < NEAR_END * size for other in seen)
            at_end = _is_at_end(splines[one], p, size) or _is_at_end(splines[two], q, size)
            if np.linalg.norm(p - q) > slack or at_end or known:
                continue
            seen.append(middle)
            yield one, _share(splines[one], at), middle
            yield two, _share(splines[two], there), middle


def met(one: Spline, two: Spline, start: Array) -> tuple[float, Array, float, Array]:
    """Return parameter and place of both curves where they come nearest, close to a place."""
    at: Array = one.foot_points(start[None])
    there: Array = two.foot_points(one.value(at))
    for _ in range(ROUNDS):
        # The nearest places of both tangents; then back onto the curves.
        way = two.value(there)[0] - one.value(at)[0]
        rows = np.column_stack((one.derivative(at)[0], -two.derivative(there)[0]))
        step, *_ = np.linalg.lstsq(rows, way, rcond=1e-9)
        nearer, beyond = one.within(at + step[0]), two.within(there + step[1])
        moved = abs(float(nearer[0] - at[0])) + abs(float(beyond[0] - there[0]))
        at, there = nearer, beyond
        if moved < 1e-13:
            break
    return float(at[0]), one.value(at)[0], float(there[0]), two.value(there)[0]


def _share(spline: Spline, at: float) -> float:
    begin, end = spline.range
    return min(1.0, max(0.0, (at - begin) / (end - begin)))


def _is_at_end(spline: Spline, place: Array, size: float) -> bool:
    if spline.closed:
        return False
    ends = spline.value(np.array(spline.range))
    return bool((np.linalg.norm(ends - place, axis=1) <= NEAR_END * size).any())


def _clusters(points: Array, reach: float, places: Sequence[Place], size: float) -> list[list[int]]:
    """Return the numbers of places that are one, in the order of their first."""
    from scipy.cluster.hierarchy import DisjointSet
    from scipy.spatial import cKDTree

    sets = DisjointSet(range(len(points)))
    for one, two in sorted(cKDTree(points).query_pairs(reach + ON_CURVE * size)):
        inner = any(0.0 < places[k][1] < 1.0 for k in (one, two))
        if inner or np.linalg.norm(points[one] - points[two]) <= reach:
            sets.merge(one, two)
    return sorted(sorted(group) for group in sets.subsets())


def _distinct(
    group: Sequence[Place], splines: Sequence[Spline], size: float
) -> list[tuple[int, float]]:
    """Return the places of a joint on the curves, each once; an end rather than a place by it.

    A curve that crosses itself there has two.
    """
    kept: list[tuple[int, float]] = []
    for number, at, _ in sorted(group, key=lambda entry: (entry[0], 0.0 < entry[1] < 1.0)):
        spline = splines[number]
        begin, end = spline.range
        here = spline.value(np.array([begin + at * (end - begin)]))[0]
        others = [
            spline.value(np.array([begin + other * (end - begin)]))[0]
            for curve, other in kept
            if curve == number
            and (0.0 < at < 1.0 or other == at)
            and not _passes_twice(spline, at, other, size)
        ]
        if all(np.linalg.norm(here - other) > NEAR_END * size for other in others):
            kept.append((number, at))
    return kept


def _passes_twice(spline: Spline, one: float, other: float, size: float) -> bool:
    """Whether a curve goes a way round between two shares of its range."""
    way = abs(one - other)
    way = min(way, 1.0 - way) if spline.closed else way
    return way * chord_length(spline) > LOOP * NEAR_END * size
