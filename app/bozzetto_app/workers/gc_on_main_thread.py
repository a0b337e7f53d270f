"""Cyclic garbage is collected on the window's thread and nowhere else.

Python's collector runs in whichever thread happens to allocate. In a worker it would
destroy forgotten Qt objects there, and Qt objects die only on the thread they live in:
anything else is a crash without a traceback.

Freed memory is given back to the system now and then, too; see `bozzetto.native_heap`.
"""

from __future__ import annotations

import gc
import threading
from typing import Final

from PySide6.QtCore import QObject, QTimer

from bozzetto.native_heap import give_back

__all__ = ["Tidier"]

INTERVAL = 1000
"""Time between two looks at the garbage, ms."""

REST: Final = 20
"""Looks between two times that memory is given back: pages that are used again at once cost
some tenths of a millisecond per megabyte."""


class Tidier(QObject):
    """Does the collector's work, by its own thresholds, once a second."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        gc.disable()
        self._looks = 0
        self._giving: threading.Thread | None = None
        self._timer = QTimer(self, interval=INTERVAL)
        self._timer.timeout.connect(self.tidy)
        self._timer.start()

    def tidy(self) -> None:
        """Collect the youngest generation, and the older ones when their turn has come."""
        due = [count > most for count, most in zip(gc.get_count(), gc.get_threshold(), strict=True)]
        if due[0]:
            gc.collect(2 if due[2] else 1 if due[1] else 0)
        self._looks += 1
        if self._looks >= REST:
            self._looks = 0
            self._give_back()

    def settle(self) -> None:
        """Exempt all objects that live now from later collections.

        The imported libraries are some hundred thousand objects, a pause of a tenth of a
        second each time.
        """
        gc.freeze()

    def _give_back(self) -> None:
        """Give free memory back, in a thread: hundreds of megabytes take some frames' time."""
        if self._giving is None or not self._giving.is_alive():
            self._giving = threading.Thread(target=give_back, name="bozzetto-heap", daemon=True)
            self._giving.start()
