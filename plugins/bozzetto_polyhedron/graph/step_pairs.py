"""Steps that cost something: what repairing step by step does not find.

Two steps together may be a gain although the first one costs something; and a step may cost little
and make the lines those of solids.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Final

from bozzetto_polyhedron.graph.draft import NOT_WHOLE, Change, Draft
from bozzetto_polyhedron.graph.repair import LEAST_GAIN, concerned, repair
from bozzetto_polyhedron.graph.steps import steps

DEAREST: Final = 30.0
"""Cost that the first step may add."""

MOST_TRIALS: Final = 45
"""First steps that are tried, at most."""

MOST_FROM_ONE: Final = 30
"""First steps that are tried from a draft that is not that of solids, the cheapest first."""

MOST_FROM_WHOLE: Final = 12
"""First steps that are tried from any other draft."""


def with_detours(
    draft: Draft, checkpoint: Callable[[], None], most_priced: int
) -> tuple[Draft, int]:
    """Return a draft that is beyond doubt more than this one, if one or two steps lead there.

    The second value is how many steps were priced.

    Parameters
    ----------
    draft : Draft
        Repaired; not changed.
    checkpoint : callable
        Called between trials; it may raise.
    most_priced : int
        Steps that are priced, after which none is tried any more.
    """
    left, priced = MOST_TRIALS, 0
    while priced < most_priced:
        whole, doubt = draft.is_whole, draft.doubt
        most = min(left, MOST_FROM_WHOLE if whole else MOST_FROM_ONE)
        every = list(steps(draft))
        priced += len(every)
        for first in _first_steps(draft, every)[:most]:
            if priced >= most_priced:
                break
            checkpoint()
            left -= 1
            made, beside, tried = _after(draft, first, whole)
            priced += tried
            if made is None:
                continue
            priced += repair(made, checkpoint, beside)
            if made.doubt < doubt - LEAST_GAIN:
                draft = made
                break
        else:
            break
    return draft, priced


def _first_steps(draft: Draft, every: Iterable[Change]) -> list[Change]:
    """Return those of all steps that cost something, the cheapest first, each outcome once."""
    found: dict[object, tuple[float, int, Change]] = {}
    for number, change in enumerate(every):
        price = draft.price(change)
        if price < DEAREST:
            outcome = change.removed, frozenset((e.pair, e.line.members) for e in change.added)
            found.setdefault(outcome, (price, number, change))
    return [change for _, _, change in sorted(found.values(), key=lambda each: each[:2])]


def _after(draft: Draft, first: Change, whole: bool) -> tuple[Draft | None, set[int], int]:
    """Return what a step makes of a draft, alone or with the best one beside it, if it is a gain.

    The other values are the corners beside which it is to be repaired, and how many steps beside it
    were priced.
    """
    made = draft.copied()
    beside = concerned(made, first)
    made.apply(first)
    if not whole and made.cost < draft.cost + NOT_WHOLE and made.is_whole:
        return made, set(), 0
    best: Change | None = None
    least = draft.cost - made.cost - LEAST_GAIN
    priced = 0
    for second in steps(made, beside):
        priced += 1
        price = made.price(second)
        if price < least:
            best, least = second, price
    if best is None:
        return None, beside, priced
    beside |= concerned(made, best)
    made.apply(best)
    return made, beside & set(made.sums), priced
