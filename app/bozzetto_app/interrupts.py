"""Ctrl+C in the terminal, heard by an event loop that nobody touches."""

from __future__ import annotations

import signal
import socket
from collections.abc import Callable
from types import FrameType

from PySide6.QtCore import QSocketNotifier

__all__ = ["InterruptWatch"]

AT_ONCE = 64
"""Signals taken from the socket at a time; each is one byte."""


class InterruptWatch:
    """Calls a function on the window's thread whenever the process is interrupted.

    Python runs a signal's handler only between two of its own instructions, and a waiting event
    loop runs none: the interpreter writes a byte into a socket, and a notifier at its other end
    wakes the loop. This object owns all of it, for the notifier of a socket that was closed
    reports its end for ever and takes all the processor's time.

    Parameters
    ----------
    interrupted : callable
        Called without arguments.

    Notes
    -----
    To be made and closed on the main thread, while the application exists.
    """

    def __init__(self, interrupted: Callable[[], object]) -> None:
        self._interrupted = interrupted
        self._reader, self._writer = socket.socketpair()
        for end in (self._reader, self._writer):
            end.setblocking(False)
        self._notifier = QSocketNotifier(self._reader.fileno(), QSocketNotifier.Type.Read)
        self._notifier.activated.connect(self._read)
        self._closed = False
        self._handler = signal.signal(signal.SIGINT, self._interrupt)
        self._wakeup = signal.set_wakeup_fd(self._writer.fileno(), warn_on_full_buffer=False)

    def close(self) -> None:
        """Stop listening, and leave signals as they were found; again does nothing."""
        if self._closed:
            return
        self._closed = True
        signal.set_wakeup_fd(self._wakeup)
        signal.signal(signal.SIGINT, self._handler)
        self._notifier.setEnabled(False)
        self._reader.close()
        self._writer.close()

    def _interrupt(self, number: int, frame: FrameType | None) -> None:
        self._interrupted()

    def _read(self) -> None:
        try:
            ended = not self._reader.recv(AT_ONCE)
        except BlockingIOError:
            return
        if ended:
            self._notifier.setEnabled(False)
