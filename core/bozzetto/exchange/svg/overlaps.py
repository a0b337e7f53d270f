"""Painted outlines that overlap: one outline around everything that they paint.

Nested outlines are left as they are. Overlapping ones cannot be nested, and on the screen
they are one area with one outline: icons and logos are full of them. An outline that runs
to and fro along a slit to reach its hole is an outer one and a hole, and a star drawn in one
line is its painted outline.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Array, Index
from bozzetto.errors import FormatError

HAIR: Final = 1e-4
"""Half the width of what is cut away where an outline touches itself, as a share of the
size: outlines that touch enclose no solid."""

NEAR: Final = 2.0 * HAIR
"""Distance, as a share of the size, up to which outlines touch: no wall is so thin."""

APART: Final = 4e-5
"""Least distance of those that touched, as a share of the size: closer ones cross once they are
smoothed."""

ALONG: Final = 3.0
"""Way along an outline, in such distances, over which it may be so near to itself."""

SPECK: Final = 1e-8
"""Area of a ring that is left out, as a share of the squared size: a rest of rounding."""

THIN: Final = 2.5e-4
"""Area of a ring that is left out, by its length, as a share of the size: about half its width.
Areas that were meant to lie side by side leave such slivers between them, which nobody sees."""

MAX_MEETINGS: Final = 200_000
"""Pairs of outlines whose boxes overlap."""

MAX_NEAR: Final = 12_000_000
"""Pairs of sides whose boxes overlap that are enumerated: two seconds of work."""

MAX_TESTED: Final = 1_500_000
"""Limit of pairs that are looked at exactly: two seconds of work, too."""

MAX_CROSSINGS: Final = 20_000
"""Places where sides of areas cross that are to be joined; the work grows faster than them."""

PAIRS_AT_ONCE: Final = 1_000_000
"""Pairs of sides that are held in memory at a time."""

PAIRS_BETWEEN: Final = 10_000
"""Pairs that are looked at before it is asked again which lines are connected by now."""

ARC_CORNERS: Final = 32
"""Corners that a whole turn gets where a tip is rounded by a hair."""


class TooManyPairs(Exception):
    """More pairs than the work for them is worth."""


@dataclass(frozen=True)
class Area:
    """The painted element that a line belongs to.

    Parameters
    ----------
    element : int
        Lines of one element have the same number.
    rule : {"nonzero", "evenodd"}
        What counts as its inside.
    """

    element: int
    rule: Literal["nonzero", "evenodd"]


def without_overlaps(
    lines: Sequence[Array], areas: Sequence[Area | None]
) -> list[tuple[int, Array]]:
    """Join painted elements whose outlines cross or touch themselves or those of others.

    An area is what the screen shows, by its fill rule. A mere line that crosses itself stays:
    that may be a slip of the pen, and the person is told.

    Parameters
    ----------
    lines : sequence of (n, 2) arrays
        Closed ones repeat their first point at the end.
    areas : sequence of Area or None
        For each line, the element whose inside is painted; None for mere lines.

    Returns
    -------
    list of (int, (n, 2) array)
        Lines, each with the number of the given one that it stands for.

    Raises
    ------
    FormatError
        If so much overlaps that joining it would take too long.
    """
    try:
        return _without_overlaps(lines, areas)
    except TooManyPairs:
        raise FormatError(
            "Too many of its areas overlap. Unite them in the program that made it, and save "
            "it again."
        ) from None


def _without_overlaps(
    lines: Sequence[Array], areas: Sequence[Area | None]
) -> list[tuple[int, Array]]:
    rings: list[int] = []
    known: set[bytes] = set()
    kept: list[int] = []
    for k, (line, area) in enumerate(zip(lines, areas, strict=True)):
        if area is not None and len(line) > 3 and (line[0] == line[-1]).all():
            content = line.tobytes()
            if content in known:
                continue  # painted twice is painted
            known.add(content)
            rings.append(k)
        kept.append(k)
    meeting = _meeting([lines[k] for k in rings], NEAR)
    meeting += [(n, n) for n, k in enumerate(rings) if _meets_itself(lines[k])]
    element_of = {k: area.element for k in rings if (area := areas[k]) is not None}
    group_of = _groups([(element_of[rings[a]], element_of[rings[b]]) for a, b in meeting])
    members_of: dict[int, list[int]] = {}
    for k in rings:
        if (group := group_of.get(element_of[k])) is not None:
            members_of.setdefault(group, []).append(k)
    result: list[tuple[int, Array]] = []
    for k in kept:
        group = group_of.get(element_of.get(k, -1))
        if group is None:
            result.append((k, lines[k]))
        elif members := members_of.pop(group, []):
            joined = _joined([lines[j] for j in members], [areas[j] for j in members])
            result.extend((k, ring) for ring in joined)
    return result


def _meeting(rings: Sequence[Array], near: float) -> list[tuple[int, int]]:
    """Return pairs of different rings that touch: enough to connect all that meet.

    Sides of rings that others connect already are not looked at. Raises `TooManyPairs`.

    Parameters
    ----------
    rings : sequence of (n, 2) arrays
        Closed.
    near : float
        Distance up to which they touch, as a share of the size of all.
    """
    import shapely

    if len(rings) < 2:
        return []
    low, high = (np.array([end(ring, axis=0) for ring in rings]) for end in (np.min, np.max))
    reach = near * float((high.max(axis=0) - low.min(axis=0)).max())
    boxes = shapely.box(*(low - reach).T, *(high + reach).T)
    close = [pair for pair in _near(boxes, 2 * MAX_MEETINGS) if len(pair)]
    if not close:
        return []
    involved = np.unique(np.concatenate(close))
    sides = [_sides(rings[k]) for k in involved]
    owner = np.repeat(involved, [len(part) for part in sides])
    row = np.concatenate(sides)
    tested = 0
    joined = _Joined(len(rings))
    for pairs in _near(row, MAX_NEAR, reach):
        for first in range(0, len(pairs), PAIRS_BETWEEN):
            some = pairs[first : first + PAIRS_BETWEEN]
            some = some[joined.apart(owner[some])]
            tested += len(some)
            if tested > MAX_TESTED:
                raise TooManyPairs
            joined.take(owner[some[shapely.dwithin(*row[some.T], reach)]])
    return joined.pairs


def _sides(ring: Array) -> NDArray[np.object_]:
    """Return the sides of a ring, as lines of two points."""
    import shapely

    sides: NDArray[np.object_] = shapely.linestrings(np.stack((ring[:-1], ring[1:]), axis=1))
    return sides


def _near(shapes: NDArray[np.object_], limit: int, reach: float = 0.0) -> Iterator[Index]:
    """Yield pairs (k, 2) of different shapes whose boxes overlap, each once, some at a time.

    With a reach, boxes that are so far apart at most in either direction count as well.

    Raises `TooManyPairs` where there are more than `limit`.
    """
    import shapely

    tree = shapely.STRtree(shapes)
    step = max(1, PAIRS_AT_ONCE // max(1, len(shapes)))
    count = 0
    for first in range(0, len(shapes), step):
        some = shapes[first : first + step]
        if reach:
            left, bottom, right, top = shapely.bounds(some).T
            some = shapely.box(left - reach, bottom - reach, right + reach, top + reach)
        a, b = tree.query(some)
        a = a + first
        once = a < b
        count += int(once.sum())
        if count > limit:
            raise TooManyPairs
        yield np.stack((a[once], b[once]), axis=1)


def near_sides(rings: Sequence[Array], limit: int) -> int:
    """Count pairs of sides of some closed rings whose boxes overlap: a measure of work.

    Raises `TooManyPairs` where there are more than `limit`.
    """
    row = np.concatenate([_sides(ring) for ring in rings])
    return sum(len(pairs) for pairs in _near(row, limit))


def _crossings(rings: Sequence[Array]) -> int:
    """Count how often the sides of some rings cross.

    Raises `TooManyPairs` where there are more than `MAX_CROSSINGS`, or it takes too long to tell.
    """
    starts = np.concatenate([ring[:-1] for ring in rings])
    steps = np.concatenate([np.diff(ring, axis=0) for ring in rings])
    row = np.concatenate([_sides(ring) for ring in rings])
    crossings = 0
    for pairs in _near(row, MAX_NEAR):
        a, b = pairs.T
        # Rounding may miss or add some that nearly touch: this is a measure of work.
        apart = starts[b] - starts[a]
        over = _turn(steps[a], apart) * _turn(steps[a], apart + steps[b]) < 0
        under = _turn(steps[b], apart) * _turn(steps[b], apart - steps[a]) < 0
        crossings += int((over & under).sum())
        if crossings > MAX_CROSSINGS:
            raise TooManyPairs
    return crossings


def _turn(one: Array, other: Array) -> Array:
    """Return twice the area between two rows of vectors (n, 2), positive to the left."""
    return np.asarray(one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0])


def _meets_itself(ring: Array) -> bool:
    """Whether a ring crosses or touches itself, unless it takes too long to tell."""
    try:
        _crossings([ring])
    except TooManyPairs:
        return False
    return not _is_simple(ring)


def _groups(pairs: Sequence[tuple[int, int]]) -> dict[int, int]:
    """Return the numbers that pairs connect, each with the smallest of those it is connected to."""
    numbers = np.array(pairs, np.int64).reshape(-1, 2)
    joined = _Joined(int(numbers.max(initial=-1)) + 1)
    joined.take(numbers)
    return {k: int(joined.smallest[k]) for k in np.unique(numbers).tolist()}


class _Joined:
    """Numbers below `count`, some of which are connected.

    Attributes
    ----------
    smallest : (count,) int
        For each, the smallest number that it is connected to.
    pairs : list of (int, int)
        The taken pairs without those whose numbers others had connected before.
    """

    def __init__(self, count: int) -> None:
        self.smallest = np.arange(count)
        self.pairs: list[tuple[int, int]] = []

    def apart(self, pairs: Index) -> NDArray[np.bool_]:
        """Tell which of some pairs (n, 2) are not connected yet."""
        return np.asarray(self.smallest[pairs[:, 0]] != self.smallest[pairs[:, 1]])

    def take(self, pairs: Index) -> None:
        """Connect the numbers of each of some pairs (n, 2)."""
        parent = dict[int, int]()

        def root(k: int) -> int:
            while (above := parent.get(k, k)) != k:
                parent[k] = parent.get(above, above)
                k = above
            return k

        pairs = pairs[self.apart(pairs)]
        ends = np.sort(self.smallest[pairs], axis=1)
        _, once = np.unique(ends[:, 0] * len(self.smallest) + ends[:, 1], return_index=True)
        for k in np.sort(once).tolist():
            low, high = sorted((root(int(ends[k, 0])), root(int(ends[k, 1]))))
            if low != high:
                parent[high] = low
                self.pairs.append((int(pairs[k, 0]), int(pairs[k, 1])))
        if parent:
            now = np.arange(len(self.smallest))
            changed = list(parent)
            now[changed] = [root(k) for k in changed]
            self.smallest = now[self.smallest]


def _joined(rings: Sequence[Array], areas: Sequence[Area | None]) -> list[Array]:
    """Return the outline of all that the rings of some elements paint. Raises `TooManyPairs`."""
    from manifold3d import CrossSection, FillRule, JoinType, OpType

    _crossings(rings)
    points = np.concatenate(rings)
    low = points.min(axis=0)
    size = float(np.ptp(points, axis=0).max()) or 1.0
    rules = {"nonzero": FillRule.NonZero, "evenodd": FillRule.EvenOdd}
    by_area: dict[Area, list[Array]] = {}
    for ring, area in zip(rings, areas, strict=True):
        if area is not None:
            by_area.setdefault(area, []).append((ring[:-1] - low) / size)
    painted = [CrossSection(contours, rules[area.rule]) for area, contours in by_area.items()]
    whole: Any = CrossSection.batch_boolean(painted, OpType.Add)
    found = _closed(whole.to_polygons())
    if _meeting(found, NEAR) or any(map(_is_tight, found)):
        for change in (-HAIR, HAIR - 0.5 * APART):
            whole = whole.offset(change, JoinType.Round, 2.0, ARC_CORNERS)
        found = _closed(whole.to_polygons())
    return [ring * size + low for ring in found]


def _closed(polygons: Sequence[Array]) -> list[Array]:
    """Return rings that repeat their first point, without specks and slivers."""
    rings = [np.vstack((p, p[:1])).astype(np.float64) for p in polygons if len(p) > 2]
    lengths = [float(np.hypot(*np.diff(ring, axis=0).T).sum()) for ring in rings]
    return [
        ring
        for ring, length in zip(rings, lengths, strict=True)
        if abs(_area(ring)) > max(SPECK, THIN * length)
    ]


def _area(ring: Array) -> float:
    x, y = (ring - ring[0]).T
    return 0.5 * float(x[:-1] @ y[1:] - x[1:] @ y[:-1])


def _is_tight(ring: Array) -> bool:
    """Whether a ring crosses, touches or nearly touches itself; pointed tips count as well."""
    import shapely

    if not _is_simple(ring):
        return True
    reach = NEAR * float(np.ptp(ring, axis=0).max())
    sides, lengths = _sides(ring), np.hypot(*np.diff(ring, axis=0).T)
    ends = np.cumsum(lengths)
    for pairs in _near(sides, MAX_NEAR, reach):
        one, other = pairs.T
        between = ends[other] - lengths[other] - ends[one]
        back = ends[-1] - between - lengths[one] - lengths[other]
        pairs = pairs[np.minimum(between, back) > ALONG * reach]
        if shapely.dwithin(*sides[pairs.T], reach).any():
            return True
    return False


def _is_simple(ring: Array) -> bool:
    import shapely

    return bool(shapely.LinearRing(ring).is_simple)
