"""From the edges of a loop to the sides of its domain.

Sides are runs of edges between convex corners. A corner that hardly turns would make a patch fold,
and so would a concave one: there sides run on, and are cut into their halves where they are bent.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from bozzetto.arrays import Array, cross_product
from bozzetto_product.fill.corners import Corner
from bozzetto_product.fill.edge_pieces import EdgePiece
from bozzetto_product.fill.half_sides import HalfSide, Side, SidePiece
from bozzetto_product.fill.normals import LoopNormals
from bozzetto_product.network.net import Loop

TURN: Final = float(np.radians(10.0))
"""Turn at which a side ends, radians."""

KINK: Final = float(np.radians(0.5))
"""Turn that a cut avoids, radians: the surface would be bent over the spoke."""

KINK_COST: Final = 0.2
"""How much further from the middle of a side a cut may be to avoid a kink, as share."""

INWARD: Final = float(np.radians(2.0))
"""Turn inward about a place from which on no side starts there if it can start elsewhere."""

SHOULDER: Final = 0.03
"""Reach of the turns that count for a start on a smooth outline, as share of its length."""

EVEN: Final = 2.0
"""What uneven sides cost there, in radians by the squares of their shares of the length."""

CANDIDATES: Final = 20
"""Most places that are tried there."""

FEWEST: Final = 3
"""Sides of a loop that has so many convex corners; others get four."""


def piece_count(corners: Sequence[Corner]) -> int:
    """Return into how many pieces the edges of a loop must be cut at least."""
    kinds = [corner_kind(corner) for corner in corners]
    convex = kinds.count(1)
    if convex >= FEWEST and not is_crowded(kinds):
        return 2
    if len(corners) == 1:
        return 8
    return 4 if len(corners) > 2 or convex >= 2 else 8


def corner_kind(corner: Corner) -> int:
    """Return 1 for a convex corner, -1 for a concave one, 0 where the loop runs on."""
    return turn_kind(corner.turn)


def turn_kind(turn: float) -> int:
    """Return the kind of a corner by its turn, radians; see `corner_kind`."""
    if abs(turn) < TURN:
        return 0
    return 1 if turn > 0 else -1


def is_crowded(kinds: list[int]) -> bool:
    """Whether two concave corners follow one another without a convex one between."""
    order = [kind for kind in kinds if kind]
    return any(a == b == -1 for a, b in zip(order, order[1:] + order[:1], strict=True))


def sides_of_loop(
    loop: Loop,
    normals: LoopNormals,
    pieces_of_edges: Sequence[Sequence[EdgePiece]] | Mapping[int, Sequence[EdgePiece]],
    first: int = 0,
) -> tuple[Side, ...]:
    """Return the sides of a loop's domain.

    Parameters
    ----------
    loop : Loop
        Head to tail.
    normals : LoopNormals
        Of that loop.
    pieces_of_edges : sequence or mapping of int, of sequence of EdgePiece
        Of each edge of the net, in its sense; of those of the loop at least.
    first : int
        Number of its first half edge: of an outline among those of a loop.
    """
    pieces: list[SidePiece] = []
    kinks: list[float] = []
    for number, (edge, forward) in enumerate(loop):
        cut = pieces_of_edges[edge]
        kinks += [normals.corners[number].turn] + [0.0] * (len(cut) - 1)
        ordered = cut if forward else cut[::-1]
        field = normals.fields[number]
        pieces += [SidePiece(first + number, each, forward, field) for each in ordered]
    return sides_of_pieces(
        pieces, kinks, [normals.corners[piece.half_edge - first].normal for piece in pieces]
    )


def sides_of_pieces(
    pieces: Sequence[SidePiece], kinks: Sequence[float], normals: Sequence[Array]
) -> tuple[Side, ...]:
    """Return the sides of the domain of a ring of pieces.

    Parameters
    ----------
    pieces : sequence of SidePiece
        Head to tail.
    kinks : sequence of float
        Turn at the start of each, radians; negative at a concave corner.
    normals : sequence of (3,) float
        Unit, near each.
    """
    kinds = [turn_kind(kink) for kink in kinks]
    plain = kinds.count(1) >= FEWEST and -1 not in kinds
    turns = [0.0] * len(pieces) if plain else _turns(pieces, normals)
    starts = _side_starts(kinds, kinks, [piece.piece.length for piece in pieces], turns)
    sides = []
    for start, end in zip(starts, [*starts[1:], starts[0] + len(pieces)], strict=True):
        run = [index % len(pieces) for index in range(start, end)]
        cut_at = _cut_of(run, pieces, kinds, kinks)
        first = HalfSide.of([pieces[index] for index in run[:cut_at]], True)
        second = HalfSide.of([pieces[index] for index in run[cut_at:]][::-1], False)
        at = run[cut_at]
        bend = abs(kinks[at]) if kinds[at] < 0 else 0.0
        sides.append(Side((first, second), bend))
    return tuple(sides)


def _turns(pieces: Sequence[SidePiece], normals: Sequence[Array]) -> list[float]:
    """Return how far the loop turns about the start of each piece, half a piece on both sides.

    Negative where it bends inward; corners are not counted.
    """
    made = []
    for piece, normal in zip(pieces, normals, strict=True):
        first, last = piece.ends()
        made.append(float(np.arctan2(cross_product(first, last) @ normal, first @ last)))
    return [0.5 * (made[index - 1] + turn) for index, turn in enumerate(made)]


def _side_starts(
    kinds: list[int], kinks: Sequence[float], lengths: list[float], turns: list[float]
) -> list[int]:
    """Return the pieces with which sides start, rising."""
    count = len(kinds)
    starts = [index for index in range(count) if kinds[index] > 0]
    if len(starts) < FEWEST and min(turns) < -INWARD:
        found = _most_outward(starts, kinds, lengths, turns)
        if found:
            return found
    if not starts:
        return _quarters(_smoothest(kinks, lengths), count)
    wanted = len(starts) if len(starts) >= FEWEST else FEWEST + 1
    concave = [index for index in range(count) if kinds[index] < 0]
    following = [*concave[1:], concave[0] + count] if concave else []
    for one, two in zip(concave, following, strict=True):
        between = range(one + 1, two)
        if not any(index % count in starts for index in between) and len(between):
            starts.append(_middle_of(list(between), lengths, turns, one, two) % count)
    starts = sorted(set(starts))
    while len(starts) < wanted:
        runs = list(zip(starts, [*starts[1:], starts[0] + count], strict=True))
        choices = [
            [index for index in range(low + 2, high - 1) if kinds[index % count] >= 0]
            for low, high in runs
        ]
        sizes = [
            sum(lengths[i % count] for i in range(*run)) if some else 0.0
            for run, some in zip(runs, choices, strict=True)
        ]
        longest = int(np.argmax(sizes))
        if sizes[longest] <= 0.0:
            break
        starts.append(_middle_of(choices[longest], lengths, turns, *runs[longest]) % count)
        starts.sort()
    return starts


def _most_outward(
    fixed: list[int], kinds: list[int], lengths: list[float], turns: list[float]
) -> list[int]:
    """Return four starts, fixed ones among them, where the loop is bent outward most; or none.

    Of a smooth outline with a waist these are its four shoulders. No side gets two concave
    corners, for it has one cut only, and none is shorter than two pieces.
    """
    count = len(kinds)
    arc = np.cumsum([0.0, *lengths])
    way = np.abs(arc[:count, None] - arc[None, :count])
    way = np.minimum(way, arc[-1] - way) / arc[-1]
    around = np.exp(-0.5 * (way / SHOULDER) ** 2) @ np.array(turns)
    free = [k for k in np.argsort(-around).tolist() if kinds[k] == 0 and around[k] > 0.0]
    concave = np.cumsum([0, *(kind < 0 for kind in kinds), *(kind < 0 for kind in kinds)])
    best, most = [], -np.inf
    for more in itertools.combinations(free[:CANDIDATES], FEWEST + 1 - len(fixed)):
        starts = sorted((*fixed, *more))
        ends = [*starts[1:], starts[0] + count]
        pairs = list(zip(starts, ends, strict=True))
        if any(b - a < 2 or concave[b] - concave[a + 1] > 1 for a, b in pairs):
            continue
        shares = np.diff([arc[k] for k in starts], append=arc[starts[0]] + arc[-1]) / arc[-1]
        worth = float(around[list(more)].sum()) - EVEN * float(((shares - 0.25) ** 2).sum())
        if worth > most:
            best, most = starts, worth
    return best


def _quarters(start: int, count: int) -> list[int]:
    return sorted((start + count * quarter // 4) % count for quarter in range(4))


def _smoothest(kinks: Sequence[float], lengths: list[float]) -> int:
    """Return the piece whose start, and those of the quarters after it, are furthest from turns."""
    count = len(kinks)
    bent = [index for index in range(count) if abs(kinks[index]) > 0.0]
    if not bent:
        return 0
    arc = np.cumsum([0.0, *lengths])
    apart = np.abs(arc[:count, None] - arc[bent])
    room = np.minimum(apart, arc[-1] - apart).min(axis=1)
    quarters = (np.arange(count)[:, None] + count * np.arange(4) // 4) % count
    return int(np.argmax(room[quarters].min(axis=1)))


def _middle_of(
    choices: list[int], lengths: list[float], turns: list[float], low: int, high: int
) -> int:
    """Return the one of some piece starts that is nearest to the middle of a run.

    Places where the loop bends inward come last: a patch folds that has its corner there.
    """
    count = len(lengths)
    arc = np.cumsum([0.0] + [lengths[i % count] for i in range(low, high)])
    off = [
        (turns[index % count] < -INWARD, abs(arc[index - low] - 0.5 * arc[-1])) for index in choices
    ]
    return choices[min(range(len(choices)), key=off.__getitem__)]


def _cut_of(
    run: list[int], pieces: Sequence[SidePiece], kinds: list[int], kinks: Sequence[float]
) -> int:
    """Return the number of the piece of a run with which the second half of the side starts."""
    for number, index in enumerate(run):
        if number and kinds[index] < 0:
            return number
    arc = np.cumsum([pieces[index].piece.length for index in run])
    shares = arc / arc[-1] if arc[-1] > 0 else np.linspace(0.0, 1.0, len(run) + 1)[1:]
    costs = [
        abs(shares[number - 1] - 0.5) + (KINK_COST if abs(kinks[run[number]]) > KINK else 0.0)
        for number in range(1, len(run))
    ]
    return 1 + int(np.argmin(costs))
