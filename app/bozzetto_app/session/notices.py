"""What the program says to the person, and in which way."""

from __future__ import annotations

import logging
import traceback
from dataclasses import dataclass
from typing import Literal

from bozzetto.errors import UserError
from bozzetto.plugin.guard.guard import Guard, PluginFault
from bozzetto_app.i18n import tr
from bozzetto_app.workers.channel import Hung

__all__ = ["Notice", "notice_of", "slow_notice"]

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Notice:
    """Something to tell the person.

    Attributes
    ----------
    kind : {"hint", "info", "error", "fault", "slow"}
        "hint" is the next expected gesture; "error" is a `UserError`; "fault" a plugin's;
        "slow" is work that goes on for long and can be stopped.
    places : tuple of (x, y)
        Canvas positions to light up.
    plugin : str
        Id of the plugin at fault.
    details : str
        A traceback, for the Details button only.
    """

    kind: Literal["hint", "info", "error", "fault", "slow"]
    text: str
    places: tuple[tuple[float, float], ...] = ()
    plugin: str = ""
    details: str = ""


def notice_of(problem: BaseException, guard: Guard) -> Notice:
    """How a problem is told: each kind in its own way."""
    if isinstance(problem, Hung):
        caught = guard.caught_in(problem.thread)
        if caught is not None:
            modeler, what = caught
            problem = guard.suspect(modeler, f"{what} gave {problem}", problem.stack)
    if isinstance(problem, UserError):
        return Notice("error", problem.message, problem.places)
    if isinstance(problem, PluginFault):
        return Notice("fault", str(problem), plugin=problem.plugin, details=problem.details)
    if isinstance(problem, Hung):
        log.error("work gave %s\n%s", problem, problem.stack)
        return Notice("error", tr("Session", "This took too long and was given up. Try it again."))
    log.error("a bug in the program itself", exc_info=problem)
    return Notice(
        "fault",
        tr("Session", "Bozzetto made a mistake; your drawing is safe."),
        details="".join(traceback.format_exception(problem)),
    )


def slow_notice(problem: Hung, guard: Guard) -> Notice:
    """How work that goes on for long is told: it can be waited for, or stopped."""
    caught = guard.caught_in(problem.thread)
    if caught is None:
        return Notice("slow", tr("Session", "Still working. Esc stops it."))
    modeler, what = caught
    found = guard.suspect(modeler, f"{what} gave {problem}", problem.stack)
    words = tr(
        "Session",
        "Still working: {plugin} ({what}), for {seconds:g} s without a sign. Esc stops it.",
        plugin=found.plugin, what=what, seconds=problem.limit,
    )  # fmt: skip
    return Notice("slow", words, plugin=found.plugin, details=found.details)
