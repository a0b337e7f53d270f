"""Patience with plugins on the window's own thread, where alone widgets can be made.

Nobody else can wait for such a call, and the window stands still while it lasts. So it is
interrupted when it goes on for too long. What `bozzetto.plugin.guard.watchdog` says about the
reach of that holds here too: one long call in C cannot be interrupted.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import TypeVar

from bozzetto.awake_time import awake_time
from bozzetto.plugin.guard.guard import Guard, Overrun, PluginFault
from bozzetto.plugin.guard.watchdog import interrupt

__all__ = ["in_time"]

PATIENCE = 2.0
"""Seconds a plugin may hold up the window."""

LOOK = 0.1
"""Time between two looks at the clock while calls are made, s."""

IDLE = 5.0
"""Seconds without a call after which nobody looks at the clock any more."""

Answer = TypeVar("Answer")


class _Watched:
    """A call that must end in time."""

    def __init__(self, thread: threading.Thread, until: float) -> None:
        self.until = until
        self.late = self.ended = False
        self._thread = thread
        self._turn = threading.Lock()

    def end(self) -> None:
        """Note that it ended; it is not interrupted after this."""
        with self._turn:
            self.ended = True

    def interrupt(self) -> None:
        """Stop it, unless it has ended."""
        with self._turn:
            if not self.ended:
                self.late = self.ended = True
                interrupt(self._thread)


class _Alarm:
    """One thread that looks at the clock for all calls.

    A timer for each call would start a thread for each tick of a slider, and wait for it.
    """

    def __init__(self) -> None:
        self._calls: list[_Watched] = []
        self._lock = threading.Lock()
        self._looks = False

    def set(self, call: _Watched) -> None:
        """Look after one more call."""
        with self._lock:
            self._calls = [known for known in self._calls if not known.ended]
            self._calls.append(call)
            if self._looks:
                return
            self._looks = True
        threading.Thread(target=self._look, name="bozzetto-patience", daemon=True).start()

    def _look(self) -> None:
        while True:
            time.sleep(LOOK)
            now = awake_time()
            with self._lock:
                calls = list(self._calls)
                if all(call.ended and now - call.until > IDLE for call in calls):
                    self._looks = False
                    return
            for call in calls:
                if now > call.until:
                    call.interrupt()


_alarm = _Alarm()


def in_time(guard: Guard, modeler_id: str, what: str, call: Callable[[], Answer]) -> Answer:
    """Make a guarded call on this thread.

    Raises
    ------
    PluginFault
        If there was no answer in time.
    BaseException
        Whatever the call raises.
    """
    watched = _Watched(threading.current_thread(), awake_time() + PATIENCE)
    _alarm.set(watched)
    details = ""
    try:
        try:
            return call()
        finally:
            watched.end()
    except Overrun:
        pass
    except PluginFault as fault:
        if not watched.late:
            raise
        details = fault.details
    raise guard.suspect(modeler_id, f"{what} gave no answer within {PATIENCE:g} s", details)
