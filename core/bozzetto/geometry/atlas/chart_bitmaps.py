"""Charts on a grid of cells, as whole numbers of a bit a cell: where one is free, shifts tell.

A square of cells is one number, row after row. Shifted by a cell's place it has that cell where
its corner was. So a chart is free wherever the square, shifted by each of the chart's cells, has no
bit: all places are asked at once. Cells are taken strip by strip: squares smeared along the rows by
powers of two cover a strip of any length with two shifts.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from bozzetto.geometry.atlas.chart_flattening import ring_area

if TYPE_CHECKING:
    from bozzetto.arrays import Array, Flags

FINER: Final = 4
"""Dots along a cell by which charts are drawn."""

DIGITS: Final = 5
"""Decimals of cells that count, so that rounding decides nothing between equals."""


class Bitmap(NamedTuple):
    """A chart in one position.

    Attributes
    ----------
    cells : (h, w) bool array
        Those that it takes.
    strips : sequence of (int, int)
        Of its cells: how many bits the first one is behind the corner, and the power of two that
        is their number.
    """

    cells: Flags
    strips: Sequence[tuple[int, int]]
    power: int


class Square:
    """Occupied cells of a square with so many cells along a side."""

    def __init__(self, cells: int) -> None:
        self.cells = cells
        self._taken = np.zeros((cells, cells), bool)
        self._smeared = [0]

    def put(self, bitmap: Bitmap, row: int, column: int, *, taken: bool = True) -> None:
        """Take the cells of a chart, or give them back."""
        high, wide = bitmap.cells.shape
        self._taken[row : row + high, column : column + wide][bitmap.cells] = taken
        self._smeared = [_bits(self._taken)]

    def spot(self, bitmap: Bitmap, side: int, *, lowest: bool) -> tuple[int, int] | None:
        """Return the row and column of the best free place of a chart, if there is one.

        Parameters
        ----------
        bitmap : Bitmap
            Of the chart.
        side : int
            Cells along the part of the square that it has to lie in.
        lowest : bool
            Whether the upper end shall be as low as can be, instead of the square around it small.
        """
        high, wide = bitmap.cells.shape
        if max(high, wide) > side:
            return None
        smeared = self._smeared
        while bitmap.power >= len(smeared):
            smeared.append(smeared[-1] | smeared[-1] >> (1 << (len(smeared) - 1)))
        blocked = 0
        for behind, power in bitmap.strips:
            blocked |= smeared[power] >> behind
        free = _corner(self.cells, side - high + 1, side - wide + 1) & ~blocked
        if not free:
            return None
        if not lowest:
            small, large = max(high, wide), side
            while small < large:
                middle = (small + large) // 2
                if free & _corner(self.cells, middle - high + 1, middle - wide + 1):
                    large = middle
                else:
                    small = middle + 1
            free &= _corner(self.cells, small - high + 1, small - wide + 1)
        return divmod((free & -free).bit_length() - 1, self.cells)


def bitmap_of(taken: Flags, cells: int) -> Bitmap:
    """Return a bitmap of cells (h, w) for a square of so many cells along a side."""
    step = np.diff(np.pad(taken, ((0, 0), (1, 1))).astype(np.int8), axis=1)
    row, begin = np.nonzero(step == 1)
    end = np.nonzero(step == -1)[1]
    strips: list[tuple[int, int]] = []
    for r, one, two in zip(row.tolist(), begin.tolist(), end.tolist(), strict=True):
        power = (two - one).bit_length() - 1
        strips.append((r * cells + one, power))
        if two - one > 1 << power:
            strips.append((r * cells + two - (1 << power), power))
    return Bitmap(taken, strips, max((power for _, power in strips), default=0))


def drawn(rings: Sequence[Array], around: int) -> tuple[Flags, Array]:
    """Return the cells (h, w) that a chart touches, and where they begin, (2,), right and down.

    Parameters
    ----------
    rings : sequence of (n, 2) float arrays
        Its borders, in cells.
    around : int
        How many cells beside it are taken, too.
    """
    from PIL import Image, ImageDraw
    from scipy.ndimage import maximum_filter

    low = np.vstack(rings).min(axis=0)
    rings = [np.round(ring - low, DIGITS) for ring in rings]
    size = np.floor(np.max([ring.max(axis=0) for ring in rings], axis=0)) + 1.0
    image = Image.new("L", (int(size[0]) * FINER, int(size[1]) * FINER))
    draw = ImageDraw.Draw(image)
    sizes = [abs(ring_area(ring)) for ring in rings]
    outer = int(np.argmax(sizes))
    draw.polygon(_pairs(rings[outer] * FINER), fill=1, outline=1)
    for number, ring in enumerate(rings):
        if number != outer and len(ring) > 2:
            draw.polygon(_pairs(ring * FINER), fill=0, outline=1)
    dots = np.asarray(image, bool).reshape(int(size[1]), FINER, int(size[0]), FINER)
    touched = np.pad(dots.any(axis=(1, 3)), around)
    return np.asarray(maximum_filter(touched, 2 * around + 1), bool), low - around


def coarser(taken: Flags, factor: int) -> Flags:
    """Return the coarse cells that hold any of these."""
    high, wide = taken.shape
    whole = np.pad(taken, ((0, -high % factor), (0, -wide % factor)))
    rows, columns = whole.shape[0] // factor, whole.shape[1] // factor
    return np.asarray(whole.reshape(rows, factor, columns, factor).any(axis=(1, 3)), bool)


def _pairs(ring: Array) -> list[tuple[float, float]]:
    return [(float(x), float(y)) for x, y in ring - 0.5]


def _bits(taken: Flags) -> int:
    return int.from_bytes(np.packbits(taken, bitorder="little").tobytes(), "little")


@lru_cache(maxsize=512)
def _columns(cells: int, columns: int) -> int:
    return _bits(np.tile(np.arange(cells) < columns, cells))


def _corner(cells: int, rows: int, columns: int) -> int:
    """Return the bits of so many rows and columns of a square."""
    if rows <= 0 or columns <= 0:
        return 0
    return _columns(cells, columns) & ((1 << rows * cells) - 1)
