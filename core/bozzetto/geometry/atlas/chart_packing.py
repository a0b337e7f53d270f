"""Charts placed in a square so that they leave little of it free.

Each is drawn on a grid of cells, in eight positions; where it can be without covering what is
there, a correlation tells for all cells at once (by fast Fourier transform). One after the other
goes where the upper end, or the square around all, stays smallest. The order is searched: that
which fits into a smaller square is kept, and the next try has the chart that found no place
earlier, or two exchanged (D. Joslin and D. Clements, *Squeaky wheel optimization*, 1999).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bozzetto.geometry.atlas.chart_flattening import ring_area

if TYPE_CHECKING:
    from bozzetto.arrays import Array, Flags, Index

FULLEST: Final = 0.8
"""Share of the square that the size of a cell is chosen for."""

SPARE: Final = 0.75
"""Share of the grid's side that a square as full as that has: the first tries are less so."""

LARGER: Final = 1.25
"""Factor on the cells until the first tries have places for all charts."""

PLACEMENTS: Final = 600
"""How often charts are placed in one search, all tries together, but for the first tries."""

MOST_TRIES: Final = 100
"""Orders that are tried at most: four times as many gain one or two hundredths."""

FINER: Final = 4
"""Dots along a cell by which charts are drawn."""

SINGLES: Final = 48
"""Charts that are placed one by one; smaller ones lie together in one block."""

SLANTED: Final = 24
"""Up to so many charts are tried on the slant as well: long ones fit along the diagonal."""

DIGITS: Final = 5
"""Decimals of shares and cells that count, so that rounding decides nothing between equals."""

SEED: Final = 17
"""Of the search: the same charts always lie in the same places."""


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


def packed(outlines: Sequence[Outline], cells: int, tries: int = MOST_TRIES) -> Packing:
    """Place charts in a square without overlaps, at least a cell apart.

    Parameters
    ----------
    outlines : sequence of Outline
        At least one with an area.
    cells : int
        Of the grid along a side of the square, at most.
    tries : int
        Orders that are tried at most.
    """
    bare = [_upright(outline) for outline in outlines]
    total = max(sum(outline.area for outline in outlines), 1e-300)
    cell = float(np.sqrt(total / FULLEST)) / (SPARE * cells)
    while True:
        grid = _Grid(outlines, bare, cell, cells)
        found = grid.searched(tries)
        if found is not None:
            return Packing(*grid.places(found), found.side * cell)
        cell *= LARGER


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


class _Placed(NamedTuple):
    """Where all pieces are: row, column and position of each, and the side of the square."""

    spots: dict[int, tuple[int, int, int]]
    side: int


class _Way(NamedTuple):
    """An order of the pieces, and how they are placed in it."""

    order: list[int]
    upright: bool
    lowest: bool


