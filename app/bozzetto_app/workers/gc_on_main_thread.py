"""Tidying: cyclic garbage is collected on the window's thread and nowhere else.

Python's collector runs in whichever thread happens to allocate. In a worker it would
destroy forgotten Qt objects there, and Qt objects die only on the thread they live in:
anything else is a crash without a traceback.
"""

from __future__ import annotations

import gc

from PySide6.QtCore import QObject, QTimer

__all__ = ["Tidier"]

INTERVAL = 1000
"""Time between two looks at the garbage, ms."""


class Tidier(QObject):
    """Does the collector's work, by its own thresholds, once a second."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        gc.disable()
        self._timer = QTimer(self, interval=INTERVAL)
        self._timer.timeout.connect(self.tidy)
        self._timer.start()

    def tidy(self) -> None:
        """Collect the youngest generation, and the older ones when their turn has come."""
        due = [count > most for count, most in zip(gc.get_count(), gc.get_threshold(), strict=True)]
        if due[0]:
            gc.collect(2 if due[2] else 1 if due[1] else 0)

    def settle(self) -> None:
        """What lives now lives for ever: it need not be looked through again.

        The imported libraries are some hundred thousand objects, a pause of a tenth of a
        second each time.
        """
        gc.freeze()
