"""Steps that cost something: what repairing step by step does not find.

Two steps together may be a gain although the first one costs something; and a step may cost little
and make the lines those of solids.
"""

from __future__ import annotations

from collections.abc import Callable
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


def with_detours(draft: Draft, checkpoint: Callable[[], None]) -> Draft:
    """Return a draft that is beyond doubt more than this one, if one or two steps lead there.

    Parameters
    ----------
    draft : Draft
        Repaired; not changed.
    checkpoint : callable
        Called between trials; it may raise.
    """
    left = MOST_TRIALS
    while True:
        whole, doubt = draft.is_whole, draft.doubt
        most = min(left, MOST_FROM_WHOLE if whole else MOST_FROM_ONE)
        for first in _first_steps(draft)[:most]:
            checkpoint()
            left -= 1
            found = _after(draft, first, whole)
            if found is None:
                continue
            repair(found[0], checkpoint, found[1])
            if found[0].doubt < doubt - LEAST_GAIN:
                draft = found[0]
                break
        else:
            return draft


def _first_steps(draft: Draft) -> list[Change]:
    """Return steps that cost something, the cheapest first, each outcome once."""
    found: dict[object, tuple[float, int, Change]] = {}
    for number, change in enumerate(steps(draft)):
        price = draft.price(change)
        if price < DEAREST:
            outcome = change.removed, frozenset((e.pair, e.line.members) for e in change.added)
            found.setdefault(outcome, (price, number, change))
    return [change for _, _, change in sorted(found.values(), key=lambda each: each[:2])]


def _after(draft: Draft, first: Change, whole: bool) -> tuple[Draft, set[int]] | None:
    """Return what a step makes of a draft, alone or with the best one beside it, if it is a gain.

    The second value are the corners beside which it is to be repaired.
    """
    made = draft.copied()
    beside = concerned(made, first)
    made.apply(first)
    if not whole and made.cost < draft.cost + NOT_WHOLE and made.is_whole:
        return made, set()
    best: Change | None = None
    least = draft.cost - made.cost - LEAST_GAIN
    for second in steps(made, beside):
        price = made.price(second)
        if price < least:
            best, least = second, price
    if best is None:
        return None
    beside |= concerned(made, best)
    made.apply(best)
    return made, beside & set(made.sums)
