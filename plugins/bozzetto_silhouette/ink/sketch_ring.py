"""A sketched outline: one line of many strokes that lie over, beside and across one another.

Joined end to end such strokes cross. What they mean is told by the band that they make: it goes
once around, and the outline is its middle.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from bozzetto.arrays import Array

if TYPE_CHECKING:
    from shapely import MultiLineString

APART = 0.02, 0.04, 0.08
"""How far lines that are meant as one lie beside one another at most: the least that does."""

OVERSHOOT = 0.08
"""Ends of strokes stick out of the band no farther than this: more was meant."""

ENCLOSED = 0.01
"""Share of the area inside up to which a gap between two lines is no hole."""

STEP = 0.004
"""Samples of the outline are so far apart."""

DETAIL = 5e-4
"""Samples of the ink that change a line by less do not count."""

THIN = 0.1
"""Ends of strokes that stick out are taken off where they are thinner than this share of it."""

MOST_SAMPLES = 5_000
"""Ink of more is a scribble."""

MOST_TIMES = 6.0
"""Ink of so many times the outline's length was rubbed, not drawn."""


def sketched_ring(lines: Sequence[Array]) -> Array | None:
    """Return the ring that sketching lines mean; None where they do not go once around.

    Parameters
    ----------
    lines : sequence of (n, 2) float array
        Of a drawing whose longest side is 1.

    Returns
    -------
    (n, 2) float array or None
        Its first vertex is not repeated.

    Notes
    -----
    The ink is widened until lines that are meant as one run together; what it encloses is made
    larger by as much again. The outer border of the ink and the inner one are left, and the
    ring lies half way between them.
    """
    import shapely

    ink = shapely.simplify(
        shapely.multilinestrings([shapely.linestrings(s) for s in lines]), DETAIL
    )
    if shapely.get_num_coordinates(ink) > MOST_SAMPLES:
        return None
    samples = shapely.points(shapely.get_coordinates(ink))
    for apart in APART:
        ring = _middle(ink, apart)
        if ring is not None:
            around = shapely.linearrings(ring)
            near = (shapely.distance(samples, around) < OVERSHOOT).all()
            return ring if near and ink.length < MOST_TIMES * around.length else None
    return None


def _middle(ink: MultiLineString, apart: float) -> Array | None:
    """Return the middle of the band of some lines; None where it does not go once around."""
    import shapely

    reach, thin = 0.5 * apart, THIN * apart
    band = shapely.buffer(ink, reach)
    if band.geom_type != "Polygon" or not len(band.interiors):
        return None
    holes = [shapely.Polygon(ring) for ring in band.interiors]
    areas = np.array([hole.area for hole in holes])
    largest = int(areas.argmax())
    if (np.delete(areas, largest) > ENCLOSED * areas[largest]).any():
        return None
    outer = shapely.Polygon(band.exterior).buffer(-reach - thin).buffer(thin)
    inner = holes[largest].buffer(reach + thin).buffer(-thin)
    if outer.geom_type != "Polygon" or inner.geom_type != "Polygon":
        return None
    along = shapely.segmentize(outer.exterior, STEP)
    points = shapely.points(shapely.get_coordinates(along)[:-1])
    across = shapely.shortest_line(points, inner.exterior)
    ring: Array = shapely.get_coordinates(across).reshape(-1, 2, 2).mean(axis=1)
    return ring
