"""The plan: a graded triangulation of the region inside the outline.

The solid is a height field over the plan, mirrored in depth. Its topology is therefore
that of the drawing, by construction: no wall can be lost and no gap closed, however thin.
What remains to be cared for is the rim, where the surface stands upright. There the
points lie in rows parallel to the outline, at the depths at which a circle of the local
radius is cut by equal angles, so that the section comes out round.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto_silhouette.numerics.isotropic_remeshing import halved
from bozzetto_silhouette.outline.boundary_sampling import Rim
from bozzetto_silhouette.outline.signed_distance import RimDistance, scanline_inside

_FIRST_ANGLE, _COARSEST_ANGLE = np.deg2rad(8.0), np.deg2rad(30.0)
"""Bounds of the angle between two rows of the rim, seen from the axis of the limb."""

_LAST_ANGLE = np.deg2rad(62.0)
"""Beyond this the surface is flat enough for a uniform lattice."""

_FAN_ANGLE = np.deg2rad(24.0)
"""Around a reflex corner the rows get a point at least every so often."""

_ROUNDING = 1e-3
"""Contraction towards the middle before triangulating. It bends the straight sides of the
convex hull outwards, by no more than 1e-10 of the size between neighbours, but enough for
samples on them to be real corners and not the tips of triangles without area."""

_REPAIRS = 10
"""Rounds of mending outline edges that the triangulation does not contain. Each leaves about a
quarter of them; a ragged outline of thousands of corners begins with hundreds."""


@dataclass(frozen=True, eq=False)
class Plan:
    """Triangles that tile the inside of an outline.

    Attributes
    ----------
    points : (n, 2) float array
        The rim's samples first, then the points inside.
    triangles : (t, 3) int array
        Counter-clockwise.
    after : (m,) int array
        Successor of each of the m rim samples.
    chords_split : int
        How many edges joined two rim samples across the inside and were halved.
    partner : (n,) int array, optional
        Mirror image of each point; None where the outline is not symmetric.
    """

    points: Array
    triangles: Index
    after: Index
    chords_split: int = 0
    partner: Index | None = None


def _rows(rim: Rim, distance: RimDistance) -> tuple[Array, Array]:
    """Return the points of the rim's rows, and for each rim sample the depth of its last row."""
    angle = np.clip(rim.step / rim.radius, _FIRST_ANGLE, _COARSEST_ANGLE)
    count = np.maximum(1, np.floor(_LAST_ANGLE / angle)).astype(np.intp)
    angle = np.minimum(angle, _LAST_ANGLE / count)
    most = int(count.max())
    points, owners, depths = [], [], []
    for k in range(1, most + 1):
        has = np.flatnonzero(count >= k)
        depth = rim.radius[has] * (1.0 - np.cos(k * angle[has]))
        spread = np.maximum(np.ceil(-rim.turn[has] / _FAN_ANGLE), 1.0)
        room = np.maximum(np.ceil(-rim.turn[has] * depth / rim.step[has] * 1.5), 1.0)
        fans = np.minimum(spread, room).astype(np.intp)
        owner = np.repeat(np.arange(len(has)), fans)
        part = np.arange(len(owner)) - np.repeat(np.cumsum(fans) - fans, fans)
        tilt = ((part + 0.5) / fans[owner] - 0.5) * -rim.turn[has[owner]]
        tilt = np.where(fans[owner] > 1, -tilt, 0.0)
        n = rim.inward[has[owner]]
        c, s = np.cos(tilt), np.sin(tilt)
        direction = np.stack([c * n[:, 0] - s * n[:, 1], s * n[:, 0] + c * n[:, 1]], axis=1)
        points.append(rim.points[has[owner]] + depth[owner, None] * direction)
        owners.append(has[owner])
        depths.append(depth[owner])
    xy, owner, depth = np.concatenate(points), np.concatenate(owners), np.concatenate(depths)
    # Near convex corners and medial branches the row of one side runs into another's.
    keep = distance(xy).distance >= 0.96 * depth
    xy, owner, depth = xy[keep], owner[keep], depth[keep]
    last = np.zeros(len(rim.points))
    np.maximum.at(last, owner, depth)
    return xy, last


