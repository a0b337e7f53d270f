"""Word of a plugin's call that takes long, for who waits at a terminal."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from bozzetto.plugin.guard.guard import Guard

LATE_AFTER: Final = 60.0
"""Seconds after which a call is told, as in the window."""


def tell_slow_calls(
    guard: Guard,
    tell: Callable[[str], object],
    *,
    late_after: float = LATE_AFTER,
    every: float = 1.0,
) -> threading.Thread:
    """Tell of each call into a plugin that takes long, once, as long as the calling thread lives.

    Parameters
    ----------
    guard : Guard
        Through which plugins are called.
    tell : callable
        Gets a sentence, in another thread.
    late_after, every : float
        Seconds that a call may take, and between two looks.
    """
    caller = threading.current_thread()

    def watch() -> None:
        seen, since, told = None, 0.0, None
        while caller.is_alive():
            time.sleep(every)
            inside, now = guard.caught_in(caller), time.monotonic()
            if inside is not seen:
                seen, since = inside, now
            elif inside is not None and inside is not told and now - since >= late_after:
                told = inside
                modeler, what = inside
                tell(
                    f"still working: {modeler} ({what}), for {now - since:.0f} s. Ctrl+C stops it."
                )

    thread = threading.Thread(target=watch, name="bozzetto-slow-calls", daemon=True)
    thread.start()
    return thread
