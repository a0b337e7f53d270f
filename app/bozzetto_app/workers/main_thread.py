"""Calls from a worker's thread that run on the window's thread.

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

__all__ = ["call_on_main_thread", "install", "release_on_main_thread"]

log = logging.getLogger(__name__)


SWITCH_INTERVAL = 0.0005
"""How long the window waits at most for a worker to lend it the interpreter, s.

Qt's calls give the interpreter away and take it back, a dozen times for a tick of a slider;
with Python's own 5 ms, work in pure Python would hold the window up at each of them.
"""


class _Receiver(QObject):
    called = Signal(object)

    def __init__(self) -> None:
        super().__init__()
        self.called.connect(self._run, Qt.ConnectionType.QueuedConnection)

    def _run(self, call: Callable[[], None]) -> None:
        call()


_receivers: list[_Receiver] = []


def install() -> None:
    """Make the receiver, on the window's thread, before any worker needs it."""
    if not _receivers:
        _receivers.append(_Receiver())
        sys.setswitchinterval(min(sys.getswitchinterval(), SWITCH_INTERVAL))


def call_on_main_thread(
    owner: QObject,
    function: Callable[..., None],
    *arguments: Any,
    otherwise: Callable[[], None] = lambda: None,
) -> None:
    """Call a function on the window's thread, from any thread, unless its owner is gone.

    Parameters
    ----------
    owner : QObject
        Whose function it is.
    function : callable
        Called with the arguments.
    *arguments
        What it is called with.
    otherwise : callable
        Called if the owner is gone, or the program ends.
    """

    def call() -> None:
        if isValid(owner):
            function(*arguments)
        else:
            otherwise()

    try:
        _receivers[0].called.emit(call)
    except RuntimeError:
        log.debug("the program ended before %s could answer", type(owner).__name__)
        otherwise()


_unreleased: list[list[Any]] = []


def release_on_main_thread(held: list[Any]) -> None:
    """Empty a list on the window's thread, from any thread.

    Whoever lets go of a Qt object last destroys it, and a worker must not. So what a worker was
    given stays in a list, and is released behind the last call that the worker has made.

    Parameters
    ----------
    held : list
        Everything that the thread still holds.
    """
    try:
        _receivers[0].called.emit(held.clear)
    except RuntimeError:
        _unreleased.append(held)  # the program ends, and what is held with it
