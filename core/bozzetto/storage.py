"""Whole files: read at once, and written so that there is always the old one or the new one.

The new content is written beside the old file, brought to the disk, and put in its place
in one step. All calls to the operating system go through a `Disk`, so that tests can let
any one of them fail.
"""

from __future__ import annotations

import contextlib
import errno
import os
import secrets
import shutil
import stat
from collections.abc import Callable
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from bozzetto.errors import UserError

__all__ = ["DISK", "Disk", "atomic_write", "backup_path", "explain", "read_bytes", "write_bytes"]


class Disk:
    """The calls to the operating system that saving needs."""

    def resolve(self, path: Path) -> Path:
        """The file that a path means, links followed."""
        return Path(os.path.realpath(path))

    def mode(self, path: Path) -> int | None:
        """Permissions of a file, or None where there is no file."""
        try:
            return os.stat(path).st_mode & 0o777
        except FileNotFoundError:
            return None

    def create(self, path: Path) -> BinaryIO:
        """A new file, open for writing; fails if there is one."""
        return open(path, "xb")

    def set_mode(self, path: Path, mode: int) -> None:
        """Give a file its permissions."""
        os.chmod(path, mode)

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
    """The name of the n-th backup of a file; 1 is the newest."""
    return path.with_name(f"{path.name}~{number}")


def atomic_write(
    path: str | os.PathLike[str],
    write: Callable[[BinaryIO], Any],
    *,
    backups: int = 0,
    disk: Disk = DISK,
) -> None:
    """Write a file whole, or leave what was there as it was.

    Parameters
    ----------
    path : path
        A link is followed: the file it means is replaced, the link stays.
    write : callable
        Gets the open file; its exceptions pass through.
    backups : int
        How many earlier versions stay beside the file as ``name~1`` (the newest) ….
    disk : Disk

    Raises
    ------
    UserError
        If the system refuses; the message says why and what to do. The old file is whole.
    """
    name = Path(path).name
    try:
        target = disk.resolve(Path(path))
        mode = disk.mode(target)
        if mode is not None and not mode & 0o222:
            raise PermissionError(errno.EACCES, "the file is read-only")
        beside = target.with_name(f".bozzetto-{secrets.token_hex(6)}.tmp")
        file = disk.create(beside)
        try:
            with file:
                write(file)
                disk.sync(file)
            if mode is not None:
                disk.set_mode(beside, mode)
                _keep_backups(target, backups, disk)
            disk.replace(beside, target)
        except BaseException:
            with contextlib.suppress(OSError):
                disk.remove(beside)
            raise
        disk.sync_folder(target.parent)
    except OSError as problem:
        raise UserError(explain(problem, name)) from problem


def read_bytes(path: str | os.PathLike[str], limit: int) -> memoryview:
    """A file's content, read-only; its length is looked at first.

    The memory is numpy's, which comes in large pages: reading 40 MB takes a third of the
    time that it takes into ``bytes``.

    Raises
    ------
    UserError
        If it cannot be read, is not a file, or is longer than `limit` bytes.
    """
    name = Path(path).name
    try:
        with open(path, "rb", buffering=0) as file:
            facts = os.fstat(file.fileno())
            if not stat.S_ISREG(facts.st_mode):
                raise UserError(f"“{name}” is not a file that can be opened. Choose another.")
            if facts.st_size > limit:
                raise UserError(
                    f"“{name}” is longer than {limit / 1e9:.1f} GB, which is too long to be opened."
                )
            content = np.empty(facts.st_size, np.uint8).data
            done = 0
            while got := file.readinto(content[done:]):
                done += got
            return content[:done].toreadonly()
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
    """What a failed call of the operating system means for the person who saves."""
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
