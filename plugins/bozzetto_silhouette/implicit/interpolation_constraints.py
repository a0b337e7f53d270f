"""Constraints of a variational surface: points on the outline, beside it, and above the axis.

As in Kukelova and Durikovic, "SketchCo", 2007: boundary constraints on the outline (value 0),
normal constraints beside it, and above and below every node of the skeleton a constraint at
the mean distance to the outline nearby. The normal constraints have their own signed distance
as value, so the function is about a distance, whatever their offset.

Where the boundary constraints go is found by the greedy algorithm of J. C. Carr et al.,
"Reconstruction and representation of 3D objects with radial basis functions", 2001, section 5:
begin with few, and add those samples of the outline that the surface misses most.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto.geometry import Placement
from bozzetto.plugin import remembered
from bozzetto_silhouette.implicit.variational import (
    SPACING,
    VariationalSurface,
    apart,
    interpolated,
)
from bozzetto_silhouette.outline.boundary_sampling import CORNER_TURN
from bozzetto_silhouette.outline.normalized import Frame
from bozzetto_silhouette.outline.signed_distance import RimDistance

OUTLINE_POINTS = 120
"""Boundary constraints of a drawing that needs no more."""

MOST_OUTLINE_POINTS = 200
"""Boundary constraints of the most intricate drawing: beyond it the system takes too long."""

LEAST_OF_A_RING = 6
"""Boundary constraints on the smallest hole."""

FIRST_SHARE = 0.5
"""Share of the boundary constraints that are there before the first look at the misses."""

GROWTH = 0.35
"""Boundary constraints added in one round, as a share of those there are."""

TOLERANCE = 5e-4
"""Miss on the outline, as a share of the size, below which no constraint is added."""

OFFSET = 0.004
"""Offset of the normal constraints, as a share of the size. Of 0.003 to 0.015 this fitted best:
more rounds corners off, less leaves the function to itself in between."""

HALVINGS = 4
"""Halvings of the offset where the place is nearer to another stretch of outline."""

TRUE_OFFSET = 0.6
"""A normal constraint is dropped where its distance is not at least this share of its offset."""

NEARBY = 1.05
"""The outline nearby is what lies within so many radii of a node; its mean distance from the
axis of a tube is then 1.02 radii."""

DENSEST = 0.5
"""Height constraints closer to a higher one than this share of their height are dropped."""

STANDS_OUT = 1.25
"""A ball that reaches less far than this from the middle of a higher one, in its heights, gets no
constraint: the axis runs on into every kink of a round end, and would pull that down to it."""

STEEP = 0.88
"""Fall of the radius along the axis, by the length, from which on it runs into a kink of a round
end: of a corner it is the sine of half its angle, so corners of up to 120 degrees are none."""

FAR = 0.5
"""Length over which that is looked at, at least, in radii of the larger ball."""

THIN = 0.04
"""Height, as a share of the size, below which the axis of a limb gets a constraint of its own:
above and below lie so close together there that the function may vanish in between."""

AXIS_LEVEL = 0.5
"""Value of it, in distances to the outline: that of (r^2 - d^2) / 2r, which has slope 1 on the
surface of a tube."""


@dataclass(frozen=True, eq=False)
class Constraints:
    """Points with values.

    Attributes
    ----------
    points : (n, 3) float array
    values : (n,) float array
        In units of length, positive inside.
    size : float
        Of the shape: what spacings are a share of.
    """

    points: Array
    values: Array
    size: float

    def placed(self, placement: Placement) -> Constraints:
        """Return the constraints moved, turned, scaled or mirrored with the shape."""
        return Constraints(
            placement.points(self.points),
            self.values * placement.scale,
            self.size * placement.scale,
        )


@dataclass(frozen=True, eq=False)
class Fit:
    """A variational surface and what it was made from, in the frame of the sums.

    Attributes
    ----------
    surface : VariationalSurface
        Symmetric in z.
    constraints : Constraints
        Of both sides.
    """

    surface: VariationalSurface
    constraints: Constraints


# The preview's surface is the final solid's, too: it does not depend on the resolution.
@remembered(limit=16)
def fitted(frame: Frame, most: int = MOST_OUTLINE_POINTS) -> Fit:
    """Fit the variational surface through an outline; remembered.

    Parameters
    ----------
    frame : Frame
        The outline, its samples and its skeleton.
    most : int
        Boundary constraints, at most.

    Raises
    ------
    UserError
        If no surface passes through it.
    """
    rim = frame.rim
    distance = RimDistance(rim.points, rim.after)
    heights = _heights(frame)
    low, high = rim.points.min(axis=0), rim.points.max(axis=0)
    top = float(heights[:, 2].max(initial=0.0))
    bounds = np.array([[*low, -top], [*high, top]])
    most = min(most, len(rim.points))
    chosen = _spread(frame, round(FIRST_SHARE * min(most, OUTLINE_POINTS)))
    while True:
        points, values = _around(frame, distance, chosen, heights)
        surface = interpolated(points, values, bounds, mirrored=True)
        if len(chosen) >= most:
            break
        flat = np.column_stack([rim.points, np.zeros(len(rim.points))])
        miss = np.abs(surface.level(flat))
        room = OUTLINE_POINTS if len(chosen) < OUTLINE_POINTS else most
        more = _worst(frame, miss, chosen, min(room - len(chosen), int(GROWTH * len(chosen)) + 1))
        if len(chosen) >= OUTLINE_POINTS:
            more = more[miss[more] > TOLERANCE]
        if not len(more):
            break
        chosen = np.sort(np.concatenate([chosen, more]))
    above = points[:, 2] > 0.0
    both = Constraints(
        np.concatenate([points, points[above] * (1.0, 1.0, -1.0)]),
        np.concatenate([values, values[above]]),
        1.0,
    )
    return Fit(surface, both)


def _lengths(frame: Frame) -> Array:
    """Return the length of outline that each sample stands for, (m,)."""
    rim = frame.rim
    half = 0.5 * np.hypot(*(rim.points[rim.after] - rim.points).T)
    total: Array = half + half[rim.before]
    return total


def _spread(frame: Frame, count: int) -> Index:
    """Choose about so many samples of the outline, closer together where limbs are thin."""
    rim = frame.rim
    density = _lengths(frame) / np.maximum(rim.radius, SPACING)
    share = count / density.sum()
    picked, first = [], 0
    for ring in rim.rings:
        filled = np.cumsum(density[first : first + len(ring)])
        wanted = min(len(ring), max(LEAST_OF_A_RING, round(share * filled[-1])))
        at = (np.arange(wanted) + 0.5) / wanted * filled[-1]
        picked.append(first + np.unique(np.searchsorted(filled, at)))
        first += len(ring)
    return np.concatenate(picked)


def _worst(frame: Frame, miss: Array, chosen: Index, count: int) -> Index:
    """Find the worst sample in each of the stretches with the most area missed."""
    rim = frame.rim
    taken = np.zeros(len(miss), bool)
    taken[chosen] = True
    begins = rim.after <= np.arange(len(miss))  # the last of a ring closes its stretch
    stretch = np.cumsum(taken | np.roll(begins, 1))
    area = np.bincount(stretch, miss * _lengths(frame))
    order = np.argsort(np.where(taken, -1.0, miss), kind="stable")
    worst = np.zeros(len(area), np.intp)
    worst[stretch[order]] = order
    found = worst[np.argsort(-area, kind="stable")[:count]]
    return found[~taken[found]]


def _around(
    frame: Frame, distance: RimDistance, chosen: Index, heights: Array
) -> tuple[Array, Array]:
    """Return boundary constraints at samples of the outline, and normal and height constraints."""
    rim = frame.rim
    edge = rim.points[rim.after] - rim.points
    edge /= np.maximum(np.hypot(*edge.T), 1e-300)[:, None]
    left = np.column_stack([-edge[:, 1], edge[:, 0]])
    # At a corner the normals of both sides, else it would be rounded.
    corner = chosen[np.abs(rim.turn[chosen]) > CORNER_TURN]
    smooth = chosen[np.abs(rim.turn[chosen]) <= CORNER_TURN]
    foot = rim.points[np.concatenate([smooth, corner, corner])]
    normal = np.concatenate([rim.inward[smooth], left[corner], left[rim.before[corner]]])
    flat, values = [rim.points[chosen]], [np.zeros(len(chosen))]
    for side in (1.0, -1.0):
        offset = np.full(len(foot), OFFSET)
        for _ in range(HALVINGS + 1):
            place = foot + side * offset[:, None] * normal
            depth = side * distance(place).distance
            true = depth >= TRUE_OFFSET * offset
            offset[~true] *= 0.5
        flat.append(place[true])
        values.append(side * depth[true])
    axis = heights[heights[:, 2] < THIN, :2]
    flat.append(axis)
    values.append(AXIS_LEVEL * distance(axis).distance)
    plane = np.concatenate(flat)
    points = np.concatenate([np.column_stack([plane, np.zeros(len(plane))]), heights])
    value = np.concatenate([*values, np.zeros(len(heights))])
    keep = apart(points, SPACING)
    return points[keep], value[keep]


def _heights(frame: Frame) -> Array:
    """Place a point above every node of the skeleton and above the middle of every edge, (k, 3)."""
    from scipy.spatial import cKDTree

    skeleton, rim = frame.skeleton, frame.rim
    nodes = skeleton.nodes
    middles = nodes[skeleton.edges].mean(axis=1)
    xy = np.concatenate([nodes, middles])[:, :2]
    radius = RimDistance(rim.points, rim.after)(xy).distance
    length = _lengths(frame)
    inside = radius > SPACING
    xy, radius = xy[inside], radius[inside]
    height = radius.copy()
    for k, near in enumerate(cKDTree(rim.points).query_ball_point(xy, NEARBY * radius)):
        if near:
            gap = np.hypot(*(rim.points[near] - xy[k]).T)
            height[k] = np.average(gap, weights=length[near])
    own = ~_in_kinks(xy, radius)
    xy, height = xy[own], height[own]
    order = np.argsort(-height, kind="stable")
    xy, height = xy[order], height[order]
    kept: list[int] = []
    for k in range(len(xy)):
        gap = np.hypot(*(xy[kept] - xy[k]).T)
        own = gap + height[k] >= STANDS_OUT * height[kept]
        if (own & (gap >= DENSEST * height[k])).all():
            kept.append(k)
    return np.column_stack([xy, height])[kept]


def _in_kinks(xy: Array, radius: Array) -> Flags:
    """Mark balls, at (k, 2), of radii (k,), to which the axis falls steeply from a larger one."""
    gap = np.sqrt(((xy[:, None] - xy) ** 2).sum(axis=2))
    steep = radius[:, None] - radius >= STEEP * gap
    found: Flags = (steep & (gap >= FAR * radius[:, None])).any(axis=0)
    return found
