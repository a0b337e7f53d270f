"""Cuts across a loop that is bent inward, and the fill of the parts between them.

Patches round one centre need a domain that is seen from its centre. A C, or a strip bent round a
corner, has none. It is cut across, from one piece of an edge to another, as long as a part folds.
A cut is a curve of the surface: both parts take the same normals along it.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, cross_product
from bozzetto.errors import UserError
from bozzetto.geometry import Spline
from bozzetto.plugin import cached_property
from bozzetto_product.fill.domain import cross
from bozzetto_product.fill.edge_pieces import EdgePiece, pieces_of
from bozzetto_product.fill.fair_solution import LoopSides
from bozzetto_product.fill.fill import CUT
from bozzetto_product.fill.half_sides import SidePiece
from bozzetto_product.fill.loop_fill import SHORTEST, key_of
from bozzetto_product.fill.loop_sides import (
    FEWEST,
    TURN,
    is_crowded,
    sides_of_pieces,
    turn_kind,
)
from bozzetto_product.fill.normal_field import NormalField, across, angle_about, carried, rotated
from bozzetto_product.fill.normals import LoopNormals
from bozzetto_product.fill.parted_fill import PartedFill
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
class _Spot:
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


Ring = tuple[_Spot, ...]
"""The spots of a part, as its outline runs."""


def parted_fill(
    loop: Loop,
    normals: LoopNormals,
    pieces: Sequence[Sequence[EdgePiece]],
    spacing: float,
) -> PartedFill | None:
    """Fill a loop in parts, none of which folds; None where no cuts were found that do it.

    Parameters
    ----------
    loop, spacing
        See `Fill`.
    normals : LoopNormals
        Along its half edges.
    pieces : sequence of sequence of EdgePiece
        Those of each half edge, in the sense of the edge.
    """
    lengths = [piece.length for own in pieces for piece in own]
    if not min(lengths) > SHORTEST * max(lengths):
        return None
    course = _Course.of(loop, normals, pieces)
    for flatten in (_unrolled, _projected):
        ring = _ring_of(course, flatten)
        if ring is None:
            continue
        found = _Search(loop, spacing).parts(ring, len(TRIED), whole=True)
        if found is not None:
            return PartedFill.of(loop, found)
    return None


class _Search:
    """The search for cuts of one loop; see `parted_fill`."""

    def __init__(self, loop: Loop, spacing: float) -> None:
        self._loop = loop
        self._spacing = spacing
        self._left = MOST_FILLS

    def parts(self, ring: Ring, most: int, *, whole: bool = False) -> tuple[PatchFill, ...] | None:
        """Return fills of a ring that do not fold, with at most so many cuts; else None."""
        if not whole:
            fill = self._filled(ring)
            if fill is not None:
                return (fill,)
        if not most or self._left <= 0:
            return None
        tried = (_cut(ring, i, j) for i, j in _best_cuts(ring))
        sound = (two for two in tried if two is not None)
        for two in itertools.islice(sound, TRIED[most - 1]):
            first = self.parts(two[0], most - 1)
            second = None if first is None else self.parts(two[1], most - len(first))
            if first is not None and second is not None:
                return (*first, *second)
        return None

    def _filled(self, ring: Ring) -> PatchFill | None:
        """Return the fill of a part; None where it folds, or leaves the normals of a cut."""
        if not _is_plain(ring) or self._left <= 0:
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
        return None if fill.folded or fill.cut_degrees > CUT_DEGREES else fill


def _has_halves(kinks: Sequence[float]) -> bool:
    """Whether there are two pieces, at least, between convex corners: the halves of a side."""
    starts = [k for k, kink in enumerate(kinks) if turn_kind(kink) > 0]
    after = [*starts[1:], *(start + len(kinks) for start in starts[:1])]
    return all(b - a >= 2 for a, b in zip(starts, after, strict=True))


def _is_plain(ring: Ring) -> bool:
    """Whether all sides end at convex corners, and each is bent inward once at most."""
    kinks = [spot.kink for spot in ring]
    kinds = [turn_kind(kink) for kink in kinks]
    return kinds.count(1) >= FEWEST and not is_crowded(kinds) and _has_halves(kinks)


# -- the ring of a loop ----------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class _Course:
    """The pieces of a loop, once round.

    Parameters
    ----------
    pieces : tuple of SidePiece
    places, normals : (n, m, 3) float
        Along each piece, with both of its ends, and unit normals of the surface there.
    kinks : (n,) float
        Turns at the starts of the pieces, radians.
    """

    pieces: tuple[SidePiece, ...]
    places: Array
    normals: Array
    kinks: Array

    @classmethod
    def of(cls, loop: Loop, normals: LoopNormals, pieces: Sequence[Sequence[EdgePiece]]) -> _Course:
        """Return the course of a loop; see `parted_fill`."""
        owners: list[SidePiece] = []
        places: list[Array] = []
        upright: list[Array] = []
        kinks: list[float] = []
        for number, (_, forward) in enumerate(loop):
            corner, after = normals.corners[number], normals.corners[(number + 1) % len(loop)]
            field = normals.fields[number]
            sense = 1 if forward else -1
            own = pieces[number][::sense]
            at = [np.linspace(*piece.curve.range, SAMPLES + 1)[::sense] for piece in own]
            rows = [piece.curve.value(each) for piece, each in zip(own, at, strict=True)]
            if field is None:
                along = np.concatenate([rows[0][:1], *(each[1:] for each in rows)])
                even = _carried_along(along, corner.normal, after.normal)
                ups = [even[k * SAMPLES : (k + 1) * SAMPLES + 1] for k in range(len(own))]
            else:
                ups = [field.value(each) for each in at]
            ups[0][0] = corner.normal
            places += rows
            upright += ups
            owners += [SidePiece(number, piece, forward, field) for piece in own]
            kinks += [corner.turn, *([0.0] * (len(own) - 1))]
        return cls(tuple(owners), np.array(places), np.array(upright), np.array(kinks))

    @cached_property
    def steps(self) -> Array:
        """Chords along all pieces, (n m - n, 3)."""
        return np.diff(self.places, axis=1).reshape(-1, 3)

    @cached_property
    def turns(self) -> Array:
        """How far each chord turns from the one before about the normal, radians."""
        up = self.normals[:, :-1].reshape(-1, 3)
        before = np.roll(self.steps, 1, axis=0)
        sine = (cross_product(before, self.steps) * up).sum(axis=1)
        turns = np.arctan2(sine, (before * self.steps).sum(axis=1))
        told = np.abs(self.kinks) > TURN
        turns[np.arange(0, len(turns), SAMPLES)[told]] = self.kinks[told]
        return np.asarray(turns)


def turn_round(loop: Loop, normals: LoopNormals, pieces: Sequence[Sequence[EdgePiece]]) -> float:
    """Return how far a loop turns once round, radians: 2 π on a plane (Gauss and Bonnet).

    Parameters
    ----------
    loop, normals, pieces
        See `parted_fill`.
    """
    return float(_Course.of(loop, normals, pieces).turns.sum())


def _ring_of(course: _Course, flatten: Callable[[_Course], Array | None]) -> Ring | None:
    """Return the ring of a loop; None where its flat outline crosses itself."""
    flat = flatten(course)
    if flat is None:
        return None
    return tuple(
        _Spot(piece, float(kink), rows[0], own)
        for piece, kink, rows, own in zip(
            course.pieces, course.kinks, course.normals, flat, strict=True
        )
    )


def _carried_along(places: Array, first: Array, last: Array) -> Array:
    """Return unit normals along a crease that turn evenly between those at its ends, (n, 3)."""
    steps = np.diff(places, axis=0)
    steps = np.concatenate((steps[:1], steps[:-1] + steps[1:], steps[-1:]))
    tangents = steps / np.maximum(np.linalg.norm(steps, axis=1, keepdims=True), 1e-300)
    made = np.empty_like(places)
    normal = first
    for k, tangent in enumerate(tangents):
        normal = across(normal[None], tangent[None])[0]
        made[k] = normal
    arc = np.cumsum([0.0, *np.linalg.norm(np.diff(places, axis=0), axis=1)])
    rest = angle_about(tangents[-1], made[-1], last)
    return rotated(made, tangents, rest * arc / max(float(arc[-1]), 1e-300))


def _unrolled(course: _Course) -> Array | None:
    """Return a course laid out in the plane, (n, m - 1, 2).

    Lengths and turns are those on the surface. What the turns are from once round, and what is
    left open, is spread by length.
    """
    turns, lengths = course.turns, np.linalg.norm(course.steps, axis=1)
    own = lengths / lengths.sum()
    way = np.cumsum(turns) + (2 * np.pi - turns.sum()) * (np.cumsum(own) - 0.5 * own)
    made = lengths[:, None] * np.column_stack((np.cos(way), np.sin(way)))
    made -= own[:, None] * made.sum(axis=0)
    flat = np.concatenate((np.zeros((1, 2)), np.cumsum(made, axis=0)[:-1]))
    return _simple(flat, len(course.pieces))


def _projected(course: _Course) -> Array | None:
    """Return a course as it is seen along the normal of its area; see `_unrolled`."""
    ring = course.places[:, :-1].reshape(-1, 3)
    ring = ring - ring.mean(axis=0)
    area = cross_product(ring, np.roll(ring, -1, axis=0)).sum(axis=0)
    normal = area / max(float(np.linalg.norm(area)), 1e-300)
    x = across((ring[np.argmax((ring**2).sum(axis=1))])[None], normal[None])[0]
    return _simple(ring @ np.stack((x, cross_product(normal, x))).T, len(course.pieces))


def _simple(flat: Array, count: int) -> Array | None:
    """Return a flat ring by its pieces; None where it crosses itself or runs clockwise."""
    import shapely

    outline = shapely.LinearRing(flat)
    if not outline.is_valid or not outline.is_ccw:
        return None
    return flat.reshape(count, -1, 2)


# -- cuts ------------------------------------------------------------------------------------------


def _best_cuts(ring: Ring) -> Iterator[tuple[int, int]]:
    """Yield pairs of spots between which a ring may be cut, best first.

    A cut is short against what it cuts off, and stands as upright on the outline as it can.
    """
    import shapely

    count = len(ring)
    outline = shapely.Polygon(np.concatenate([spot.flat for spot in ring]))
    if not outline.is_valid:
        return
    spots = np.array([spot.flat[0] for spot in ring])
    out = np.array([spot.flat[1] for spot in ring]) - spots
    back = np.array([ring[k - 1].flat[-1] for k in range(count)]) - spots
    inside = _angle(out, back)
    arc = np.cumsum([0.0, *(spot.piece.piece.length for spot in ring)])
    room = outline.buffer(1e-6 * float(np.sqrt(outline.area)))
    kinks = [spot.kink for spot in ring]
    rated = []
    for i, j in itertools.combinations(range(count), 2):
        way = spots[j] - spots[i]
        one, other = float(_angle(out[i], way)), float(_angle(out[j], -way))
        angles = np.array((one, inside[i] - one, other, inside[j] - other))
        if angles.min() < SHARPEST or (np.abs(angles - np.pi) < np.pi - FLATTEST).any():
            continue
        turns = (np.pi - angles).tolist()
        along = [0.0] * (CUT_PIECES - 1)
        first = [turns[0], *kinks[i + 1 : j], turns[3], *along]
        second = [turns[2], *kinks[j + 1 :], *kinks[:i], turns[1], *along]
        if not (_has_halves(first) and _has_halves(second)):
            continue
        if not room.covers(shapely.LineString(spots[[i, j]])):
            continue
        between = float(arc[j] - arc[i])
        cost = float(np.hypot(*way)) / min(between, float(arc[-1]) - between)
        cost *= 1.0 + float(np.maximum(GOOD[0] - angles, 0.0).sum() / GOOD[0])
        cost *= 1.0 + float(np.maximum(angles - GOOD[1], 0.0).sum() / GOOD[0])
        for k, parts in ((i, angles[:2]), (j, angles[2:])):
            if turn_kind(ring[k].kink) < 0 and parts.max() < np.pi:
                cost *= CONCAVE_GAIN
        rated.append((cost, i, j))
    for _, i, j in sorted(rated):
        yield i, j


def _angle(one: Array, other: Array) -> Array:
    """Return the angle counter-clockwise from one vector to the other, 0 … 2 π."""
    return np.asarray(np.mod(np.arctan2(cross(one, other), (one * other).sum(axis=-1)), 2 * np.pi))


def _cut(ring: Ring, i: int, j: int) -> tuple[Ring, Ring] | None:
    """Return both parts of a ring cut between two spots; None where no curve can lead across."""
    starts = [_place(ring[k].piece) for k in (i, j)]
    ups = [ring[k].normal for k in (i, j)]
    chord = starts[1] - starts[0]
    length = float(np.linalg.norm(chord))
    slopes = []
    for up in ups:
        way = chord - (chord @ up) * up
        size = float(np.linalg.norm(way))
        if size < 0.1 * length:
            return None
        slopes.append(2.0 * length / (1.0 + size / length) * way / size)
    points = np.stack(
        (starts[0], starts[0] + slopes[0] / 3.0, starts[1] - slopes[1] / 3.0, starts[1])
    )
    spline = Spline(np.repeat((0.0, 1.0), 4), points)
    field = carried(spline, ups[0], ups[1])
    pieces = pieces_of(spline, CUT_PIECES)
    line = (ring[i].flat[0], ring[j].flat[0])
    onward = _spots_of_cut(pieces, field, line, forward=True)
    backward = _spots_of_cut(pieces, field, line, forward=False)
    return (
        _closed(ring[i:j], backward),
        _closed((*ring[j:], *ring[:i]), onward),
    )


def _place(piece: SidePiece) -> Array:
    """Return where a piece starts, as the loop runs."""
    return np.asarray(piece.piece.curve.control_points[0 if piece.forward else -1])


def _spots_of_cut(
    pieces: Sequence[EdgePiece], field: NormalField, line: tuple[Array, Array], *, forward: bool
) -> Ring:
    """Return the spots along a cut."""
    made = []
    for piece in pieces if forward else pieces[::-1]:
        low, high = piece.curve.range
        share = np.linspace(*((low, high) if forward else (high, low)), SAMPLES + 1)[:-1, None]
        flat = (1.0 - share) * line[0] + share * line[1]
        up = field.value(share[:1, 0])[0]
        made.append(_Spot(SidePiece(CUT, piece, forward, field), 0.0, up, flat))
    return tuple(made)


def _closed(rim: Ring, cut: Ring) -> Ring:
    """Return the ring of a part: some of the outline, and the cut back to its start."""
    return (_turned(rim[0], cut[-1]), *rim[1:], _turned(cut[0], rim[-1]), *cut[1:])


def _turned(spot: _Spot, before: _Spot) -> _Spot:
    """Return a spot with the turn from another one's piece to its own."""
    enter, leave = before.piece.ends()[1], spot.piece.ends()[0]
    turn = np.arctan2(cross_product(enter, leave) @ spot.normal, enter @ leave)
    return _Spot(spot.piece, float(turn), spot.normal, spot.flat)
