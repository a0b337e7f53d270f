"""The doorbell: how a worker's thread has something done on the window's thread.

A worker must not emit the signals of an object that the window's thread may delete at the
same moment: that is a crash without a traceback. So there is one object that is never
deleted, and what is to be done waits behind it until its owner can be looked at safely.
"""

from __future__ import annotations

import logging
import sys
from collections.abc import Callable
from typing import Any

from PySide6.QtCore import QObject, Qt, Signal
from shiboken6 import isValid

__all__ = ["hang_up", "ring"]

log = logging.getLogger(__name__)


SWITCH_INTERVAL = 0.0005
"""How long the window waits at most for a worker to lend it the interpreter, s.

Qt's calls give the interpreter away and take it back, a dozen times for a tick of a slider;
with Python's own 5 ms, work in pure Python would hold the window up at each of them.
"""


class _Bell(QObject):
    rung = Signal(object)

    def __init__(self) -> None:
        super().__init__()
        self.rung.connect(self._open, Qt.ConnectionType.QueuedConnection)

    def _open(self, call: Callable[[], None]) -> None:
        call()


_bells: list[_Bell] = []


def hang_up() -> None:
    """On the window's thread: put up the bell, before any worker may ring it."""
    if not _bells:
        _bells.append(_Bell())
        sys.setswitchinterval(min(sys.getswitchinterval(), SWITCH_INTERVAL))


def ring(owner: QObject, function: Callable[..., None], *arguments: Any) -> None:
    """From any thread: call a function on the window's thread, unless its owner is gone."""

    def call() -> None:
        if isValid(owner):
            function(*arguments)

    try:
        _bells[0].rung.emit(call)
    except RuntimeError:
        log.debug("the program ended before %s could answer", type(owner).__name__)
