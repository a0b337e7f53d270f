"""Which triangle is seen at each pixel: a scan converter that works on all rows at once.

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

__all__ = ["Buffer", "blank", "rasterize"]

Array = NDArray[np.float64]

NOTHING = np.int32(-1)
"""Stands for no triangle."""

SPANS_AT_ONCE = 1_000_000
FRAGMENTS_AT_ONCE = 2_000_000
"""How many spans and pixels are worked on in one sweep; bounds the memory used."""

TILE = 8
"""Side (px) of the tiles that remember the farthest nearness in them."""


@dataclass(frozen=True, eq=False)
class Buffer:
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
    nearness: NDArray[np.float32]
    triangle: NDArray[np.int32]


def blank(width: int, height: int) -> Buffer:
    """An empty buffer."""
    return Buffer(
        width,
        height,
        np.full(width * height, -np.inf, np.float32),
        np.full(width * height, NOTHING, np.int32),
    )


def rasterize(
    buffer: Buffer, places: Array, faces: NDArray[np.int32], first: NDArray[np.bool_] | None = None
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


def _may_be_seen(buffer: Buffer, places: Array, faces: NDArray[np.int32]) -> NDArray[np.bool_]:
    """Which triangles are not surely behind everything drawn where they lie."""
    across, down = -(-buffer.width // TILE), -(-buffer.height // TILE)
    full = np.full((down * TILE, across * TILE), np.inf, np.float32)
    full[: buffer.height, : buffer.width] = buffer.nearness.reshape(buffer.height, buffer.width)
    farthest = full.reshape(down, TILE, across, TILE).min((1, 3))
    cells = []
    for axis, count in ((0, across), (1, down)):
        values = places[:, axis][faces]
        for end in (values.min(1), values.max(1)):
            cells.append(np.clip(end / TILE, 0, count - 1).astype(np.int32))
    left, right, top, bottom = cells
    behind = np.full(len(faces), np.inf, np.float32)
    for row in (top, bottom):
        for column in (left, right):
            np.minimum(behind, farthest[row, column], out=behind)
    small = (right - left <= 1) & (bottom - top <= 1)
    # float32, as the buffer is: rounding is monotone, so the comparison stays honest
    nearest = places[:, 2].astype(np.float32)[faces].max(1)
    return ~small | (nearest >= behind)


def _draw(
    buffer: Buffer, places: Array, faces: NDArray[np.int32], names: NDArray[np.int32]
) -> None:
    corners = places[faces]
    x, y = corners[:, :, 0], corners[:, :, 1]
    low, high = y.min(1), y.max(1)
    on_sheet = (x.max(1) > 0) & (x.min(1) < buffer.width)
    top = np.ceil(np.clip(low, 0, buffer.height) - 0.5).astype(np.int32)
    bottom = np.ceil(np.clip(high, 0, buffer.height) - 0.5).astype(np.int32)
    rows = np.where(on_sheet, bottom - top, 0)
    keep = np.flatnonzero(rows > 0)
    corners, rows, top, names = corners[keep], rows[keep], top[keep], names[keep]
    upper, middle, lower = _by_height(corners)
    ends = np.cumsum(rows, dtype=np.int64)
    begin = 0
    while begin < len(keep):
        done = ends[begin - 1] if begin else 0
        end = max(begin + 1, int(np.searchsorted(ends, done + SPANS_AT_ONCE, "right")))
        part = slice(begin, end)
        _draw_spans(
            buffer, upper[part], middle[part], lower[part], rows[part], top[part], names[part]
        )
        begin = end


def _by_height(corners: Array) -> tuple[Array, Array, Array]:
    """Corners of each triangle from the top of the sheet down; (n, 3) each."""
    order = np.argsort(corners[:, :, 1], axis=1, kind="stable")
    each = np.arange(len(corners))
    return tuple(corners[each, order[:, k]] for k in range(3))  # type: ignore[return-value]


def _draw_spans(
    buffer: Buffer,
    upper: Array,
    middle: Array,
    lower: Array,
    rows: NDArray[np.int32],
    top: NDArray[np.int32],
    names: NDArray[np.int32],
) -> None:
    which = np.repeat(np.arange(len(rows)), rows)
    row = np.arange(len(which)) - np.repeat(np.cumsum(rows) - rows - top, rows)
    center = row + 0.5
    a, b, c = upper[which], middle[which], lower[which]
    x_long, q_long = _on_edge(a, c, center)
    above = (center < b[:, 1])[:, None]
    x_short, q_short = _on_edge(np.where(above, a, b), np.where(above, b, c), center)
    swap = x_short < x_long
    left, right = np.minimum(x_long, x_short), np.maximum(x_long, x_short)
    q_left, q_right = np.where(swap, q_short, q_long), np.where(swap, q_long, q_short)
    first = np.ceil(np.clip(left, 0, buffer.width) - 0.5).astype(np.int64)
    count = np.ceil(np.clip(right, 0, buffer.width) - 0.5).astype(np.int64) - first
    keep = np.flatnonzero(count > 0)
    first, count, left, right = first[keep], count[keep], left[keep], right[keep]
    q_left = q_left[keep]
    slope = (q_right[keep] - q_left) / (right - left)
    start = q_left + slope * (first + 0.5 - left)
    pixel = row[keep] * buffer.width + first
    names = names[which[keep]]
    ends = np.cumsum(count)
    begin = 0
    while begin < len(keep):
        done = int(ends[begin - 1]) if begin else 0
        end = max(begin + 1, int(np.searchsorted(ends, done + FRAGMENTS_AT_ONCE, "right")))
        part = slice(begin, end)
        _draw_fragments(buffer, pixel[part], start[part], slope[part], count[part], names[part])
        begin = end


def _on_edge(begin: Array, end: Array, y: Array) -> tuple[Array, Array]:
    """Where an edge crosses rows: x and nearness."""
    t = (y - begin[:, 1]) / (end[:, 1] - begin[:, 1])
    x = begin[:, 0] + t * (end[:, 0] - begin[:, 0])
    return x, begin[:, 2] + t * (end[:, 2] - begin[:, 2])


def _draw_fragments(
    buffer: Buffer,
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
