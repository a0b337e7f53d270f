"""Whole files: read at once, and written so that there is always the old one or the new one.

The new content is written beside the old file, brought to the disk, and put in its place
in one step. All calls to the operating system go through a `Disk`, so that tests can let
any one of them fail.
"""

from __future__ import annotations

import contextlib
import errno
import os
import shutil
import stat
import zlib
from collections.abc import Callable
from enum import Enum
from pathlib import Path
from typing import Any, BinaryIO, Final

import msgspec

from bozzetto.errors import UserError
from bozzetto.file_locks import take
from bozzetto.temporary_files import temporary_path

PIECE: Final = 1 << 20
"""Bytes that are read at a time for a checksum."""


class FileStamp(msgspec.Struct, frozen=True):
    """Which content a file had, so that it can be told from what it has later.

    Attributes
    ----------
    size : int
        Bytes.
    modified : int
        Nanoseconds since 1970.
    place : tuple of int
        The disk, and the file's number on it.
    checksum : int
        CRC-32 of the content.
    """

    size: int
    modified: int
    place: tuple[int, int]
    checksum: int

    def is_content_of(self, other: FileStamp) -> bool:
        """Whether both were taken of the same content, whatever its time."""
        return (self.size, self.checksum) == (other.size, other.checksum)


class Over(Enum):
    """Content that a file may be written over, where it is not a known one."""

    ANYTHING = "anything"
    NOTHING = "nothing"


class Written(msgspec.Struct, frozen=True):
    """Result of writing a file.

    Attributes
    ----------
    stamp : FileStamp
    other_names : int
        Hard links that go on meaning the earlier content.
    is_new : bool
        There was no file of that name.
    """

    stamp: FileStamp
    other_names: int = 0
    is_new: bool = False


class FileChanged(UserError):
    """There is another content than the one that was to be replaced.

    Attributes
    ----------
    path : Path
    expected : FileStamp, optional
        What was there last; None if nothing was.
    found : FileStamp
        What is there now.
    """

    def __init__(self, path: Path, expected: FileStamp | None, found: FileStamp) -> None:
        super().__init__(
            f"“{path.name}” was changed by another program. Save under another name, or open "
            "it again."
            if expected is not None
            else f"There is a file “{path.name}” already. Save under another name."
        )
        self.path = path
        self.expected = expected
        self.found = found


class Disk:
    """The calls to the operating system that saving needs."""

    def resolve(self, path: Path) -> Path:
        """Return the file that a path means, links followed."""
        return Path(os.path.realpath(path))

    def facts(self, path: Path) -> os.stat_result | None:
        """Return the system's facts on a file, or None where there is no file."""
        try:
            return os.stat(path)
        except FileNotFoundError:
            return None

    def create(self, path: Path, mode: int) -> BinaryIO:
        """Create a file, open for writing and locked; fail if there is one."""
        file = open(path, "x+b", opener=lambda name, flags: os.open(name, flags, mode))
        take(file.fileno())  # not a leftover, then
        return file

    def stamp(self, file: BinaryIO) -> FileStamp:
        """Return the stamp of an open file's content."""
        return _stamp(file)

    def dress(self, path: Path, like: Path, facts: os.stat_result) -> None:
        """Give a file the owner, attributes and permissions of another, where the system lets."""
        if os.name != "nt":
            mine = os.stat(path)
            for user, group in ((-1, facts.st_gid), (facts.st_uid, -1)):
                if (mine.st_uid if group < 0 else mine.st_gid) != max(user, group):
                    with contextlib.suppress(OSError):
                        os.chown(path, user, group)
        if hasattr(os, "listxattr"):
            with contextlib.suppress(OSError):
                for name in os.listxattr(like):
                    with contextlib.suppress(OSError):
                        os.setxattr(path, name, os.getxattr(like, name))
        os.chmod(path, stat.S_IMODE(facts.st_mode))

    def sync(self, file: BinaryIO) -> None:
        """Bring a file's content to the disk."""
        file.flush()
        os.fsync(file.fileno())

    def same(self, first: Path, second: Path) -> bool:
        """Whether two names mean one file."""
        return second.exists() and os.path.samefile(first, second)

    def link(self, path: Path, name: Path) -> None:
        """Give a file a second name."""
        os.link(path, name)

    def copy(self, path: Path, name: Path) -> None:
        """Copy a file with its times."""
        shutil.copy2(path, name)

    def replace(self, path: Path, name: Path) -> None:
        """Rename a file over another in one step."""
        os.replace(path, name)

    def remove(self, path: Path) -> None:
        """Delete a file."""
        os.unlink(path)

    def sync_folder(self, folder: Path) -> None:
        """Bring a folder's list of files to the disk, where the system can."""
        if os.name == "nt":
            return
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        except OSError as problem:
            if problem.errno not in (errno.EINVAL, errno.ENOTSUP):  # some network disks
                raise
        finally:
            os.close(handle)


