"""Depth buffer: a scan converter that works on all rows at once.

Each triangle is cut into spans, one for each row of pixel centres it crosses. The ends of
a span are found on the triangle's edges, always walked from the upper to the lower end:
two triangles that share an edge compute the very same number there, and a pixel centre
belongs to the half-open span [left, right). So neighbours neither overlap nor leave a
crack, and the nearness, interpolated between the span's ends, never leaves the triangle.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Array, Flags, Floats

NOTHING = np.int32(-1)
"""Stands for no triangle."""

SPANS_AT_ONCE = 1_000_000
FRAGMENTS_AT_ONCE = 2_000_000
"""Limit of spans and pixels in one sweep; bounds the memory used."""

TILE = 8
"""Side (px) of the tiles that remember the farthest nearness in them."""


@dataclass(frozen=True, eq=False)
class DepthBuffer:
    """The nearest triangle at each pixel, row by row.

    Attributes
    ----------
    width, height : int
    nearness : (height · width,) float32
        −inf where nothing is seen.
    triangle : (height · width,) int32
        −1 where nothing is seen.
    """

    width: int
    height: int
    nearness: Floats
    triangle: NDArray[np.int32]


def blank_buffer(width: int, height: int) -> DepthBuffer:
    """Return an empty buffer."""
    return DepthBuffer(
        width,
        height,
        np.full(width * height, -np.inf, np.float32),
        np.full(width * height, NOTHING, np.int32),
    )


def rasterize(
    buffer: DepthBuffer, places: Array, faces: NDArray[np.int32], first: Flags | None = None
) -> None:
    """Draw triangles into a buffer.

    Parameters
    ----------
    buffer : Buffer
        Written to.
    places : (v, 3) float
        x, y (px) and nearness.
    faces : (t, 3) int32
        The row in this array is what is written into ``buffer.triangle``.
    first : (t,) bool, optional
        Triangles to draw before the others, because they are likely to hide them; the
        result does not depend on it but for triangles at exactly the same depth.
    """
    names = np.arange(len(faces), dtype=np.int32)
    if first is None:
        _draw(buffer, places, faces, names)
        return
    _draw(buffer, places, faces[first], names[first])
    others = np.flatnonzero(~first)
    others = others[_may_be_seen(buffer, places, faces[others])]
    _draw(buffer, places, faces[others], names[others])


def _may_be_seen(buffer: DepthBuffer, places: Array, faces: NDArray[np.int32]) -> Flags:
    """Return which triangles are not surely behind everything drawn where they lie."""
    across, down = -(-buffer.width // TILE), -(-buffer.height // TILE)
    full = np.full((down * TILE, across * TILE), np.inf, np.float32)
    full[: buffer.height, : buffer.width] = buffer.nearness.reshape(buffer.height, buffer.width)
    rows = np.minimum.reduce([full[k::TILE] for k in range(TILE)])
    farthest = np.minimum.reduce([rows[:, k::TILE] for k in range(TILE)])
    # float32, as the buffer is: rounding is monotone, so the comparison stays honest
    x, y, near = (_columns(places[:, axis].astype(np.float32), faces) for axis in range(3))
    left, right = (_cells(end(x), across) for end in (_least, _most))
    top, bottom = (_cells(end(y), down) for end in (_least, _most))
    behind = np.minimum(farthest[top, left], farthest[top, right])
    np.minimum(behind, farthest[bottom, left], out=behind)
    np.minimum(behind, farthest[bottom, right], out=behind)
    small = (right - left <= 1) & (bottom - top <= 1)
    return np.asarray(~small | (_most(near) >= behind))


Columns = tuple[NDArray[np.floating], NDArray[np.floating], NDArray[np.floating]]


def _columns(values: NDArray[np.floating], faces: NDArray[np.int32]) -> Columns:
    """Return a vertex value at the first, second and third corner of each face."""
    return values.take(faces[:, 0]), values.take(faces[:, 1]), values.take(faces[:, 2])


def _least(corner: Columns) -> NDArray[np.floating]:
    return np.asarray(np.minimum(np.minimum(corner[0], corner[1]), corner[2]))


def _most(corner: Columns) -> NDArray[np.floating]:
    return np.asarray(np.maximum(np.maximum(corner[0], corner[1]), corner[2]))


def _cells(value: NDArray[np.floating], count: int) -> NDArray[np.int32]:
    return np.asarray(np.clip(value * (1.0 / TILE), 0, count - 1), np.int32)


def _centers_before(value: NDArray[np.floating], size: int) -> NDArray[np.int64]:
    """Return how many pixel centres of a row or column of `size` lie before a place."""
    return np.asarray(np.ceil(np.clip(value, 0, size) - 0.5), np.int64)


def _draw(
    buffer: DepthBuffer, places: Array, faces: NDArray[np.int32], names: NDArray[np.int32]
) -> None:
    x, y = (_columns(places[:, axis], faces) for axis in (0, 1))
    top = _centers_before(_least(y), buffer.height)
    rows = _centers_before(_most(y), buffer.height) - top
    keep = np.flatnonzero((rows > 0) & (_most(x) > 0) & (_least(x) < buffer.width))
    rows, top, names = rows[keep], top[keep], names[keep]
    upper, middle, lower = _by_height(places, faces[keep])
    ends = np.cumsum(rows)
    begin = 0
    while begin < len(keep):
        done = int(ends[begin - 1]) if begin else 0
        end = max(begin + 1, int(np.searchsorted(ends, done + SPANS_AT_ONCE, "right")))
        part = slice(begin, end)
        corners = (upper[part], middle[part], lower[part])
        _draw_spans(buffer, places, corners, rows[part], top[part], names[part])
        begin = end


def _by_height(
    places: Array, faces: NDArray[np.int32]
) -> tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.int32]]:
    """Return vertices of each triangle from the top of the sheet down."""
    y = places[:, 1]
    a, b, c = faces.T
    for _ in range(2):  # a bubble sort of three
        swap = y.take(a) > y.take(b)
        a, b = np.where(swap, b, a), np.where(swap, a, b)
        swap = y.take(b) > y.take(c)
        b, c = np.where(swap, c, b), np.where(swap, b, c)
    return a, b, c


def _draw_spans(
    buffer: DepthBuffer,
    places: Array,
    corners: tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.int32]],
    rows: NDArray[np.int64],
    top: NDArray[np.int64],
    names: NDArray[np.int32],
) -> None:
    upper, middle, lower = corners
    which = np.repeat(np.arange(len(rows), dtype=np.int32), rows)
    row = np.arange(len(which)) - np.repeat(np.cumsum(rows) - rows - top, rows)
    center = row.astype(np.float64) + 0.5
    x_long, q_long = _on_edge(places, upper.take(which), lower.take(which), center)
    turn = middle.take(which)
    above = center < places[:, 1].take(turn)
    begin = np.where(above, upper.take(which), turn)
    end = np.where(above, turn, lower.take(which))
    x_short, q_short = _on_edge(places, begin, end, center)
    swap = x_short < x_long
    left, right = np.minimum(x_long, x_short), np.maximum(x_long, x_short)
    first = _centers_before(left, buffer.width)
    count = _centers_before(right, buffer.width) - first
    keep = np.flatnonzero(count > 0)
    q_left = np.where(swap, q_short, q_long)[keep]
    q_right = np.where(swap, q_long, q_short)[keep]
    first, count, left, right = first[keep], count[keep], left[keep], right[keep]
    slope = (q_right - q_left) / (right - left)
    start = q_left + slope * (first + 0.5 - left)
    pixel = row[keep] * buffer.width + first
    seen = names.take(which[keep])
    ends = np.cumsum(count)
    at = 0
    while at < len(keep):
        done = int(ends[at - 1]) if at else 0
        to = max(at + 1, int(np.searchsorted(ends, done + FRAGMENTS_AT_ONCE, "right")))
        part = slice(at, to)
        _draw_fragments(buffer, pixel[part], start[part], slope[part], count[part], seen[part])
        at = to


def _on_edge(
    places: Array, begin: NDArray[np.int32], end: NDArray[np.int32], y: Array
) -> tuple[Array, Array]:
    """Return x and nearness where the edges between vertices cross rows."""
    x0, y0, q0 = (places[:, axis].take(begin) for axis in range(3))
    x1, y1, q1 = (places[:, axis].take(end) for axis in range(3))
    t = (y - y0) / (y1 - y0)
    return x0 + t * (x1 - x0), q0 + t * (q1 - q0)


def _draw_fragments(
    buffer: DepthBuffer,
    pixel: NDArray[np.int64],
    start: Array,
    slope: Array,
    count: NDArray[np.int64],
    names: NDArray[np.int32],
) -> None:
    total = int(count.sum())
    before = np.cumsum(count) - count
    span = np.repeat(np.arange(len(count), dtype=np.int32), count)
    step = np.arange(total) - before[span]
    index = pixel[span] + step
    nearness = start.astype(np.float32)[span]
    nearness += slope.astype(np.float32)[span] * step.astype(np.float32)
    np.maximum.at(buffer.nearness, index, nearness)
    won = np.flatnonzero(nearness == buffer.nearness[index])
    buffer.triangle[index[won]] = names[span[won]]
