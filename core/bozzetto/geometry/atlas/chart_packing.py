"""Charts placed in a square so that they leave little of it free.

Each is drawn on a grid of cells, in four positions, the largest first; where it can be without
covering what is there, a correlation tells for all cells at once (by fast Fourier transform). It
goes where its upper end is lowest. The square begins too small and grows until it holds all.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bozzetto.geometry.atlas.chart_flattening import ring_area

if TYPE_CHECKING:
    from bozzetto.arrays import Array, Flags, Index

FULLEST: Final = 0.94
"""Share of the square that is tried first."""

STEP: Final = 0.985
"""Factor on that share until all charts have a place."""

FINER: Final = 4
"""Dots along a cell by which charts are drawn."""

SINGLES: Final = 96
"""Charts that are placed one by one; smaller ones lie together in one block."""


class Outline(NamedTuple):
    """A chart to be placed.

    Attributes
    ----------
    rings : sequence of (n, 2) float arrays
        Its borders.
    area : float
    """

    rings: Sequence[Array]
    area: float


class Packing(NamedTuple):
    """Where charts are in the square.

    Attributes
    ----------
    turn : (n, 2, 2) float array
        The turn of each, by columns.
    offset : (n, 2) float array
        Added after the turn.
    side : float
        Of the square.
    """

    turn: Array
    offset: Array
    side: float


def packed(outlines: Sequence[Outline], cells: int) -> Packing:
    """Place charts in a square without overlaps, at least a cell apart.

    Parameters
    ----------
    outlines : sequence of Outline
        At least one with an area.
    cells : int
        Of the grid along a side of the square.
    """
    bare = [_upright(outline) for outline in outlines]
    order = np.argsort([-float(np.prod(size)) for _, size in bare], kind="stable")
    single, rest = order[:SINGLES], order[SINGLES:]
    total = sum(outline.area for outline in outlines)
    share = FULLEST
    while True:
        side = float(np.sqrt(max(total, 1e-300) / share))
        found = _placed(outlines, bare, single, rest, side / cells, cells)
        if found is not None:
            return Packing(*found, side)
        share *= STEP


def box_sizes(points: Array, angles: Array) -> tuple[Array, Array]:
    """Return widths and heights of the boxes around points (n, 2) at angles (a,)."""
    along = points @ np.stack([np.cos(angles), np.sin(angles)])
    across = points @ np.stack([-np.sin(angles), np.cos(angles)])
    return np.ptp(along, axis=0), np.ptp(across, axis=0)


def _upright(outline: Outline) -> tuple[Array, Array]:
    """Return the turn (2, 2) of the smallest box around an outline to lie flat, and its size."""
    points = np.concatenate(list(outline.rings))
    angles: Array = np.linspace(0.0, 0.5 * np.pi, 64, endpoint=False, dtype=np.float64)
    width, height = box_sizes(points, angles)
    size = width * height
    # Of nearly equal ones the first, in whatever unit.
    best = int((size <= (1.0 + 1e-9) * size.min()).argmax())
    c, s = np.cos(angles[best]), np.sin(angles[best])
    turn = np.array([[c, -s], [s, c]])
    if width[best] < height[best]:
        turn = turn @ np.array([[0.0, -1.0], [1.0, 0.0]])
    return turn, np.ptp(points @ turn, axis=0)


def _placed(
    outlines: Sequence[Outline], bare: Sequence[tuple[Array, Array]],
    single: Index, rest: Index, cell: float, cells: int,
) -> tuple[Array, Array] | None:  # fmt: skip
    """Place all charts at one size of the cells; None if one finds no place."""
    from scipy.fft import irfft2, rfft2

    taken = np.zeros((cells, cells), np.float32)
    turns, offsets = np.zeros((len(outlines), 2, 2)), np.zeros((len(outlines), 2))
    block = _block(bare, rest, cell)
    for number in [*single.tolist(), *([-1] if len(rest) else [])]:
        sea = rfft2(taken)
        best: tuple[int, int, int, Array, Array, Flags] | None = None
        for quarter in range(4) if number >= 0 else (0,):
            if number >= 0:
                turn = bare[number][0] @ _QUARTERS[quarter]
                mask, low = _mask([ring @ turn / cell for ring in outlines[number].rings])
            else:
                turn, low, mask = np.eye(2), np.zeros(2), np.ones(block[1], bool)
            high, wide = mask.shape
            if high > cells or wide > cells:
                continue
            drawn = np.zeros_like(taken)
            drawn[:high, :wide] = mask
            hits = irfft2(sea * np.conj(rfft2(drawn)), s=taken.shape)
            free = hits[: cells - high + 1, : cells - wide + 1] < 0.5
            rows = np.flatnonzero(free.any(axis=1))
            if not len(rows):
                continue
            row = int(rows[0])
            found = (row + high, int(free[row].argmax()), row, turn, low, mask)
            if best is None or found[:2] < best[:2]:
                best = found
        if best is None:
            return None
        _, column, row, turn, low, mask = best
        _cover(taken, mask, row, column)
        if number >= 0:
            turns[number], offsets[number] = turn, (np.array([column, row]) - low) * cell
            continue
        for k, place in zip(rest.tolist(), block[0], strict=True):
            turn = bare[k][0]
            least = np.concatenate(list(outlines[k].rings)) @ turn
            turns[k] = turn
            offsets[k] = (place + np.array([column, row])) * cell - least.min(axis=0)
    return turns, offsets


_QUARTERS: Final = [
    np.array(m, float)
    for m in ([[1, 0], [0, 1]], [[0, 1], [-1, 0]], [[-1, 0], [0, -1]], [[0, -1], [1, 0]])
]


def _mask(rings: Sequence[Array]) -> tuple[Flags, Array]:
    """Draw rings, in cells: those that they touch, and where these begin."""
    from PIL import Image, ImageDraw

    low = np.floor(np.min([ring.min(axis=0) for ring in rings], axis=0))
    size = np.floor(np.max([ring.max(axis=0) for ring in rings], axis=0)) + 1.0 - low
    image = Image.new("L", (int(size[0]) * FINER, int(size[1]) * FINER))
    draw = ImageDraw.Draw(image)
    sizes = [abs(ring_area(ring)) for ring in rings]
    outer = int(np.argmax(sizes))
    draw.polygon(_pairs((rings[outer] - low) * FINER), fill=1, outline=1)
    for number, ring in enumerate(rings):
        if number != outer and len(ring) > 2:
            draw.polygon(_pairs((ring - low) * FINER), fill=0, outline=1)
    fine = np.asarray(image, bool)
    cells = fine.reshape(int(size[1]), FINER, int(size[0]), FINER)
    touched: Flags = np.asarray(cells.any(axis=(1, 3)), bool)
    return touched, low


def _pairs(ring: Array) -> list[tuple[float, float]]:
    return [(float(x), float(y)) for x, y in ring - 0.5]


def _cover(taken: NDArray[np.float32], mask: Flags, row: int, column: int) -> None:
    """Take the cells of a chart and those around them."""
    high, wide = mask.shape
    spread = np.zeros((high + 2, wide + 2), bool)
    for down in range(3):
        for right in range(3):
            spread[down : down + high, right : right + wide] |= mask
    top, left = max(row - 1, 0), max(column - 1, 0)
    bottom = min(row + high + 1, taken.shape[0])
    end = min(column + wide + 1, taken.shape[1])
    part = spread[top - row + 1 : bottom - row + 1, left - column + 1 : end - column + 1]
    np.maximum(taken[top:bottom, left:end], part, out=taken[top:bottom, left:end])


def _block(
    bare: Sequence[tuple[Array, Array]], rest: Index, cell: float
) -> tuple[list[Array], tuple[int, int]]:
    """Put small charts on shelves: their places in cells, and rows and columns of the block."""
    if not len(rest):
        return [], (0, 0)
    sizes = np.array([bare[k][1] for k in rest.tolist()]) / cell + 1.0
    wide = max(float(np.sqrt(sizes.prod(axis=1).sum())), float(sizes[:, 0].max()))
    order = np.argsort(-sizes[:, 1], kind="stable")
    places: list[Array] = [np.zeros(2)] * len(sizes)
    x = y = shelf = 0.0
    for k in order.tolist():
        if x + sizes[k, 0] > wide:
            x, y, shelf = 0.0, y + shelf, 0.0
        places[k] = np.array([x, y]) + 0.5
        x, shelf = x + float(sizes[k, 0]), max(shelf, float(sizes[k, 1]))
    return places, (int(np.ceil(y + shelf)) + 1, int(np.ceil(wide)) + 1)
