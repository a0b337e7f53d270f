"""How slow this machine is, for promises that are meant in seconds of a usual one."""

from __future__ import annotations

import time

USUAL = 0.06
"""Seconds in which a usual machine adds a million squares in Python."""


def slowness() -> float:
    """Return how many times longer than a usual machine this one takes now; at least 1."""
    taken = []
    for _ in range(3):
        started = time.process_time()
        sum(i * i for i in range(10**6))
        taken.append(time.process_time() - started)
    return max(1.0, min(taken) / USUAL)
