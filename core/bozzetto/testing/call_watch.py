"""A watch over calls into a plugin: one that gives no answer for long is interrupted, and named."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Final
from weakref import WeakSet

from bozzetto.awake_time import awake_time
from bozzetto.plugin.guard.guard import Guard
from bozzetto.plugin.guard.watchdog import GRACE, REPEAT, interrupt, stack_of

LONGEST_CALL: Final = 120.0
"""Seconds that one call may take; what the program asks for comes within a few, on any machine."""

LOOK: Final = 0.2
"""Seconds between two looks at what a check is in."""


class Unanswered(Exception):
    """A call into a plugin gave no answer in time.

    Parameters
    ----------
    message : str
        Which one, and for how long, without a full stop.
    details : str
        Where it was then, as a traceback.
    """

    def __init__(self, message: str, details: str) -> None:
        super().__init__(message)
        self.message = message
        self.details = details


class CallWatch:
    """Runs checks in a thread, and looks at how long each call into a plugin takes.

    Parameters
    ----------
    limit : float, optional
        Seconds; by default `LONGEST_CALL`.
    """

    def __init__(self, limit: float | None = None) -> None:
        self._limit = LONGEST_CALL if limit is None else limit
        self._guards: WeakSet[Guard] = WeakSet()

    def add(self, guard: Guard) -> None:
        """Watch the calls of a guard, too."""
        self._guards.add(guard)

    def run(self, check: Callable[[], None]) -> None:
        """Run a check; what it raises is raised here.

        Raises
        ------
        Unanswered
            If a call into the plugin gives no answer in time. A thread that is in native code
            cannot be stopped and is left behind.
        """
        problems: list[BaseException] = []
        ended = threading.Event()

        def work() -> None:
            try:
                check()
            except BaseException as problem:
                problems.append(problem)
            finally:
                ended.set()

        thread = threading.Thread(target=work, name="bozzetto-check", daemon=True)
        thread.start()
        call, since = self._call_of(thread), awake_time()
        while not ended.wait(LOOK):
            now = self._call_of(thread)
            if now is not call:
                call, since = now, awake_time()
            elif call is not None and awake_time() - since > self._limit:
                details = stack_of(thread)
                _stop(thread, ended)
                raise Unanswered(f"{call[1]} gave no answer for {self._limit:g} s", details)
        if problems:
            raise problems[0]

    def _call_of(self, thread: threading.Thread) -> tuple[str, str] | None:
        """Return the call that a thread is in: the same object as long as it is in the same."""
        calls = (guard.caught_in(thread) for guard in tuple(self._guards))
        return next((call for call in calls if call is not None), None)


def _stop(thread: threading.Thread, ended: threading.Event) -> None:
    until = awake_time() + GRACE
    while not ended.is_set() and awake_time() < until:
        interrupt(thread)
        ended.wait(REPEAT)
