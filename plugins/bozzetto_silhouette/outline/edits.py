"""Edits of an outline: strokes drawn over it since it was drawn, in order.

Rings keep their numbers through all edits: one that is gone leaves None in its place, and what
was drawn over it later has no effect any more.
"""

from __future__ import annotations

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto_silhouette.ink.oversketch import drawn_over
from bozzetto_silhouette.ink.ring_smoothing import rubbed
from bozzetto_silhouette.ink.self_intersections import rings_that_cross, untangled
from bozzetto_silhouette.model.state import Edit, Oversketch, Removal

Rings = tuple[Array | None, ...]


def size_of(rings: Rings) -> float:
    """Return the longest side of the box around rings, in their own unit."""
    there = [ring for ring in rings if ring is not None]
    return float(np.ptp(np.concatenate(there), axis=0).max()) if there else 0.0


def edited(rings: Rings, edit: Edit, line: Array) -> Rings:
    """Apply one more edit to the rings.

    Parameters
    ----------
    rings : tuple of (n, 2) float arrays
        None where a ring is gone.
    edit : Edit
        What to do, and to which ring.
    line : (m, 2) float array
        The edit's stroke, in the frame of the rings.

    Raises
    ------
    UserError
        If the ring would cross itself or another one, with the places.
    """
    old = rings[edit.ring] if 0 <= edit.ring < len(rings) else None
    if old is None:
        return rings
    if isinstance(edit, Removal):
        return _with(rings, edit.ring, None)
    size = size_of(rings)
    if isinstance(edit, Oversketch):
        new = drawn_over(old, line, size)
    else:
        new = _simple(rubbed(old, line, size), size)
    result = _without_lost(_with(rings, edit.ring, new), old, new)
    meetings = rings_that_cross([ring for ring in result if ring is not None])
    if len(meetings):
        raise UserError(
            "Two outlines would cross at the marked place. Draw the piece again, clear of the "
            "other outline.",
            places=[(float(x), float(y)) for x, y in meetings],
        )
    return result


def _with(rings: Rings, number: int, ring: Array | None) -> Rings:
    return (*rings[:number], ring, *rings[number + 1 :])


def _simple(ring: Array, size: float) -> Array:
    """Remove the small loops that smoothing may have made in thin limbs."""
    middle = ring[0]
    simple, places = untangled((ring - middle) / size)
    if simple is None or len(places):
        raise UserError(
            "Smoothed so much the outline would cross itself at the marked place. Rub more "
            "lightly, or draw over that piece.",
            places=[(float(x), float(y)) for x, y in places * size + middle],
        )
    return np.asarray(simple * size + middle, np.float64)


def _without_lost(rings: Rings, old: Array, new: Array) -> Rings:
    """Remove the rings that lay inside a ring before it changed, and lie outside it now.

    A hole in a piece that was cut off goes with that piece; it is no body of its own.
    """
    from shapely import Polygon

    before, after = Polygon(old).buffer(0), Polygon(new).buffer(0)

    def lost(ring: Array) -> bool:
        region = Polygon(ring).buffer(0)
        return bool(before.contains(region) and after.disjoint(region))

    return tuple(
        None if ring is not None and ring is not new and lost(ring) else ring for ring in rings
    )