class _Grid:
    """Charts drawn on cells, in all their positions; the last piece is a block of small ones."""

    def __init__(
        self,
        outlines: Sequence[Outline],
        bare: Sequence[tuple[Array, Array]],
        cell: float,
        cells: int,
    ) -> None:
        from scipy.fft import rfft2

        boxes = np.array([float(np.prod(size)) for _, size in bare])
        order = np.argsort(-np.round(boxes / max(boxes.sum(), 1e-300), DIGITS), kind="stable")
        self.single, self.rest = order[:SINGLES].tolist(), order[SINGLES:]
        self.outlines, self.bare, self.cell, self.cells = outlines, bare, cell, cells
        slants = (0.0, 0.25 * np.pi) if len(self.single) <= SLANTED else (0.0,)
        self.turns: list[list[Array]] = []
        self.lows: list[list[Array]] = []
        self.masks: list[list[Flags]] = []
        for number in self.single:
            turns = [
                bare[number][0] @ _turn(slant) @ quarter
                for slant in slants
                for quarter in _QUARTERS
            ]
            drawn = [_mask([r @ turn / cell for r in outlines[number].rings]) for turn in turns]
            self.turns.append(turns)
            self.masks.append([mask for mask, _ in drawn])
            self.lows.append([low for _, low in drawn])
        self.block = _block(bare, self.rest, cell)
        sizes = [float(boxes[k]) / cell**2 for k in self.single]
        if len(self.rest):
            self.turns.append([np.eye(2)])
            self.masks.append([np.ones(self.block[1], bool)])
            self.lows.append([np.zeros(2)])
            sizes.append(float(np.prod(self.block[1])))
        self.sizes = np.round(sizes, 1)
        self.waves = []
        for masks in self.masks:
            pictures = np.zeros((len(masks), cells, cells), np.float32)
            for picture, mask in zip(pictures, masks, strict=True):
                high, wide = mask.shape
                if max(high, wide) <= cells:
                    picture[:high, :wide] = mask
            self.waves.append(np.conj(rfft2(pictures)))

    def searched(self, tries: int) -> _Placed | None:
        """Return the smallest square found; None if the first tries find no place for all."""
        count = len(self.masks)
        random = np.random.default_rng(SEED)
        longest = np.array([max(masks[0].shape) for masks in self.masks])
        starts = [np.argsort(-key, kind="stable").tolist() for key in (self.sizes, longest)]
        ways = [_Way(o, u, w) for o in starts for u in (True, False) for w in (True, False)]
        best: _Placed | None = None
        way, failed = ways[0], -1
        for number in range(max(len(ways), min(tries, PLACEMENTS // count))):
            if number < len(ways):
                tried = ways[number]
            elif best is None:
                return None
            else:
                tried = _next(way, failed, random)
            found = self._placed(tried, self.cells if best is None else best.side - 1)
            if isinstance(found, _Placed):
                best, way, failed = found, tried, -1
            elif best is None or number >= len(ways):
                failed = found
        return best

    def _placed(self, way: _Way, side: int) -> _Placed | int:
        """Place all in a square; the piece that finds no place, if one does not."""
        from scipy.fft import irfft2, rfft2

        taken = np.zeros((self.cells, self.cells), np.float32)
        spots: dict[int, tuple[int, int, int]] = {}
        reach = 0
        for piece in way.order:
            masks = self.masks[piece][:4] if way.upright else self.masks[piece]
            fits = [k for k, mask in enumerate(masks) if max(mask.shape) <= side]
            if not fits:
                return piece
            hits = irfft2(rfft2(taken)[None] * self.waves[piece][fits], s=taken.shape)
            best: tuple[tuple[int, int], tuple[int, int, int]] | None = None
            for k, hit in zip(fits, hits, strict=True):
                high, wide = masks[k].shape
                free = hit[: side - high + 1, : side - wide + 1] < 0.5
                found = _spot(free, high, wide, way.lowest)
                if found is not None and (best is None or found[0] < best[0]):
                    best = found[0], (found[1], found[2], k)
            if best is None:
                return piece
            spots[piece] = row, column, position = best[1]
            high, wide = masks[position].shape
            reach = max(reach, row + high, column + wide)
            _cover(taken, masks[position], row, column)
        return _Placed(spots, reach)

    def places(self, placed: _Placed) -> tuple[Array, Array]:
        """Return the turns (n, 2, 2) and offsets (n, 2) of all charts."""
        count = len(self.outlines)
        turns, offsets = np.zeros((count, 2, 2)), np.zeros((count, 2))
        for piece, (row, column, position) in placed.spots.items():
            corner = np.array([column, row])
            if piece < len(self.single):
                number = self.single[piece]
                turns[number] = self.turns[piece][position]
                offsets[number] = (corner - self.lows[piece][position]) * self.cell
                continue
            for k, place in zip(self.rest.tolist(), self.block[0], strict=True):
                turns[k] = self.bare[k][0]
                least = np.concatenate(list(self.outlines[k].rings)) @ turns[k]
                offsets[k] = (place + corner) * self.cell - least.min(axis=0)
        return turns, offsets


def _next(way: _Way, failed: int, random: np.random.Generator) -> _Way:
    """Return a way beside this one."""
    order = list(way.order)
    if failed >= 0 and random.random() < 0.6:
        place = order.index(failed)
        order.pop(place)
        order.insert(int(random.integers(0, max(place, 1))), failed)
    else:
        one, two = random.integers(0, len(order), 2).tolist()
        order[one], order[two] = order[two], order[one]
    upright = way.upright != bool(random.random() < 0.2)
    return _Way(order, upright, way.lowest != bool(random.random() < 0.2))


def _spot(
    free: Flags, high: int, wide: int, lowest: bool
) -> tuple[tuple[int, int], int, int] | None:
    """Return the price of the best free place, and its row and column."""
    if lowest:
        rows = np.flatnonzero(free.any(axis=1))
        if not len(rows):
            return None
        row = int(rows[0])
        column = int(free[row].argmax())
        return (row + high, column), row, column
    down, right = np.nonzero(free)
    if not len(down):
        return None
    around = np.maximum(down + high, right + wide)
    first = int((around * (4 * len(free) + 4 * free.shape[1]) + down + right).argmin())
    row, column = int(down[first]), int(right[first])
    return (int(around[first]), row + column), row, column


def _turn(angle: float) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s], [s, c]])


_QUARTERS: Final = [
    np.array(m, float)
    for m in ([[1, 0], [0, 1]], [[0, 1], [-1, 0]], [[-1, 0], [0, -1]], [[0, -1], [1, 0]])
]


def _mask(rings: Sequence[Array]) -> tuple[Flags, Array]:
    """Draw rings, in cells: those that they touch, and where these begin."""
    from PIL import Image, ImageDraw

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