DISK = Disk()


def backup_path(path: Path, number: int) -> Path:
    """Return the name of the n-th backup of a file; 1 is the newest."""
    return path.with_name(f"{path.name}~{number}")


def atomic_write(
    path: str | os.PathLike[str],
    write: Callable[[BinaryIO], Any],
    *,
    backups: int = 0,
    over: FileStamp | Over = Over.ANYTHING,
    disk: Disk = DISK,
) -> Written:
    """Write a file whole, or leave what was there as it was.

    Parameters
    ----------
    path : path
        A link is followed: the file it means is replaced, the link stays.
    write : callable
        Gets the open file; its exceptions pass through.
    backups : int
        How many earlier versions stay beside the file as ``name~1`` (the newest) ….
    over : FileStamp or Over
        The content that may be replaced. A file that is gone may always be written again.
    disk : Disk
        The operating system; tests give one that fails.

    Raises
    ------
    FileChanged
        If the file has another content than `over` says.
    UserError
        If the system refuses; the message says why and what to do. The old file is whole.
    """
    name = Path(path).name
    try:
        target = disk.resolve(Path(path))
        before = disk.facts(target)
        _check_writable(before)
        beside = temporary_path(target)
        # What nobody else may read is not shown while it is being written, either.
        file = disk.create(beside, 0o666 if before is None else 0o600)
        try:
            with file:
                write(file)
                disk.sync(file)
                stamp = disk.stamp(file)
            other_names = 0
            now = disk.facts(target)
            if now is not None:
                _check_writable(now)
                _check_expected(target, now, over, disk)
                disk.dress(beside, target, now)
                other_names = now.st_nlink - 1 - _is_backup(target, now, disk)
                _keep_backups(target, backups, disk)
            disk.replace(beside, target)
        except BaseException:
            with contextlib.suppress(OSError):
                disk.remove(beside)
            raise
        disk.sync_folder(target.parent)
    except OSError as problem:
        raise UserError(explain(problem, name)) from problem
    return Written(stamp, other_names, now is None)


def _check_writable(facts: os.stat_result | None) -> None:
    if facts is None:
        return
    if stat.S_ISDIR(facts.st_mode):
        raise IsADirectoryError(errno.EISDIR, "this is a folder")
    if not facts.st_mode & 0o222:
        raise PermissionError(errno.EACCES, "the file is read-only")


def _check_expected(
    target: Path, facts: os.stat_result, over: FileStamp | Over, disk: Disk
) -> None:
    """Check that a file has the content that may be replaced."""
    if over is Over.ANYTHING:
        return
    expected = over if isinstance(over, FileStamp) else None
    if expected is not None and expected.place == (facts.st_dev, facts.st_ino):
        if (expected.size, expected.modified) == (facts.st_size, facts.st_mtime_ns):
            return
    with open(target, "rb") as file:
        found = disk.stamp(file)
    if expected is None or not expected.is_content_of(found):
        raise FileChanged(target, expected, found)


def _stamp(file: BinaryIO) -> FileStamp:
    file.seek(0)
    checksum = 0
    while piece := file.read(PIECE):
        checksum = zlib.crc32(piece, checksum)
    return _stamp_of(os.fstat(file.fileno()), checksum)


def _stamp_of(facts: os.stat_result, checksum: int) -> FileStamp:
    return FileStamp(facts.st_size, facts.st_mtime_ns, (facts.st_dev, facts.st_ino), checksum)


