"""Straight cuts that let charts fill a square, searched on their outlines alone.

A chart that leaves much of its box free is cut in two as long as every further chart fills enough
more of the square; so are its twins at once, such as the back beside the front. What each cut would
give is seen by packing the parts on a few cells; the best ones are made, and packed again: a cut
along triangles is not quite straight, and what fits by a hair as a sketch does not then.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from bozzetto.geometry.atlas.chart_bitmaps import Bitmap, Square, bitmap_of
from bozzetto.geometry.atlas.chart_packing import best_spot, box_sizes, quarters, upright_turn

if TYPE_CHECKING:
    from bozzetto.arrays import Array

CELLS: Final = 170
"""Along the square; charts that touch none in common are about as far apart as they have to be."""

SKETCHED: Final = 110
"""The same where only straight lines are tried."""

FULL: Final = 0.84
"""Share of the square from which no more charts are cut."""

GAIN: Final = 0.001
"""By how much more of the square the tenth chart has to fill, as a tenth: few are better."""

STEPS: Final = 20
"""How many cuts are made at most, twins counted once."""

IDLE: Final = 4
"""After how many that gain nothing no more are."""

CHOICES: Final = 4
"""How many groups of twins are tried to be cut each time."""

LINES: Final = 3
"""In how many ways each."""

MADE: Final = 2
"""How many of these cuts are made each time, to choose among them: triangles fray their borders."""

PIECES: Final = 3
"""Into how many pieces one cut may part a chart: a straight line parts a winding band into many."""

TWINS: Final = 0.01
"""By how much areas and boxes of twins differ at most, as shares."""

ANGLES: Final = np.arange(12) * (np.pi / 12)
PLACES: Final = np.arange(2, 15) / 16.0
"""Directions and places of the straight cuts that are tried."""

LARGE: Final = 0.15
"""Share of a chart that counts beside what it leaves free: large ones are worth a cut."""

APART: Final = 0.2
"""How far two cuts of one direction are apart at least, as a share of the size."""

LEAST: Final = 0.06
"""Share of a chart that a cut leaves on either side at least."""

LONG: Final = 0.08
"""What a cut costs: the area of a strip along it, as wide as this share of the chart's size."""

MANY: Final = 0.05
"""What every further place costs that a cut leads through, as a share of the chart."""

CRUMB: Final = 1e-4
"""Share of a chart below which what is cut off does not count."""

DIGITS: Final = 6
"""Decimals of a chart's size that count where it is cut."""


class Line(NamedTuple):
    """A straight cut: points with ``point @ towards > level`` are beyond it."""

    towards: Array
    level: float


@dataclass(eq=False)
class Part:
    """A chart, or what is cut off one.

    Attributes
    ----------
    polygon : shapely.Polygon
        Its outline.
    content : object
        What whoever asks needs to cut it; None for what was only sketched.
    """

    polygon: Any
    content: Any = None
    _maps: dict[int, list[Bitmap]] = field(default_factory=dict)
    _choices: list[tuple[Line, list[Part]]] | None = None
    _cut: dict[int, list[Part]] = field(default_factory=dict)

    @property
    def rings(self) -> list[Array]:
        """Its borders, (n, 2) each."""
        rings = [self.polygon.exterior, *self.polygon.interiors]
        return [np.asarray(ring.coords)[:-1] for ring in rings]

    def maps(self, cell: float, cells: int) -> list[Bitmap]:
        """Return bitmaps in eight positions."""
        if cells not in self._maps:
            rings = self.rings
            made = quarters(rings, upright_turn(rings)[0], cell, 0)
            self._maps[cells] = [bitmap_of(mask, cells) for _, mask, _ in made]
        return self._maps[cells]

    def free(self) -> float:
        """Return the area of its box that it leaves free."""
        width, height = box_sizes(np.concatenate(self.rings), BOXES)
        return float((width * height).min()) - float(self.polygon.area)

    def choices(self) -> list[tuple[Line, list[Part]]]:
        """Return cuts and what they would leave, the most promising first."""
        if self._choices is None:
            made = [(line, _parts(self.polygon, line)) for line in straight_cuts(self.rings)]
            self._choices = [(line, parts) for line, parts in made if 1 < len(parts) <= PIECES]
        return self._choices

    def cut(self, choice: int, cut: Cutter) -> list[Part]:
        """Return what one of these cuts does leave."""
        if choice not in self._cut:
            self._cut[choice] = cut(self, self.choices()[choice][0])
        return self._cut[choice]


Cutter = Callable[[Part, Line], list[Part]]
"""Cuts a part along a line, as near to it as its triangles allow; returns it where it does not."""

BOXES: Final = np.linspace(0.0, 0.5 * np.pi, 32, endpoint=False)


