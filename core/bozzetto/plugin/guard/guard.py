"""The guard: every call into a plugin passes here, and no error of a plugin gets past it.

Whatever goes wrong inside becomes a `PluginFault` that names the plugin and keeps the
traceback; arguments that a plugin wrote to are put back; a plugin that failed three times
is switched off until the program is started again. To be slow is no fault.
"""

from __future__ import annotations

import logging
import threading
import traceback
from collections import Counter
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

from bozzetto.errors import Cancelled, Unfinished, UserError, message_of

if TYPE_CHECKING:
    from bozzetto.plugin.guard.argument_snapshot import ArgumentSnapshot

log = logging.getLogger("bozzetto.plugin")

MOST_FAULTS = 3
"""Faults in one session after which a plugin is switched off."""

LONGEST_DETAILS = 100_000
"""Characters of a traceback that are kept."""

Answer = TypeVar("Answer")


class PluginFault(Exception):
    """A plugin did something it must not do. The document is as it was.

    Parameters
    ----------
    plugin : str
        Id of the plugin.
    what : str
        What happened, in words, without a full stop: "solve failed (ValueError: …)".
    details : str
        The traceback, for the log and the plugin's author.
    name : str, optional
        What the plugin is called in words; its id if absent.
    """

    said = "made a mistake"

    def __init__(self, plugin: str, what: str, details: str = "", name: str = "") -> None:
        super().__init__(f"The plugin {name or plugin} {self.said}: {what}.")
        self.plugin = plugin
        self.what = what
        self.details = details


class PluginSlow(PluginFault):
    """A plugin gave no answer in time; that may be the machine, and does not count as a fault."""

    said = "is slow"


class Overrun(BaseException):
    """Raised by `watchdog.interrupt` inside a call that takes too long.

    Not an `Exception`, so that a plugin's ``except Exception`` does not swallow it.
    """


