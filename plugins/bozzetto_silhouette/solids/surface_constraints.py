"""Constraints all over a finished solid, for what is made of it and another.

The constraints that a variational surface is made from lie in the plane of the drawing and
above the axis. Put together with another body they would leave the flanks to chance, and they
know nothing of inflation, profile and fairing. So the solid is sampled itself: with as few
points as its roundness allows, first on the rim, then everywhere, each farthest from those
before (T. F. Gonzalez, "Clustering to minimize the maximum intercluster distance", 1985) when
distances are measured in local radii; and outside each a normal constraint.
"""

from __future__ import annotations

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto_silhouette.implicit.implicit_solid import Implicit
from bozzetto_silhouette.implicit.interpolation_constraints import Constraints
from bozzetto_silhouette.implicit.variational import SPACING, apart
from bozzetto_silhouette.inflation.solidify import SilhouetteSolid

RIM_POINTS = 90
"""Constraints on the rim, at most."""

ALL_POINTS = 260
"""Constraints on the surface, at most: two bodies of that many are solved in a twentieth of a
second."""

CLOSEST = 0.3
"""Points are not closer than this many local radii: a ball is round to a thousandth then."""

THINNEST = 0.02
"""Smallest local radius, as a share of the size, that asks for a closer spacing."""

OFFSET = 0.01
"""Offset of the normal constraints, as a share of the size."""

TRUE_OFFSET = 0.6
"""A normal constraint is dropped where its distance is not at least this share of its offset:
something else is near."""


def constraints_on(solid: SilhouetteSolid, implicit: Implicit) -> Constraints:
    """Return constraints on and outside a solid.

    Parameters
    ----------
    solid : SilhouetteSolid
        The part as a mesh.
    implicit : Implicit
        The same solid as a function of space.

    Returns
    -------
    Constraints
        In the solid's object frame.
    """
    from scipy.spatial import cKDTree

    size = solid.outline.size
    nodes = solid.skeleton.nodes
    _, nearest = cKDTree(nodes[:, :2]).query(solid.vertices[:, :2])
    scale = np.maximum(nodes[nearest, 2], THINNEST * size)
    chosen = _farthest(solid.vertices, scale, len(solid.plan.after))
    points, normals = solid.vertices[chosen], solid.normals[chosen]
    offset = OFFSET * size
    beside = points + offset * normals
    depth = implicit.value(beside)
    true = depth <= -TRUE_OFFSET * offset
    points = np.concatenate([points, beside[true]])
    values = np.concatenate([np.zeros(len(chosen)), np.maximum(depth[true], -offset)])
    keep = apart(points, SPACING * size)
    return Constraints(points[keep], values[keep], size)


def _farthest(points: Array, scale: Array, rim: int) -> Index:
    """Choose vertices far apart in their own radii: of the first `rim`, then of all."""
    gap = np.full(len(points), np.inf)
    chosen: list[int] = []
    for candidates, most in ((rim, RIM_POINTS), (len(points), ALL_POINTS)):
        while len(chosen) < most:
            k = int(np.argmax(gap[:candidates]))
            if gap[k] < CLOSEST:
                break
            chosen.append(k)
            np.minimum(gap, np.sqrt(((points - points[k]) ** 2).sum(axis=1)) / scale, out=gap)
    return np.array(chosen, dtype=np.intp)
