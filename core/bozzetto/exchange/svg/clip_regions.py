"""Regions that clips of SVG let through, and lines and areas cut by them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final, Literal, NamedTuple

import numpy as np

from bozzetto.arrays import Array
from bozzetto.cached_properties import cached_property
from bozzetto.exchange.svg.overlaps import Area, TooManyPairs, near_sides

Rule = Literal["nonzero", "evenodd"]

MAX_EFFORT: Final = 3_000_000
"""Corners of lines and clips that are looked at, each pair of these anew: some seconds."""

MAX_NEAR: Final = 200_000
"""Pairs of sides of one clip or area that are near each other: more are a tangle."""

PER_SIDE: Final = 5
"""Corners of a clip that are looked at for a side that it cuts in the time of one, else."""

SPECK: Final = 1e-9
"""Area of a ring that is left out, as a share of the squared size: a rest of rounding."""

SHORTEST: Final = 1e-6
"""Length of a piece that is left out, as a share of the line's size: where it touches a border."""


@dataclass(frozen=True, eq=False)
class Region:
    """Region that a clip lets through.

    Parameters
    ----------
    rings : tuple of (n, 2) arrays
        Its borders without overlaps, closed implicitly: outer ones to the left, holes to the right.
    """

    rings: tuple[Array, ...]

    @classmethod
    def of(
        cls, shapes: Sequence[tuple[Sequence[Array], Rule]], within: Region | None = None
    ) -> Region:
        """Return what is in any of some shapes, and in another region if one is given.

        Parameters
        ----------
        shapes : sequence of (rings, rule)
            What counts as the inside of their rings.
        within : Region, optional
            What it has to lie in besides.

        Raises
        ------
        TooManyPairs
            If its borders are a tangle.
        """
        given = [ring for rings, _ in shapes for ring in rings if len(ring) > 2]
        if not given or not np.isfinite(np.concatenate(given)).all():
            return cls(())
        near_sides([np.vstack((ring, ring[:1])) for ring in given], MAX_NEAR)
        frame = _Frame.around(given)
        whole = _united([(frame.inner(rings), rule) for rings, rule in shapes])
        if within is not None:
            whole = whole ^ _united([(frame.inner(within.rings), "nonzero")])
        return cls(tuple(frame.outer(whole)))

    @property
    def size(self) -> int:
        """How many corners it has."""
        return sum(map(len, self.rings))

    @cached_property
    def shape(self) -> Any:
        """The region for shapely, prepared."""
        import shapely

        lines = [np.vstack((ring, ring[:1])) for ring in self.rings]
        shape = shapely.build_area(shapely.MultiLineString(lines))
        shapely.prepare(shape)
        return shape


class _Frame(NamedTuple):
    """Lower left corner and size of what is worked on: the library counts in fixed steps."""

    low: Array
    size: float

    @classmethod
    def around(cls, rings: Sequence[Array]) -> _Frame:
        points = np.concatenate(list(rings))
        low = points.min(axis=0)
        return cls(low, max(float(np.ptp(points, axis=0).max()), 1e-300))

    def inner(self, rings: Sequence[Array]) -> list[Array]:
        return [(ring - self.low) / self.size for ring in rings if len(ring) > 2]

    def outer(self, section: Any) -> list[Array]:
        rings = [np.asarray(ring, np.float64) for ring in section.to_polygons() if len(ring) > 2]
        return [self.low + self.size * ring for ring in rings if abs(_area(ring)) > SPECK]


class Clipped(NamedTuple):
    """Lines as far as clips let them through.

    Attributes
    ----------
    lines : list of (n, 2) arrays
    areas : list of Area or None
    of : list of int
        Which given line each is, or is a part of.
    given_up : int
        How many are left whole, for cutting them would take too long.
    """

    lines: list[Array]
    areas: list[Area | None]
    of: list[int]
    given_up: int


