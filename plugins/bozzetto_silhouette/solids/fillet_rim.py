"""The rim of a fillet that is shown by itself, among the parts that it goes under."""

from __future__ import annotations

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto.plugin import remembered
from bozzetto_silhouette.implicit.composite import Composite
from bozzetto_silhouette.implicit.fillet_solid import Shaped
from bozzetto_silhouette.numerics.isotropic_remeshing import dot, unit
from bozzetto_silhouette.solids.fillet import BEYOND, Fillet
from bozzetto_silhouette.solids.polygonize import Surface

OUTER, END = 0, 2
"""Sides of a fillet, by the order of their values: the blended one, and where it ends."""

RIM_STEPS = 4
"""Steps of Newton's method from the teeth of a rim to the line that it is."""

FLATTEST = 0.05
"""Where the outer side and the ends of a fillet are nearly one no step is longer than by this share
of the product of their slopes."""


@remembered(limit=512, key=lambda fillet, solid, step: fillet)
def with_even_rim(fillet: Fillet, solid: Composite, step: float) -> Surface:
    """Return the surface of a fillet with an even rim, and the normals of the blend near it.

    Cells cut its sharp rim off in teeth; there vertices go to where its outer side meets its ends,
    which is a smooth line under the parts. The others of the outer side are evened out once, and
    brought onto it. All are shaded like the parts around, down to a cell below the blend, and not
    as the flanks that they are.

    Parameters
    ----------
    fillet : Fillet
        As it was polygonized.
    solid : Composite
        Whose blend it is.
    step : float
        Spacing of the meshes of the two solids.
    """
    surface = fillet.surface
    points, cell = surface.vertices.copy(), fillet.cell
    margin = np.array([[-cell], [cell]])
    solid = solid.within(fillet.box + margin, BEYOND * solid.reach)
    shaped, blended = Shaped.of(solid, step, cell, points)
    side = np.stack([shaped.top, shaped.floor, shaped.flank]).argmin(axis=0)
    faces = surface.faces.astype(np.intp)
    a, b = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    on_rim = np.zeros(len(points), bool)
    on_rim[a[(side[a] == OUTER) & (side[b] == END)]] = True
    on_rim[b[(side[b] == OUTER) & (side[a] == END)]] = True
    rim, outer = np.flatnonzero(on_rim), np.flatnonzero((side == OUTER) & ~on_rim)
    for _ in range(RIM_STEPS if len(rim) else 0):
        points[rim] += _to_rim(Shaped.of(solid, step, cell, points[rim])[0], cell)
    slope = unit(shaped.slope[outer])
    way = (_middles(points, a, b) - points)[outer]
    points[outer] += way - dot(way, slope)[:, None] * slope
    shaped, blended = Shaped.of(solid, step, cell, points)
    points[outer] += _onto(shaped, cell)[outer]
    near = (blended.value < cell)[:, None]
    return Surface(points, surface.faces, np.where(near, -unit(blended.gradient), surface.normals))


def _middles(points: Array, a: Index, b: Index) -> Array:
    """Return the mean (n, 3) of the neighbours of each point, for edges from a to b (e,)."""
    count = np.maximum(np.bincount(a, minlength=len(points)), 1)
    sums = [np.bincount(a, points[b, axis], len(points)) for axis in range(3)]
    return np.stack(sums, axis=1) / count[:, None]


def _onto(shaped: Shaped, cell: float) -> Array:
    """Return the step (n, 3) onto the outer side of a fillet, half a cell long at most."""
    square = np.maximum(dot(shaped.slope, shaped.slope), 0.25)
    way = np.clip(shaped.top / square, -0.5 * cell, 0.5 * cell)
    return np.asarray(-way[:, None] * shaped.slope)


def _to_rim(shaped: Shaped, cell: float) -> Array:
    """Return Newton's step (n, 3) to where the outer side of a fillet meets its ends.

    No step is longer than a cell.
    """
    one, other = shaped.slope, shaped.apart
    aa, ab, bb = dot(one, one), dot(one, other), dot(other, other)
    det = np.maximum(aa * bb - ab * ab, FLATTEST * aa * bb + 1e-12)
    x = (-bb * shaped.top + ab * shaped.flank) / det
    y = (-aa * shaped.flank + ab * shaped.top) / det
    move = x[:, None] * one + y[:, None] * other
    length = np.sqrt(dot(move, move))
    return np.asarray(move * np.minimum(1.0, cell / np.maximum(length, 1e-300))[:, None])