def read_stamped(path: str | os.PathLike[str], limit: int) -> tuple[memoryview, FileStamp]:
    """Read a file as `read_bytes`; return the stamp of its content, for `atomic_write`, too."""
    content, facts = _read(path, limit)
    return content, _stamp_of(facts, zlib.crc32(content))


def read_bytes(path: str | os.PathLike[str], limit: int) -> memoryview:
    """Return a file's content, read-only; its length is looked at first.

    The memory is numpy's, which comes in large pages: reading 40 MB takes a third of the
    time that it takes into ``bytes``.

    Raises
    ------
    UserError
        If it cannot be read, is not a file, or is longer than `limit` bytes.
    """
    return _read(path, limit)[0]


def open_at_once(path: str, flags: int) -> int:
    """Open a file without waiting: a pipe that nobody writes to would hold its reader for ever."""
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))


def _read(path: str | os.PathLike[str], limit: int) -> tuple[memoryview, os.stat_result]:
    name = Path(path).name
    try:
        with open(path, "rb", buffering=0, opener=open_at_once) as file:
            facts = os.fstat(file.fileno())
            if not stat.S_ISREG(facts.st_mode):
                raise UserError(f"“{name}” is not a file that can be opened. Choose another.")
            if facts.st_size > limit:
                raise UserError(
                    f"“{name}” is longer than {limit / 1e9:.1f} GB, which is too long to be opened."
                )
            import numpy as np  # here: most who write files have no use for it

            content = np.empty(facts.st_size, np.uint8).data
            done = 0
            while got := file.readinto(content[done:]):
                done += got
            return content[:done].toreadonly(), facts
    except FileNotFoundError:
        raise UserError(f"There is no file “{name}”. Was it moved or renamed?") from None
    except OSError as problem:
        raise UserError(
            f"“{name}” cannot be read ({problem.strerror}). Check its permissions, or copy it "
            "to another folder."
        ) from problem


def write_bytes(path: str | os.PathLike[str], content: bytes) -> None:
    """Write a file whole from its content; as `atomic_write`."""
    atomic_write(path, lambda file: file.write(content))


def _is_backup(target: Path, facts: os.stat_result, disk: Disk) -> bool:
    """Whether a file is its own newest backup: the last save did not come to its end."""
    return facts.st_nlink > 1 and disk.same(target, backup_path(target, 1))


def _keep_backups(target: Path, count: int, disk: Disk) -> None:
    """Give the file that is about to be replaced its place among the backups.

    A backup that cannot be made does not stop the save: the new version is worth more.
    """
    newest = backup_path(target, 1)
    with contextlib.suppress(OSError):
        if count < 1 or disk.same(target, newest):  # the last save did not come to its end
            return
        for number in range(count - 1, 0, -1):
            with contextlib.suppress(FileNotFoundError):
                disk.replace(backup_path(target, number), backup_path(target, number + 1))
        if count == 1:
            with contextlib.suppress(FileNotFoundError):
                disk.remove(newest)
        try:
            disk.link(target, newest)
        except OSError:  # a disk without second names
            disk.copy(target, newest)


def explain(problem: OSError, name: str) -> str:
    """Explain to the person who saves what a failed call of the operating system means."""
    untouched = "Nothing was changed."
    if problem.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG):
        return (
            f"There is no room for “{name}” on this disk. Free some space or save it "
            f"somewhere else. {untouched}"
        )
    if problem.errno in (errno.EACCES, errno.EPERM, errno.EROFS):
        return f"“{name}” may not be written there. Save it somewhere else. {untouched}"
    if problem.errno in (errno.ENOENT, errno.ENOTDIR):
        return f"The folder for “{name}” does not exist. Choose another one."
    if problem.errno == errno.EISDIR:
        return f"“{name}” is a folder. Save under another name."
    if problem.errno in (errno.ENAMETOOLONG, errno.EINVAL):
        return f"The disk does not accept the name “{name}”. Save under a shorter one."
    reason = problem.strerror or str(problem)
    return f"“{name}” could not be saved ({reason}). Save it on another disk."
