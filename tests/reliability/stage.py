"""A real window in a process of its own, used by a script while it is watched."""

from __future__ import annotations

import faulthandler
import json
import os
import shutil
import sys
import tempfile
import threading
import time
import traceback
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Final

from tests.conftest import move_home

__all__ = ["Script", "Stage", "perform"]

CLEARED: Final = 3
"""Times that the sheet is cleared before a measurement: what arrives late asks again."""

SIZE: Final = (1200, 800)
"""Of the window while it is measured, pixels."""

PATIENCE: Final = 4.0
"""Seconds that each of these waits for the window's work at most."""

STUCK: Final = 4.0
"""Seconds after which a menu or dialog that holds up an action is closed."""

WORKERS: Final = "bozzetto-"
"""Beginning of the names of the program's threads."""

LASTING: Final = frozenset({"bozzetto-journal"})
"""Threads that live as long as the window."""

LONGEST_REST: Final = 90.0
"""Seconds that a measurement waits for the workers at most: work that does not listen when it is
cancelled is interrupted after sixty."""

TURN: Final = 20
"""Time between two signs of life of the event loop, ms."""

NEWS: Final = frozenset({"qt", "warning"})
"""Kinds of problems that are told, but are no faults."""

Script = Iterator[float]
"""Does a thing between two yields; each yield says how many seconds to wait for the work."""


class Stage:
    """The application, its window and what is noticed of them.

    Parameters
    ----------
    folder : Path
        Where this process keeps everything.
    log : Path
        Names the action under way, for those who look after a crash.
    """

    def __init__(self, folder: Path, log: Path) -> None:
        from PySide6.QtCore import QTimer

        from bozzetto_app.startup import application
        from bozzetto_app.workers.gc_on_main_thread import Tidier
        from tests.reliability.window_watch import Watch

        self.folder = folder
        self.recovery = folder / "recovery"
        self.app = application()
        self.app.setQuitOnLastWindowClosed(False)
        self.tidier = Tidier(self.app)
        self.watch = Watch()
        self.window: Any = None
        self.figures: list[dict[str, float]] = []
        self._log = open(log, "w", encoding="utf-8")
        self._began = self._calm_by = 0.0
        self._rests = False
        # One timer for all: each single shot at a method leaves something behind.
        self._next = QTimer(singleShot=True)
        self._next.timeout.connect(self._go_on)
        self._turns = QTimer(interval=TURN)
        self._turns.timeout.connect(self._turned)
        self._script: Script = iter(())

    def open_window(self) -> None:
        """Close the window for good, if there is one, and open another."""
        from bozzetto.plugin.host.registry import Registry
        from bozzetto_app.main_window import Window
        from bozzetto_app.session.session import Session

        old, self.window = self.window, Window(Session(Registry()), self.recovery)
        if old is not None:
            if old.isVisible():
                old.close_without_asking()
            old.deleteLater()
            old.session.deleteLater()
        self.window.show()

    def clear(self) -> None:
        """Close every dialog and menu, and put an empty sheet on the table."""
        for widget in self.app.topLevelWidgets():
            if widget is not self.window and widget.isVisible():
                widget.close()
        self.window.session.cancel_all()
        self.window.session.files.new()

    def do(self, number: int, name: str, action: Callable[[], object]) -> None:
        """Do something under a number and a name; what it raises is noted."""
        self.watch.action = number
        self._began = time.monotonic()
        self._log.seek(0)
        self._log.write(f"{number} {name}".ljust(60))
        self._log.flush()
        try:
            action()
        except Exception:
            self.watch.note("exception", traceback.format_exc())
        if not self.window.isVisible():
            self.open_window()

    def measure(self, number: int) -> Script:
        """Clear the sheet, wait until no worker works, and keep what the process holds then.

        What a solve holds that was cancelled, but does not listen yet, is no growth; nor are the
        pictures of a larger window.
        """
        from tests.reliability.window_watch import figures_now

        for _ in range(CLEARED):
            self.clear()
            if not self.window.isVisible():  # it closed since the last action; it is over
                self.open_window()
            self.window.showNormal()
            self.window.resize(*SIZE)
            yield PATIENCE
        self._rests = True
        yield LONGEST_REST
        self._rests = False
        self.figures.append(figures_now(number).as_dict())
        print(f"… {self.figures[-1]}", file=sys.stderr, flush=True)

    def run(self, script: Script) -> dict[str, Any]:
        """Play a script in the event loop; return what was noticed."""
        self.watch.begin()
        self._turns.start()
        self.open_window()
        self._script = script
        self._go_on()
        self.app.exec()
        self.watch.end()
        return {
            "platform": self.app.platformName(),
            "longest_pause": round(self.watch.longest, 2),
            "problems": [
                {"kind": one.kind, "action": one.action, "text": one.text}
                for one in self.watch.problems
            ],
            "figures": self.figures,
        }

    def _go_on(self) -> None:
        """Let the script go on, if the window is ready or was waited for long enough."""
        if self._is_busy() and time.monotonic() < self._calm_by:
            self._next.start(3)
            return
        try:
            patience = next(self._script)
        except StopIteration:
            self.app.quit()
            return
        self._calm_by = time.monotonic() + patience
        self._next.start(0)

    def _is_busy(self) -> bool:
        """Whether the window has work; at a measurement, whether any worker lives."""
        busy = bool(self.window.session.busy or self.window.keeper.busy)
        if self._rests and not busy:
            names = {thread.name for thread in threading.enumerate()} - LASTING
            busy = any(name.startswith(WORKERS) for name in names)
        return busy

    def _turned(self) -> None:
        self.watch.beat()
        if time.monotonic() - self._began > STUCK:
            self._began = time.monotonic()
            front = self.app.activePopupWidget() or self.app.activeModalWidget()
            if front is not None:
                front.close()


def perform(play: Callable[[Stage], dict[str, Any]], log: Path | None) -> None:
    """Play in a home of our own, print the result as JSON, and end the process.

    Its code is 1 if something went wrong. Threads of workers may still run: what is looked at
    is the window, not its end.
    """
    faulthandler.enable()
    with tempfile.TemporaryDirectory(prefix="bozzetto-stage-") as name:
        folder = Path(name)
        os.environ.update(move_home(folder))
        result = play(Stage(folder, log or folder / "log"))
        print(json.dumps(result), flush=True)
        wrong = any(problem["kind"] not in NEWS for problem in result["problems"])
        shutil.rmtree(folder, ignore_errors=True)
        os._exit(1 if wrong else 0)
