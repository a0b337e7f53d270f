"""How calm a solid's shading is: the measure that zebra stripes show to the eye."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import LinearNDInterpolator

from bozzetto.geometry import ring_links
from bozzetto_silhouette.inflation.solidify import SilhouetteSolid
from bozzetto_silhouette.outline.signed_distance import RimDistance
from tests.plugins.silhouette import outlines as o

STEP = 0.1
"""Step of the second difference, in local radii: what is drawn bends on a larger scale."""


def front(solid: SilhouetteSolid) -> LinearNDInterpolator:
    """Height and normal, (n, 4), as a function of the place on the sheet."""
    seen = solid.vertices[:, 2] >= 0
    values = np.column_stack([solid.vertices[:, 2], solid.normals])
    return LinearNDInterpolator(solid.vertices[seen, :2], values[seen])


def unfairness(solid: SilhouetteSolid, count: int = 1000) -> float:
    """Root mean square of the second difference of the unit normals over `STEP` local radii.

    On a ball it is about 0.017, from the curvature itself; a ripple of one degree adds 0.07.
    Near the rim, where the section turns away from the eye, nothing is measured.
    """
    size = solid.outline.size
    rings = [o.dense(ring, 0.004 * size) for ring in solid.outline.rings]
    rim = RimDistance(np.concatenate(rings), ring_links([len(r) for r in rings])[0])
    shown = front(solid)
    low, high = solid.outline.bounds
    place = np.random.default_rng(0).uniform(low, high, (5 * count, 2))
    depth = np.maximum(rim(place).distance, 0.0)
    radius = np.hypot(depth, np.nan_to_num(shown(place)[:, 0]))
    clear = (depth > 0.35 * radius) & (radius > 0.02 * size)
    place, radius = place[clear][:count], radius[clear][:count]
    bends, here = [], shown(place)
    for angle in np.arange(4) * np.pi / 4:
        step = STEP * radius[:, None] * np.array([np.cos(angle), np.sin(angle)])
        bends.append((shown(place + step) - 2.0 * here + shown(place - step))[:, 1:])
    return float(np.sqrt(np.nanmean((np.stack(bends) ** 2).sum(axis=2))))
