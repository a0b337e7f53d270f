"""Prisms over visible faces: the far end is the same ring moved along sides that leave it.

Where the sides draw together, as in perspective, it is the ring drawn towards their vanishing
point. Lengths are shares of the diagonal.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto_polyhedron.reconstruction.drawing import Drawing
from bozzetto_polyhedron.reconstruction.missing_lines import Whole
from bozzetto_polyhedron.reconstruction.parallel_classes import parallel_classes
from bozzetto_polyhedron.reconstruction.visible_regions import Junctions, regions_of

LEAST_SHARE: Final = 0.05
"""Share of the way to a vanishing point below which sides are parallel."""

FEWEST: Final = 3
"""Corners of the least ring."""


def extruded(drawing: Drawing, junctions: Junctions, reach: float) -> list[Whole]:
    """Return prisms over every visible ring, along every direction of lines that leave it."""
    labels = parallel_classes(drawing).labels
    everything = np.arange(len(labels))
    found = []
    for ring in regions_of(drawing, junctions):
        if len(ring) < FEWEST:
            continue
        shrunk = _shrunk(drawing, ring, *steps_of(drawing, junctions, ring, everything), reach)
        found += [prism(drawing, ring, far, reach) for far in shrunk]
        for name in np.unique(labels).tolist():
            _, steps = steps_of(drawing, junctions, ring, np.flatnonzero(labels == name))
            for step in distinct_steps(steps, reach):
                found.append(prism(drawing, ring, drawing.points[list(ring)] + step, reach))
    return found


def steps_of(
    drawing: Drawing, junctions: Junctions, ring: Sequence[int], sides: Index
) -> tuple[Array, Array]:
    """Return where sides leave a ring, and the ways to corners of their own, both (k, 2)."""
    inside = set(ring)
    nears, made = [], []
    for first, second in drawing.lines[sides].tolist():
        if (first in inside) == (second in inside):
            continue
        near, far = (first, second) if first in inside else (second, first)
        if not junctions.is_stem[far]:
            nears.append(drawing.points[near])
            made.append(drawing.points[far] - drawing.points[near])
    return np.array(nears).reshape(-1, 2), np.array(made).reshape(-1, 2)


def _shrunk(
    drawing: Drawing, ring: Sequence[int], nears: Array, steps: Array, reach: float
) -> list[Array]:
    """Return the far end of a prism in perspective: the ring drawn towards a vanishing point.

    Two sides or more tell the point and the share of the way, way = share (point - near).
    """
    if len(nears) < 2:
        return []
    middle = nears - nears.mean(0)
    square = float((middle**2).sum())
    if square < reach**2:
        return []
    share = -float((middle * steps).sum()) / square
    ways = steps.mean(0) - share * (drawing.points[list(ring)] - nears.mean(0))
    misfit = steps - steps.mean(0) + share * middle
    if not LEAST_SHARE < abs(share) < 1.0 or np.linalg.norm(misfit, axis=1).max() > reach:
        return []
    return [drawing.points[list(ring)] + ways]


def distinct_steps(steps: Array, reach: float) -> list[Array]:
    """Return the mean of all ways, and each one that is far from it."""
    if not len(steps):
        return []
    mean = np.median(steps, axis=0)
    far = steps[np.linalg.norm(steps - mean, axis=1) > reach]
    return [mean, *far]


def prism(drawing: Drawing, ring: Sequence[int], far: Array, reach: float) -> Whole:
    """Return the prism between a ring and its far end, (n, 2)."""
    count = len(ring)
    near = drawing.points[list(ring)]
    points = np.concatenate((near, _snapped(far, drawing.points[np.unique(drawing.lines)], reach)))
    here = np.arange(count)
    following = np.roll(here, -1)
    lines = np.concatenate(
        (
            np.column_stack((here, following)),
            np.column_stack((here, following)) + count,
            np.column_stack((here, here + count)),
        )
    )
    return Whole(points, lines)


def _snapped(guessed: Array, drawn: Array, reach: float) -> Array:
    """Put guessed corners on drawn ones that are close."""
    away = np.linalg.norm(guessed[:, None] - drawn, axis=2)
    nearest = away.argmin(1)
    close = away[np.arange(len(guessed)), nearest] < reach
    return np.where(close[:, None], drawn[nearest], guessed)
