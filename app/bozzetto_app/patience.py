"""Patience with plugins on the window's own thread, where alone widgets can be made.

Nobody else can wait for such a call, and the window stands still while it lasts. So it is
interrupted when it goes on for too long. What `bozzetto.plugin.watchdog` says about the
reach of that holds here too: one long call in C cannot be interrupted.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TypeVar

from bozzetto.plugin.guard import Guard, Overrun, PluginFault
from bozzetto.plugin.watchdog import interrupt

__all__ = ["in_time"]

PATIENCE = 2.0
"""Seconds a plugin may hold up the window."""

Answer = TypeVar("Answer")


def in_time(guard: Guard, modeler_id: str, what: str, call: Callable[[], Answer]) -> Answer:
    """Make a guarded call on this thread.

    Raises
    ------
    PluginFault
        If there was no answer in time.
    BaseException
        Whatever the call raises.
    """
    here, turn = threading.current_thread(), threading.Lock()
    ended = late = False

    def look() -> None:
        nonlocal late
        with turn:
            if not ended:
                late = True
                interrupt(here)

    timer = threading.Timer(PATIENCE, look)
    timer.daemon = True
    timer.start()
    details = ""
    try:
        try:
            return call()
        finally:
            with turn:
                ended = True
            timer.cancel()
    except Overrun:
        pass
    except PluginFault as fault:
        if not late:
            raise
        details = fault.details
    raise guard.blame(modeler_id, f"{what} gave no answer within {PATIENCE:g} s", details)
