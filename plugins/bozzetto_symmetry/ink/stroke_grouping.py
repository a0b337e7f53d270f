"""Which strokes belong together: drawn alongside one another, or one continuing another."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto.ink import resample
from bozzetto_symmetry.ink.polyline import length_of

STEP: Final = 4.0
"""Distance of the places at which strokes are compared, px."""

MOST_PLACES: Final = 100
"""Most places of a stroke: bounds the time of many long strokes."""

BESIDE_SHARE: Final = 0.04
"""Distance within which strokes may run alongside, as a share of the longer one's length."""

BESIDE: Final = (8.0, 16.0)
"""Least and greatest of that distance, px."""

PARALLEL: Final = 0.7
"""Cosine of the angle between strokes that run alongside one another."""

GOOD_PART: Final = 0.5
"""Share of the shorter stroke that has to run alongside the other."""

TOUCHING: Final = 2.5
"""Mean distance of two strokes, px, that were surely drawn over one another. Farther apart they
may be the two sides of a pair seen from the side, which the view has to decide."""

CONTINUING: Final = 0.85
"""Cosine of the bend at which one stroke still continues another."""

OVERLAP: Final = 5.0
"""Greatest distance where one stroke takes up the end of another, px."""

GAP_SHARE: Final = 0.04
"""Widest gap of a continued stroke, as a share of the shorter piece."""

GAP: Final = (3.0, 10.0)
"""Least and greatest of that gap, px."""

END: Final = 10.0
"""Length over which the direction of an end is taken, px."""

CONTRAST: Final = 1.3
"""Distance of two groups that are surely one, over that of the strokes within them."""

BENT: Final = 0.25
"""Price of a bend of 90° where strokes have to be united, as a share of the shorter one's
length."""


@dataclass(frozen=True)
class Bond:
    """How two strokes belong together.

    Attributes
    ----------
    distance : float
        Mean distance where they run alongside, or the gap between two ends; px.
    over : bool
        Drawn over one another, at least in part; not merely continued.
    sure : bool
        Close enough by itself; else only where strokes have to be united.
    part : float
        Length that was drawn over, px.
    """

    distance: float
    over: bool
    sure: bool
    part: float = 0.0


@dataclass(frozen=True, eq=False)
class _Trail:
    places: Array
    tangents: Array
    length: float

    @classmethod
    def of(cls, pixels: Array) -> _Trail:
        length = length_of(pixels)
        places = resample(pixels, count=int(np.clip(length / STEP, 8, MOST_PLACES)))
        tangents = np.gradient(places, axis=0)
        tangents /= np.maximum(np.linalg.norm(tangents, axis=1, keepdims=True), 1e-300)
        return cls(places, tangents, length)

    def end(self, last: bool) -> tuple[Array, Array]:
        """Return the place of an end, and the direction in which the stroke leaves through it."""
        spacing = self.length / (len(self.places) - 1)
        back = int(np.clip(round(END / max(spacing, 1e-9)), 1, len(self.places) - 1))
        at, inner = (-1, -1 - back) if last else (0, back)
        way = self.places[at] - self.places[inner]
        return self.places[at], way / max(float(np.linalg.norm(way)), 1e-300)


def group_strokes(
    lines: Sequence[Array], *, apart: bool = False, pieces: Iterable[tuple[int, int]] = ()
) -> list[list[int]]:
    """Put strokes in one or two groups, the one of the first stroke first.

    Strokes that run alongside one another over a good part of the shorter one, or continue
    one another, belong together; strokes that merely cross do not. Where more than two
    groups are left, those are united that continue or accompany one another best. The last
    two are united only where nothing else can be meant: the two sides of a pair may be as
    near to one another as the strokes of a scribble, and the halves of a curve across the
    plane continue one another. `bozzetto_symmetry.interpretation.side_reading`
    decides what two groups mean.

    Parameters
    ----------
    lines : sequence of (n, 2) float
        Each stroke smoothed, px.
    apart : bool
        Two groups are wanted.
    pieces : iterable of (int, int)
        Numbers of two strokes that are known to be pieces of one line.
    """
    count = len(lines)
    if count == 1:
        return [[0]]
    bonds = bonds_between(lines)
    groups = {k: {k} for k in range(count)}
    least = 1 if not apart else 2
    sizes = [length_of(line) for line in lines]
    links = _Links(bonds, sizes)
    for piece in pieces:
        one, other = sorted(next(k for k in groups if number in groups[k]) for number in piece)
        if one != other:
            groups[one] |= groups.pop(other)
            links.unite(one, other)
    while len(groups) > least:
        first, second, bond = links.nearest()
        last_two = len(groups) == 2
        if last_two and not _one_side(list(groups.values()), bonds, bond, sizes):
            break
        groups[first] |= groups.pop(second)
        links.unite(first, second)
    return [sorted(group) for group in sorted(groups.values(), key=min)]


