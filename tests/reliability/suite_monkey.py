"""The window before a monkey.

Seeded runs of random use (see `monkey`) on each platform. A run that fails is named by platform,
seed and action, and can be played again:
``QT_QPA_PLATFORM=xcb python -m tests.reliability.monkey --seed 3 --actions 5000``.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Final

from tests.reliability.children import PLATFORMS, Outcome, is_possible, play
from tests.reliability.figures import Row
from tests.reliability.growth import has_grown, spread

SEEDS: Final = 20
ACTIONS: Final = 5000
"""Of a run; the last one of a share may be shorter."""

LEAST: Final = 60
"""Actions that even the smallest share has on each platform."""

WARM: Final = 1000
"""Actions after which a process holds what it needs."""

FLAT: Final = 0.10
"""By how much of its mean the memory may differ after that."""

START: Final = 120.0
PACE: Final = 1.0
"""Seconds that a process may take to start, and for an action on average, before it is ended."""


def rows(share: float, seed: int = 0) -> Iterator[Row]:
    """Play a share of the runs on every platform.

    Parameters
    ----------
    share : float
    seed : int
        The runs' own seeds are those after it.
    """
    for platform in PLATFORMS:
        if not is_possible(platform):
            yield Row(f"{platform}: no X server here", "left out")
            continue
        lengths = lengths_of(share)
        outcomes = [
            play(
                "monkey",
                ("--seed", str(number), "--actions", str(actions)),
                platform,
                START + PACE * actions,
                f"{platform} seed {number}",
            )
            for number, actions in enumerate(lengths, seed + 1)
        ]
        yield from rows_of(platform, lengths, outcomes)


def lengths_of(share: float) -> list[int]:
    """How many actions each seed gets."""
    total = max(LEAST, round(share * SEEDS * ACTIONS))
    full, rest = divmod(total, ACTIONS)
    return [ACTIONS] * full + ([rest] if rest else [])


def rows_of(platform: str, lengths: Sequence[int], outcomes: Sequence[Outcome]) -> Iterator[Row]:
    what = f"{platform}, {len(lengths)} seeds, {sum(lengths)} actions"
    died = [f"{one.name} at {one.last}" for one in outcomes if one.result is None]
    yield _counted(f"{what}: crashes", died)
    raised = [name for one in outcomes for name in one.of_kind("exception", "fault")]
    yield _counted(f"{what}: uncaught exceptions and faults of plugins", raised)
    hung = [name for one in outcomes for name in one.of_kind("hang")]
    yield _counted(f"{what}: pauses of more than 2 s", hung)
    long = [found for one in outcomes if len(found := one.figures(WARM)) > 1]
    if not long:
        return
    widest = max(spread([each["memory"] for each in found]) for found in long)
    promise = f"± {FLAT:.0%}"
    yield Row(
        f"{platform}: memory after the first {WARM} actions",
        f"± {math.ceil(1000 * widest) / 10:g} %",
        promise,
        kept=widest <= FLAT,
    )
    for name in ("threads", "widgets", "files"):
        grown = sum(has_grown([each[name] for each in found]) for found in long)
        yield Row(f"{platform}: runs in which {name} grow", str(grown), "0", kept=not grown)


def _counted(what: str, found: Sequence[str]) -> Row:
    """Return how many there were, and the names of the first."""
    names = f" ({', '.join(found[:3])})" if found else ""
    return Row(what, f"{len(found)}{names}", "0", kept=not found)