def _apart(xy: Array, spacing: Array, fixed: Array, fixed_spacing: Array) -> Flags:
    """Mark the points that keep at least their spacing from fixed ones."""
    from scipy.spatial import cKDTree

    if not len(xy) or not len(fixed):
        return np.ones(len(xy), dtype=bool)
    gap, near = cKDTree(fixed).query(xy)
    kept: Flags = gap > np.minimum(spacing, fixed_spacing[near])
    return kept


def _lattice(rim: Rim, distance: RimDistance, last: Array, step: float) -> Array:
    """Return the nodes of a triangular lattice that begins where the rows end."""
    low, high = rim.points.min(axis=0), rim.points.max(axis=0)
    pitch = np.array([step, step * np.sqrt(3.0)])
    nodes = []
    for shift in (0.0, 0.5):
        start = low + (shift + 0.013) * pitch
        shape = np.maximum(np.ceil((high - start) / pitch).astype(np.intp) + 1, 1)
        inside = scanline_inside(rim.points, rim.after, start, pitch, (shape[0], shape[1]))
        nodes.append(start + pitch * np.argwhere(inside))
    xy = np.concatenate(nodes)
    closest = distance(xy)
    # Where rows were cut short (at convex corners) the lattice comes closer to the rim.
    room = np.maximum(
        last[closest.segment] + 0.55 * rim.step[closest.segment], 0.6 * rim.step[closest.segment]
    )
    return xy[closest.distance > room]


def _ridge(ridge: Array, rim: Rim, distance: RimDistance, taken: Array, step: float) -> Array:
    """Return points along the medial axis where limbs are too thin for the lattice."""
    from scipy.spatial import cKDTree

    if not len(ridge):
        return ridge[:, :2]
    closest = distance(ridge[:, :2])
    spacing = np.minimum(rim.step[closest.segment], step)
    thin = (closest.distance > 0.45 * spacing) & (closest.distance < 2.5 * step)
    xy, spacing = ridge[thin, :2], spacing[thin]
    if not len(xy):
        return xy
    clear = cKDTree(taken).query(xy)[0] > 0.55 * spacing
    xy, spacing = xy[clear], spacing[clear]
    return xy[_thinned(xy, 0.8 * spacing)]


def _thinned(xy: Array, spacing: Array) -> Flags:
    """Greedily keep points that are at least their spacing from all kept before."""
    from scipy.spatial import cKDTree

    keep = np.ones(len(xy), dtype=bool)
    if len(xy) < 2:
        return keep
    pairs = cKDTree(xy).query_pairs(float(spacing.max()), output_type="ndarray")
    if not len(pairs):
        return keep
    gap = np.hypot(*(xy[pairs[:, 0]] - xy[pairs[:, 1]]).T)
    pairs = pairs[gap < np.minimum(spacing[pairs[:, 0]], spacing[pairs[:, 1]])]
    for a, b in pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))].tolist():
        if keep[a]:
            keep[b] = False
    return keep


def _edge_keys(a: Index, b: Index, n: int) -> Index:
    return np.minimum(a, b) * n + np.maximum(a, b)


def _delaunay(points: Array, after: Index) -> tuple[Index, Index]:
    """Return Delaunay triangles, and the rim samples whose outgoing edge is missing."""
    from scipy.spatial import Delaunay

    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    offset = (points - middle) / np.ptp(points, axis=0).max()
    rounded = offset * (1.0 - _ROUNDING * (offset**2).sum(axis=1, keepdims=True))
    triangles = Delaunay(rounded).simplices.astype(np.intp)
    a, b, c = rounded[triangles].transpose(1, 0, 2)
    twice = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    triangles = np.where((twice < 0)[:, None], triangles[:, [0, 2, 1]], triangles)
    m = len(after)
    absent = np.ones(m, dtype=bool)
    for i in range(3):
        one, other = triangles[:, i], triangles[:, (i + 1) % 3]
        both = (one < m) & (other < m)
        one, other = one[both], other[both]
        absent[one[after[one] == other]] = False
        absent[other[after[other] == one]] = False
    return triangles, np.flatnonzero(absent)


