"""All classes of Qt, made on the window's thread before a worker asks for one."""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from time import monotonic
from typing import Final

from PySide6.QtCore import QObject, QTimer, Signal

__all__ = ["QtClasses"]

MODULES: Final = ("QtCore", "QtGui", "QtWidgets", "QtSvg", "QtOpenGLWidgets", "QtTest")
"""Those that pyqtgraph takes all classes of, or imports."""

SLICE: Final = 0.005
"""Seconds that the window's thread is held at a time."""


class QtClasses(QObject):
    """Makes them little by little, 200 ms of work in all.

    PySide makes a class when it is first asked for, and goes through a table of those to be made
    while Python code runs. Where a worker imports pyqtgraph, which asks for all of them, and the
    window happens to ask for another one meanwhile, the table changes below the worker, and the
    process may die.

    Signals
    -------
    made
        There is none left to be made.
    """

    made = Signal()

    def __init__(self, parent: QObject) -> None:
        super().__init__(parent)
        self._left: Iterator[None] = _classes()
        self._timer = QTimer(self)
        self._timer.timeout.connect(self._go_on)

    def start(self) -> None:
        """Begin; `made` comes later in any case."""
        self._timer.start()

    def _go_on(self) -> None:
        end = monotonic() + SLICE
        for _ in self._left:
            if monotonic() > end:
                return
        self._timer.stop()
        self.made.emit()


def _classes() -> Iterator[None]:
    """Make one class after another."""
    for name in MODULES:
        try:
            module = importlib.import_module(f"PySide6.{name}")
        except ImportError:  # pyqtgraph does without it
            continue
        for entry in dir(module):
            getattr(module, entry, None)
            yield
