"""Starting up: the window first, everything heavy after its first paint."""

from __future__ import annotations

import atexit
import faulthandler
import logging
import os
import sys
import threading
from collections.abc import Callable
from contextlib import ExitStack
from importlib import import_module
from pathlib import Path
from time import monotonic
from typing import Final, TextIO

from PySide6.QtCore import QEvent, QObject, QTimer
from PySide6.QtWidgets import QApplication

from bozzetto.cached_properties import cached_property
from bozzetto.native_heap import bound_heap
from bozzetto.plugin.host.registry import Registry
from bozzetto_app.application import Application
from bozzetto_app.main_window import Window
from bozzetto_app.paths import crash_log, log_file
from bozzetto_app.session.session import Session
from bozzetto_app.session.window_faults import watch_window_faults
from bozzetto_app.settings import ORGANISATION, PROGRAM, disabled_plugins, settings
from bozzetto_app.workers.gc_on_main_thread import Tidier
from bozzetto_app.workers.main_thread import call_on_main_thread

__all__ = ["application", "start"]

VIEWPORT = "view/backend"
FIRST_OBJECT = (
    "bozzetto.plugin.context",
    "bozzetto_app.panels.objects.part_row",
    "bozzetto_app.panels.properties.parameter_row",
)
"""Imported in a thread after the first paint: the first stroke and what comes of it show them."""

HEAVY = ("scipy.optimize", "scipy.spatial", "scipy.sparse.linalg", "shapely", "manifold3d")
"""Imported in a thread after the first paint, so that the first stroke need not wait."""

RECOVERY = "bozzetto_app.session.autosave"
"""Imported before them: what is drawn from then on survives a crash."""

LAST_MOMENT: Final = 1.0
"""How long a closed program waits for its threads at most, seconds; they stop within a tenth."""


def application() -> QApplication:
    """Return the one Qt application; make it if there is none."""
    existing = QApplication.instance()
    if isinstance(existing, QApplication):
        return existing
    bound_heap()
    app = Application(sys.argv[:1])
    app.setOrganizationName(ORGANISATION)
    app.setApplicationName(PROGRAM)
    app.setDesktopFileName("bozzetto")
    return app


def start(document: Path | None, *, plugins: bool = True) -> int:
    """Open the window and stay until it is closed.

    Parameters
    ----------
    document : Path, optional
        Opened at the start.
    plugins : bool
        False is the safe mode: no plugin is used.

    Returns
    -------
    int
        The process's exit code.
    """
    app = application()
    viewport = str(settings().value(VIEWPORT, "auto"))
    if viewport != "auto":
        os.environ.setdefault("BOZZETTO_VIEWPORT", viewport)
    crash_log = _log_to_disk()
    tidier = Tidier(app)
    session = Session(Registry(disabled=disabled_plugins(), no_plugins=not plugins))
    closing = ExitStack()
    closing.callback(watch_window_faults(session))
    window = Window(session)
    early = _early_interrupts(closing)
    paint = _FirstPaint(
        window, lambda: _after_first_paint(window, document, tidier, closing, early)
    )
    window.installEventFilter(paint)
    if document is not None:
        window.expect_document()
    window.show()
    with closing:
        code = app.exec()
    window.keeper.wait()
    if not _workers_end():
        atexit.register(_leave, code)
    faulthandler.disable()
    crash_log.close()
    return code


def _early_interrupts(closing: ExitStack) -> list[int]:
    """Return where Ctrl+C is noted until the event loop listens to it.

    An exception in the midst of the first paint would be printed by Qt, and forgotten.
    """
    import signal

    early: list[int] = []
    before = signal.signal(signal.SIGINT, lambda number, frame: early.append(number))
    closing.callback(signal.signal, signal.SIGINT, before)
    return early


def _workers_end() -> bool:
    """Wait a moment for threads that were asked to stop; return whether all of them have."""
    end = monotonic() + LAST_MOMENT
    workers = [each for each in threading.enumerate() if each.name.startswith("bozzetto-")]
    for thread in workers:
        thread.join(max(0.0, end - monotonic()))
    return not any(thread.is_alive() for thread in workers)


def _leave(code: int) -> None:
    """End the process with its threads, everything being written.

    A hung plugin must not keep a closed program alive, and an interpreter that is taken down
    under a thread in native code crashes now and then.
    """
    logging.shutdown()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)


class _FirstPaint(QObject):
    """Calls back once, when the window has been painted for the first time."""

    def __init__(self, window: Window, then: Callable[[], None]) -> None:
        super().__init__(window)
        self._then = then

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        if event.type() == QEvent.Type.Paint:
            watched.removeEventFilter(self)
            # The sheet is painted with the window, before the event loop turns.
            QTimer.singleShot(0, self._then)
        return False


def _after_first_paint(
    window: Window, document: Path | None, tidier: Tidier, closing: ExitStack, early: list[int]
) -> None:
    """Listen to Ctrl+C, and import in a thread what the first paint did not need, recovery first.

    Parameters
    ----------
    window : Window
        Closed by Ctrl+C.
    document : Path, optional
        Opened now.
    tidier : Tidier
        Told when everything is imported.
    closing : ExitStack
        Given what has to end with the event loop.
    early : list of int
        Not empty if there was a Ctrl+C before.
    """
    from bozzetto_app.interrupts import InterruptWatch

    closing.callback(InterruptWatch(window.close).close)
    if early:
        window.close()

    def import_heavy() -> None:
        import_module(RECOVERY)
        call_on_main_thread(window, window.offer_recovery)
        for name in (*FIRST_OBJECT, *HEAVY):
            import_module(name)
        call_on_main_thread(tidier, tidier.settle)

    threading.Thread(target=import_heavy, name="bozzetto-imports", daemon=True).start()
    if document is not None:
        window.session.files.open_safely(document)


class DiskLog(logging.Handler):
    """Writes to a rotating file, which is opened and whose module is imported for the first."""

    @cached_property
    def _file(self) -> logging.Handler:
        from logging.handlers import RotatingFileHandler

        # What a plugin says may hold half a character.
        handler = RotatingFileHandler(
            log_file(),
            maxBytes=1_000_000,
            backupCount=2,
            encoding="utf-8",
            errors="backslashreplace",
        )
        handler.setFormatter(logging.Formatter("%(asctime)s %(levelname)s %(name)s: %(message)s"))
        return handler

    def emit(self, record: logging.LogRecord) -> None:
        """Write a record down."""
        self._file.emit(record)

    def close(self) -> None:
        """Close the file, if there was something to write."""
        if "_file" in vars(self):
            self._file.close()
        super().close()


def _log_to_disk() -> TextIO:
    """Log faults to a rotating file; crashes of native code leave a traceback beside it."""
    logging.getLogger().addHandler(DiskLog())
    file = open(crash_log(), "a", encoding="utf-8")
    faulthandler.enable(file)
    return file