class Guard:
    """The border between the program and its plugins; usable from any thread.

    Parameters
    ----------
    plugin_of : callable
        Gives the id of the plugin that a modeler belongs to.
    name_of : callable
        Gives what a plugin of some id is called in messages.
    """

    def __init__(
        self, plugin_of: Callable[[str], str] = str, name_of: Callable[[str], str] = str
    ) -> None:
        self._plugin_of, self._name_of = plugin_of, name_of
        self._faults: Counter[str] = Counter()
        self._lock = threading.Lock()
        self._inside: dict[threading.Thread, tuple[str, str]] = {}

    # -- calling --------------------------------------------------------------------------

    def call(
        self, modeler_id: str, what: str, function: Callable[..., Answer], *arguments: Any
    ) -> Answer:
        """Call a plugin's function.

        Parameters
        ----------
        modeler_id : str
            Whose function it is.
        what : str
            Its name, for messages.
        function : callable
            The plugin's function.
        *arguments
            Frozen values; what the plugin changes in them is put back.

        Raises
        ------
        UserError, Unfinished, Cancelled
            As the function says; also `UserError` if the plugin is switched off.
        PluginFault
            If the function fails in any other way, refuses without a word, or changed an argument.
        """
        plugin = self._plugin_of(modeler_id)
        self.refuse_if_off(plugin)
        from bozzetto.plugin.guard.argument_snapshot import ArgumentSnapshot  # no call, no numpy

        before = ArgumentSnapshot(arguments)
        here = threading.current_thread()
        around = self._inside.get(here)
        self._inside[here] = (modeler_id, what)
        try:
            answer = function(*arguments)
        except (UserError, Unfinished, Cancelled, KeyboardInterrupt) as problem:
            self._put_back(plugin, what, before)
            if isinstance(problem, UserError | Unfinished) and not message_of(problem):
                kind = type(problem).__name__
                reason = f"{what} refused without a word ({kind} needs a message)"
                raise self._fault(plugin, reason, _traceback_of(problem)) from None
            raise
        except PluginFault:  # of a scene that was made inside this call: told and counted there
            before.restore()
            raise
        except Overrun as overrun:
            # Not counted here: the one who waited for the answer says so (`blame`).
            before.restore()
            reason = f"{what} did not answer in time"
            details = _traceback_of(overrun)
            raise PluginSlow(plugin, reason, details, self._name_of(plugin)) from None
        except BaseException as problem:
            before.restore()
            name = type(problem).__name__
            said = message_of(problem)
            reason = f"{what} failed ({name}{': ' if said else ''}{said})"
            raise self._fault(plugin, reason, _traceback_of(problem)) from None
        finally:
            if around is None:
                del self._inside[here]
            else:
                self._inside[here] = around
        self._put_back(plugin, what, before)
        return answer

    def caught_in(self, thread: threading.Thread) -> tuple[str, str] | None:
        """Return the modeler's function that a thread is in, as given to `call`, or None."""
        return self._inside.get(thread)

    def _put_back(self, plugin: str, what: str, before: ArgumentSnapshot) -> None:
        changed = before.restore()
        if changed:
            raise self._fault(
                plugin, f"{what} changed its argument ({', '.join(changed[:5])})"
            ) from None

    def check(self, modeler_id: str, what: str, check: Callable[[], Answer]) -> Answer:
        """Return what came back from a plugin, checked.

        Parameters
        ----------
        modeler_id : str
            Who made it.
        what : str
            The function that made it, for messages.
        check : callable
            Returns it, or raises where it cannot be used.

        A state of the document that it was made from, `before`, saves time; see
        `check_encodable`.

        Raises
        ------
        PluginFault
            If it cannot be used. A broken object may fail in any way when it is read.
        """
        try:
            return check()
        except Exception as problem:
            said = message_of(problem)
            raise self._fault(
                self._plugin_of(modeler_id),
                f"{what} gave what cannot be used ({said})",
                _traceback_of(problem),
            ) from None

    # -- faults --------------------------------------------------------------------------------

    def blame(self, modeler_id: str, what: str, details: str = "") -> PluginFault:
        """Record a fault that was seen from outside, such as a call that never answers."""
        return self._fault(self._plugin_of(modeler_id), what.rstrip("."), details)

    def suspect(self, modeler_id: str, what: str, details: str = "") -> PluginSlow:
        """Tell of a call that gave no answer in time, without counting it as a fault.

        A slow machine is nobody's fault, and from outside it cannot be told from a plugin that
        hangs; only what a plugin did counts towards switching it off.
        """
        plugin = self._plugin_of(modeler_id)
        found = PluginSlow(plugin, what.rstrip("."), _last(details), self._name_of(plugin))
        log.warning("%s\n%s", found, found.details)
        return found

    def faults(self, plugin_id: str) -> int:
        """Count the failures of a plugin in this session."""
        return self._faults[plugin_id]

    def is_off(self, plugin_id: str) -> bool:
        """Whether a plugin failed so often that it is switched off until the next start."""
        return self._faults[plugin_id] >= MOST_FAULTS

    def refuse_if_off(self, plugin_id: str) -> None:
        """Raise `UserError` if a plugin is switched off."""
        if self.is_off(plugin_id):
            raise UserError(
                f"The plugin {self._name_of(plugin_id)} failed {MOST_FAULTS} times and is "
                "switched off. "
                "Save your work and start the program again to use it."
            )

    def _fault(self, plugin: str, what: str, details: str = "") -> PluginFault:
        fault = PluginFault(plugin, what, _last(details), self._name_of(plugin))
        with self._lock:
            self._faults[plugin] += 1
        log.error("%s\n%s", fault, fault.details)
        return fault


def _last(details: str) -> str:
    return details[-LONGEST_DETAILS:]


def _traceback_of(problem: BaseException) -> str:
    return "".join(traceback.format_exception(problem))