def cut_to_fit(
    parts: Sequence[Part], cut: Cutter, checkpoint: Callable[[float], None]
) -> list[Part]:
    """Return parts that are cut as far as that pays.

    Parameters
    ----------
    parts : sequence of Part
        All of the square.
    cut : callable
        Cuts one.
    checkpoint : callable
        Called with the fraction done (0 … 1); may raise to stop it.
    """
    bench, coarse = _Bench(parts, CELLS), _Bench(parts, SKETCHED)
    now = kept = list(parts)
    side = bench.side(now, bench.cells)
    worth, idle = bench.share(side), 0
    for number in range(STEPS):
        checkpoint(number / STEPS)
        if bench.share(side) >= FULL or idle == IDLE:
            break
        found: _Tried | None = None
        for sketch in _sketched(coarse, now, len(parts)):
            made = [piece for one in sketch.group for piece in one.cut(sketch.choice, cut)]
            if len(made) == len(sketch.group):
                continue
            tried = [one for one in now if one not in sketch.group] + made
            price = _price(len(tried)) - _price(len(parts))
            there = bench.side(tried, bench.most(price + (found.worth if found else 0.0)))
            if there is not None:
                found = _Tried(bench.share(there) - price, there, tried)
            elif side is None and found is None:
                found = _Tried(0.0, None, tried)
        if found is None:
            break
        side, now = found.side, found.parts
        idle += side is not None
        if found.worth > worth + 1e-6:
            worth, idle, kept = found.worth, 0, now
    return kept


def _price(count: int) -> float:
    """Return how much of the square so many charts have to fill to be worth it."""
    return 0.5 * GAIN * count**2


class _Sketch(NamedTuple):
    """Twins, which of their choices is meant, and how full the square would be, less its price."""

    worth: float
    group: list[Part]
    choice: int


class _Tried(NamedTuple):
    """Result of some cuts: how full the square is, less their price, and all parts."""

    worth: float
    side: int | None
    parts: list[Part]


def _sketched(bench: _Bench, now: Sequence[Part], first: int) -> list[_Sketch]:
    """Return the best cuts, as far as their straight lines tell."""
    found: list[_Sketch] = []
    for group in _groups(now, CHOICES):
        left = [one for one in now if one not in group]
        for k in range(LINES):
            if any(len(one.choices()) <= k for one in group):
                break
            tried = left + [part for one in group for part in one.choices()[k][1]]
            price = _price(len(tried)) - _price(first)
            least = found[MADE - 1].worth if len(found) >= MADE else 0.0
            there = bench.side(tried, bench.most(price + least))
            if there is None and len(found) >= MADE:
                continue
            found.append(_Sketch(bench.share(there) - price, group, k))
            found.sort(key=lambda one: -one.worth)
    return found[:MADE]


class _Bench:
    """A square on which parts are packed."""

    def __init__(self, parts: Sequence[Part], cells: int) -> None:
        longest = max(float(max(upright_turn(part.rings)[1])) for part in parts)
        self.area, self.cells = sum(float(part.polygon.area) for part in parts), cells
        side = max(float(np.sqrt(self.area / 0.6)), float(np.sqrt(0.55)) * longest)
        self.cell = side / (0.9 * cells)

    def share(self, side: int | None) -> float:
        """Return how much of a square of this side is full."""
        return 0.0 if side is None else self.area / (side * self.cell) ** 2

    def most(self, share: float) -> int:
        """Return the longest side of a square that is more than this full."""
        if share <= 0.0:
            return self.cells
        return min(self.cells, int(np.ceil(np.sqrt(self.area / share) / self.cell)) - 1)

    def side(self, parts: Sequence[Part], most: int) -> int | None:
        """Return the side of a square that these fit into, if it is no more than this."""
        maps = {id(part): part.maps(self.cell, self.cells) for part in parts}
        found: int | None = None
        sizes = [float(part.polygon.area) for part in parts]
        longest = [max(maps[id(part)][0].cells.shape) for part in parts]
        for key in (sizes, longest):
            order = [maps[id(parts[k])] for k in sorted(range(len(parts)), key=lambda k: -key[k])]
            for lowest in (True, False):
                side = self._placed(order, most if found is None else found - 1, lowest=lowest)
                found = side if side is not None else found
        return found

    def _placed(self, order: Sequence[Sequence[Bitmap]], side: int, *, lowest: bool) -> int | None:
        square, reach = Square(self.cells), 0
        for maps in order:
            spot = best_spot(square, maps, range(len(maps)), side, lowest=lowest)
            if spot is None:
                return None
            row, column, position = spot
            high, wide = maps[position].cells.shape
            reach = max(reach, row + high, column + wide)
            square.put(maps[position], row, column)
        return reach


