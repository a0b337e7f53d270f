"""Outlines whose halves mirror each other: plans and skeletons that do so exactly.

A triangulation of a symmetric outline is not symmetric: samples begin somewhere, and of four points
on a circle either diagonal will do. So one half is kept, cut along the axis, and mirrored. The axis
is upright or level on the sheet, through the middle of the outline.
"""

from __future__ import annotations

from dataclasses import replace
from functools import reduce

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto_silhouette.numerics.grouping import connected_pieces
from bozzetto_silhouette.numerics.isotropic_remeshing import halved
from bozzetto_silhouette.outline.domain_mesh import Plan
from bozzetto_silhouette.outline.medial_axis import Skeleton

ALIKE = 1e-3
"""How far an outline may be from its mirror image, as a share of its longest side: less than the
width of a line on the screen, and more than curves lose when they become polygons."""

UNLIKE = 4e-3
"""Share of its area by which an outline and its mirror image may differ at most: of a thin thing
`ALIKE` may be a good part."""

GLANCE = 50
"""Points that are looked at first."""

NEAR = 0.3
"""Points nearer to the axis than this share of their shortest edge are moved onto it."""

STRAY = 0.04
"""The same for nodes of a skeleton, as a share of their radius: a spine lies on the axis."""


def mirrored_coordinate(rings: tuple[Array, ...]) -> int | None:
    """Return which coordinate changes its sign in the mirror image of an outline.

    Parameters
    ----------
    rings : tuple of (n, 2) float arrays
        Around (0, 0), the longest side being 1.

    Returns
    -------
    int or None
        0 where left and right are alike, else 1 where top and bottom are; None where neither.
    """
    lines = _Lines(rings)
    for coordinate in (0, 1):
        flip = np.where(np.arange(2) == coordinate, -1.0, 1.0)
        seen = np.concatenate(rings) * flip
        # Most outlines are not alike, and some of their points say so.
        some = seen[:: max(1, len(seen) // GLANCE)]
        if all(lines.are_near(places) for places in (some, seen)) and _shares(rings, flip):
            return coordinate
    return None


class _Lines:
    """Rings as lines.

    Parameters
    ----------
    rings : tuple of (n, 2) float arrays
    """

    def __init__(self, rings: tuple[Array, ...]) -> None:
        from scipy.spatial import cKDTree

        self._rings = rings
        self._points = np.concatenate(rings)
        self._after = np.concatenate([np.roll(ring, -1, axis=0) for ring in rings])
        self._before = np.concatenate([np.roll(ring, 1, axis=0) for ring in rings])
        self._tree = cKDTree(self._points)
        self._longest = float(np.hypot(*(self._after - self._points).T).max())

    def are_near(self, places: Array) -> bool:
        """Whether all places (n, 2) lie within `ALIKE` of them.

        Of most the nearest point and the two edges there tell it, in a fraction of the time.
        """
        gap, nearest = self._tree.query(places)
        if float(np.max(gap)) > ALIKE + 0.5 * self._longest:
            return False  # no point of an edge is farther than half of it from both its ends
        point = self._points[nearest]
        away = np.minimum(*(
            _distances(places, point, other[nearest]) for other in (self._before, self._after)
        ))  # fmt: skip
        rest = places[away > ALIKE]
        if not len(rest):
            return True
        import shapely

        lines = shapely.MultiLineString([np.vstack([ring, ring[:1]]) for ring in self._rings])
        return bool(shapely.dwithin(shapely.points(rest), lines, ALIKE).all())


def _distances(places: Array, start: Array, end: Array) -> Array:
    """Return the distance (n,) of each place from a segment of its own; all are (n, 2)."""
    way = end - start
    along = ((places - start) * way).sum(axis=1) / np.maximum((way * way).sum(axis=1), 1e-300)
    away: Array = np.hypot(*(places - start - np.clip(along, 0.0, 1.0)[:, None] * way).T)
    return away


def _shares(rings: tuple[Array, ...], flip: Array) -> bool:
    """Whether an outline and its mirror image cover the same but for `UNLIKE`."""
    import shapely

    inside, image = (
        reduce(
            shapely.symmetric_difference,
            (shapely.make_valid(shapely.Polygon(ring * sign)) for ring in rings),
        )
        for sign in (np.ones(2), flip)
    )
    differs = shapely.area(shapely.symmetric_difference(inside, image))
    return bool(differs <= UNLIKE * shapely.area(inside))


def mirrored_plan(plan: Plan, coordinate: int) -> Plan:
    """Return a plan of two halves that mirror each other, with partners.

    Parameters
    ----------
    plan : Plan
        Of an outline that is symmetric.
    coordinate : int
        The one that changes its sign.

    Returns
    -------
    Plan
        The same plan where its halves meet at single points, or where what lies apart, or a hole,
        is too narrow at the axis for points that are moved onto it.
    """
    points, triangles = _half(plan, coordinate)
    points, triangles = _without_chords(points, triangles, coordinate)
    count = len(points)
    on_axis = points[:, coordinate] == 0.0
    other = np.where(on_axis, np.arange(count), count + np.cumsum(~on_axis) - 1)
    flip = np.where(np.arange(2) == coordinate, -1.0, 1.0)
    whole = np.vstack([points, points[~on_axis] * flip])
    triangles = np.concatenate([triangles, other[triangles][:, ::-1]])
    partner = np.concatenate([other, np.flatnonzero(~on_axis)])

    a, b = _rim_edges(triangles)
    if max(np.bincount(a).max(initial=0), np.bincount(b).max(initial=0)) > 1:
        return plan  # a rim that meets itself
    if _connection(triangles) != _connection(plan.triangles):
        return plan  # pieces that are one now, or a hole that is closed
    rim = np.zeros(len(whole), bool)
    rim[a] = True
    order = np.concatenate([np.flatnonzero(rim), np.flatnonzero(~rim)])
    number = np.empty(len(whole), np.intp)
    number[order] = np.arange(len(whole))
    after = np.empty(len(a), np.intp)
    after[number[a]] = number[b]
    return replace(
        plan,
        points=whole[order],
        triangles=number[triangles],
        after=after,
        partner=number[partner[order]],
    )


def _half(plan: Plan, coordinate: int) -> tuple[Array, Index]:
    """Cut a plan along the axis and return the half with positive coordinates."""
    points, triangles = plan.points.copy(), plan.triangles
    a, b = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    lengths = np.hypot(*(points[a] - points[b]).T)
    shortest = np.full(len(points), np.inf)
    np.minimum.at(shortest, a, lengths)
    np.minimum.at(shortest, b, lengths)
    aside = points[:, coordinate]
    points[np.abs(aside) < NEAR * shortest, coordinate] = 0.0

    side = np.sign(points[:, coordinate])
    crossing = side[a] * side[b] < 0.0
    keys = np.minimum(a, b) * len(points) + np.maximum(a, b)
    unique = np.unique(keys[crossing])
    one, other = points[unique // len(points)], points[unique % len(points)]
    share = one[:, coordinate] / (one - other)[:, coordinate]
    middles = one + share[:, None] * (other - one)
    middles[:, coordinate] = 0.0
    label = np.where(crossing, len(points) + np.searchsorted(unique, keys), -1)
    triangles = halved(triangles, label.reshape(-1, 3))
    points = np.vstack([points, middles])
    sides = points[triangles][:, :, coordinate]
    return _used(points, triangles[(sides >= 0.0).all(axis=1) & (sides > 0.0).any(axis=1)])


def _without_chords(points: Array, triangles: Index, coordinate: int) -> tuple[Array, Index]:
    """Halve the edges of a half that join two samples of the rim across the inside."""
    rim_a, rim_b = _rim_edges(triangles)
    on_axis = points[:, coordinate] == 0.0
    cut = on_axis[rim_a] & on_axis[rim_b]
    rim: Flags = np.zeros(len(points), bool)
    rim[rim_a[~cut]] = rim[rim_b[~cut]] = True
    a, b = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    count = len(points)
    keys = np.minimum(a, b) * count + np.maximum(a, b)
    outer = np.minimum(rim_a, rim_b) * count + np.maximum(rim_a, rim_b)
    chord = rim[a] & rim[b]
    chord[chord] = ~np.isin(keys[chord], outer[~cut])
    unique = np.unique(keys[chord])
    label = np.where(chord, count + np.searchsorted(unique, keys), -1).reshape(-1, 3)
    middles = 0.5 * (points[unique // count] + points[unique % count])
    return np.vstack([points, middles]), halved(triangles, label)


def _rim_edges(triangles: Index) -> tuple[Index, Index]:
    """Return the ends of the edges that belong to one triangle, in its sense."""
    a, b = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    count = int(triangles.max(initial=0)) + 1
    against = np.sort(b * count + a)
    along = a * count + b
    place = np.minimum(np.searchsorted(against, along), len(against) - 1)
    alone = against[place] != along
    return a[alone], b[alone]


def _connection(triangles: Index) -> tuple[int, int]:
    """Return how many pieces triangles form, and their Euler characteristic."""
    count = int(triangles.max(initial=-1)) + 1
    used = int(np.count_nonzero(np.bincount(triangles.ravel(), minlength=count)))
    a, b = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    # A point that no triangle uses is a piece of its own.
    pieces, _ = connected_pieces(a, b, count)
    edges = np.sort(np.minimum(a, b) * count + np.maximum(a, b))
    different = len(edges) and 1 + int(np.count_nonzero(np.diff(edges)))
    return pieces - (count - used), used - different + len(triangles)


def _used(points: Array, triangles: Index) -> tuple[Array, Index]:
    """Return the points that triangles use, and the triangles by their new numbers."""
    kept = np.bincount(triangles.ravel(), minlength=len(points)) > 0
    return points[kept], (np.cumsum(kept) - 1)[triangles]


def mirrored_skeleton(skeleton: Skeleton, coordinate: int) -> Skeleton:
    """Return a skeleton of two halves that mirror each other.

    Parameters
    ----------
    skeleton : Skeleton
        Of an outline that is symmetric, in the frame of the sums.
    coordinate : int
        The one that changes its sign.

    Returns
    -------
    Skeleton
        The same one where no edge lies in either half.
    """
    nodes = skeleton.nodes.copy()
    near = np.abs(nodes[:, coordinate]) < np.maximum(STRAY * nodes[:, 2], ALIKE)
    nodes[near, coordinate] = 0.0
    a, b = skeleton.edges.T
    side = np.sign(nodes[:, coordinate])
    crossing = np.flatnonzero(side[a] * side[b] < 0.0)
    one, other = nodes[a[crossing]], nodes[b[crossing]]
    share = one[:, coordinate] / (one - other)[:, coordinate]
    middles = one + share[:, None] * (other - one)
    middles[:, coordinate] = 0.0
    new = len(nodes) + np.arange(len(crossing))
    whole = np.delete(skeleton.edges, crossing, axis=0)
    nodes = np.vstack([nodes, middles])
    ends = [np.column_stack([end[crossing], new]) for end in (a, b)]
    edges = np.concatenate([whole, *ends]).astype(np.intp)
    edges = edges[(nodes[edges][:, :, coordinate] >= 0.0).all(axis=1)]
    if not len(edges):
        return skeleton
    kept = np.zeros(len(nodes), bool)
    kept[edges] = True
    kept |= (nodes[:, coordinate] >= 0.0) & (np.bincount(edges.ravel(), minlength=len(nodes)) == 0)
    kept &= nodes[:, coordinate] >= 0.0
    number = np.cumsum(kept) - 1
    nodes, edges = nodes[kept], number[edges]

    on_axis = nodes[:, coordinate] == 0.0
    partner = np.where(on_axis, np.arange(len(nodes)), len(nodes) + np.cumsum(~on_axis) - 1)
    flip = np.where(np.arange(3) == coordinate, -1.0, 1.0)
    both = np.concatenate([edges, partner[edges]])
    both = np.unique(np.sort(both, axis=1), axis=0)
    return Skeleton(np.vstack([nodes, nodes[~on_axis] * flip]), both)