def clipped(
    lines: Sequence[Array], areas: Sequence[Area | None], clips: Sequence[Sequence[Region]]
) -> Clipped:
    """Cut lines and areas by clips.

    Parameters
    ----------
    lines, areas
        As `without_overlaps` takes them.
    clips : sequence of sequences of Region
        Of each line, all that it has to lie in.
    """
    made = Clipped([], [], [], 0)
    work, given_up = _Work(), 0
    rings_of: dict[int, list[int]] = {}
    for k, (line, area) in enumerate(zip(lines, areas, strict=True)):
        if area is not None and clips[k] and _is_ring(line):
            rings_of.setdefault(area.element, []).append(k)
    done: set[int] = set()
    for k, (line, area) in enumerate(zip(lines, areas, strict=True)):
        if k in done:
            continue
        is_area = area is not None and clips[k] and _is_ring(line)
        own = rings_of[area.element] if area is not None and is_area else [k]
        done.update(own)
        found: list[tuple[int, Array, Area | None]] = [(j, lines[j], areas[j]) for j in own]
        try:
            for region in clips[k]:
                work.spend(region.size + sum(len(lines[j]) for j in own))
            if area is not None and is_area:
                after = _area_within([lines[j] for j in own], area.rule, clips[k])
                found = [(k, ring, Area(area.element, "evenodd")) for ring in after]
            elif clips[k]:
                found = [(k, piece, None) for piece in _line_within(line, clips[k], work)]
        except TooManyPairs:
            given_up += 1
        for number, piece, kind in found:
            made.of.append(number)
            made.lines.append(piece)
            made.areas.append(kind)
    return made._replace(given_up=given_up)


@dataclass
class _Work:
    """How much was done."""

    done: int = 0

    def spend(self, corners: int) -> None:
        """Raise `TooManyPairs` where so much more is too much."""
        if self.done + corners > MAX_EFFORT:
            raise TooManyPairs
        self.done += corners


def _area_within(rings: Sequence[Array], rule: Rule, clips: Sequence[Region]) -> list[Array]:
    """Return the borders of an area as far as it lies in all regions; closed."""
    if any(not region.rings for region in clips):
        return []
    near_sides(rings, MAX_NEAR)
    frame = _Frame.around(rings)
    section = _united([(frame.inner(rings), rule)])
    for region in clips:
        section = section ^ _united([(frame.inner(region.rings), "nonzero")])
    return [np.vstack((ring, ring[:1])) for ring in frame.outer(section)]


def _line_within(line: Array, clips: Sequence[Region], work: _Work) -> list[Array]:
    """Return the stretches of a line that lie in all regions, in its order and direction."""
    left = [line]
    for region in clips:
        left = [piece for one in left for piece in _stretches(one, region, work)]
    least = SHORTEST * float(np.ptp(line, axis=0).max())
    return [one for one in left if one is line or _length(one) > least]


def _stretches(line: Array, region: Region, work: _Work) -> list[Array]:
    """Return the stretches of a line in a region; side by side, for it may cross itself."""
    import shapely

    if len(line) < 2:
        return [line] if region.shape.covers(shapely.Point(line[0])) else []
    sides = shapely.linestrings(np.stack((line[:-1], line[1:]), axis=1))
    whole = shapely.covers(region.shape, sides)
    if whole.all():
        return [line]
    cut = shapely.intersects(region.shape, sides) & ~whole
    work.spend(int(cut.sum()) * region.size // PER_SIDE)
    found: list[list[Array]] = []
    for k in np.flatnonzero(whole | cut).tolist():
        for begin, end in [(line[k], line[k + 1])] if whole[k] else _within(sides[k], region):
            if found and (found[-1][-1] == begin).all():
                found[-1].append(end)
            else:
                found.append([begin, end])
    closed = len(found) > 1 and (line[0] == line[-1]).all()
    if closed and (found[0][0] == line[0]).all() and (found[-1][-1] == line[0]).all():
        found[0] = found.pop() + found[0][1:]
    return [np.array(one) for one in found]


def _within(side: Any, region: Region) -> list[tuple[Array, Array]]:
    """Return the parts of one side that lie in a region, from its begin to its end."""
    import shapely

    begin, end = np.asarray(side.coords)
    parts = []
    for one in shapely.get_parts(shapely.intersection(side, region.shape)):
        if one.geom_type == "LineString":
            ends = np.asarray(one.coords)[[0, -1]]
            where = (ends - begin) @ (end - begin)
            parts.append((float(where.min()), *ends[np.argsort(where)]))
    return [(one, other) for _, one, other in sorted(parts, key=lambda part: part[0])]


def _length(line: Array) -> float:
    return float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum())


def _united(shapes: Sequence[tuple[Sequence[Array], Rule]]) -> Any:
    """Return what is in any of some shapes."""
    from manifold3d import CrossSection, FillRule, OpType

    rules = {"nonzero": FillRule.NonZero, "evenodd": FillRule.EvenOdd}
    return CrossSection.batch_boolean(
        [CrossSection([np.asarray(ring) for ring in rings], rules[rule]) for rings, rule in shapes],
        OpType.Add,
    )


def _is_ring(line: Array) -> bool:
    return len(line) > 3 and bool((line[0] == line[-1]).all())


def _area(ring: Array) -> float:
    x, y = (ring - ring[0]).T
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))