def _groups(parts: Sequence[Part], most: int) -> list[list[Part]]:
    """Return parts that leave much free or are large, and those with their twins."""
    total = sum(float(part.polygon.area) for part in parts)
    rows = []
    for part in parts:
        area, free = float(part.polygon.area), part.free()
        rows.append((round((free + LARGE * area) / total, 4), area, free, part))
    rows.sort(key=lambda row: -row[0])
    groups: list[list[Part]] = []
    taken: set[int] = set()
    for _, area, free, part in rows:
        if id(part) in taken or len(taken) == most:
            continue
        twins = [
            two for _, other, left, two in rows
            if id(two) not in taken
            and abs(other - area) <= TWINS * area
            and abs(left - free) <= 2.0 * TWINS * (area + free)
        ]  # fmt: skip
        taken |= {id(two) for two in twins}
        groups += [twins] if len(twins) == 1 else [twins, [part]]
    return groups[:most]


def _parts(polygon: Any, line: Line) -> list[Part]:
    """Return what a cut leaves of a polygon."""
    import shapely

    low_x, low_y, high_x, high_y = polygon.bounds
    middle = np.array([low_x + high_x, low_y + high_y]) / 2.0
    far = high_x - low_x + high_y - low_y
    along = np.array([-line.towards[1], line.towards[0]])
    foot = middle + (line.level - middle @ line.towards) * line.towards
    found: list[Part] = []
    for sign in (1.0, -1.0):
        ends = np.array([foot - far * along, foot + far * along])
        half = shapely.Polygon([*ends, *(ends[::-1] + sign * far * line.towards)])
        cut = shapely.intersection(polygon, half)
        for one in shapely.get_parts(cut):
            if one.geom_type == "Polygon" and one.area > CRUMB * polygon.area:
                found.append(Part(one))
    return found


def straight_cuts(rings: Sequence[Array]) -> list[Line]:
    """Return cuts after which the boxes around both sides leave little free, the best first.

    Parameters
    ----------
    rings : sequence of (n, 2) float arrays
        The borders of a chart.
    """
    start = np.concatenate(list(rings))
    end = np.concatenate([np.roll(ring, -1, axis=0) for ring in rings])
    area = abs(float(np.sum(start[:, 0] * end[:, 1] - start[:, 1] * end[:, 0]))) / 2.0
    size = float(np.sqrt(area))
    start, end = start / size, end / size
    frames = np.arange(8) * (np.pi / 16)
    axes = np.concatenate([
        np.stack([np.cos(frames), np.sin(frames)]), np.stack([-np.sin(frames), np.cos(frames)])
    ], axis=1)  # fmt: skip
    rows: list[tuple[float, float, float]] = []
    for angle in ANGLES.tolist():
        to, beside = (
            np.array([np.cos(angle), np.sin(angle)]),
            np.array([-np.sin(angle), np.cos(angle)]),
        )
        along = np.round(start @ to, DIGITS)
        low, high = float(along.min()), float(along.max())
        for place in PLACES.tolist():
            level = low + place * (high - low)
            one, two = np.round(along - level, DIGITS), np.round(end @ to - level, DIGITS)
            over = one > 0.0
            crossed = np.flatnonzero(over != (two > 0.0))
            if not len(crossed):
                continue
            share = one[crossed] / (one[crossed] - two[crossed])
            there = start[crossed] + share[:, None] * (end[crossed] - start[crossed])
            # The area beyond: over the line its integral is zero.
            begin, finish = (
                np.where(over[:, None], start, 0.0),
                np.where((two > 0.0)[:, None], end, 0.0),
            )
            entering = crossed[~over[crossed]]
            begin[entering] = there[~over[crossed]]
            finish[crossed[over[crossed]]] = there[over[crossed]]
            heights = np.maximum(one, 0.0) + np.maximum(two, 0.0)
            beyond = abs(float((heights * ((finish - begin) @ beside)).sum())) / 2.0
            if not LEAST < beyond < 1.0 - LEAST:
                continue
            spots = np.sort(there @ beside)
            price = LONG * float((spots[1::2] - spots[:-1:2]).sum()) + MANY * (len(spots) // 2 - 1)
            for part in (over, ~over):
                span = np.ptp(np.concatenate([start[part], there]) @ axes, axis=0)
                price += float((span[:8] * span[8:]).min())
            rows.append((round(price, 4), angle, level))
    rows.sort(key=lambda row: row[0])
    chosen: list[tuple[float, float]] = []
    for _, angle, level in rows:
        if len(chosen) == LINES:
            break
        if all(abs(angle - other) > 0.1 or abs(level - at) > APART for other, at in chosen):
            chosen.append((angle, level))
    return [Line(np.array([np.cos(angle), np.sin(angle)]), level * size) for angle, level in chosen]
