"""Work of a panel in a thread of its own, so that the window stays responsive."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any, Final

from PySide6.QtCore import QObject, QTimer

from bozzetto.errors import UserError

__all__ = ["PanelWorker"]

LOOK: Final = 12
"""Interval at which the window looks for the answer, ms. The thread never touches Qt."""


@dataclass(frozen=True)
class _Request:
    work: Callable[[], Any]
    done: Callable[[Any], None]
    failed: Callable[[UserError], None]


def _ignore(problem: UserError) -> None:
    """Leave it to the program, which says the same where it solves the model."""


class PanelWorker(QObject):
    """Computes one thing at a time in a thread; of what is asked meanwhile, the newest.

    Parameters
    ----------
    parent : QObject
        The object that owns the work; answers after its end are dropped.
    """

    def __init__(self, parent: QObject) -> None:
        super().__init__(parent)
        self._pool = ThreadPoolExecutor(1, thread_name_prefix="panel")
        self._running: tuple[Future[Any], _Request] | None = None
        self._next: _Request | None = None
        self._timer = QTimer(self, interval=LOOK)
        self._timer.timeout.connect(self._look)
        pool = self._pool
        self.destroyed.connect(lambda: pool.shutdown(wait=False, cancel_futures=True))

    @property
    def busy(self) -> bool:
        """Whether an answer is still to come."""
        return self._running is not None

    def ask(
        self,
        work: Callable[[], Any],
        done: Callable[[Any], None],
        failed: Callable[[UserError], None] = _ignore,
    ) -> None:
        """Compute something, and give its answer to `done` on the window's thread.

        Parameters
        ----------
        work : callable
            A pure function of what it holds; it runs in the thread and touches no widget.
        done : callable
            Called with the answer.
        failed : callable
            Called with the `UserError` that the work raised, if it did. Any other exception is a
            fault of the plugin, and is raised on the window's thread.
        """
        self._next = _Request(work, done, failed)
        if self._running is None:
            self._begin()

    def _begin(self) -> None:
        request, self._next = self._next, None
        if request is None:
            self._timer.stop()
            return
        self._running = self._pool.submit(request.work), request
        self._timer.start()

    def _look(self) -> None:
        if self._running is None or not self._running[0].done():
            return
        (future, request), self._running = self._running, None
        self._begin()
        try:
            answer = future.result()
        except UserError as problem:
            request.failed(problem)
            return
        request.done(answer)
