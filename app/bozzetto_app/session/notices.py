"""Messages to the person: news, errors and faults of plugins."""

from __future__ import annotations

import logging
import traceback
from threading import Thread
from typing import Literal, NamedTuple
from weakref import WeakSet

from PySide6.QtCore import QObject, Signal

from bozzetto.errors import UserError
from bozzetto.plugin.guard.guard import Guard, PluginFault
from bozzetto_app.i18n import tr
from bozzetto_app.workers.channel import Channel, Hung

__all__ = ["Notice", "Notices"]

log = logging.getLogger(__name__)


class Notice(NamedTuple):
    """A message to the person.

    Attributes
    ----------
    kind : {"info", "error", "fault", "slow"}
        "error" is a `UserError`; "fault" a plugin's; "slow" is work that takes long and can be
        stopped.
    text : str
    places : tuple of (x, y)
        Canvas positions to highlight, pixels.
    plugin : str
        Id of the plugin at fault.
    details : str
        A traceback, for the Details button only.
    """

    kind: Literal["info", "error", "fault", "slow"]
    text: str
    places: tuple[tuple[float, float], ...] = ()
    plugin: str = ""
    details: str = ""


class Notices(QObject):
    """Sends messages to the window.

    Signals
    -------
    noticed : Notice
    caught_up
        Work that was told as slow has ended.
    """

    noticed = Signal(object)
    caught_up = Signal()

    def __init__(self, guard: Guard, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._guard = guard
        self._gathered: list[Notice] | None = None
        self._named: WeakSet[Thread] = WeakSet()

    def gather(self) -> None:
        """Keep news and errors until `tell_gathered`: of many at once only the last is read."""
        self._gathered = []

    def tell_gathered(self) -> None:
        """Report all errors that were kept, as one, or else all news."""
        kept, self._gathered = self._gathered or [], None
        errors = [notice for notice in kept if notice.kind == "error"]
        told = errors or kept
        if told:
            words = dict.fromkeys(notice.text for notice in told)
            self.send(told[0]._replace(text=" ".join(words)))

    def send(self, notice: Notice) -> None:
        """Report what a notice says."""
        if self._gathered is None or notice.kind not in ("info", "error"):
            self.noticed.emit(notice)
        else:
            self._gathered.append(notice)

    def tell(self, text: str) -> None:
        """Report a success."""
        self.send(Notice("info", text))

    def say_nothing_changed(self, why: str) -> None:
        """Report that a request changed nothing, and why or what to do instead."""
        self.complain(UserError(tr("Session", "Nothing changed. {why}", why=why).strip()))

    def complain(self, problem: BaseException) -> None:
        """Report a problem, in the way that suits its type."""
        self.send(self.of_problem(problem))

    def watch(self, channel: Channel) -> None:
        """Report when work on a channel takes long, until it has ended."""
        channel.slow.connect(self._tell_slow)
        channel.caught_up.connect(self.caught_up)

    def _tell_slow(self, problem: Hung) -> None:
        """Report that work takes long and can be stopped, and whose it is as soon as that is seen.

        On a crowded machine the time is up before the worker has come to the plugin.
        """
        caught = self._guard.caught_in(problem.thread)
        if problem.is_again and (caught is None or problem.thread in self._named):
            return
        self._named.discard(problem.thread)
        if caught is None:
            words = tr("Session", "Still working. Esc stops it.")
            self.send(Notice("slow", words))
            return
        self._named.add(problem.thread)
        modeler, what = caught
        found = self._guard.suspect(modeler, f"{what} gave {problem}", problem.stack)
        words = tr(
            "Session", "Still working: {plugin} ({what}). Esc stops it.",
            plugin=found.plugin, what=what,
        ) if problem.is_again else tr(
            "Session",
            "Still working: {plugin} ({what}) has not answered for {seconds:g} s. Esc stops it.",
            plugin=found.plugin, what=what, seconds=problem.limit,
        )  # fmt: skip
        self.send(Notice("slow", words, plugin=found.plugin, details=found.details))

    def of_problem(self, problem: BaseException) -> Notice:
        """Return the message for an exception; bugs and hung work are logged as well."""
        if isinstance(problem, Hung):
            caught = self._guard.caught_in(problem.thread)
            if caught is not None:
                modeler, what = caught
                problem = self._guard.suspect(modeler, f"{what} gave {problem}", problem.stack)
        if isinstance(problem, UserError):
            return Notice("error", problem.message, problem.places)
        if isinstance(problem, PluginFault):
            return Notice("fault", str(problem), plugin=problem.plugin, details=problem.details)
        if isinstance(problem, Hung):
            log.error("work gave %s\n%s", problem, problem.stack)
            words = tr("Session", "This took too long and was stopped. Try it again.")
            return Notice("error", words)
        log.error("a bug in the program itself", exc_info=problem)
        return Notice(
            "fault",
            tr("Session", "Bozzetto made a mistake; your drawing is safe."),
            details="".join(traceback.format_exception(problem)),
        )
