"""Triangulation of a region between rings over a grid of unit cells, without new ring corners."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from bozzetto.arrays import Array, Flags, Index

MARGIN: Final = 0.4
"""Least distance between rings and whole cells, in cells."""

MOST_EXCHANGES: Final = 100
"""Exchanges of diagonals, per triangle, after which they stay as they are."""

ROUNDING: Final = 1e-14
"""Bound of rounding in the test for circles, as share of the sum of all products in it
(Shewchuk 1997, "Adaptive precision floating-point arithmetic")."""


def triangulated(rings: list[Array], counts: tuple[int, int]) -> tuple[Array, Index]:
    """Triangulate the region between an outer ring and holes.

    Whole cells of the grid that keep away from the rings are two triangles each. What is left
    is cut into ears (manifold3d), whose diagonals are exchanged until they are Delaunay.

    Parameters
    ----------
    rings : list of (n, 2) float
        Corners, each once; the first ring counter-clockwise, holes clockwise.
    counts : (int, int)
        Cells of the grid from 0 along both coordinates; 0 for none.

    Returns
    -------
    points : (k, 2) float
        Crossings of grid lines that became corners, behind those of the rings.
    triangles : (t, 3) int
        Numbers of corners: those of the rings in order, then of the points; counter-clockwise.
        Each side of a ring is a side of one triangle, any other one is shared by two, also where
        rings cross and triangles overlap.
    """
    import manifold3d

    corners = np.concatenate(rings)
    points, quads, borders = _cell_mesh(_whole_cells(rings, counts))
    everything = np.concatenate((corners, points))
    count = len(corners)
    holes = [border[::-1] + count for border in borders]
    numbers = np.concatenate((np.arange(count), *holes))
    lines = [*rings, *(everything[hole] for hole in holes)]
    ears = np.asarray(manifold3d.triangulate([np.ascontiguousarray(line) for line in lines]))
    between = exchanged(numbers[ears.reshape(-1, 3).astype(np.intp)], everything)
    return points, np.concatenate((quads + count, between))


def _whole_cells(rings: list[Array], counts: tuple[int, int]) -> Flags:
    """Return which cells lie inside, away from the rings, and nowhere meet at a corner only."""
    import shapely

    cells = np.ones(counts, bool)
    if not cells.size:
        return cells
    for ring in rings:
        after = np.roll(ring, -1, axis=0)
        low = np.floor(np.minimum(ring, after) - MARGIN).astype(np.intp).clip(0)
        high = np.floor(np.maximum(ring, after) + MARGIN).astype(np.intp).clip(-1) + 1
        for (i, j), (k, m) in zip(low.tolist(), high.tolist(), strict=True):
            cells[i:k, j:m] = False
    numbers = np.argwhere(cells)
    if len(numbers):
        polygon = shapely.Polygon(rings[0], rings[1:])
        shapely.prepare(polygon)
        inside = shapely.contains_xy(polygon, *(numbers + 0.5).T)
        cells[tuple(numbers[~inside].T)] = False
    while True:
        a, b, c, d = cells[:-1, :-1], cells[1:, :-1], cells[1:, 1:], cells[:-1, 1:]
        pinched = np.argwhere((a & c & ~b & ~d) | (b & d & ~a & ~c))
        if not len(pinched):
            return cells
        for i, j in pinched.tolist():
            cells[i : i + 2, j : j + 2] = False


def _cell_mesh(cells: Flags) -> tuple[Array, Index, list[Index]]:
    """Return corners (k, 2) of cells, two triangles in each, and numbers of corners round them."""
    numbers = np.argwhere(cells)
    square = numbers[:, None] + np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    across = cells.shape[1] + 1
    codes = square[..., 0] * across + square[..., 1]
    known, which = np.unique(codes, return_inverse=True)
    a, b, c, d = which.reshape(codes.shape).T
    # Diagonals change from cell to cell, so that no direction is preferred.
    odd = (numbers.sum(axis=1) % 2 == 1)[:, None]
    one = np.where(odd, np.stack((a, b, d), axis=1), np.stack((a, b, c), axis=1))
    two = np.where(odd, np.stack((b, c, d), axis=1), np.stack((a, c, d), axis=1))
    starts = codes.ravel()
    ends = np.roll(codes, -1, axis=1).ravel()
    total = across * (cells.shape[0] + 1)
    border = ~np.isin(starts * total + ends, ends * total + starts)
    following = dict(zip(starts[border].tolist(), ends[border].tolist(), strict=True))
    rings = []
    while following:
        first, at = following.popitem()
        ring = [first]
        while at != first:
            ring.append(at)
            at = following.pop(at)
        rings.append(np.searchsorted(known, ring))
    points = np.stack(np.divmod(known, across), axis=1).astype(float)
    return points, np.concatenate((one, two)), rings


def exchanged(triangles: Index, corners: Array) -> Index:
    """Return triangles with diagonals exchanged until they are Delaunay (Lawson 1977).

    Sides of one triangle only stay.

    Parameters
    ----------
    triangles : (t, 3) int
        Counter-clockwise.
    corners : (n, 2) float
        Places of their corners.
    """
    rows = triangles.tolist()
    at = {(row[k], row[k - 2]): (t, k) for t, row in enumerate(rows) for k in range(3)}
    places = corners.tolist()
    waiting = [side for side in at if side[::-1] in at]
    left = MOST_EXCHANGES * len(rows)
    while waiting and left:
        side = waiting.pop()
        a, b = side
        if side not in at or (b, a) not in at:
            continue
        (t, k), (other, m) = at[side], at[b, a]
        c, d = rows[t][k - 1], rows[other][m - 1]
        if c == d or (c, d) in at or not _inside_circle(places, a, b, c, d):
            continue
        left -= 1
        rows[t], rows[other] = [c, d, b], [d, c, a]
        del at[side], at[b, a]
        for number in (t, other):
            row = rows[number]
            at.update({(row[i], row[i - 2]): (number, i) for i in range(3)})
        waiting += [(b, c), (c, a), (a, d), (d, b)]
    return np.array(rows, np.intp).reshape(-1, 3)


def _inside_circle(places: list[list[float]], a: int, b: int, c: int, d: int) -> bool:
    """Whether d is inside the circle round the triangle a b c, beyond rounding."""
    x, y = places[d]
    (ax, ay), (bx, by), (cx, cy) = ((places[k][0] - x, places[k][1] - y) for k in (a, b, c))
    one, two, three = ax * ax + ay * ay, bx * bx + by * by, cx * cx + cy * cy
    row = (
        one * (bx * cy - by * cx),
        two * (ay * cx - ax * cy),
        three * (ax * by - ay * bx),
    )
    whole = (
        one * (abs(bx * cy) + abs(by * cx))
        + two * (abs(ay * cx) + abs(ax * cy))
        + three * (abs(ax * by) + abs(ay * bx))
    )
    return sum(row) > ROUNDING * whole
