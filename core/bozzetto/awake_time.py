"""A clock for time limits, which stands still while the process does.

A laptop that sleeps, a virtual machine that is paused, Ctrl+Z and a debugger stop all threads at
once; depending on the system the monotonic clock goes on meanwhile. Nobody was slow then: a limit
that went by that clock would end every call that happened to be running, and blame its plugin.
"""

from __future__ import annotations

import threading
import time
from typing import Final

__all__ = ["awake_time", "wait_awake"]

GAP: Final = 1.0
"""Seconds that count at most between two looks at the clock."""

LOOK: Final = 0.2
"""Seconds between two looks while something is waited for."""


class _Clock:
    """The time that has passed while somebody looked."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._seen = time.monotonic()
        self._passed = 0.0

    def now(self) -> float:
        """Return it, in s."""
        with self._lock:
            now = time.monotonic()
            self._passed += min(max(now - self._seen, 0.0), GAP)
            self._seen = now
            return self._passed


_clock = _Clock()


def awake_time() -> float:
    """Return the seconds for which the process has run.

    Only differences mean something, and only to who looks at least once in `GAP` from the
    beginning of what is measured to its end: of a longer time without any look no more counts.
    """
    return _clock.now()


def wait_awake(event: threading.Event, seconds: float) -> bool:
    """Wait for an event as `threading.Event.wait` does, by this clock.

    Parameters
    ----------
    event : threading.Event
        What is waited for.
    seconds : float
        The longest wait.

    Returns
    -------
    bool
        Whether the event has happened.
    """
    until = awake_time() + seconds
    while not event.is_set():
        left = until - awake_time()
        if left <= 0.0:
            return False
        event.wait(min(left, LOOK))
    return True
