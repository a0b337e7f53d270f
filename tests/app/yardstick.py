"""What the machine gives to anybody: a process that only sleeps, beside what is measured."""

from __future__ import annotations

import json
import subprocess
import sys

import numpy as np

STRETCH = 0.005
"""Seconds that it sleeps at a stretch."""

SLEEPER = """
import json, select, sys, time
pauses, last = [], time.perf_counter()
while not select.select([sys.stdin], [], [], 0)[0]:
    time.sleep(0.005)
    now = time.perf_counter()
    pauses.append(now - last)
    last = now
print(json.dumps(pauses))
"""
"""Sleeps 5 ms at a stretch until its input ends, and then says how long each took."""


class Yardstick:
    """Pauses of such a process while it is in use, as a context.

    A loaded machine takes its slices of time from it as from the window's. It is a process of
    its own: a thread would also be held up by whoever holds the interpreter, and that is the
    program's doing.
    """

    def __init__(self) -> None:
        self._pauses = np.zeros(1)

    def __enter__(self) -> Yardstick:
        self._process = subprocess.Popen(
            [sys.executable, "-I", "-S", "-c", SLEEPER],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
        )
        return self

    def __exit__(self, *problem: object) -> None:
        told, _ = self._process.communicate()
        self._pauses = np.array([*json.loads(told), 0.0])

    @property
    def longest(self) -> float:
        """The longest pause, s."""
        return float(self._pauses.max())

    @property
    def share(self) -> float:
        """How much of the time it gets that it asks for, 0 … 1."""
        return min(1.0, STRETCH * len(self._pauses) / float(self._pauses.sum()))

    def percentile(self, share: float) -> float:
        """A percentile of the pauses, s."""
        return float(np.percentile(self._pauses, share))
