"""Which lines go on through a junction: crossing lines straight on, others end there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.ink.trace.skeleton import LineChain, Skeleton, length

MERGED: Final = 2.5
"""Longest piece of a skeleton between two nodes that is one junction, in widths of the line:
thinning makes two of a crossing."""

NEAR: Final = 1.0
"""Distance from a junction, in widths, within which a skeleton is bent by it."""

FAR: Final = 6.0
"""Distance from a junction, in widths, up to which the direction of a line is looked at."""

TIP: Final = 5.0
"""Longest dead end, in widths, that is the tip of a limb whose two sides have run together."""

NARROW: Final = float(np.cos(np.deg2rad(60.0)))
"""Cosine of the largest angle between the sides of such a limb."""

STRAIGHT: Final = np.deg2rad(20.0)
"""Largest turn of a line that goes on through a junction."""


@dataclass(frozen=True, eq=False)
class _End:
    """One end of a chain at a junction: (number of the chain, 0 or 1), and where it goes."""

    key: tuple[int, int]
    outward: Array
    """Unit vector, (2,): away from the junction."""


def joined_lines(skeleton: Skeleton) -> list[Array]:
    """Join the chains of a skeleton to lines as a hand draws them.

    Nodes that a short chain joins are one junction. Of the chains that meet there, the pair that
    makes the straightest line is joined first, up to `STRAIGHT`; chains without a partner end at
    the junction. Where two chains meet they are one line, whatever the corner between them.

    Parameters
    ----------
    skeleton : Skeleton
        Middle lines of the ink.

    Returns
    -------
    list of (n, 2) float
        Closed lines begin and end in one place.
    """
    chains = [chain for chain in skeleton.chains if len(chain.points) > 1]
    if not chains:
        return []
    group, inner = _junctions(chains, skeleton)
    outer = [number for number in range(len(chains)) if number not in inner]
    at: dict[int, list[tuple[int, int]]] = {}
    for number in outer:
        for side in (0, 1):
            at.setdefault(group[chains[number].ends[side]], []).append((number, side))
    sums: dict[int, list[Array]] = {}
    for number in (*inner, *outer):
        for side in (0, 1):
            node = group[chains[number].ends[side]]
            sums.setdefault(node, []).append(chains[number].points[-side])
    middle = {node: np.mean(places, axis=0) for node, places in sums.items()}
    partner: dict[tuple[int, int], tuple[int, int]] = {}
    points = {number: chains[number].points for number in outer}
    for node, keys in at.items():
        if len(keys) == 1:
            continue
        tip = _tip(keys, chains, skeleton, middle[node], at, group)
        if tip is not None:
            points.pop(tip[0])
            one, other = (key for key in keys if key != tip)
            partner[one], partner[other] = other, one
            for key in (one, other):
                points[key[0]] = _ended(
                    points[key[0]], key[1], middle[node], skeleton, passes=False
                )
            out = chains[tip[0]].points if tip[1] == 0 else chains[tip[0]].points[::-1]
            first = points[one[0]]
            points[one[0]] = np.vstack((out[::-1], first) if one[1] == 0 else (first, out))
            continue
        _pair(keys, chains, skeleton, middle[node], partner)
        if len(keys) > 2:
            for number, side in keys:
                passes = (number, side) in partner
                points[number] = _ended(points[number], side, middle[node], skeleton, passes=passes)
    return _walked(points, partner)


def _junctions(chains: list[LineChain], skeleton: Skeleton) -> tuple[dict[int, int], set[int]]:
    """Return the junction of each node, and the chains that lie within a junction."""
    degree: dict[int, int] = {}
    for chain in chains:
        for end in chain.ends:
            degree[end] = degree.get(end, 0) + 1
    group = {node: node for node in degree}

    def root(node: int) -> int:
        while group[node] != node:
            node = group[node]
        return node

    inner = set()
    for number, chain in enumerate(chains):
        a, b = chain.ends
        if a == b or min(degree[a], degree[b]) < 3:
            continue
        width = float(np.median(skeleton.width_at(chain.points)))
        if length(chain.points) <= MERGED * width:
            inner.add(number)
            group[root(a)] = root(b)
    return {node: root(node) for node in degree}, inner


def _tip(
    keys: list[tuple[int, int]],
    chains: list[LineChain],
    skeleton: Skeleton,
    middle: Array,
    at: dict[int, list[tuple[int, int]]],
    group: dict[int, int],
) -> tuple[int, int] | None:
    """Return the dead end at a junction that is the tip of a narrow limb, if there is one.

    The pencil went along one side to the tip and back along the other.
    """
    if len(keys) != 3 or len({number for number, _ in keys}) < 2:
        return None
    for number, side in keys:
        chain = chains[number]
        is_free = len(at[group[chain.ends[1 - side]]]) == 1
        width = float(np.median(skeleton.width_at(chain.points)))
        if not is_free or length(chain.points) > TIP * width:
            continue
        tip = _outward(chain.points, side, skeleton, middle)
        one, other = (
            _outward(chains[key[0]].points, key[1], skeleton, middle)
            for key in keys
            if key != (number, side)
        )
        if one @ other > NARROW and tip @ (one + other) < 0.0:
            return number, side
    return None


def _pair(
    keys: list[tuple[int, int]],
    chains: list[LineChain],
    skeleton: Skeleton,
    middle: Array,
    partner: dict[tuple[int, int], tuple[int, int]],
) -> None:
    """Join the ends at a junction that go on in one another, the straightest pairs first."""
    if len(keys) == 2:
        partner[keys[0]], partner[keys[1]] = keys[1], keys[0]
        return
    ends = [_End(key, _outward(chains[key[0]].points, key[1], skeleton, middle)) for key in keys]
    turns = [
        (float(np.arccos(np.clip(-(a.outward @ b.outward), -1.0, 1.0))), a.key, b.key)
        for i, a in enumerate(ends)
        for b in ends[:i]
    ]
    for turn, one, other in sorted(turns):
        if turn > STRAIGHT:
            break
        if one not in partner and other not in partner:
            partner[one], partner[other] = other, one


def _outward(points: Array, side: int, skeleton: Skeleton, middle: Array) -> Array:
    """Return the direction in which a chain leaves a junction, beyond what the junction bends."""
    away = points if side == 0 else points[::-1]
    width = float(np.median(skeleton.width_at(away)))
    apart = np.linalg.norm(away - middle, axis=1)
    beyond = np.flatnonzero(apart >= FAR * width)
    window = away[: beyond[0] + 1] if len(beyond) else away
    apart = apart[: len(window)]
    clear = window[apart >= NEAR * width]
    used = clear if len(clear) >= 3 else window
    centred = used - used.mean(0)
    along: Array = np.linalg.svd(centred, full_matrices=False)[2][0]
    if along @ (used[-1] - used[0]) < 0.0:
        along = -along
    return along


def _ended(points: Array, side: int, middle: Array, skeleton: Skeleton, *, passes: bool) -> Array:
    """Take away what a junction bends of a chain, and lead it to the junction's middle.

    A line that goes on is led straight through instead.
    """
    away = points if side == 0 else points[::-1]
    width = float(np.median(skeleton.width_at(away)))
    apart = np.linalg.norm(away - middle, axis=1)
    clear = np.flatnonzero(apart >= NEAR * width)
    kept = away[clear[0] :] if len(clear) and len(away) - clear[0] >= 2 else away[-2:]
    made = kept if passes else np.vstack((middle, kept))
    return made if side == 0 else made[::-1]


def _walked(
    points: dict[int, Array], partner: dict[tuple[int, int], tuple[int, int]]
) -> list[Array]:
    """Follow chains from end to end."""
    left = dict.fromkeys(points)
    lines = []
    free = [(number, side) for number in points for side in (0, 1) if (number, side) not in partner]
    for start in (*free, *((number, 0) for number in points)):
        if start[0] not in left:
            continue
        pieces = []
        key: tuple[int, int] | None = start
        while key is not None and key[0] in left:
            number, side = key
            del left[number]
            pieces.append(points[number] if side == 0 else points[number][::-1])
            key = partner.get((number, 1 - side))
        line = np.vstack(pieces)
        lines.append(np.vstack((line, line[:1])) if key == start else line)
    return lines
