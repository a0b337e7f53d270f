"""How the benchmarks measure: medians after a warm-up, alternatives in turn in one run."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass

__all__ = ["Row", "in_turn", "median_ms", "processor_ms"]


@dataclass(frozen=True)
class Row:
    """One line of the table.

    Attributes
    ----------
    room : str
        Part of the program.
    what : str
        What was timed.
    measured : float
        Median, in `unit`.
    unit : str
    budget : str
        What the issue asks for, as text; "" where it asks for nothing.
    alternative : str
        What a person would use instead, timed in the same run; "" where there is none.
    other : float
        The alternative's median, in `unit`.
    """

    room: str
    what: str
    measured: float
    unit: str = "ms"
    budget: str = ""
    alternative: str = ""
    other: float = float("nan")

    def cells(self) -> tuple[str, ...]:
        """The row as text."""
        ratio = f"{self.other / self.measured:.1f}×" if self.alternative else ""
        other = f"{self.alternative}: {self.other:.3g} {self.unit}" if self.alternative else ""
        return self.room, self.what, f"{self.measured:.3g} {self.unit}", self.budget, other, ratio


def median_ms(work: Callable[[], object], *, repeats: int = 7, warm_up: int = 1) -> float:
    """Median time of a call, milliseconds."""
    return in_turn(work, repeats=repeats, warm_up=warm_up)[0]


def processor_ms(work: Callable[[], object], *, repeats: int = 7, warm_up: int = 1) -> float:
    """Median processor time of a call, milliseconds: what other programs do hardly matters."""
    times = []
    for turn in range(warm_up + repeats):
        start = time.process_time()
        work()
        if turn >= warm_up:
            times.append(1000.0 * (time.process_time() - start))
    return statistics.median(times)


def in_turn(*works: Callable[[], object], repeats: int = 7, warm_up: int = 1) -> list[float]:
    """Median times of several calls, taken in turn so that a drifting machine is fair."""
    times: list[list[float]] = [[] for _ in works]
    for turn in range(warm_up + repeats):
        for work, kept in zip(works, times, strict=True):
            start = time.perf_counter()
            work()
            spent = 1000.0 * (time.perf_counter() - start)
            if turn >= warm_up:
                kept.append(spent)
    return [statistics.median(kept) for kept in times]
