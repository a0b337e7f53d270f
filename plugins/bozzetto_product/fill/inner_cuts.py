"""Cuts across a loop that is bent inward, and the fill of the parts between them.

Patches round one centre need a domain that is seen from its centre. A C, or a strip bent round a
corner, has none. It is cut across, from one piece of an edge to another, as long as a part folds.
A cut is a curve of the surface: both parts take the same normals along it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from bozzetto.arrays import Array, cross_product
from bozzetto.plugin import cached_property
from bozzetto_product.fill.cut_rings import SAMPLES, TRIED, Ring, Search, Spot, bridged
from bozzetto_product.fill.edge_pieces import EdgePiece
from bozzetto_product.fill.half_sides import SidePiece
from bozzetto_product.fill.loop_fill import SHORTEST
from bozzetto_product.fill.loop_sides import TURN
from bozzetto_product.fill.normal_field import across, angle_about, rotated
from bozzetto_product.fill.normals import LoopNormals
from bozzetto_product.fill.parted_fill import PartedFill
from bozzetto_product.network.net import Loop


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
        found = Search(loop, spacing, bridged).parts(ring, len(TRIED), whole=True)
        if found is not None:
            return PartedFill.of(loop, found)
    return None


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
        Spot(piece, float(kink), rows[0], own)
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