class _Links:
    """The bonds between all groups; uniting two of them costs one row.

    Where several strokes run alongside, the mean of their distances counts, as in average
    linkage: one stroke that strays towards the other side does not unite the sides.

    Parameters
    ----------
    bonds : list of list of Bond
        Of each stroke with each other one.
    sizes : sequence of float
        Lengths of the strokes, px.
    """

    def __init__(self, bonds: Sequence[Sequence[Bond]], sizes: Sequence[float]) -> None:
        count = len(bonds)
        over = np.array([[bond.over and bond.sure for bond in row] for row in bonds])
        sure = np.array([[bond.sure for bond in row] for row in bonds])
        distance = np.array([[bond.distance for bond in row] for row in bonds])
        shorter = np.minimum.outer(np.asarray(sizes), np.asarray(sizes))
        self._weight = np.where(over, shorter, 0.0)
        self._total = np.where(over, shorter * np.where(over, distance, 0.0), 0.0)
        self._over = over
        self._sure = np.where(sure, distance, np.inf)
        self._loose = np.where(sure, np.inf, distance)
        self._gone = ~np.tri(count, k=-1, dtype=bool)

    def nearest(self) -> tuple[int, int, Bond]:
        """Return the two groups that belong together most: sure ones first, then by distance."""
        with np.errstate(invalid="ignore", divide="ignore"):
            along = np.where(self._over, self._total / self._weight, np.inf)
        surely = np.where(self._over, along, self._sure)
        surely[self._gone] = np.inf
        loosely = np.where(np.isfinite(surely) | self._gone, np.inf, self._loose)
        sure = bool(np.isfinite(surely).any())
        found = surely if sure else loosely
        second, first = np.unravel_index(int(found.argmin()), found.shape)
        over = sure and bool(self._over[second, first])
        return int(first), int(second), Bond(float(found[second, first]), over, sure)

    def unite(self, first: int, second: int) -> None:
        """Put the second group into the first."""
        for table, together in (
            (self._weight, np.add),
            (self._total, np.add),
            (self._over, np.logical_or),
            (self._sure, np.minimum),
            (self._loose, np.minimum),
        ):
            row = together(table[first], table[second])
            table[first], table[:, first] = row, row
        self._gone[second], self._gone[:, second] = True, True


def _one_side(
    groups: Sequence[set[int]],
    bonds: Sequence[Sequence[Bond]],
    bond: Bond,
    sizes: Sequence[float],
) -> bool:
    """Return whether the last two groups are surely one side."""
    drawn_over = sum(bonds[i][j].part for i in groups[0] for j in groups[1])
    shorter = min(sum(sizes[i] for i in group) for group in groups)
    if not (bond.over and bond.sure) or drawn_over < GOOD_PART * shorter:
        return False
    within = [
        bonds[i][j].distance
        for group in groups
        for i in group
        for j in group
        if i < j and bonds[i][j].over and bonds[i][j].sure
    ]
    return bond.distance <= max(TOUCHING, CONTRAST * float(np.mean(within or [0.0])))


def bonds_between(lines: Sequence[Array]) -> list[list[Bond]]:
    """Return the bond of each stroke with each other one."""
    trails = [_Trail.of(line) for line in lines]
    none = Bond(np.inf, False, False)
    made = [[none] * len(trails) for _ in trails]
    for j in range(1, len(trails)):
        for i in range(j):
            made[i][j] = made[j][i] = _between(trails[i], trails[j])
    return made


def any_drawn_over(lines: Sequence[Array]) -> bool:
    """Return whether any two strokes were drawn over one another."""
    trails = [_Trail.of(line) for line in lines]
    return any(_between(one, other).over for one, other in combinations(trails, 2))


def _between(one: _Trail, other: _Trail) -> Bond:
    offset = one.places[:, None] - other.places
    apart = np.linalg.norm(offset, axis=2)
    reach = float(np.clip(BESIDE_SHARE * max(one.length, other.length), *BESIDE))
    shorter, longer, square = (
        (one, other, apart) if one.length <= other.length else (other, one, apart.T)
    )
    nearest = square.argmin(axis=1)
    rows = np.arange(len(nearest))
    # Places stand some pixels apart along the stroke: only the distance across it counts.
    tangents = longer.tangents[nearest]
    step = shorter.places - longer.places[nearest]
    across = np.abs(step[:, 0] * tangents[:, 1] - step[:, 1] * tangents[:, 0])
    inside = (nearest > 0) & (nearest < len(longer.places) - 1)
    distance = np.where(inside, across, square[rows, nearest])
    cosine = np.abs((shorter.tangents * tangents).sum(axis=1))
    beside = (distance < reach) & (cosine > PARALLEL)
    if beside.mean() < GOOD_PART:
        beside = (distance < OVERLAP) & (cosine > CONTINUING)
        if not _overlapping(beside, nearest, len(longer.places)):
            return _continued(one, other)
    part = float(beside.mean()) * shorter.length
    return Bond(float(distance[beside].mean()), True, True, part)


def _overlapping(beside: Flags, nearest: Index, count: int) -> bool:
    """Return whether one stroke begins alongside the end of the other and so continues it."""
    if beside.sum() < 3 or beside.sum() != np.ptp(np.flatnonzero(beside)) + 1:
        return False
    own_end = bool(beside[0] or beside[-1])
    met = nearest[beside]
    return own_end and bool(met.min() == 0 or met.max() == count - 1)


def _continued(one: _Trail, other: _Trail) -> Bond:
    """Return the best joint of an end of one stroke with an end of the other."""
    shorter = min(one.length, other.length)
    widest = float(np.clip(GAP_SHARE * shorter, *GAP))
    best = Bond(np.inf, False, False)
    for last in (False, True):
        place, way = one.end(last)
        for other_last in (False, True):
            there, back = other.end(other_last)
            gap = float(np.linalg.norm(there - place))
            straight = float(-(way @ back))
            ahead = gap < GAP[0] or float(way @ (there - place)) > 0.5 * gap
            if gap <= widest and straight > CONTINUING and ahead:
                found = Bond(gap, False, True)
            else:
                found = Bond(gap + BENT * shorter * (1.0 - straight), False, False)
            best = min(best, found, key=lambda bond: (not bond.sure, bond.distance))
    return best