def _inside(points: Array, triangles: Index, after: Index, distance: RimDistance) -> Index:
    """Return the triangles that lie inside."""
    # A triangle with a vertex inside is inside, as all rim edges are there to stop it.
    doubtful = np.flatnonzero((triangles < len(after)).all(axis=1))
    inside = np.ones(len(triangles), dtype=bool)
    if len(doubtful):
        inside[doubtful] = _rim_triangles_inside(points, triangles[doubtful], after, distance)
    return triangles[inside]


def _rim_triangles_inside(
    points: Array, triangles: Index, after: Index, distance: RimDistance
) -> Flags:
    """Mark which triangles, whose corners all lie on the rim, are inside."""
    # A rim edge run forwards by a counter-clockwise triangle has it on its left: inside,
    # beyond any rounding. Run backwards: outside.
    inside, told = np.zeros((2, len(triangles)), dtype=bool)
    for i in range(3):
        a, b = triangles[:, i], triangles[:, (i + 1) % 3]
        ahead, back = after[a] == b, after[b] == a
        inside = np.where(ahead, True, np.where(back, False, inside))
        told |= ahead | back
    rest = np.flatnonzero(~told)
    if len(rest):
        inside[rest] = distance(points[triangles[rest]].mean(axis=1)).distance > 0
    return inside


def _split_chords(points: Array, triangles: Index, after: Index) -> tuple[Array, Index, int]:
    """Halve edges that join two rim samples across the inside.

    Both would lie in the drawing plane and so would the edge; front and back would touch
    along it, and the solid would not be a manifold.
    """
    m, n = len(after), len(points)
    a, b = triangles, np.roll(triangles, -1, axis=1)
    chord = (a < m) & (b < m)
    rim_a, rim_b = np.where(chord, a, 0), np.where(chord, b, 0)
    chord &= (after[rim_a] != b) & (after[rim_b] != a)
    if not chord.any():
        return points, triangles, 0
    keys = _edge_keys(a, b, n)
    unique = np.unique(keys[chord])
    middle = 0.5 * (points[unique // n] + points[unique % n])
    label = np.where(chord, n + np.searchsorted(unique, keys), -1)
    return np.vstack([points, middle]), halved(triangles, label), len(unique)


def plan_of(rim: Rim, ridge: Array, step: float) -> Plan:
    """Triangulate the inside of a sampled outline.

    Parameters
    ----------
    rim : Rim
        The samples; all of them become vertices, in this order.
    ridge : (k, >=2) float array
        Points near the medial axis, used where limbs are thin.
    step : float
        Spacing of the lattice in the thick parts.

    Returns
    -------
    Plan
    """
    points, after = rim.points, rim.after
    distance = RimDistance(points, after)
    rows, last = _rows(rim, distance)
    lattice = _lattice(rim, distance, last, step)
    inner = np.concatenate([rows, lattice])
    inner = np.concatenate([inner, _ridge(ridge, rim, distance, np.vstack([points, inner]), step)])
    triangles, missing = _delaunay(np.vstack([points, inner]), after)
    for _ in range(_REPAIRS):
        if not len(missing):
            break
        points, after, inner = _mended(points, after, inner, missing)
        triangles, missing = _delaunay(np.vstack([points, inner]), after)
    if len(points) > len(rim.points):
        distance = RimDistance(points, after)
    vertices = np.vstack([points, inner])
    triangles = _inside(vertices, triangles, after, distance)
    vertices, triangles, split = _split_chords(vertices, triangles, after)
    return Plan(vertices, triangles, after, split)


def _mended(
    points: Array, after: Index, inner: Array, missing: Index
) -> tuple[Array, Index, Array]:
    """Halve the missing rim edges and clear the circles over them of inner points."""
    from scipy.spatial import cKDTree

    a, b = points[missing], points[after[missing]]
    middle, half = 0.5 * (a + b), 0.5 * np.hypot(*(b - a).T)
    keep = np.ones(len(inner), dtype=bool)
    if len(inner):
        for hit in cKDTree(inner).query_ball_point(middle, 0.7 * half):
            keep[hit] = False
    new = len(points) + np.arange(len(missing))
    longer = np.concatenate([after, after[missing]])
    longer[missing] = new
    return np.vstack([points, middle]), longer, inner[keep]
