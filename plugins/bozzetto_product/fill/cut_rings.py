"""Rings of pieces of curves, cut across into parts that are filled one by one."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Index, cross_product
from bozzetto.errors import UserError
from bozzetto.geometry import Spline
from bozzetto_product.fill.domain import cross
from bozzetto_product.fill.edge_pieces import EdgePiece, pieces_of
from bozzetto_product.fill.fill import CUT
from bozzetto_product.fill.half_sides import SidePiece
from bozzetto_product.fill.loop_fill import key_of
from bozzetto_product.fill.loop_frame import LoopSides
from bozzetto_product.fill.loop_sides import (
    FEWEST,
    TURN,
    is_crowded,
    sides_of_pieces,
    turn_kind,
)
from bozzetto_product.fill.normal_field import NormalField, carried
from bozzetto_product.fill.patch_fill import PatchFill, patch_fill
from bozzetto_product.network.net import Loop

SAMPLES: Final = 16
"""Chords of a piece in the flat outline."""

CUT_PIECES: Final = 4
"""Pieces of a cut: a part may be cut again from its middle."""

SHARPEST: Final = float(np.radians(20.0))
"""Least angle between a cut and the outline."""

FLATTEST: Final = float(np.pi) - 1.2 * TURN
"""Largest angle between a cut and the outline: a side is to end there."""

GOOD: Final = (0.25 * float(np.pi), 0.75 * float(np.pi))
"""Angles between a cut and the outline that cost nothing."""

CONCAVE_GAIN: Final = 0.5
"""Factor on the worth of a cut for each concave corner that it takes away."""

TRIED: Final = (2, 2, 3, 5)
"""Cuts of a part that are tried where so many more may follow; its length is the most cuts."""

MOST_FILLS: Final = 16
"""Parts of a loop that are filled, at most."""

CUT_DEGREES: Final = 1.0
"""Largest angle to the normals along a cut: both parts are to look like one surface."""


@dataclass(frozen=True, eq=False)
class Spot:
    """The start of a piece on the ring of a part.

    Parameters
    ----------
    piece : SidePiece
        That leaves it.
    kink : float
        Turn there, radians, negative where concave.
    normal : (3,) float
        Unit, of the surface.
    flat : (m, 2) float
        The course of the piece in the flat outline, without its end.
    """

    piece: SidePiece
    kink: float
    normal: Array
    flat: Array


Ring = tuple[Spot, ...]
"""The spots of a part, as its outline runs."""

Leading = Callable[[Spot, Spot], tuple[Spline, NormalField] | None]
"""From two spots to a cut from one to the other, over 0 … 1, with the normals along it; None where
no curve can lead across."""


class Search:
    """The search for cuts of a ring.

    Parameters
    ----------
    loop, spacing
        See `Fill`.
    leading : callable
        Makes the cuts.
    accepts : callable
        Says of a part that does not fold whether it is good enough; by default any is.
    most_degrees : float
        Largest angle to the normals of cuts.
    """

    def __init__(
        self,
        loop: Loop,
        spacing: float,
        leading: Leading,
        accepts: Callable[[PatchFill], bool] = lambda fill: True,
        most_degrees: float = CUT_DEGREES,
    ) -> None:
        self._loop = loop
        self._spacing = spacing
        self._leading = leading
        self._accepts = accepts
        self._most_degrees = most_degrees
        self._left = MOST_FILLS

    def parts(self, ring: Ring, most: int, *, whole: bool = False) -> tuple[PatchFill, ...] | None:
        """Return fills of a ring that do not fold, with at most so many cuts; else None."""
        if not whole:
            fill = self._filled(ring)
            if fill is not None:
                return (fill,)
        if not most or self._left <= 0:
            return None
        tried = (_cut(ring, i, j, self._leading) for i, j in best_cuts(ring))
        sound = (two for two in tried if two is not None)
        for two in itertools.islice(sound, TRIED[most - 1]):
            first = self.parts(two[0], most - 1)
            second = None if first is None else self.parts(two[1], most - len(first))
            if first is not None and second is not None:
                return (*first, *second)
        return None

    def _filled(self, ring: Ring) -> PatchFill | None:
        """Return the fill of a part; None where it folds, or leaves the normals of a cut."""
        if not is_plain([spot.kink for spot in ring]) or self._left <= 0:
            return None
        self._left -= 1
        sides = sides_of_pieces(
            [spot.piece for spot in ring],
            [spot.kink for spot in ring],
            [spot.normal for spot in ring],
        )
        frame = LoopSides.of(sides)
        try:
            fill = patch_fill(frame, self._loop, self._spacing, key_of(frame, self._spacing))
        except UserError:
            return None
        if fill.folded or fill.cut_degrees > self._most_degrees or not self._accepts(fill):
            return None
        return fill


def has_halves(kinks: Sequence[float]) -> bool:
    """Whether there are two pieces, at least, between convex corners: the halves of a side."""
    starts = [k for k, kink in enumerate(kinks) if turn_kind(kink) > 0]
    after = [*starts[1:], *(start + len(kinks) for start in starts[:1])]
    return all(b - a >= 2 for a, b in zip(starts, after, strict=True))


def is_plain(kinks: Sequence[float]) -> bool:
    """Whether all sides end at convex corners, and each is bent inward once at most.

    Parameters
    ----------
    kinks : sequence of float
        Turns at the starts of the pieces, radians.
    """
    kinds = [turn_kind(kink) for kink in kinks]
    return kinds.count(1) >= FEWEST and not is_crowded(kinds) and has_halves(kinks)


def best_cuts(ring: Ring) -> Iterator[tuple[int, int]]:
    """Yield pairs of spots between which a ring may be cut, best first.

    A cut is short against what it cuts off, and stands as upright on the outline as it can.
    """
    import shapely

    outline = shapely.Polygon(np.concatenate([spot.flat for spot in ring]))
    if not outline.is_valid:
        return
    room = outline.buffer(1e-6 * float(np.sqrt(outline.area)))
    shapely.prepare(room)
    arc = np.cumsum([0.0, *(spot.piece.piece.length for spot in ring)])
    kinks = [spot.kink for spot in ring]
    one, other = np.triu_indices(len(ring), 1)
    ways = FlatWays.of(ring)
    angles, lengths = ways.cuts(one, ways, other)
    between = arc[other] - arc[one]
    costs = factors_of_angles(angles, ways.kinks[one], ways.kinks[other])
    costs *= lengths / np.minimum(between, arc[-1] - between)
    along = [0.0] * (CUT_PIECES - 1)
    for k in np.argsort(costs, kind="stable").tolist():
        if not np.isfinite(costs[k]):
            return
        i, j, turns = int(one[k]), int(other[k]), (np.pi - angles[k]).tolist()
        first = [turns[0], *kinks[i + 1 : j], turns[3], *along]
        second = [turns[2], *kinks[j + 1 :], *kinks[:i], turns[1], *along]
        if not (has_halves(first) and has_halves(second)):
            continue
        if room.covers(shapely.LineString(ways.spots[[i, j]])):
            yield i, j


@dataclass(frozen=True, eq=False)
class FlatWays:
    """How a ring runs through its spots in the flat outline.

    Parameters
    ----------
    spots, out : (n, 2) float
        Where they are, and the chords that leave them.
    inside : (n,) float
        Angles within the ring, radians.
    kinks : (n,) float
        See `Spot`.
    """

    spots: Array
    out: Array
    inside: Array
    kinks: Array

    @classmethod
    def of(cls, ring: Ring) -> FlatWays:
        """Return the ways of a ring."""
        spots = np.array([spot.flat[0] for spot in ring])
        out = np.array([spot.flat[1] for spot in ring]) - spots
        back = np.array([ring[k - 1].flat[-1] for k in range(len(ring))]) - spots
        kinks = np.array([spot.kink for spot in ring])
        return cls(spots, out, angle_from(out, back), kinks)

    def cuts(self, one: Index, ways: FlatWays, other: Index) -> tuple[Array, Array]:
        """Return how cuts to spots of a ring stand on both outlines, and their lengths.

        Returns
        -------
        angles : (n, 4) float
            On both sides of each cut at its start, and at its end, radians.
        lengths : (n,) float
        """
        way = ways.spots[other] - self.spots[one]
        first, second = angle_from(self.out[one], way), angle_from(ways.out[other], -way)
        angles = (first, self.inside[one] - first, second, ways.inside[other] - second)
        return np.stack(angles, axis=1), np.linalg.norm(way, axis=1)


def factors_of_angles(angles: Array, first: Array, last: Array) -> Array:
    """Return the factors on the costs of cuts by how they stand on the outline, (n,).

    Infinite where one is too sharp, or where a side would not end.

    Parameters
    ----------
    angles : (n, 4) float
        See `FlatWays.cuts`.
    first, last : (n,) float
        Turns of the outlines at the starts and ends, radians, negative where concave.
    """
    unsound = (angles < SHARPEST) | (np.abs(angles - np.pi) < np.pi - FLATTEST)
    factors = 1.0 + np.maximum(GOOD[0] - angles, 0.0).sum(axis=1) / GOOD[0]
    factors *= 1.0 + np.maximum(angles - GOOD[1], 0.0).sum(axis=1) / GOOD[0]
    for kinks, parts in ((first, angles[:, :2]), (last, angles[:, 2:])):
        factors[(kinks <= -TURN) & (parts.max(axis=1) < np.pi)] *= CONCAVE_GAIN
    return np.where(unsound.any(axis=1), np.inf, factors)


def angle_from(one: Array, other: Array) -> Array:
    """Return the angle counter-clockwise from one vector to the other, 0 … 2 π."""
    return np.asarray(np.mod(np.arctan2(cross(one, other), (one * other).sum(axis=-1)), 2 * np.pi))


def _cut(ring: Ring, i: int, j: int, leading: Leading) -> tuple[Ring, Ring] | None:
    """Return both parts of a ring cut between two spots; None where no curve can lead across."""
    led = leading(ring[i], ring[j])
    if led is None:
        return None
    onward, backward = spots_of_cut(ring[i], ring[j], *led)
    return joined_rings(ring[i:j], backward), joined_rings((*ring[j:], *ring[:i]), onward)


def spots_of_cut(one: Spot, other: Spot, spline: Spline, field: NormalField) -> tuple[Ring, Ring]:
    """Return the spots along a cut from one spot to another, and those along it back."""
    pieces = pieces_of(spline, CUT_PIECES)
    line = (one.flat[0], other.flat[0])
    return (
        _spots_along(pieces, field, line, forward=True),
        _spots_along(pieces, field, line, forward=False),
    )


def bridged(one: Spot, other: Spot) -> tuple[Spline, NormalField] | None:
    """Return a curve from one spot to another that leaves both in their planes; see `Leading`."""
    starts = [place_of(spot.piece) for spot in (one, other)]
    ups = [one.normal, other.normal]
    chord = starts[1] - starts[0]
    length = float(np.linalg.norm(chord))
    slopes = []
    for up in ups:
        way = chord - (chord @ up) * up
        size = float(np.linalg.norm(way))
        if size <= 0.1 * length:
            return None
        slopes.append(2.0 * length / (1.0 + size / length) * way / size)
    points = np.stack(
        (starts[0], starts[0] + slopes[0] / 3.0, starts[1] - slopes[1] / 3.0, starts[1])
    )
    spline = Spline(np.repeat((0.0, 1.0), 4), points)
    return spline, carried(spline, ups[0], ups[1])


def place_of(piece: SidePiece) -> Array:
    """Return where a piece starts, as the loop runs."""
    return np.asarray(piece.piece.curve.control_points[0 if piece.forward else -1])


def _spots_along(
    pieces: Sequence[EdgePiece], field: NormalField, line: tuple[Array, Array], *, forward: bool
) -> Ring:
    """Return the spots along a cut."""
    made = []
    for piece in pieces if forward else pieces[::-1]:
        low, high = piece.curve.range
        share = np.linspace(*((low, high) if forward else (high, low)), SAMPLES + 1)[:-1, None]
        flat = (1.0 - share) * line[0] + share * line[1]
        up = field.value(share[:1, 0])[0]
        made.append(Spot(SidePiece(CUT, piece, forward, field), 0.0, up, flat))
    return tuple(made)


def joined_rings(*rows: Ring) -> Ring:
    """Return rows of spots, of which each begins where the one before ends, as one ring."""
    made: list[Spot] = []
    for before, row in zip((rows[-1], *rows[:-1]), rows, strict=True):
        made += [turned_from(row[0], before[-1]), *row[1:]]
    return tuple(made)


def turned_from(spot: Spot, before: Spot) -> Spot:
    """Return a spot with the turn from another one's piece to its own."""
    enter, leave = before.piece.ends()[1], spot.piece.ends()[0]
    turn = np.arctan2(cross_product(enter, leave) @ spot.normal, enter @ leave)
    return Spot(spot.piece, float(turn), spot.normal, spot.flat)
