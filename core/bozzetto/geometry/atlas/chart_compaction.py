"""Charts in a square pushed together, all at once, by small moves, turns and growths.

Z. Li and V. Milenkovic, *Compaction and separation algorithms for non-convex polygons and their
applications*, 1995: a linear program finds those moves that fill the square most, where every
point keeps its distance from the edges that are near; then again from there. Charts that have room
grow a little.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from bozzetto.geometry.atlas.chart_flattening import ring_area

if TYPE_CHECKING:
    from bozzetto.arrays import Array, Index

ROUNDS: Final = 30
"""Linear programs at most."""

REACH: Final = 3.0
"""How far a point moves at first in one of them, in gaps."""

LEAST: Final = 0.4
"""The same below which it ends."""

WORTH: Final = 5e-4
"""Share of the side that a round has to gain, or the reach is halved."""

COARSE: Final = 0.08
"""How far outlines are off where they are made simpler, in gaps."""

SLACK: Final = 0.05
"""By how much more charts are kept apart than they have to be: moves are not quite straight."""

GROWN: Final = 0.05
"""By how much a chart may be larger than others where there is room, along its sides."""

PULL: Final = 1e-3
"""How much a chart's way to the corner counts beside the side of the square."""


def compacted(
    outlines: Sequence[Sequence[Array]], gap: float, checkpoint: Callable[[float], None]
) -> tuple[Array, Array, float]:
    """Push charts together, and let them grow where there is room.

    Parameters
    ----------
    outlines : sequence of sequences of (n, 2) float arrays
        The borders of each chart, within a square whose corner is (0, 0), and apart.
    gap : float
        How far they have to be apart, as a share of the side of the square.
    checkpoint : callable
        Called with the fraction done (0 … 1); may raise to stop it.

    Returns
    -------
    turn : (n, 2, 2) float array
        With the growth, by columns.
    offset : (n, 2) float array
        Added after the turn.
    side : float
        Of the square that they lie in afterwards.
    """
    side = float(max(ring.max() for rings in outlines for ring in rings))
    count = len(outlines)
    apart = gap * (1.0 + COARSE)
    now = [_simpler(rings, 0.5 * COARSE * gap * side) for rings in outlines]
    turn, offset = np.tile(np.eye(2), (count, 1, 1)), np.zeros((count, 2))
    grown, full = np.ones(count), np.array([_area(rings) for rings in now])
    reach, growing = REACH, False
    for number in range(ROUNDS):
        checkpoint(number / ROUNDS)
        room = (1.0 + GROWN) / grown - 1.0 if growing else np.zeros(count)
        moves = _moves(now, (1.0 + SLACK) * apart, side, reach * gap * side, room)
        if moves is not None:
            c, s = np.cos(moves[:, 2]), np.sin(moves[:, 2])
            turns = np.stack([np.stack([c, s], 1), np.stack([-s, c], 1)], 1)
            turns *= 1.0 + moves[:, 3, None, None]
            middles = np.array([_middle(rings) for rings in now])
            steps = middles + moves[:, :2] - np.einsum("nd,nde->ne", middles, turns)
            low = np.min([
                (np.concatenate(rings) @ t + o).min(axis=0)
                for rings, t, o in zip(now, turns, steps, strict=True)
            ], axis=0)  # fmt: skip
            steps = steps - low
            tried = [
                [ring @ t + o for ring in rings]
                for rings, t, o in zip(now, turns, steps, strict=True)
            ]
            there = float(max(ring.max() for rings in tried for ring in rings))
            larger = grown * (1.0 + moves[:, 3])
            better = 0.5 * np.log((full @ larger**2) / (full @ grown**2)) - np.log(there / side)
            if better > 1e-6 and _apart(tried, apart * there):
                now, side, grown = tried, there, larger
                turn, offset = turn @ turns, np.einsum("nd,nde->ne", offset, turns) + steps
                if better > WORTH:
                    continue
        reach *= 0.5
        if reach < LEAST and growing:
            break
        if reach < LEAST:  # closer together they cannot be
            reach, growing = REACH, True
    least = float(grown.min())
    return turn / least, offset / least, side / least


def _simpler(rings: Sequence[Array], off: float) -> list[Array]:
    """Return rings, the outer one first, with fewer points."""
    import shapely

    order = sorted(rings, key=lambda ring: -abs(ring_area(ring)))
    closed = [shapely.LinearRing(ring) for ring in order if len(ring) > 2]
    found = [np.asarray(shapely.simplify(ring, off).coords)[:-1] for ring in closed]
    return [ring for ring in found if len(ring) > 2] or [order[0]]


def _area(rings: Sequence[Array]) -> float:
    return sum((1.0 if k == 0 else -1.0) * abs(ring_area(ring)) for k, ring in enumerate(rings))


def _middle(rings: Sequence[Array]) -> Array:
    return np.asarray(0.5 * (rings[0].min(axis=0) + rings[0].max(axis=0)))


