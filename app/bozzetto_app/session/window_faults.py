"""Exceptions that nobody caught on the window's thread: told, logged, and whose they are.

Qt calls slots and event handlers of a plugin's panel itself, so no guard is around them. What they
raise comes to `sys.excepthook`; without this it would only be printed where nobody looks.
"""

from __future__ import annotations

import sys
import threading
import traceback
from collections.abc import Callable
from types import TracebackType
from typing import TYPE_CHECKING

from bozzetto.errors import Cancelled, UserError, message_of

if TYPE_CHECKING:
    from bozzetto.plugin.host.registry import Registry
    from bozzetto_app.session.session import Session

__all__ = ["owner_of", "watch_window_faults"]

OWN = "bozzetto_app"
TOOLKIT = "bozzetto_app.toolkit"
"""What plugins call themselves of the shell; it fails where they give it what it cannot use."""


def watch_window_faults(session: Session) -> Callable[[], None]:
    """Tell the person of exceptions that nobody caught, besides printing them.

    Those of a plugin are faults of it, until it is switched off for them; those of the program are
    told once for each place. A `UserError` is told as everywhere.

    Returns
    -------
    callable
        Ends it.
    """
    before, main = sys.excepthook, threading.main_thread()
    told: set[tuple[type[BaseException], str, int]] = set()

    def tell(
        kind: type[BaseException], problem: BaseException, trace: TracebackType | None
    ) -> None:
        if not isinstance(problem, Exception) or threading.current_thread() is not main:
            before(kind, problem, trace)
            return
        if isinstance(problem, Cancelled):
            return
        notices, registry = session.notices, session.registry
        if isinstance(problem, UserError):
            notices.complain(problem)
            return
        before(kind, problem, trace)
        modeler, guard = owner_of(trace, registry), registry.guard
        if not modeler:
            last = traceback.extract_tb(trace)[-1:]
            place = (kind, last[0].filename if last else "", (last[0].lineno or 0) if last else 0)
            if place not in told:
                told.add(place)
                notices.complain(problem)
            return
        if guard.is_off(registry.info(modeler).plugin):
            return  # told so often that it is switched off
        said = message_of(problem)
        what = f"its panel failed ({kind.__name__}{': ' if said else ''}{said})"
        details = "".join(traceback.format_exception(problem))
        notices.complain(guard.blame(modeler, what, details))

    sys.excepthook = tell

    def end() -> None:
        if sys.excepthook is tell:
            sys.excepthook = before

    return end


def owner_of(trace: TracebackType | None, registry: Registry) -> str:
    """Return a modeler of the plugin whose code an exception came from; "" for the program's own.

    It is the plugin that was called last, unless that called the shell, which failed then.
    """
    modeler_of = {info.folder.name: info.id for info in reversed(registry.modelers())}
    owner = ""
    while trace is not None:
        module = str(trace.tb_frame.f_globals.get("__name__", ""))
        package = module.partition(".")[0]
        if package in modeler_of:
            owner = modeler_of[package]
        elif package == OWN and not (module == TOOLKIT or module.startswith(f"{TOOLKIT}.")):
            owner = ""
        trace = trace.tb_next
    return owner
