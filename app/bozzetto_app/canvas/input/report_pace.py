"""The pace of reports: the session hears of a gesture under way thirty times a second at most."""

from __future__ import annotations

import math
from time import perf_counter
from typing import Final

from PySide6.QtCore import QObject, QTimer, Signal

__all__ = ["ReportPace"]

REPORT_INTERVAL: Final = 1.0 / 30.0
"""Least time between two reports, seconds."""


class ReportPace(QObject):
    """Says when the next report may be made.

    Signals
    -------
    due
        A report that was asked for is to be made now.
    """

    due = Signal()

    def __init__(self, parent: QObject) -> None:
        super().__init__(parent)
        self._last = -math.inf
        self._later = QTimer(self, singleShot=True)
        self._later.timeout.connect(self.due)

    def forget(self) -> None:
        """Let the next report be made at once: another gesture begins."""
        self._last = -math.inf

    def is_time(self) -> bool:
        """Whether the interval has passed."""
        return perf_counter() - self._last >= REPORT_INTERVAL

    def begin(self) -> None:
        """Note that a report is made now."""
        self._last = perf_counter()
        self._later.stop()

    def ask(self) -> None:
        """Have a report made: now, or once the interval has passed."""
        wait = REPORT_INTERVAL - (perf_counter() - self._last)
        if wait <= 0:
            self.due.emit()
        elif not self._later.isActive():
            self._later.start(math.ceil(1000.0 * wait))

    def stop(self) -> None:
        """Let a report that was asked for be."""
        self._later.stop()
