"""The journal: records appended to a file, of which a crash loses none that is complete.

A record is its length and its checksum (both uint32, little-endian), then its content.
Every append reaches the operating system before it returns, and so survives the death of
the process; a thread brings it to the disk within `SYNC_SECONDS`, so that it also survives
a power cut. Reading stops at the first record that is not whole.
"""

from __future__ import annotations

import contextlib
import os
import struct
import threading
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from bozzetto.atomic_files import DISK, explain
from bozzetto.errors import UserError

MAGIC: Final = b"BOZZJRN1"
HEAD: Final = struct.Struct("<2I")
SYNC_SECONDS: Final = 1.0


class JournalWriter:
    """A new journal; fails if there is one of that name.

    Parameters
    ----------
    path : Path

    Attributes
    ----------
    path : Path

    Raises
    ------
    UserError
        If the system refuses.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._name, self._folder = path.name, path.parent
        self._is_listed = False
        try:
            self._file = open(path, "xb", buffering=0)
        except OSError as problem:
            raise UserError(explain(problem, self._name)) from problem
        self._end = 0
        self._lock = threading.Lock()
        self._unsynced = False
        self._closing = threading.Event()
        self._problem: OSError | None = None
        try:
            self._put(MAGIC)
        except UserError:
            self._file.close()
            with contextlib.suppress(OSError):  # no leftover for each attempt on a full disk
                os.unlink(path)
            raise
        self._thread = threading.Thread(target=self._keep_synced, name="journal", daemon=True)
        self._thread.start()

    def __len__(self) -> int:
        """Bytes written."""
        return self._end

    @property
    def is_gone(self) -> bool:
        """Whether the file was deleted: what is written now would be found by nobody."""
        try:
            return not os.path.samestat(os.stat(self.path), os.fstat(self._file.fileno()))
        except (FileNotFoundError, NotADirectoryError):
            return True
        except OSError:
            return False

    def append(self, content: bytes) -> None:
        """Append a record; it survives the process from here on.

        Raises
        ------
        UserError
            If the disk is full or fails; the journal then ends with the record before.
        """
        self._put(HEAD.pack(len(content), zlib.crc32(content)) + content)

    def sync(self) -> None:
        """Bring everything to the disk before going on; it survives a power cut from here on.

        Raises
        ------
        UserError
            If the disk is full or fails.
        """
        try:
            self._bring_to_disk()
        except OSError as problem:
            self._problem = problem
            raise UserError(explain(problem, self._name)) from problem

    def close(self) -> None:
        """Bring everything to the disk and stop."""
        self._closing.set()
        self._thread.join()
        with contextlib.suppress(OSError):
            self._file.close()

    def _put(self, content: bytes) -> None:
        with self._lock:
            try:
                if self._problem is not None:
                    raise self._problem
                rest = memoryview(content)
                while rest:
                    rest = rest[self._file.write(rest) :]
            except OSError as problem:
                self._problem = problem
                self._cut()
                raise UserError(explain(problem, self._name)) from problem
            self._end += len(content)
            self._unsynced = True

    def _cut(self) -> None:
        """Take back half a record, which would hide all that come after it."""
        try:
            self._file.truncate(self._end)
            self._file.seek(self._end)
        except OSError:
            return  # no record is written behind it: the problem stays
        self._problem = None

    def _keep_synced(self) -> None:
        ended = False
        while not ended:
            ended = self._closing.wait(SYNC_SECONDS)
            if self._unsynced:
                try:
                    self._bring_to_disk()
                except OSError as problem:  # said when the next record comes
                    self._problem = problem

    def _bring_to_disk(self) -> None:
        self._unsynced = False
        os.fsync(self._file.fileno())
        if not self._is_listed:
            DISK.sync_folder(self._folder)
            self._is_listed = True


def read_records(path: Path) -> Iterator[bytes]:
    """Iterate over the records of a journal, up to the first one that is not whole."""
    return iter(JournalReader(path))


class JournalReader:
    """Reads a journal up to the first record that is not whole.

    Parameters
    ----------
    path : Path

    Attributes
    ----------
    is_damaged : bool
        After reading: it ended at a record that was written whole and is not so any more,
        and not at its end, or at one that was being written.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self.is_damaged = False

    def __iter__(self) -> Iterator[bytes]:
        with open(self._path, "rb") as file:
            left = os.fstat(file.fileno()).st_size - len(MAGIC)
            if file.read(len(MAGIC)) != MAGIC:
                self.is_damaged = left > 0
                return
            while left >= HEAD.size:
                length, crc = HEAD.unpack(file.read(HEAD.size))
                left -= HEAD.size + length
                if left < 0 or length == 0:
                    return
                content = file.read(length)
                if zlib.crc32(content) != crc:
                    self.is_damaged = True
                    return
                yield content
