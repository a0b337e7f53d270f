"""Squares of texture coordinates drawn as pictures: what lies on what, and how far apart."""

from __future__ import annotations

import numpy as np
from PIL import Image, ImageDraw

from bozzetto.arrays import Array, Index


def owners(corners: Array, chart: Index, side: int) -> tuple[Index, int]:
    """Draw charts one after the other.

    Returns
    -------
    owner : (side, side) int array
        The chart of each texel whose middle it covers, -1 where there is none.
    twice : int
        How often a texel was another chart's already.
    """
    owner = np.full((side, side), -1)
    twice = 0
    for number in range(int(chart.max()) + 1):
        own = corners[chart == number] * side
        low = np.floor(own.min(axis=(0, 1))).astype(int) - 1
        size = np.ceil(own.max(axis=(0, 1))).astype(int) + 2 - low
        # Eight dots along a texel; its middle is one of them.
        picture = Image.new("1", tuple((size * 8).tolist()))
        draw = ImageDraw.Draw(picture)
        for triangle in ((own - low) * 8.0).tolist():
            draw.polygon([(x - 0.5, y - 0.5) for x, y in triangle], fill=1)
        mask = np.asarray(picture, bool)[4::8, 4::8]
        rows, columns = np.nonzero(mask)
        rows, columns = rows + low[1], columns + low[0]
        within = (rows >= 0) & (rows < side) & (columns >= 0) & (columns < side)
        rows, columns = rows[within], columns[within]
        twice += int((owner[rows, columns] >= 0).sum())
        owner[rows, columns] = number
    return owner, twice


def overlapping(corners: Array, chart: Index, side: int) -> int:
    """Return how many texels are of two charts."""
    return owners(corners, chart, side)[1]


def least_gap(corners: Array, chart: Index, side: int, most: int = 8) -> float:
    """Return the least number of free texels between charts, by their middles, up to so many."""
    owner, _ = owners(corners, chart, side)
    steps = [(down, right) for down in range(most + 2) for right in range(-most - 1, most + 2)]
    for down, right in sorted(steps, key=lambda step: (np.hypot(*step), step)):
        one = owner[: side - down, max(0, -right) : side - max(0, right)]
        two = owner[down:, max(0, right) : side + min(0, right)]
        if ((one >= 0) & (two >= 0) & (one != two)).any():
            return float(np.hypot(down, right)) - 1.0
    return float(most)


def drawn_out(points: Array, faces: Index, corners: Array) -> Array:
    """Return both singular values (f, 2) of every triangle's way into the square, in its unit."""
    a, b = points[faces[:, 1]] - points[faces[:, 0]], points[faces[:, 2]] - points[faces[:, 0]]
    with np.errstate(divide="ignore", invalid="ignore"):
        right = a / np.linalg.norm(a, axis=1, keepdims=True)
        along = np.einsum("fd,fd->f", b, right)
        height = np.linalg.norm(b - along[:, None] * right, axis=1)
        length = np.linalg.norm(a, axis=1)
        one = (corners[:, 1] - corners[:, 0]) / length[:, None]
        two = ((corners[:, 2] - corners[:, 0]) - along[:, None] * one) / height[:, None]
    p, q, r, s = one[:, 0], two[:, 0], one[:, 1], two[:, 1]
    alike, against = np.hypot(p + s, r - q), np.hypot(p - s, r + q)
    return np.stack([0.5 * (alike + against), 0.5 * np.abs(alike - against)], axis=1)
