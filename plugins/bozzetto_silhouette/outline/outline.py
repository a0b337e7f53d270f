"""The drawn outline as a value: closed rings, nested by the even-odd rule.

An `Outline` is what the rest of the modeler works on. How pen strokes become one
is described in `bozzetto_silhouette.ink.rings_from_strokes`; call `outline_from_strokes`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array
from bozzetto.ink import signed_area
from bozzetto.plugin import cached_property

if TYPE_CHECKING:
    from shapely import MultiPolygon


@dataclass(frozen=True, eq=False)
class Outline:
    """Closed rings in the drawing plane.

    Attributes
    ----------
    rings : tuple of (n, 2) read-only float arrays
        Outer rings run counter-clockwise and holes clockwise, so the inside always
        lies to the left. The first vertex is not repeated.
    parents : tuple of int
        For a hole, the index of the outer ring around it; for an outer ring, -1.
    """

    rings: tuple[Array, ...]
    parents: tuple[int, ...]

    @property
    def outers(self) -> tuple[int, ...]:
        """Indices of the outer rings, one for every separate body."""
        return tuple(i for i, parent in enumerate(self.parents) if parent < 0)

    def holes_of(self, outer: int) -> tuple[int, ...]:
        """Return the indices of the holes inside the outer ring with index `outer`."""
        return tuple(i for i, parent in enumerate(self.parents) if parent == outer)

    @property
    def components(self) -> int:
        """How many separate bodies the outline describes."""
        return len(self.outers)

    @property
    def genus(self) -> int:
        """How many holes are drawn, all bodies together."""
        return len(self.rings) - self.components

    @cached_property
    def bounds(self) -> tuple[Array, Array]:
        """Lower and upper corner of the box around all rings, each (2,)."""
        points = np.concatenate(self.rings)
        return points.min(axis=0), points.max(axis=0)

    @property
    def size(self) -> float:
        """Longest side of the box, in the outline's own unit."""
        low, high = self.bounds
        return float((high - low).max())

    @property
    def diagonal(self) -> float:
        """Diagonal of the box, in the outline's own unit."""
        low, high = self.bounds
        return float(np.hypot(*(high - low)))

    @property
    def area(self) -> float:
        """Area inside the outers and outside the holes."""
        return sum(signed_area(ring) for ring in self.rings)

    def transformed(self, scale: float, shift: ArrayLike) -> Outline:
        """Return the same outline at ``scale * (x, y) + shift``; `scale` is positive."""
        shift = np.asarray(shift, dtype=np.float64)
        return Outline(tuple(_frozen(r * scale + shift) for r in self.rings), self.parents)

    def polygon(self) -> MultiPolygon:
        """Return the same region as a shapely geometry."""
        import shapely

        return shapely.MultiPolygon(
            [(self.rings[i], [self.rings[j] for j in self.holes_of(i)]) for i in self.outers]
        )


def _frozen(points: Any) -> Array:
    array = np.array(points, dtype=np.float64, order="C")
    array.setflags(write=False)
    return array


COINCIDENT = 1e-6
"""Vertices closer than this share of the size are one: nothing can be meshed in between."""


def _without_repeats(ring: Array, closer: float) -> Array:
    """Drop vertices that repeat the one before; the closing repetition as well."""
    while len(ring) > 2:
        gap = np.hypot(*(ring - np.roll(ring, 1, axis=0)).T)
        repeats = gap <= closer
        if not repeats.any():
            break
        # Of a run of near repeats every other one goes, until none are left.
        repeats &= ~np.roll(repeats, 1) | (np.arange(len(ring)) % 2 == 1)
        if not repeats.any():
            break
        ring = ring[~repeats]
    return ring


def outline_from_rings(rings: Sequence[ArrayLike]) -> Outline:
    """Nest simple rings that do not cross each other by the even-odd rule.

    Parameters
    ----------
    rings : sequence of (n, 2) array_like
        Closed rings, in any order and direction; a repeated first vertex is dropped.

    Returns
    -------
    Outline
        Outer rings first, each followed by its holes.
    """
    import shapely

    given = [np.asarray(r, dtype=np.float64).reshape(-1, 2) for r in rings]
    everything = np.concatenate([*given, np.zeros((0, 2))])
    size = float(np.ptp(everything, axis=0).max()) if len(everything) else 0.0
    clean = [_without_repeats(r, COINCIDENT * size) for r in given]
    clean = [r for r in clean if len(r) >= 3 and signed_area(r) != 0.0]
    solids = [shapely.Polygon(r) for r in clean]
    inside: list[list[int]] = []
    for i, solid in enumerate(solids):
        probe = solid.representative_point()
        inside.append([
            j for j, other in enumerate(solids)
            if j != i and other.area > solid.area and other.contains(probe)
        ])  # fmt: skip
    result: list[Array] = []
    parents: list[int] = []
    for i in sorted(range(len(clean)), key=lambda k: -abs(solids[k].area)):
        if len(inside[i]) % 2:
            continue
        ring = clean[i] if signed_area(clean[i]) > 0 else clean[i][::-1]
        outer = len(result)
        result.append(_frozen(ring))
        parents.append(-1)
        for j, around in enumerate(inside):
            if i in around and len(around) == len(inside[i]) + 1:
                hole = clean[j] if signed_area(clean[j]) < 0 else clean[j][::-1]
                result.append(_frozen(hole))
                parents.append(outer)
    return Outline(tuple(result), tuple(parents))


def outline_from_strokes(
    strokes: Sequence[ArrayLike], *, tolerance: float | None = None, by_hand: bool = True
) -> Outline:
    """Turn pen strokes into filtered, closed, nested rings.

    Gaps are closed, overlapping ends trimmed at their crossing, hooks cut off, repeated
    samples dropped, jitter filtered without rounding corners, and an outline drawn in
    several strokes is joined, whatever their order and direction. Exact polygons pass
    through unchanged, smooth curves of a file if they are said to be no hand's.

    Parameters
    ----------
    strokes : sequence of (n, 2) array_like
        Samples of each stroke, in canvas units (any unit).
    tolerance : float, optional
        Deviation from the ink that counts as jitter, in the same unit. By default it is
        measured on the ink itself.
    by_hand : bool
        Whether a hand drew them, which trembles; curves of a file do not.

    Returns
    -------
    Outline

    Raises
    ------
    UserError
        When there is nothing to close, or when the outline really crosses itself; the
        crossings are in ``places``, in the unit of the strokes.
    """
    from bozzetto_silhouette.ink.rings_from_strokes import rings_from_strokes

    return outline_from_rings(rings_from_strokes(strokes, tolerance=tolerance, by_hand=by_hand))
