"""A person's day.

An hour of work, document after document (see `soak`), without a rest: drawn or brought in,
corrected, turned, saved, exported, closed and opened again.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

from tests.reliability.children import PLATFORMS, Outcome, is_possible, play
from tests.reliability.figures import Row
from tests.reliability.growth import has_grown, spread

HOUR: Final = 3600.0

GRACE: Final = 300.0
"""Seconds that the last document may take after the day is over."""

WARM: Final = 0.25
"""Share of the documents after which a process holds what it needs."""

ENOUGH: Final = 8
"""Documents from which on growth can be told from chance."""

FLAT: Final = 0.10
"""By how much of its mean the memory may differ after that."""


def rows(share: float) -> Iterator[Row]:
    """Work a share of an hour, half of it on each platform that there is."""
    platforms = [platform for platform in PLATFORMS if is_possible(platform)]
    seconds = share * HOUR / len(platforms)
    for platform in platforms:
        arguments = ("--seconds", f"{seconds:g}")
        outcome = play("soak", arguments, platform, seconds + GRACE, platform)
        yield from rows_of(platform, seconds, outcome)


def rows_of(platform: str, seconds: float, outcome: Outcome) -> Iterator[Row]:
    figures = outcome.figures(0)
    what = f"{platform}, {seconds / 60:.1f} minutes"
    whole = outcome.result is not None and len(figures) > 1
    ended = f"{len(figures)} documents" if whole else f"died at {outcome.last}"
    yield Row(what, ended, "all of it", kept=whole)
    wrong = outcome.of_kind("exception", "fault", "hang")
    named = f"{len(wrong)} ({', '.join(wrong[:3])})" if wrong else "0"
    yield Row(f"{platform}: faults and pauses of more than 2 s", named, "0", kept=not wrong)
    later = figures[math.ceil(WARM * len(figures)) :]
    if len(later) < ENOUGH:
        return
    widest = spread([each["memory"] for each in later])
    yield Row(
        f"{platform}: memory after the first quarter",
        f"± {100 * widest:.1f} %",
        f"± {FLAT:.0%}",
        kept=widest <= FLAT,
    )
    for name in ("threads", "widgets", "files"):
        grows = has_grown([each[name] for each in later])
        yield Row(f"{platform}: {name}", "grow" if grows else "stay", "stay", kept=not grows)
