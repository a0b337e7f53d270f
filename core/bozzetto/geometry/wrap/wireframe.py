"""Curves in space as evenly spaced places of one size, ready to have a skin drawn over them."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array, Flags, Index, frozen
from bozzetto.errors import UserError

SPACING: Final = 1.0 / 250.0
"""Distance of neighbouring places per diagonal of the box about all curves: a quarter of an
edge of the finest usual skin, so that no triangle is missed."""

MOST_PLACES: Final = 20_000
"""Places along all curves; tangles of more have them farther apart."""

CORNER: Final = np.cos(np.radians(30.0))
"""Cosine of the turn from which on a vertex of a polyline is a corner that the skin keeps."""

MOST_CORNERS: Final = 2000
"""Limit of corners: a line with more is noise and not a shape."""

THIN: Final = 1e-3
"""Thickness per diagonal below which curves lie in a plane, so that a skin has no inside."""

APART: Final = 3.0
"""Gap between two groups of curves, per diagonal of the larger group, beyond which one skin
would hang between them like a thread."""

SAME: Final = 1e-4
"""Distance per diagonal between the curves of one side and the mirror images of the other's
below which they count as symmetric: less than one sees."""

FARTHEST: Final = 1e9
"""mm; beyond this the single precision of meshes tells nothing from nothing."""


@dataclass(frozen=True, eq=False)
class Wireframe:
    """Places along curves, the diagonal of the box about them scaled to one.

    Attributes
    ----------
    places : (n, 3) float
        Piece after piece. Of a symmetric network those with y ≥ 0 only.
    piece : (n,) int
        The number of the piece that each place belongs to. Pieces end in corners.
    sharp : (n,) bool
        The ends of pieces, which the skin should pass through; not where a piece was cut in
        the plane of symmetry.
    symmetric : bool
        Whether the curves are their own mirror image about the plane y = 0.
    centre : (3,) float
        mm.
    size : float
        mm per unit.
    """

    places: Array
    piece: Index
    sharp: Flags
    symmetric: bool
    centre: Array
    size: float

    def every(self, step: int) -> Wireframe:
        """Return a coarser row of places: every `step`-th of them, and the ends of pieces."""
        turn = np.diff(self.piece) != 0
        ends = np.append(True, turn) | np.append(turn, True)
        kept = ends | (np.arange(len(self.places)) % step == 0)
        return replace(
            self,
            places=self.places[kept],
            piece=self.piece[kept],
            sharp=self.sharp[kept],
        )

    def both_sides(self) -> Array:
        """Return the places of the whole network, with the mirror images of a half, (m, 3)."""
        if not self.symmetric:
            return self.places
        return np.vstack((self.places, self.places[self.places[:, 1] > 0] * MIRROR))


MIRROR: Final = frozen([1.0, -1.0, 1.0], np.float64)
"""Factors that make a place its mirror image about the plane y = 0."""


def wireframe(curves: Sequence[ArrayLike]) -> Wireframe:
    """Sample polylines at equal steps, and find out whether they are symmetric.

    Parameters
    ----------
    curves : sequence of (n, 3) array_like
        Polylines, mm, at least one point each.

    Raises
    ------
    UserError
        If there is no curve, a coordinate is not finite or beyond `FARTHEST`, or the curves
        have no extent or lie in a plane.
    """
    from scipy.spatial import cKDTree

    lines = [_checked(curve) for curve in curves]
    lines = [line for line in lines if len(line)]
    if not lines:
        raise UserError("There is no curve to draw a skin over. Draw a few curves in space first.")
    everything = np.vstack(lines)
    low, high = everything.min(axis=0), everything.max(axis=0)
    size = float(np.linalg.norm(high - low))
    _require_extent(everything, size)
    centre = 0.5 * (low + high)
    sides = abs(centre[1]) <= SAME * size
    if sides:
        centre[1] = 0.0
    pieces = _pieces([(line - centre) / size for line in lines])
    length = sum(float(_steps(piece).sum()) for piece in pieces)
    spacing = max(SPACING, length / MOST_PLACES)
    whole = [_spaced(piece, spacing) for piece in pieces]
    _require_nearness(np.vstack(whole))
    if not (sides and _is_symmetric(whole)):
        return _assembled(whole, False, centre, size)
    halves = [_spaced(half, spacing) for piece in pieces for half in _half(piece)]
    frame = _assembled(halves, True, centre, size)
    ends = cKDTree(np.vstack([piece[[0, -1]] for piece in pieces]))
    true_end = ends.query(frame.places, distance_upper_bound=SAME)[0] <= SAME
    return replace(frame, sharp=frame.sharp & true_end)


def _checked(curve: ArrayLike) -> Array:
    line = np.asarray(curve, float).reshape(-1, 3)
    if not np.isfinite(line).all() or np.abs(line).max(initial=0.0) > FARTHEST:
        raise UserError(
            "A curve has coordinates that are not finite, or far too large. Leave it out, or "
            "draw it again."
        )
    fresh = np.append(True, (line[1:] != line[:-1]).any(axis=1))[: len(line)]
    return np.asarray(line[fresh])


def _require_extent(points: Array, size: float) -> None:
    if not size > 0:
        raise UserError("A single point has no skin. Draw a few curves in space.")
    offset = (points - points.mean(axis=0)) / size
    axes = np.linalg.eigh(offset.T @ offset)[1]
    width = np.ptp(offset @ axes, axis=0)
    if np.sort(width)[1] < THIN:
        raise UserError(
            "The curves lie along one line, so a skin over them would have no inside. "
            "Add curves beside it."
        )
    if width.min() < THIN:
        raise UserError(
            "The curves lie in one plane, so a skin over them would have no inside. "
            "Add a curve that leaves the plane."
        )


def _require_nearness(points: Array) -> None:
    """Refuse groups of curves that lie far apart along the axis of their greatest extent."""
    offset = points - points.mean(axis=0)
    height = offset @ np.linalg.eigh(offset.T @ offset)[1][:, -1]
    order = np.argsort(height)
    gaps = np.diff(height[order])
    widest = int(np.argmax(gaps))
    groups = points[order[: widest + 1]], points[order[widest + 1 :]]
    larger = max(float(np.linalg.norm(np.ptp(group, axis=0))) for group in groups)
    if gaps[widest] > APART * larger > 0:
        raise UserError(
            "There are two groups of curves that lie far apart. "
            "Draw a skin over each by itself, or a curve from one to the other."
        )


def _steps(line: Array) -> Array:
    return np.asarray(np.linalg.norm(np.diff(line, axis=0), axis=1))


def _pieces(lines: list[Array]) -> list[Array]:
    """Return the polylines, cut at their corners."""
    turns = [_corners(line) for line in lines]
    if sum(len(turn) for turn in turns) > MOST_CORNERS:
        return lines
    made = []
    for line, turn in zip(lines, turns, strict=True):
        ends = [0, *turn, len(line) - 1]
        made += [line[a : b + 1] for a, b in itertools.pairwise(ends)]
    return made


def _corners(line: Array) -> Index:
    """Return inner vertices in which a polyline turns sharply."""
    along = np.diff(line, axis=0)
    along = along / np.linalg.norm(along, axis=1, keepdims=True)
    return 1 + np.flatnonzero(np.einsum("ij,ij->i", along[1:], along[:-1]) < CORNER)


def _spaced(line: Array, spacing: float) -> Array:
    """Return places at equal steps of a polyline, both ends among them."""
    if len(line) < 2:
        return line
    along = np.concatenate(([0.0], np.cumsum(_steps(line))))
    count = 1 + max(1, int(np.ceil(along[-1] / spacing)))
    at = np.linspace(0.0, along[-1], count)
    places = np.stack([np.interp(at, along, line[:, axis]) for axis in range(3)], axis=1)
    places[[0, -1]] = line[[0, -1]]
    return places


def _half(line: Array) -> list[Array]:
    """Return the parts of a polyline on the side y ≥ 0, cut in the plane exactly."""
    line = np.where(np.abs(line) < np.array([0.0, SAME, 0.0]), 0.0, line)
    side = line[:, 1]
    cuts = np.flatnonzero(side[1:] * side[:-1] < 0)
    share = (side[cuts] / (side[cuts] - side[cuts + 1]))[:, None]
    crossing = (1.0 - share) * line[cuts] + share * line[cuts + 1]
    crossing[:, 1] = 0.0
    line = np.insert(line, cuts + 1, crossing, axis=0)
    inside = np.concatenate(([0], (line[:, 1] >= 0).astype(int), [0]))
    begin, end = np.flatnonzero(np.diff(inside) > 0), np.flatnonzero(np.diff(inside) < 0)
    pairs = zip(begin, end, strict=True)
    return [line[a:b] for a, b in pairs if b - a > 1 or len(line) == 1]


def _is_symmetric(pieces: list[Array]) -> bool:
    """Whether every place's mirror image lies on one of the pieces."""
    from scipy.spatial import cKDTree

    places = np.vstack(pieces)
    lengths = np.array([len(piece) for piece in pieces])
    last = np.cumsum(lengths) - 1
    before, after = np.arange(len(places)) - 1, np.arange(len(places)) + 1
    first = last - lengths + 1
    before[first], after[last] = first, last
    image = places * MIRROR
    nearest = cKDTree(places).query(image)[1]
    distance = np.full(len(places), np.inf)
    for other in (before, after):
        distance = np.minimum(
            distance, _from_segment(image, places[nearest], places[other[nearest]])
        )
    return bool(distance.max() <= SAME)


def _from_segment(point: Array, start: Array, end: Array) -> Array:
    along, offset = end - start, point - start
    square = np.einsum("ij,ij->i", along, along)
    share = np.einsum("ij,ij->i", offset, along) / np.where(square > 0, square, 1.0)
    return np.asarray(np.linalg.norm(offset - np.clip(share, 0, 1)[:, None] * along, axis=1))


def _assembled(pieces: list[Array], symmetric: bool, centre: Array, size: float) -> Wireframe:
    lengths = np.array([len(piece) for piece in pieces])
    last = np.cumsum(lengths) - 1
    sharp = np.zeros(lengths.sum(), bool)
    sharp[last] = sharp[last - lengths + 1] = True
    number = np.repeat(np.arange(len(pieces)), lengths)
    return Wireframe(np.vstack(pieces), number, sharp, symmetric, centre, size)
