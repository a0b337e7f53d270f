"""Changes that deal segments out anew among lines that run close: dashes of neighbours."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations
from math import atan2, pi, radians
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto_polyhedron.graph.draft import Change, Joined
from bozzetto_polyhedron.graph.grouping import Members
from bozzetto_polyhedron.graph.likelihood import Fits
from bozzetto_polyhedron.graph.surroundings import Surroundings, placed

SHORT: Final = 0.15
"""Length up to which a line may be what two other lines share at their beginning."""

STRAIGHT: Final = radians(12.0)
"""Angle up to which a line goes straight on through a corner."""

CUTS: Final = (0.25, 0.5, 0.75)
"""Where two lines are cut to exchange what lies beyond, shares of the stretch where both run."""

MOST_UNSURE: Final = 6
"""Segments about as near to both lines that are tried at either."""

OVER: Final = radians(16.0)
"""Angle up to which two lines that meet in a corner may be lines that run over one another."""

CLOSE_BY: Final = 0.06
"""Distance of a corner from a line on which it may lie instead."""

FEWEST: Final = 3
"""Segments of two lines from which on they are dealt out anew."""


def exchanged(around: Surroundings, key: int, others: Sequence[int]) -> Iterator[Change]:
    """Deal the segments of two lines that run along each other out anew.

    Between the same corners, and with an end of one exchanged for an end of the other.
    """
    draft = around.draft
    mine = draft.lines[key]
    for other in others:
        theirs = draft.lines[other]
        members = (*mine.line.members, *theirs.line.members)
        if len(members) < FEWEST:
            continue
        crossed = draft.fits.once(_crossed_over, mine.line.members, theirs.line.members)
        ways = [
            pairs
            for pairs in (
                (mine.pair, theirs.pair),
                ((mine.start, theirs.stop), (theirs.start, mine.stop)),
                ((mine.start, theirs.start), (mine.stop, theirs.stop)),
            )
            if all(one != two for one, two in pairs)
        ]
        away = _distances(around, members, [pair for pairs in ways for pair in pairs])
        for number, pairs in enumerate(ways):
            if set(pairs[0]) != set(mine.pair) and set(pairs[1]) != set(mine.pair):
                for parts in crossed:
                    yield Change((key, other), _lines(around, parts, pairs))
            dealt = _dealt(around, members, pairs, away[2 * number : 2 * number + 2])
            if dealt:
                yield Change((key, other), dealt)


def contracted(around: Surroundings, key: int) -> Iterator[Change]:
    """Let a short line be the beginning of both lines that go on from its end.

    Dashes of two lines that leave a corner in nearly the same direction are one row at first.
    """
    draft = around.draft
    each = draft.lines[key]
    if each.line.length > SHORT:
        return
    for near, far in ((each.start, each.stop), (each.stop, each.start)):
        if draft.degrees[far] != 3:
            continue
        one, two = (k for k in draft.at(far) if k != key)
        pairs = tuple((near, _other_end(draft.lines[k], far)) for k in (one, two))
        if any(a == b for a, b in pairs) or set(pairs[0]) == set(pairs[1]):
            continue
        parts = [draft.lines[k].line.members for k in (one, two)]
        mine = each.line.members
        members = (*mine, *parts[0], *parts[1])
        dealt = _dealt(around, members, pairs, _distances(around, members, pairs))
        if dealt:
            yield Change((key, one, two), dealt)
        for first, second in (((*mine, *parts[0]), parts[1]), (parts[0], (*mine, *parts[1]))):
            yield Change((key, one, two), _lines(around, (first, second), pairs))


def overlapping(around: Surroundings, key: int) -> Iterator[Change]:
    """Let lines that go on from one another run over one another along one of them, or not.

    Lines from A to B, B to C and C to D may be from A to C and from B to D, with or without one
    from B to C. So may two of them, from A to B and B to C, be from A to C and from B to C, or the
    other way round; and lines from A to B, B to C and from C to E, back along B, may be from A to
    C, B to C and B to E.
    """
    draft = around.draft
    middle = draft.lines[key]
    for near, far in ((middle.start, middle.stop), (middle.stop, middle.start)):
        on = _beside(around, key, near, far)
        back = _beside(around, key, far, near, going_on=False)
        for one in on:
            first = _other_end(draft.lines[one], near), far
            yield from _dealt_anew(around, (one, key), (first, (near, far)))
            for two in back:
                second = near, _other_end(draft.lines[two], far)
                yield from _dealt_anew(around, (one, two, key), (first, second, (near, far)))
        for two in back:
            second = near, _other_end(draft.lines[two], far)
            yield from _dealt_anew(around, (two, key), (second, (near, far)))
    for one in _beside(around, key, middle.start, middle.stop):
        first = _other_end(draft.lines[one], middle.start), middle.stop
        for two in _beside(around, key, middle.stop, middle.start):
            second = middle.start, _other_end(draft.lines[two], middle.stop)
            yield from _dealt_anew(around, (one, key, two), (first, second))
            yield from _dealt_anew(around, (one, key, two), (first, second, middle.pair))


def _beside(
    around: Surroundings, key: int, corner: int, beyond: int, *, going_on: bool = True
) -> list[int]:
    """Return the lines that go on from a line through one of its corners, or back along it."""
    found = []
    for other in around.draft.at(corner):
        end = _other_end(around.draft.lines[other], corner)
        if other != key and end != beyond:
            turn = _turn(around, corner, end, beyond)
            if (turn if going_on else pi - turn) < OVER:
                found.append(other)
    return found


def _dealt_anew(
    around: Surroundings, keys: tuple[int, ...], pairs: Sequence[tuple[int, int]]
) -> Iterator[Change]:
    """Deal the segments of lines out among lines between other corners."""
    draft = around.draft
    members = tuple(m for k in keys for m in draft.lines[k].line.members)
    same = len({frozenset(pair) for pair in pairs}) < len(pairs)
    if same or len(members) < FEWEST or any(one == two for one, two in pairs):
        return
    dealt = _dealt(around, members, pairs, _distances(around, members, pairs))
    if dealt:
        yield Change(keys, dealt)


def passing_straight(around: Surroundings, corner: int) -> Iterator[Change]:
    """Let two lines that go straight on through a corner be one that passes it.

    With four lines at the corner the other two may go straight on as well: then two lines cross
    there, and no corner is left.
    """
    draft = around.draft
    keys = draft.at(corner)
    if len(keys) < 4:
        return
    for way in combinations(keys, 2):
        rest = tuple(k for k in keys if k not in way)
        ways = (way, rest) if len(keys) == 4 else (way,)
        ends = [
            (_other_end(draft.lines[a], corner), _other_end(draft.lines[b], corner))
            for a, b in ways
        ]
        straight = [a != b and _is_straight(around, corner, a, b) for a, b in ends]
        if not straight[0]:
            continue
        parts = [tuple(m for k in each for m in draft.lines[k].line.members) for each in ways]
        if not all(straight):
            ways, parts, ends = (way,), parts[:1], ends[:1]
        yield Change(tuple(k for each in ways for k in each), _lines(around, parts, ends))


def on_another_line(around: Surroundings, corner: int) -> Iterator[Change]:
    """Let a corner through which two lines go straight on lie on another line close by instead.

    The two become one that passes it, and the other line becomes two that end there.
    """
    draft = around.draft
    keys = draft.at(corner)
    ends = {k: _other_end(draft.lines[k], corner) for k in keys}
    ways = [
        way
        for way in combinations(keys, 2)
        if ends[way[0]] != ends[way[1]] and _is_straight(around, corner, *(ends[k] for k in way))
    ]
    if not ways:
        return
    cut = [
        (key, parts)
        for key in around.keys
        if corner not in draft.lines[key].pair
        and (parts := _cut_at(around, draft.lines[key], around.place[corner])) is not None
    ]
    for one, two in ways:
        members = (*draft.lines[one].line.members, *draft.lines[two].line.members)
        passing = _lines(around, (members,), ((ends[one], ends[two]),))
        for key, parts in cut:
            each = draft.lines[key]
            if not {ends[one], ends[two]} & {each.start, each.stop}:
                pairs = (each.start, corner), (corner, each.stop)
                yield Change((one, two, key), (*passing, *_lines(around, parts, pairs)))


def _cut_at(
    around: Surroundings, each: Joined, place: tuple[float, float]
) -> tuple[Members, Members] | None:
    """Return the segments of a line before and beyond a place close to it; None where it is far."""
    members, length = each.line.members, each.line.length
    if len(members) < 2 or length < CLOSE_BY:
        return None
    (x, y), (x1, y1) = each.line.start, each.line.stop
    ux, uy = (x1 - x) / length, (y1 - y) / length
    dx, dy = place[0] - x, place[1] - y
    at = ux * dx + uy * dy
    if abs(ux * dy - uy * dx) > CLOSE_BY or not 0.0 < at < length:
        return None
    rows = around.draft.fits.rows
    middles = {
        m: sum((a - x) * ux + (b - y) * uy for a, b in rows[m]) / len(rows[m]) for m in members
    }
    before = tuple(m for m in members if middles[m] < at)
    beyond = tuple(m for m in members if middles[m] >= at)
    return (before, beyond) if before and beyond else None


def _is_straight(around: Surroundings, corner: int, one: int, two: int) -> bool:
    """Whether the way from a corner over another one to a third goes straight on."""
    return _turn(around, corner, one, two) < STRAIGHT


def _turn(around: Surroundings, corner: int, one: int, two: int) -> float:
    """Return by how much the way from a corner over another one to a third turns, radians."""
    (x, y), (x0, y0), (x1, y1) = (around.place[k] for k in (corner, one, two))
    cross = (x0 - x) * (y1 - y) - (y0 - y) * (x1 - x)
    return abs(atan2(cross, -(x0 - x) * (x1 - x) - (y0 - y) * (y1 - y)))


def _crossed_over(fits: Fits, mine: Members, theirs: Members) -> Iterator[tuple[Members, Members]]:
    """Exchange all segments beyond a place along two lines, for places where both run."""
    rows = fits.segments.ends
    first, second = rows[list(mine)].mean(1), rows[list(theirs)].mean(1)
    line = fits.line(mine)
    along = np.subtract(line.stop, line.start)
    a, b = (first - line.start) @ along, (second - line.start) @ along
    low, high = max(a.min(), b.min()), min(a.max(), b.max())
    for share in CUTS:
        cut = low + share * (high - low)
        one = tuple(m for m, at in zip(mine, a, strict=True) if at < cut)
        two = tuple(m for m, at in zip(theirs, b, strict=True) if at < cut)
        one_on = tuple(m for m, at in zip(theirs, b, strict=True) if at >= cut)
        two_on = tuple(m for m, at in zip(mine, a, strict=True) if at >= cut)
        if (one or one_on) and (two or two_on):
            yield (*one, *one_on), (*two, *two_on)


def _other_end(each: Joined, corner: int) -> int:
    return each.stop if each.start == corner else each.start


def _dealt(
    around: Surroundings, members: Members, pairs: Sequence[tuple[int, int]], away: Array
) -> tuple[Joined, ...]:
    """Give each segment to the nearest of lines between corners; empty if one gets nothing.

    Segments that are about as near to two go where all lines fit better. The distances from the
    lines are (lines, k).
    """
    order = np.argsort(away, axis=0, kind="stable")
    home, second = order[0].tolist(), order[1].tolist()
    margins = np.take_along_axis(away, order[:2], axis=0)
    unsure = np.argsort(margins[1] - margins[0], kind="stable")[:MOST_UNSURE].tolist()
    parts = _parts(members, home, len(pairs))
    if not all(parts):
        return ()
    misfit = _misfit(around, parts)
    for number in unsure:
        home[number], second[number] = second[number], home[number]
        others = _parts(members, home, len(pairs))
        if all(others) and (least := _misfit(around, others)) < misfit:
            parts, misfit = others, least
        else:
            home[number], second[number] = second[number], home[number]
    return _lines(around, parts, pairs)


def _parts(members: Members, home: Sequence[int], count: int) -> tuple[Members, ...]:
    """Return the segments of each of some lines."""
    found: list[list[int]] = [[] for _ in range(count)]
    for member, own in zip(members, home, strict=True):
        found[own].append(member)
    return tuple(map(tuple, found))


def _misfit(around: Surroundings, parts: Sequence[Members]) -> float:
    return sum(around.draft.fits.line(part).misfit for part in parts)


def _lines(
    around: Surroundings, parts: Sequence[Members], pairs: Sequence[tuple[int, int]]
) -> tuple[Joined, ...]:
    fits = around.draft.fits
    return tuple(
        placed(around, fits.line(part), *pair) for part, pair in zip(parts, pairs, strict=True)
    )


def _distances(around: Surroundings, members: Members, pairs: Sequence[tuple[int, int]]) -> Array:
    """Return the root mean square distances of segments' ends from stretches, (pairs, segments)."""
    ends = around.draft.fits.segments.ends[list(members)]
    begin = np.array([around.place[a] for a, _ in pairs]).reshape(-1, 1, 1, 2)
    step = np.array([around.place[b] for _, b in pairs]).reshape(-1, 1, 1, 2) - begin
    away = ends - begin
    at = (away * step).sum(3) / np.maximum((step * step).sum(3), 1e-18)
    away = away - np.clip(at, 0.0, 1.0)[..., None] * step
    made: Array = np.sqrt((away**2).sum(3).mean(2))
    return made
