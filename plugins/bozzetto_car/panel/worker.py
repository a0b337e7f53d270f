"""Work in a thread of its own, so that the window stays responsive."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any, Final

from PySide6.QtCore import QObject, QTimer

from bozzetto.errors import UserError

LOOK: Final = 12
"""Interval at which the window looks for the answer, ms. The thread never touches Qt."""


class Work(QObject):
    """One request at a time; of those that come meanwhile, the newest.

    Parameters
    ----------
    parent : QObject
        The object that owns the work; answers after its end are dropped.
    """

    def __init__(self, parent: QObject) -> None:
        super().__init__(parent)
        self._pool = ThreadPoolExecutor(1, thread_name_prefix="car-guide")
        self._running: Future[Any] | None = None
        self._done: Callable[[Any], None] = lambda answer: None
        self._next: tuple[Callable[[], Any], Callable[[Any], None]] | None = None
        self._timer = QTimer(self, interval=LOOK)
        self._timer.timeout.connect(self._look)
        pool = self._pool
        self.destroyed.connect(lambda: pool.shutdown(wait=False, cancel_futures=True))

    @property
    def busy(self) -> bool:
        """Whether an answer is still to come."""
        return self._running is not None

    def ask(self, work: Callable[[], Any], done: Callable[[Any], None]) -> None:
        """Compute something, and give its answer to `done` on the window's thread.

        Work that fails with a `UserError` gets no answer: the program reports it where it solves
        the model.
        """
        self._next = work, done
        if self._running is None:
            self._begin()

    def _begin(self) -> None:
        if self._next is None:
            self._timer.stop()
            return
        work, self._done = self._next
        self._next = None
        self._running = self._pool.submit(work)
        self._timer.start()

    def _look(self) -> None:
        running = self._running
        if running is None or not running.done():
            return
        self._running = None
        done = self._done
        self._begin()
        try:
            answer = running.result()
        except UserError:
            return
        done(answer)
