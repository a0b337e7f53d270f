"""Charts placed in a square so that they leave little of it free.

Each is drawn on a grid of cells, in eight positions. One after the other goes where the upper end,
or the square around all, stays smallest. The order is searched on coarse cells: that which fits
into a smaller square is kept, and the next try has the chart that found no place earlier, or two
exchanged (D. Joslin and D. Clements, *Squeaky wheel optimization*, 1999). On fine cells the charts
of the best order are then taken out one by one and put back closer to the corner.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from bozzetto.geometry.atlas.chart_bitmaps import Bitmap, Square, bitmap_of, coarser, drawn
from bozzetto.geometry.atlas.chart_compaction import compacted

if TYPE_CHECKING:
    from bozzetto.arrays import Array, Flags, Index

FULLEST: Final = 0.85
"""Share of the square that the size of a cell is chosen for."""

SPARE: Final = 0.9
"""Share of the grid's side that a square as full as that has: the first tries are less so."""

LARGER: Final = 1.2
"""Factor on the cells until the first tries have places for all charts."""

GAP: Final = 2
"""Fine cells between charts."""

COARSE: Final = 3
"""Fine cells along a coarse one."""

WORK: Final = 600_000
"""Strips of cells that one search may look at, but for the first tries."""

MOST_TRIES: Final = 200
"""Orders that are tried at most: more gain less than a hundredth."""

MOVES: Final = 600
"""How often charts are put back closer to the corner, all together."""

MOST_ROUNDS: Final = 16
"""How often each of them is at most."""

SINGLES: Final = 160
"""Charts that are placed one by one; smaller ones lie together in one block."""

SLANTED: Final = 48
"""Up to so many charts are tried on the slant as well: long ones fit along the diagonal."""

DIGITS: Final = 5
"""Decimals of shares that count, so that rounding decides nothing between equals."""

SEED: Final = 17
"""Of the search: the same charts always lie in the same places."""

SLANTS: Final = (0.0, 0.25 * np.pi)
"""Angles by which charts are turned, besides quarters."""

QUARTER: Final = np.array([[0.0, -1.0], [1.0, 0.0]])
"""A quarter of a turn, by columns."""


