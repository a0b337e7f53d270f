"""Cuts between the outline of a region and the holes in it, so that no part has a hole.

Short cuts that stand upright on both outlines come first. Each is kept that crosses no other one,
leaves halves of sides on both of its own, and is in a part that cannot be filled as it is.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto_product.fill.cut_rings import (
    CUT_PIECES,
    FlatWays,
    Leading,
    Ring,
    Spot,
    factors_of_angles,
    has_halves,
    is_plain,
    joined_rings,
    spots_of_cut,
)
from bozzetto_product.fill.loop_sides import FEWEST, turn_kind

LEAST_SHARE: Final = 0.15
"""Least share of a hole between two cuts from it: parts get no thinner."""

MOST_SIDES: Final = 7
"""Sides of a part, at most: with more, patches are slow and leave the guide of the loop."""


@dataclass(frozen=True)
class _Cut:
    """A cut between two spots.

    Parameters
    ----------
    ends : (int, int)
        Their numbers.
    angles : tuple of float
        See `FlatWays.cuts`.
    """

    ends: tuple[int, int]
    angles: tuple[float, float, float, float]


@dataclass(frozen=True)
class _Step:
    """A piece of an outline, or a cut, as a part is run round.

    Parameters
    ----------
    spot : int
        Where it begins.
    cut : int
        Number of the cut; −1 for a piece.
    turn : float
        There, radians.
    """

    spot: int
    cut: int
    turn: float


def parted_region(outer: Ring, holes: Sequence[Ring], leading: Leading) -> list[Ring]:
    """Return the rings into which cuts part a region; none where a hole cannot be cut free.

    Parameters
    ----------
    outer : Ring
        The outline.
    holes : sequence of Ring
        Those in it, which run the other way.
    leading : callable
        Makes the cuts.
    """
    region = _Region.of((outer, *holes))
    cuts: list[_Cut] = []
    for cut in region.possible_cuts():
        cycles = region.cycles(cuts)
        if all(map(_is_good, cycles)):
            break
        if region.fits(cut, cuts, cycles):
            cuts.append(cut)
    cycles = region.cycles(cuts)
    if any(_has_slit(cycle) for cycle in cycles) or len(cycles) != len(cuts) - len(holes) + 1:
        return []
    return region.rings(cuts, cycles, leading)


def _has_slit(cycle: Sequence[_Step]) -> bool:
    """Whether a part is on both sides of a cut."""
    cuts = [step.cut for step in cycle if step.cut >= 0]
    return len(set(cuts)) < len(cuts)


def _kinks(cycle: Sequence[_Step]) -> list[float]:
    """Return the turns at the starts of the pieces of a part, radians."""
    made: list[float] = []
    for step in cycle:
        made += [step.turn, *([0.0] * (CUT_PIECES - 1 if step.cut >= 0 else 0))]
    return made


def _is_good(cycle: Sequence[_Step]) -> bool:
    """Whether a part can be filled as it is."""
    kinks = _kinks(cycle)
    few = sum(turn_kind(kink) > 0 for kink in kinks) <= MOST_SIDES
    return few and not _has_slit(cycle) and is_plain(kinks)


@dataclass(frozen=True, eq=False)
class _Region:
    """The spots of an outline and of holes in it.

    Parameters
    ----------
    spots : tuple of Spot
        Those of the outline first.
    ways : FlatWays
        Of all of them.
    following : (n,) int
        Number of the spot after each.
    owners : (n,) int
        Number of the outline of each.
    shares : (n,) float
        Where each is on its outline, as share of its length.
    starts : tuple of int
        Number of the first spot of each outline, and of all spots.
    """

    spots: tuple[Spot, ...]
    ways: FlatWays
    following: Index
    owners: Index
    shares: Array
    starts: tuple[int, ...]

    @classmethod
    def of(cls, rings: Sequence[Ring]) -> _Region:
        """Return the region of an outline and of holes."""
        starts = np.cumsum([0, *map(len, rings)])
        ways = [FlatWays.of(ring) for ring in rings]
        shares = []
        for ring in rings:
            ends = np.cumsum([spot.piece.piece.length for spot in ring])
            shares.append(np.append(0.0, ends[:-1]) / ends[-1])
        return cls(
            tuple(spot for ring in rings for spot in ring),
            FlatWays(
                np.concatenate([each.spots for each in ways]),
                np.concatenate([each.out for each in ways]),
                np.concatenate([each.inside for each in ways]),
                np.concatenate([each.kinks for each in ways]),
            ),
            np.concatenate(
                [a + np.roll(np.arange(b - a), -1) for a, b in itertools.pairwise(starts)]
            ),
            np.repeat(np.arange(len(rings)), [len(ring) for ring in rings]),
            np.concatenate(shares),
            tuple(starts.tolist()),
        )

    def possible_cuts(self) -> Iterator[_Cut]:
        """Yield cuts between different outlines that nothing is in the way of, the best first."""
        import shapely

        flat = [spot.flat for spot in self.spots]
        lines = [np.concatenate(flat[a:b]) for a, b in itertools.pairwise(self.starts)]
        whole = shapely.Polygon(lines[0], lines[1:])
        if not whole.is_valid:
            return
        room = whole.buffer(1e-6 * float(np.sqrt(whole.area)))
        shapely.prepare(room)
        one, other = np.triu_indices(len(self.spots), 1)
        apart = self.owners[one] != self.owners[other]
        one, other = one[apart], other[apart]
        angles, lengths = self.ways.cuts(one, self.ways, other)
        costs = lengths * factors_of_angles(angles, self.ways.kinks[one], self.ways.kinks[other])
        for k in np.argsort(costs, kind="stable").tolist():
            if not np.isfinite(costs[k]):
                return
            ends = int(one[k]), int(other[k])
            if room.covers(shapely.LineString(self.ways.spots[list(ends)])):
                a, b, c, d = angles[k].tolist()
                yield _Cut(ends, (a, b, c, d))

    def cycles(self, cuts: Sequence[_Cut]) -> list[list[_Step]]:
        """Return the parts that cuts make, each as its border is run."""
        at: dict[int, tuple[int, int]] = {}
        for number, cut in enumerate(cuts):
            for end, spot in enumerate(cut.ends):
                at[spot] = number, end
        left: dict[tuple[int, int], None] = dict.fromkeys((k, -1) for k in range(len(self.spots)))
        left |= dict.fromkeys((spot, number) for spot, (number, _) in at.items())
        made = []
        while left:
            spot, number = next(iter(left))
            cycle: list[_Step] = []
            while (spot, number) in left:
                del left[spot, number]
                turn = float(self.ways.kinks[spot])
                if spot in at:
                    own, end = at[spot]
                    beside = cuts[own].angles[2 * end : 2 * end + 2]
                    turn = float(np.pi - beside[0 if number < 0 else 1])
                cycle.append(_Step(spot, number, turn))
                if number >= 0:
                    spot, number = cuts[number].ends[1 - at[spot][1]], -1
                else:
                    spot = int(self.following[spot])
                    number = at[spot][0] if spot in at else -1
            made.append(cycle)
        return made

    def fits(self, cut: _Cut, cuts: Sequence[_Cut], cycles: Sequence[Sequence[_Step]]) -> bool:
        """Whether a cut can be added to others, and helps."""
        taken = {spot for other in cuts for spot in other.ends}
        if not taken.isdisjoint(cut.ends) or self._is_beside(cut, cuts):
            return False
        if any(self._crosses(cut, other) for other in cuts):
            return False
        around = [[c for c in cycles if any(s.spot == spot for s in c)] for spot in cut.ends]
        both = [c for c in around[0] if c in around[1]]
        if both and _is_good(both[0]):
            return False
        number = len(cuts)
        made = [
            cycle
            for cycle in self.cycles([*cuts, cut])
            if any(step.cut == number for step in cycle)
        ]
        return all(
            has_halves(kinks := _kinks(cycle))
            and sum(turn_kind(kink) > 0 for kink in kinks) >= FEWEST
            for cycle in made
        )

    def _is_beside(self, cut: _Cut, cuts: Sequence[_Cut]) -> bool:
        """Whether a cut leaves a hole beside another one that does."""
        for spot in cut.ends:
            for other in (end for each in cuts for end in each.ends):
                if self.owners[other] == self.owners[spot] > 0:
                    share = abs(float(self.shares[spot] - self.shares[other]))
                    if min(share, 1.0 - share) < LEAST_SHARE:
                        return True
        return False

    def _crosses(self, cut: _Cut, other: _Cut) -> bool:
        (a, b), (c, d) = (self.ways.spots[list(each.ends)] for each in (cut, other))

        def left(p: Array, q: Array, r: Array) -> bool:
            return bool((q[0] - p[0]) * (r[1] - p[1]) > (q[1] - p[1]) * (r[0] - p[0]))

        return left(a, b, c) != left(a, b, d) and left(c, d, a) != left(c, d, b)

    def rings(
        self, cuts: Sequence[_Cut], cycles: Sequence[Sequence[_Step]], leading: Leading
    ) -> list[Ring]:
        """Return parts as rings; none where no curve can lead across."""
        ways: list[tuple[Ring, Ring]] = []
        for cut in cuts:
            one, other = (self.spots[spot] for spot in cut.ends)
            led = leading(one, other)
            if led is None:
                return []
            ways.append(spots_of_cut(one, other, *led))
        made = []
        for cycle in cycles:
            rows: list[Ring] = []
            for step in cycle:
                if step.cut >= 0:
                    rows.append(ways[step.cut][cuts[step.cut].ends.index(step.spot)])
                else:
                    rows.append((self.spots[step.spot],))
            made.append(_with_turns(rows, cycle))
        return made


def _with_turns(rows: Sequence[Ring], cycle: Sequence[_Step]) -> Ring:
    """Return rows of spots as a ring: only those beside cuts turn otherwise than before."""
    made: list[Spot] = []
    before = cycle[-1]
    for place, (row, step) in enumerate(zip(rows, cycle, strict=True)):
        if step.cut >= 0 or before.cut >= 0:
            row = (*joined_rings(rows[place - 1], row)[len(rows[place - 1]) :],)
        made += row
        before = step
    return tuple(made)
