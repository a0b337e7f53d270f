"""Locks of the operating system on open files: they end with the process that holds them."""

from __future__ import annotations

import errno
import os
import sys
from enum import Enum

FAR: int = 1 << 40
"""Place of the one locked byte on Windows, which does not let others read locked bytes."""


class Taken(Enum):
    """Result of trying to lock a file."""

    YES = "yes"
    BUSY = "busy"
    UNKNOWN = "unknown"
    """This disk has no locks."""


def take(handle: int) -> Taken:
    """Lock an open file if that is possible without waiting."""
    try:
        if sys.platform == "win32":
            import msvcrt

            _on_far_byte(handle, msvcrt.LK_NBLCK)
        else:
            import fcntl

            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as problem:
        busy = problem.errno in (errno.EWOULDBLOCK, errno.EAGAIN, errno.EACCES, errno.EDEADLK)
        return Taken.BUSY if busy else Taken.UNKNOWN
    return Taken.YES


def untake(handle: int) -> None:
    """Unlock a file, also for processes that were forked meanwhile and share it."""
    if sys.platform == "win32":
        import msvcrt

        _on_far_byte(handle, msvcrt.LK_UNLCK)
    else:
        import fcntl

        fcntl.flock(handle, fcntl.LOCK_UN)


if sys.platform == "win32":

    def _on_far_byte(handle: int, mode: int) -> None:
        import msvcrt

        place = os.lseek(handle, 0, os.SEEK_CUR)
        os.lseek(handle, FAR, os.SEEK_SET)
        try:
            msvcrt.locking(handle, mode, 1)
        finally:
            os.lseek(handle, place, os.SEEK_SET)