def _apart(outlines: Sequence[Sequence[Array]], gap: float) -> bool:
    """Whether no two charts are nearer than this."""
    import shapely

    shapes = [shapely.Polygon(rings[0], rings[1:]) for rings in outlines]
    one, other = shapely.STRtree(shapes).query(shapes, "dwithin", gap * (1.0 - 1e-6))
    return bool((one == other).all())


def _moves(
    outlines: Sequence[Sequence[Array]], gap: float, side: float, reach: float, room: Array
) -> Array | None:
    """Return the moves, turns and growths (n, 4) that fill the square most, if they are found."""
    from scipy.optimize import linprog
    from scipy.sparse import coo_array

    count = len(outlines)
    middles = np.array([_middle(rings) for rings in outlines])
    every = [np.concatenate(list(rings)) for rings in outlines]
    sizes = np.array([float(np.linalg.norm(np.ptp(points, axis=0))) / 2.0 for points in every])
    boxes = [(points.min(axis=0), points.max(axis=0)) for points in every]
    edges = [
        (points, np.concatenate([np.roll(ring, -1, axis=0) for ring in rings]) - points)
        for points, rings in zip(every, outlines, strict=True)
    ]
    rows: list[Index] = []
    columns: list[Index] = []
    values: list[Array] = []
    bound: list[Array] = []
    first = 0

    def add(parts: Sequence[tuple[Index, Array, Array, Array]], share: Array, most: Array) -> None:
        """Add rows: sum of (chart, direction, arm, sign) + share of the side <= most."""
        nonlocal first
        own = first + np.arange(len(most))
        for chart, way, arm, sign in parts:
            lever = way[:, 1] * arm[:, 0] - way[:, 0] * arm[:, 1]
            away = (way * arm).sum(axis=1)
            for k, value in enumerate((way[:, 0], way[:, 1], lever, away)):
                rows.append(own)
                columns.append(4 * chart + k)
                values.append(sign * value)
        rows.append(own)
        columns.append(np.full(len(own), 4 * count))
        values.append(share)
        bound.append(most)
        first += len(most)

    near = 2.2 * reach + gap * side
    for one in range(count):
        hull = _extreme(outlines[one][0])
        arm, chart = hull - middles[one], np.full(len(hull), one)
        for way in np.eye(2):
            ways = np.tile(way, (len(hull), 1))
            add([(chart, ways, arm, np.ones(len(hull)))], -np.ones(len(hull)), -(hull @ way))
            add([(chart, ways, arm, -np.ones(len(hull)))], np.zeros(len(hull)), hull @ way)
        for other in range(count):
            if one == other:
                continue
            low, high = boxes[other][0] - near, boxes[other][1] + near
            points = every[one][((every[one] > low) & (every[one] < high)).all(axis=1)]
            if not len(points):
                continue
            points, foot, distance = _nearest(points, *edges[other], near)
            if not len(points):
                continue
            way = (points - foot) / distance[:, None]
            size = len(points)
            add(
                [
                    (np.full(size, one), way, points - middles[one], -np.ones(size)),
                    (np.full(size, other), way, foot - middles[other], np.ones(size)),
                ],
                np.full(size, gap), distance,
            )  # fmt: skip
    matrix = coo_array(
        (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))),
        shape=(first, 4 * count + 1),
    ).tocsr()
    cost = np.zeros(4 * count + 1)
    cost[-1] = 1.0
    cost[0:-1:4] = cost[1:-1:4] = PULL / count
    area = np.array([_area(rings) for rings in outlines])
    cost[3:-1:4] = -side * area / area.sum()
    most = np.full((count, 4), 0.7 * reach)
    most[:, 2:] = 0.3 * reach / np.maximum(sizes, reach)[:, None]
    least = -most
    least[:, 3], most[:, 3] = 0.0, np.minimum(most[:, 3], room)
    limits = np.concatenate([np.stack([least.ravel(), most.ravel()], 1), [[0.5 * side, side]]])
    solve: Any = linprog  # whose types do not know sparse arrays
    found = solve(cost, A_ub=matrix, b_ub=np.concatenate(bound), bounds=limits, method="highs")
    return np.asarray(found.x[:-1]).reshape(-1, 4) if found.status == 0 else None


def _extreme(ring: Array) -> Array:
    """Return the corners of the convex hull."""
    from scipy.spatial import ConvexHull

    return np.asarray(ring[ConvexHull(ring).vertices])


def _nearest(points: Array, start: Array, along: Array, near: float) -> tuple[Array, Array, Array]:
    """Return those points near some edges, with the nearest ones on these and their distances."""
    length = np.maximum((along**2).sum(axis=1), 1e-300)
    ahead = points[:, None] - start[None]
    share = np.clip((ahead * along).sum(axis=2) / length, 0.0, 1.0)
    foot = start[None] + share[..., None] * along[None]
    away = ((points[:, None] - foot) ** 2).sum(axis=2)
    which = away.argmin(axis=1)
    rows = np.arange(len(points))
    distance = np.sqrt(away[rows, which])
    kept = (distance < near) & (distance > 0.0)
    return points[kept], foot[rows, which][kept], distance[kept]
