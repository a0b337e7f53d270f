"""Every call to the operating system that touches a folder, counted, failing, slow or refused.

`watch` replaces the functions by which Python reaches the disk (in `os`, in `open`, in files
opened by it) while a block of code runs; calls outside the folder are left alone.
"""

from __future__ import annotations

import builtins
import contextlib
import errno
import io
import os
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any
from unittest import mock

__all__ = ["Calls", "fail_at", "full_after", "watch"]

BY_PATH = (
    "open stat lstat mkdir rmdir unlink remove rename replace link symlink scandir listdir chmod "
    "chown utime listxattr getxattr setxattr"
).split()
BY_HANDLE = ("fstat", "fsync", "read", "write", "lseek", "ftruncate")
BY_FILE = ("read", "readinto", "write", "truncate", "flush")
WRITES = {"write"}


class Calls:
    """The calls that touched the folder, in order.

    Parameters
    ----------
    folder : Path
    before : callable
        Called with the name of each call, and with the size of what it writes, before it is
        made; may raise, or wait.
    """

    def __init__(self, folder: Path, before: Callable[[str, int], None]) -> None:
        self.names: list[str] = []
        self.threads: list[str] = []
        self._folder = os.path.realpath(folder)
        self._before = before
        self._lock = threading.Lock()
        self._handles: set[int] = set()

    def touches(self, path: Any) -> bool:
        """Whether a path lies in the folder."""
        if isinstance(path, int):
            return path in self._handles
        try:
            name = os.path.abspath(os.fsdecode(path))
        except TypeError:
            return False
        return name == self._folder or name.startswith(self._folder + os.sep)

    def made(self, name: str, size: int = 0) -> None:
        """Note a call that is about to be made."""
        with self._lock:
            self.names.append(name)
            self.threads.append(threading.current_thread().name)
        self._before(name, size)

    def opened(self, handle: int) -> None:
        """Watch an open file as well."""
        with self._lock:
            self._handles.add(handle)

    def closed(self, handle: int) -> None:
        """Forget an open file."""
        with self._lock:
            self._handles.discard(handle)


@contextlib.contextmanager
def watch(folder: Path, before: Callable[[str, int], None] = lambda *_: None) -> Iterator[Calls]:
    """Watch all calls that touch a folder while the block runs."""
    calls = Calls(folder, before)
    with contextlib.ExitStack() as stack:
        for name in BY_PATH:
            if hasattr(os, name):
                stack.enter_context(mock.patch.object(os, name, _by_path(calls, name)))
        for name in BY_HANDLE:
            stack.enter_context(mock.patch.object(os, name, _by_handle(calls, name)))
        stack.enter_context(mock.patch.object(os, "close", _closing(calls)))
        opening = _opening(calls)
        for module in (io, builtins):
            stack.enter_context(mock.patch.object(module, "open", opening))
        yield calls


def fail_at(k: int, number: int = errno.EIO) -> Callable[[str, int], None]:
    """What makes the k-th call fail, and no other."""
    left = [k]
    turn = threading.Lock()

    def before(name: str, size: int) -> None:
        with turn:
            left[0] -= 1
            fails = left[0] == 0
        if fails:
            raise OSError(number, os.strerror(number))

    return before


def full_after(size: int, number: int = errno.EDQUOT) -> Callable[[str, int], None]:
    """What makes all writes fail once so many bytes were written."""
    left = [size]

    def before(name: str, size: int) -> None:
        if name in WRITES:
            left[0] -= size
            if left[0] < 0:
                raise OSError(number, os.strerror(number))

    return before


def _by_path(calls: Calls, name: str) -> Any:
    real = getattr(os, name)

    def call(*arguments: Any, **more: Any) -> Any:
        if not (arguments and calls.touches(arguments[0])):
            return real(*arguments, **more)
        calls.made(name)
        answer = real(*arguments, **more)
        if name == "open":
            calls.opened(answer)
        return answer

    return call


def _by_handle(calls: Calls, name: str) -> Any:
    real = getattr(os, name)

    def call(handle: int, *arguments: Any) -> Any:
        if calls.touches(handle):
            calls.made(name, len(arguments[0]) if name == "write" else 0)
        return real(handle, *arguments)

    return call


def _closing(calls: Calls) -> Any:
    real = os.close

    def close(handle: int) -> None:
        calls.closed(handle)
        real(handle)

    return close


def _opening(calls: Calls) -> Any:
    real = io.open

    def call(path: Any, *arguments: Any, **more: Any) -> Any:
        if not calls.touches(path):
            return real(path, *arguments, **more)
        calls.made("open")
        return _File(real(path, *arguments, **more), calls)

    return call


class _File:
    """An open file whose calls are watched."""

    def __init__(self, file: Any, calls: Calls) -> None:
        self._file, self._calls = file, calls
        self._handle = file.fileno()
        calls.opened(self._handle)
        for name in BY_FILE:
            if hasattr(file, name):
                setattr(self, name, self._watched(name))

    def _watched(self, name: str) -> Any:
        real = getattr(self._file, name)

        def call(*arguments: Any) -> Any:
            writes = name == "write" and arguments
            self._calls.made(name, len(arguments[0]) if writes else 0)
            return real(*arguments)

        return call

    def close(self) -> None:
        self._calls.closed(self._handle)
        self._file.close()

    def __enter__(self) -> _File:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __iter__(self) -> Any:
        return iter(self._file)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._file, name)
