"""Small changes of a draft that may make it likelier.

Two corners become one, an end goes to another corner, a corner becomes two, a line turns out to be
part of another one or a stray mark, a corner of two lines is straightened, and strokes that were
taken for one line are told apart.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from itertools import pairwise
from math import atan2, hypot, pi, radians
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto_polyhedron.graph.draft import Change, Draft, Joined
from bozzetto_polyhedron.graph.grouping import Members
from bozzetto_polyhedron.graph.likelihood import LONGEST_TICK, Fits, strain_of
from bozzetto_polyhedron.graph.shared_segments import (
    contracted,
    exchanged,
    on_another_line,
    overlapping,
    passing_straight,
)
from bozzetto_polyhedron.graph.surroundings import Surroundings, placed

CLOSE_BY: Final = 0.06
"""Shares of the diagonal within which lines of two corners may exchange their ends."""

NEIGHBOURS: Final = 4
"""Other corners that are tried for one, the nearest first."""

STRAINED: Final = 9.0
"""Strain from which on a corner may be two."""

STRAIGHT: Final = radians(25.0)
"""Angle up to which two lines may be one line drawn in two pieces."""


def steps(draft: Draft, corners: Collection[int] | None = None) -> Iterator[Change]:
    """Return changes that may lower the cost.

    Parameters
    ----------
    draft : Draft
        What is to be changed.
    corners : collection of int, optional
        Only changes beside these corners; all without.
    """
    around = Surroundings(draft)
    chosen = around.corners if corners is None else [k for k in around.corners if k in corners]
    keys = [
        k
        for k in around.keys
        if corners is None or draft.lines[k].start in corners or draft.lines[k].stop in corners
    ]
    for corner in chosen:
        yield from _joined_corners(around, corner)
        yield from _exchanged_ends(around, corner)
        yield from _parted_corner(around, corner)
        yield from passing_straight(around, corner)
        yield from on_another_line(around, corner)
        if draft.degrees[corner] == 2:
            yield from _straightened(around, corner)
    along = _lying_along(around, keys)
    for key in keys:
        yield from _moved_ends(around, key)
        if draft.lines[key].line.length < LONGEST_TICK:
            yield Change((key,), (), draft.lines[key].line.members)
        yield from _absorbed(around, key, along[key])
        yield from exchanged(around, key, along[key])
        yield from contracted(around, key)
        yield from overlapping(around, key)
        if len(draft.lines[key].line.members) > 1:
            yield from _told_apart(around, key, along[key])


def _with_joined_pairs(around: Surroundings, moved: dict[int, Joined]) -> Change:
    """Return the change to moved lines; those that now share both corners become one."""
    draft = around.draft
    taken: dict[tuple[int, int], list[int]] = {}
    for key, each in moved.items():
        taken.setdefault(each.pair, []).append(key)
    removed: set[int] = set(moved)
    added = []
    for pair, keys in taken.items():
        same = [k for k in draft.pairs.get(pair, ()) if k not in moved]
        if len(keys) + len(same) == 1 or pair[0] == pair[1]:
            added += [moved[k] for k in keys]
            continue
        removed |= set(same)
        lines = [moved[k].line for k in keys] + [draft.lines[k].line for k in same]
        members = tuple(m for line in lines for m in line.members)
        added.append(placed(around, draft.fits.line(members), *pair))
    return Change(tuple(sorted(removed)), tuple(added))


def _moved(each: Joined, corner: int, other: int) -> Joined:
    start = other if each.start == corner else each.start
    stop = other if each.stop == corner else each.stop
    return Joined(each.line, start, stop)


def _joined_corners(around: Surroundings, corner: int) -> Iterator[Change]:
    draft = around.draft
    mine = draft.at(corner)
    for other in around.near(around.place[corner], NEIGHBOURS + 1):
        if other == corner:
            continue
        moved = {k: _moved(draft.lines[k], corner, other) for k in mine}
        yield _with_joined_pairs(around, moved)


def _exchanged_ends(around: Surroundings, corner: int) -> Iterator[Change]:
    """Let a line of a corner and one of another corner close by exchange these ends."""
    draft = around.draft
    for other in around.near(around.place[corner], NEIGHBOURS, CLOSE_BY):
        if other <= corner:
            continue
        for mine in draft.at(corner):
            for theirs in draft.at(other):
                if mine != theirs:
                    one = _moved(draft.lines[mine], corner, other)
                    two = _moved(draft.lines[theirs], other, corner)
                    yield Change((mine, theirs), (one, two))


def _parted_corner(around: Surroundings, corner: int) -> Iterator[Change]:
    """Let some ends of a strained corner be a corner of their own."""
    draft = around.draft
    if draft.degrees[corner] < 4 or strain_of(draft.sums[corner]) < STRAINED:
        return
    mine = draft.at(corner)
    tips = np.array([_tip(draft.lines[k], corner) for k in mine])
    tried: set[frozenset[int]] = set()
    for tip in tips:
        order = np.argsort(np.hypot(*(tips - tip).T), kind="stable").tolist()
        for count in range(2, len(mine) - 1):
            chosen = frozenset(mine[k] for k in order[:count])
            if chosen not in tried:
                tried.add(chosen)
                moved = {k: _moved(draft.lines[k], corner, draft.next_corner) for k in chosen}
                yield Change(tuple(moved), tuple(moved.values()))


def _tip(each: Joined, corner: int) -> tuple[float, float]:
    return each.line.start if each.start == corner else each.line.stop


def _moved_ends(around: Surroundings, key: int) -> Iterator[Change]:
    each = around.draft.lines[key]
    for here, there, tip in (
        (each.start, each.stop, each.line.start),
        (each.stop, each.start, each.line.stop),
    ):
        for corner in around.near(tip, NEIGHBOURS):
            if corner not in (here, there):
                yield _with_joined_pairs(around, {key: _moved(each, here, corner)})


def _lying_along(around: Surroundings, chosen: Sequence[int]) -> dict[int, list[int]]:
    """Return for chosen lines at most three others by whose side they were drawn, nearest first."""
    draft, keys = around.draft, around.keys
    lines = [draft.lines[k].line for k in keys]
    starts: Array = np.array([each.start for each in lines]).reshape(-1, 2)
    stops: Array = np.array([each.stop for each in lines]).reshape(-1, 2)
    steps_ = stops - starts
    lengths = np.maximum(np.hypot(*steps_.T), 1e-9)
    axes = steps_ / lengths[:, None]
    rows = np.searchsorted(keys, chosen)
    tips = np.stack([starts[rows], stops[rows]], 1)
    away = tips[:, None] - starts[None, :, None]
    along = (away * axes[:, None]).sum(3)
    across = np.abs(away[..., 0] * axes[:, None, 1] - away[..., 1] * axes[:, None, 0]).max(2)
    shared = np.minimum(along.max(2), lengths) - np.maximum(along.min(2), 0.0)
    tolerance = 4.0 * draft.fits.spread.across + 0.012
    fit = (across < tolerance) & (shared > -0.03) & (lengths >= 0.8 * lengths[rows, None])
    fit[np.arange(len(rows)), rows] = False
    made = {}
    for row, key in enumerate(chosen):
        order = np.argsort(np.where(fit[row], across[row], np.inf), kind="stable")[:3]
        made[key] = [keys[k] for k in order if fit[row, k]]
    return made


def _absorbed(around: Surroundings, key: int, others: list[int]) -> Iterator[Change]:
    """Let a line be part of another one that it lies along."""
    draft = around.draft
    mine = draft.lines[key]
    for other in others:
        theirs = draft.lines[other]
        merged = draft.fits.line((*mine.line.members, *theirs.line.members))
        pairs = {theirs.pair, mine.pair}
        for one in (mine.start, mine.stop):
            pairs |= {(theirs.start, one), (one, theirs.stop)}
        for one, two in sorted(pairs):
            if one != two:
                yield Change((key, other), (placed(around, merged, one, two),))


def _straightened(around: Surroundings, corner: int) -> Iterator[Change]:
    """Let two lines that go on straight through a corner be one."""
    draft = around.draft
    one, two = draft.at(corner)
    ends = [
        each.stop if each.start == corner else each.start
        for each in (draft.lines[one], draft.lines[two])
    ]
    if ends[0] == ends[1]:
        return
    (x, y), (x0, y0), (x1, y1) = (around.place[k] for k in (corner, *ends))
    ax, ay, bx, by = x0 - x, y0 - y, x1 - x, y1 - y
    if pi - abs(atan2(ax * by - ay * bx, ax * bx + ay * by)) > STRAIGHT:
        return
    members = (*draft.lines[one].line.members, *draft.lines[two].line.members)
    merged = placed(around, draft.fits.line(members), *ends)
    same = draft.pairs.get(merged.pair, [])
    if same:
        members = (*members, *(m for k in same for m in draft.lines[k].line.members))
        merged = placed(around, draft.fits.line(members), *ends)
    yield Change((one, two, *same), (merged,))


def _told_apart(around: Surroundings, key: int, others: list[int]) -> Iterator[Change]:
    """Let some segments of a line be another line, or part of another one."""
    draft = around.draft
    each = draft.lines[key]
    for part, rest in draft.fits.once(_partitions, each.line.members):
        mine, left = draft.fits.line(part), draft.fits.line(rest)
        homes = {each.pair}
        nearest = [around.near(tip, 1) for tip in (left.start, left.stop)]
        starts, stops = around.near(mine.start, 2), around.near(mine.stop, 2)
        if nearest[0] and nearest[1]:
            homes.add((nearest[0][0], nearest[1][0]))
        for home in sorted(homes):
            if home[0] == home[1]:
                continue
            kept = placed(around, left, *home)
            for start in starts:
                for stop in stops:
                    if start != stop and {start, stop} != set(home):
                        yield Change((key,), (kept, Joined(mine, start, stop)))
            for other in others:
                if other != key:
                    theirs = draft.lines[other]
                    joined = draft.fits.line((*part, *theirs.line.members))
                    both = placed(around, joined, theirs.start, theirs.stop)
                    yield Change((key, other), (kept, both))


def _partitions(fits: Fits, members: Members) -> Iterator[tuple[Members, Members]]:
    """Return ways to part the segments of a line: each one alone, by side, and by place along."""
    line = fits.line(members)
    rows = fits.segments.ends[list(members)].mean(1) - np.array(line.start)
    axis = np.array(line.stop) - np.array(line.start)
    axis /= max(hypot(*axis), 1e-9)
    seen: set[Members] = set()
    for values in (rows @ axis, rows @ np.array([-axis[1], axis[0]])):
        order = [members[k] for k in np.argsort(values, kind="stable")]
        gaps = [b - a for a, b in pairwise(np.sort(values).tolist())]
        cuts = sorted(range(1, len(order)), key=lambda cut: -gaps[cut - 1])[:2]
        for cut in cuts:
            for part in (tuple(sorted(order[:cut])), tuple(sorted(order[cut:]))):
                if part not in seen:
                    seen.add(part)
                    yield part, tuple(k for k in members if k not in part)
    if 2 < len(members) < 6:
        for one in members:
            if (one,) not in seen:
                yield (one,), tuple(k for k in members if k != one)