def _nobody(fraction: float) -> None:
    """Ignore progress that no one watches."""


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
        How each is turned and made a little larger, by columns.
    offset : (n, 2) float array
        Added after the turn.
    side : float
        Of the square.
    """

    turn: Array
    offset: Array
    side: float


def packed(
    outlines: Sequence[Outline], cells: int, checkpoint: Callable[[float], None] = _nobody
) -> Packing:
    """Place charts in a square without overlaps.

    Parameters
    ----------
    outlines : sequence of Outline
        At least one with an area.
    cells : int
        Along the square, of which charts are at least one apart.
    checkpoint : callable
        Called with the fraction done (0 … 1); may raise to stop it.
    """
    fine = GAP * cells // COARSE * COARSE
    grid, found = _searched(outlines, fine, GAP, COARSE, MOST_TRIES, checkpoint)
    found = grid.settled(found, checkpoint)
    turns, offsets = grid.places(found)
    edge = GAP // 2 * grid.cell  # what is free around all
    packing = Packing(turns, offsets - edge, found.side * grid.cell - 2.0 * edge)
    return _compacted(outlines, packing, 1.0 / cells, checkpoint)


def _compacted(
    outlines: Sequence[Outline], packing: Packing, gap: float, checkpoint: Callable[[float], None]
) -> Packing:
    """Push charts together, if they are not too many."""
    if not 1 < len(outlines) <= SLANTED:
        return packing
    placed = [
        [ring @ turn + offset for ring in outline.rings]
        for outline, turn, offset in zip(outlines, packing.turn, packing.offset, strict=True)
    ]
    low = np.min([np.concatenate(rings).min(axis=0) for rings in placed], axis=0)
    # In shares of the side, to so many digits that the unit decides nothing.
    size = packing.side
    placed = [[np.round((ring - low) / size, 9) for ring in rings] for rings in placed]
    turn, offset, side = compacted(placed, gap, lambda part: checkpoint(0.7 + 0.3 * part))
    moved = np.einsum("nd,nde->ne", packing.offset - low, turn) + offset * size
    return Packing(packing.turn @ turn, moved, side * size)


def box_sizes(points: Array, angles: Array) -> tuple[Array, Array]:
    """Return widths and heights of the boxes around points (n, 2) at angles (a,)."""
    along = points @ np.stack([np.cos(angles), np.sin(angles)])
    across = points @ np.stack([-np.sin(angles), np.cos(angles)])
    return np.ptp(along, axis=0), np.ptp(across, axis=0)


def _searched(
    outlines: Sequence[Outline],
    cells: int,
    gap: int,
    coarse: int,
    tries: int,
    checkpoint: Callable[[float], None] = _nobody,
) -> tuple[_Grid, _Placed]:
    bare = [upright_turn(outline.rings) for outline in outlines]
    total = max(sum(outline.area for outline in outlines), 1e-300)
    longest = max(float(size[0]) for _, size in bare)
    # A long one lies along the diagonal at best.
    cell = max(float(np.sqrt(total / FULLEST)), float(np.sqrt(0.5)) * longest) / (SPARE * cells)
    while True:
        grid = _Grid(outlines, bare, cell, cells, gap, coarse)
        found = grid.searched(tries, checkpoint)
        if found is not None:
            return grid, found
        cell *= LARGER


def upright_turn(rings: Sequence[Array]) -> tuple[Array, Array]:
    """Return the turn (2, 2) of the smallest box around rings to lie flat, and its size."""
    points = np.concatenate(list(rings))
    angles: Array = np.linspace(0.0, 0.5 * np.pi, 64, endpoint=False, dtype=np.float64)
    width, height = box_sizes(points, angles)
    size = width * height
    # Of nearly equal ones the first, in whatever unit.
    best = int((size <= (1.0 + 1e-9) * size.min()).argmax())
    turn = _turn(angles[best])
    if width[best] < height[best]:
        turn = turn @ QUARTER
    return turn, np.ptp(points @ turn, axis=0)


def quarters(
    rings: Sequence[Array], turn: Array, cell: float, around: int, slants: Sequence[float] = SLANTS
) -> Iterator[tuple[Array, Flags, Array]]:
    """Draw a chart in all positions: the turn (2, 2), its cells and where they begin, (2,).

    Parameters
    ----------
    rings : sequence of (n, 2) float arrays
        Its borders.
    turn : (2, 2) float array
        The one of the first position.
    cell : float
        Size of a cell.
    around : int
        How many cells beside it are taken, too.
    slants : sequence of float
        Angles that are added; each of them four times, by quarters.
    """
    for slant in slants:
        turned = turn @ _turn(slant)
        mask, low = drawn([ring @ turned / cell for ring in rings], around)
        for _ in range(4):
            yield turned, mask, low
            turned = turned @ QUARTER
            low = np.array([low[1], -low[0] - mask.shape[1]])
            mask = mask.T[::-1]


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
        gap: int,
        coarse: int,
    ) -> None:
        boxes = np.array([float(np.prod(size)) for _, size in bare])
        order = np.argsort(-np.round(boxes / max(boxes.sum(), 1e-300), DIGITS), kind="stable")
        self.single, self.rest = order[:SINGLES].tolist(), order[SINGLES:]
        self.outlines, self.bare, self.cell, self.cells = outlines, bare, cell, cells
        self.coarse = coarse
        slants = SLANTS if len(self.single) <= SLANTED else SLANTS[:1]
        self.turns: list[list[Array]] = []
        self.lows: list[list[Array]] = []
        masks: list[list[Flags]] = []
        for number in self.single:
            made = list(quarters(outlines[number].rings, bare[number][0], cell, gap // 2, slants))
            self.turns.append([turn for turn, _, _ in made])
            self.lows.append([low for _, _, low in made])
            masks.append([mask for _, mask, _ in made])
        self.block = _block(bare, self.rest, cell, gap)
        sizes = [float(boxes[k]) / cell**2 for k in self.single]
        if len(self.rest):
            self.turns.append([np.eye(2)])
            masks.append([np.ones(self.block[1], bool)])
            self.lows.append([np.zeros(2)])
            sizes.append(float(np.prod(self.block[1])))
        self.sizes = np.round(sizes, 1)
        self.maps = [[bitmap_of(mask, cells) for mask in row] for row in masks]
        self.rough = [
            [bitmap_of(coarser(mask, coarse), cells // coarse) for mask in row] for row in masks
        ]

    def searched(self, tries: int, checkpoint: Callable[[float], None]) -> _Placed | None:
        """Return a placement on coarse cells, in fine ones; None if the first tries find none."""
        random = np.random.default_rng(SEED)
        longest = np.array([max(maps[0].cells.shape) for maps in self.maps])
        starts = [np.argsort(-key, kind="stable").tolist() for key in (self.sizes, longest)]
        ways = [_Way(o, u, w) for o in starts for u in (True, False) for w in (True, False)]
        effort = sum(len(one.strips) for maps in self.rough for one in maps)
        best: _Placed | None = None
        way, failed = ways[0], -1
        tries = max(len(ways), min(tries, WORK // max(effort, 1)))
        for number in range(tries):
            checkpoint(0.4 * number / tries)
            if number < len(ways):
                tried = ways[number]
            elif best is None:
                return None
            else:
                tried = _next(way, failed, random)
            side = self.cells // self.coarse if best is None else best.side - 1
            found = self._placed(tried, side)
            if isinstance(found, _Placed):
                best, way, failed = found, tried, -1
            elif best is None or number >= len(ways):
                failed = found
        if best is None:
            return None
        spots = {
            piece: (row * self.coarse, column * self.coarse, position)
            for piece, (row, column, position) in best.spots.items()
        }
        return _Placed(spots, max(max(self._ends(*row)) for row in spots.items()))

    def _ends(self, piece: int, spot: tuple[int, int, int]) -> tuple[int, int]:
        """Return the row and the column behind a piece at its place."""
        high, wide = self.maps[piece][spot[2]].cells.shape
        return spot[0] + high, spot[1] + wide

    def _placed(self, way: _Way, side: int) -> _Placed | int:
        """Place all in a square; the piece that finds no place, if one does not."""
        square = Square(self.cells // self.coarse)
        spots: dict[int, tuple[int, int, int]] = {}
        reach = 0
        for piece in way.order:
            maps = self.rough[piece][:4] if way.upright else self.rough[piece]
            spot = best_spot(square, maps, range(len(maps)), side, lowest=way.lowest)
            if spot is None:
                return piece
            spots[piece] = row, column, position = spot
            high, wide = maps[position].cells.shape
            reach = max(reach, row + high, column + wide)
            square.put(maps[position], row, column)
        return _Placed(spots, reach)

    def settled(self, placed: _Placed, checkpoint: Callable[[float], None]) -> _Placed:
        """Put charts back one by one: those at the far ends in any position that makes all smaller.

        In every second round the others go down instead of closer to the corner.
        """
        spots = dict(placed.spots)
        square = Square(self.cells)
        for piece, (row, column, position) in spots.items():
            square.put(self.maps[piece][position], row, column)
        side = placed.side
        rounds = min(MOST_ROUNDS, MOVES // len(spots))
        for number in range(rounds):
            checkpoint(0.4 + 0.3 * number / rounds)
            ends = {piece: max(self._ends(piece, spot)) for piece, spot in spots.items()}
            for piece in sorted(spots, key=lambda piece: (ends[piece], piece)):
                row, column, position = spots[piece]
                maps = self.maps[piece]
                square.put(maps[position], row, column, taken=False)
                far = ends[piece] == side
                spot = best_spot(
                    square, maps, range(len(maps)) if far else (position,), side,
                    lowest=number % 2 == 1 and not far,
                )  # fmt: skip
                spots[piece] = row, column, position = spot or spots[piece]
                square.put(maps[position], row, column)
            shorter = max(max(self._ends(*row)) for row in spots.items())
            if shorter == side and number % 2 == 1:
                break
            side = shorter
        return _Placed(spots, side)

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


def best_spot(
    square: Square, maps: Sequence[Bitmap], positions: Sequence[int], side: int, *, lowest: bool
) -> tuple[int, int, int] | None:
    """Return row, column and position of the best place for a chart, if there is one."""
    best: tuple[tuple[int, int], tuple[int, int, int]] | None = None
    for position in positions:
        found = square.spot(maps[position], side, lowest=lowest)
        if found is None:
            continue
        row, column = found
        high, wide = maps[position].cells.shape
        around = max(row + high, column + wide), row + column
        price = (row + high, column) if lowest else around
        if best is None or price < best[0]:
            best = price, (row, column, position)
    return best[1] if best is not None else None


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


def _turn(angle: float) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s], [s, c]])


def _block(
    bare: Sequence[tuple[Array, Array]], rest: Index, cell: float, gap: int
) -> tuple[list[Array], tuple[int, int]]:
    """Put small charts on shelves: their places in cells, and rows and columns of the block."""
    if not len(rest):
        return [], (0, 0)
    sizes = np.array([bare[k][1] for k in rest.tolist()]) / cell + gap
    wide = max(float(np.sqrt(sizes.prod(axis=1).sum())), float(sizes[:, 0].max()))
    order = np.argsort(-sizes[:, 1], kind="stable")
    places: list[Array] = [np.zeros(2)] * len(sizes)
    x = y = shelf = 0.0
    for k in order.tolist():
        if x + sizes[k, 0] > wide:
            x, y, shelf = 0.0, y + shelf, 0.0
        places[k] = np.array([x, y]) + 0.5 * gap
        x, shelf = x + float(sizes[k, 0]), max(shelf, float(sizes[k, 1]))
    return places, (int(np.ceil(y + shelf)) + 1, int(np.ceil(wide)) + 1)
