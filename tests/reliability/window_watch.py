"""What is noticed while a window is used by a program: pauses, exceptions, words of Qt, growth."""

from __future__ import annotations

import gc
import logging
import os
import sys
import threading
import time
import traceback
from collections import Counter
from dataclasses import asdict, dataclass, field
from pathlib import Path
from types import TracebackType
from typing import Final

from PySide6.QtCore import QEvent, QMessageLogContext, QtMsgType, qInstallMessageHandler
from PySide6.QtWidgets import QApplication

from bozzetto.native_heap import give_back
from bozzetto.plugin.guard.watchdog import stack_of

__all__ = ["Figures", "Problem", "Watch", "figures_now"]

HANG: Final = 2.0
"""Seconds without a turn of the event loop that count as a hang."""

CORES: Final = os.cpu_count() or 1

LOOK: Final = 0.1
"""Seconds between two looks at the window's thread."""

LONGEST: Final = 90.0
"""Seconds after which a window that hangs is given up, with the stacks of all threads."""

GIVEN_UP: Final = 3
"""Exit code of a process that was given up."""

QUIET: Final = (
    "This plugin does not support propagateSizeHints",
    "This plugin does not support raise",
    "This plugin does not support grabbing the",
    "This plugin does not support setting window opacity",
    "libEGL warning",
)
"""Beginnings of words of Qt that tell of the platform and not of the program."""


@dataclass(frozen=True)
class Problem:
    """Something that must not happen.

    Parameters
    ----------
    kind : {"exception", "fault", "hang", "qt"}
    action : int
        Number of the action during which it was noticed.
    text : str
        Its traceback, stack or words.
    """

    kind: str
    action: int
    text: str

    @property
    def headline(self) -> str:
        """The last line, which names it; of a hang the innermost place in the program, too."""
        lines = [line.strip() for line in self.text.splitlines() if line.strip()]
        if self.kind == "hang":
            own = [line for line in lines if "bozzetto" in line and line.startswith("File")]
            return f"{own[-1] if own else ''} {lines[-1]}"
        return lines[-1] if lines else ""


@dataclass(frozen=True)
class Figures:
    """What a process holds.

    Parameters
    ----------
    action : int
        After how many actions.
    memory : float
        Resident memory, MB.
    threads, native_threads : int
        Known to Python, and to the system.
    widgets : int
        Alive in Qt.
    files : int
        Open file handles.
    """

    action: int
    memory: float
    threads: int
    native_threads: int
    widgets: int
    files: int

    def as_dict(self) -> dict[str, float]:
        """Return the figures by name."""
        return asdict(self)


def figures_now(action: int) -> Figures:
    """Tidy up as the program does now and then, and measure; Linux only."""
    QApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete.value)
    gc.collect()
    give_back()
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return Figures(
        action,
        round(pages * os.sysconf("SC_PAGE_SIZE") / 1e6, 1),
        threading.active_count(),
        len(os.listdir("/proc/self/task")),
        len(QApplication.allWidgets()),
        len(os.listdir("/proc/self/fd")),
    )


@dataclass(eq=False)
class Watch:
    """Notices what goes wrong in this process from `begin` on.

    Attributes
    ----------
    action : int
        Number of the action under way; set by whoever acts.
    problems : list of Problem
        Different ones, the first of each.
    longest : float
        Longest time without a turn of the event loop, seconds.
    """

    action: int = 0
    problems: list[Problem] = field(default_factory=list)
    counts: Counter[str] = field(default_factory=Counter)
    longest: float = 0.0
    _beat: float = 0.0
    _ended: threading.Event = field(default_factory=threading.Event)

    def begin(self) -> None:
        """Listen to everything that tells of a fault."""
        sys.excepthook = self._uncaught
        threading.excepthook = lambda told: self._uncaught(
            told.exc_type, told.exc_value, told.exc_traceback
        )
        sys.unraisablehook = lambda told: self._uncaught(
            told.exc_type, told.exc_value, told.exc_traceback
        )
        qInstallMessageHandler(self._qt_said)
        logging.getLogger().addHandler(_Listener(self))
        self._window_thread = threading.current_thread()
        self._window_ident = threading.get_ident()
        self.beat()
        threading.Thread(target=self._look, name="watch", daemon=True).start()

    def end(self) -> None:
        """Stop looking at the window's thread."""
        self._ended.set()
        qInstallMessageHandler(None)

    def beat(self) -> None:
        """The event loop turns."""
        self._beat = time.monotonic()

    def note(self, kind: str, text: str) -> None:
        """Keep a problem, once of each."""
        problem = Problem(kind, self.action, text)
        known = f"{kind}: {problem.headline}"
        self.counts[known] += 1
        if self.counts[known] == 1:
            self.problems.append(problem)
            print(f"[{self.action}] {kind}: {text}", file=sys.stderr, flush=True)

    def _uncaught(
        self,
        kind: type[BaseException],
        problem: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.note("exception", "".join(traceback.format_exception(kind, problem, trace)))

    def _qt_said(self, kind: QtMsgType, context: QMessageLogContext, message: str) -> None:
        if kind != QtMsgType.QtDebugMsg and not message.startswith(QUIET):
            self.note("qt", message)

    def _look(self) -> None:
        """Count the time in which the window's thread could have turned its loop.

        On a machine that has more to do than it has cores for, a second of the clock counts
        as the part of it that this process can have had, but never as less than the window's
        thread computed.
        """
        waited, stood, told = 0.0, self._beat, False
        last, computed = time.monotonic(), self._window_time()
        while not self._ended.wait(LOOK):
            now, used = time.monotonic(), self._window_time()
            gap, last = now - last, now
            worked, computed = used - computed, used
            if self._beat != stood:
                waited, stood, told = 0.0, self._beat, False
                continue
            waited += max(worked, gap * min(1.0, CORES / max(os.getloadavg()[0], 0.01)))
            self.longest = max(self.longest, waited)
            if waited > HANG and not told:
                told = True
                self.note("hang", f"{stack_of(self._window_thread)}hang of more than {HANG:g} s")
            if waited > LONGEST:
                self.note("hang", f"{_stacks()}\ngiven up after {LONGEST:g} s")
                os._exit(GIVEN_UP)

    def _window_time(self) -> float:
        """Processor time of the window's thread, seconds."""
        return time.clock_gettime(time.pthread_getcpuclockid(self._window_ident))


class _Listener(logging.Handler):
    """Hears what the program writes to its log about its own and plugins' faults."""

    def __init__(self, watch: Watch) -> None:
        super().__init__(logging.WARNING)
        self._watch = watch

    def emit(self, record: logging.LogRecord) -> None:
        text = record.getMessage()
        if record.exc_info and record.exc_info[1] is not None:
            text += "\n" + "".join(traceback.format_exception(record.exc_info[1]))
        kind = "fault" if record.levelno >= logging.ERROR else "warning"
        self._watch.note(kind, text)


def _stacks() -> str:
    return "\n".join(f"{thread.name}:\n{stack_of(thread)}" for thread in threading.enumerate())
