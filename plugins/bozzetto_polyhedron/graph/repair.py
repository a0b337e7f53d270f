"""Take steps that make a draft likelier, until none does."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from bozzetto_polyhedron.graph.draft import Change, Draft
from bozzetto_polyhedron.graph.steps import steps

MOST_ROUNDS: Final = 12
"""Rounds after which a draft is left as it is."""

LEAST_GAIN: Final = 1e-6
"""Cost by which a step must at least be better."""


def repair(draft: Draft, checkpoint: Callable[[], None], beside: set[int] | None = None) -> int:
    """Change a draft in place until no step lowers its cost.

    In each round all steps are priced, then taken in the order of their gain, each only if
    it still is one. From the second round on, only steps beside what was changed are looked at.

    Parameters
    ----------
    draft : Draft
        Changed in place.
    checkpoint : callable
        Called between rounds; it may raise.
    beside : set of int, optional
        Only steps beside these corners in the first round; all without.

    Returns
    -------
    int
        How many steps were priced, which is what the time goes into.
    """
    priced = 0
    for _ in range(MOST_ROUNDS):
        checkpoint()
        found = []
        for change in steps(draft, beside):
            priced += 1
            gain = draft.price(change)
            if gain < -LEAST_GAIN:
                found.append((gain, change))
        if not found:
            break
        found.sort(key=lambda each: each[0])
        beside = set()
        for _, change in found:
            if draft.fits_now(change) and draft.price(change) < -LEAST_GAIN:
                beside |= concerned(draft, change)
                draft.apply(change)
    return priced


def concerned(draft: Draft, change: Change) -> set[int]:
    """Return the corners whose lines a change takes or brings.

    Parameters
    ----------
    draft : Draft
        Before the change.
    change : Change
        Not yet made.
    """
    gone = [draft.lines[key] for key in change.removed]
    return {corner for each in (*gone, *change.added) for corner in (each.start, each.stop)}
