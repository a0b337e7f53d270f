"""The lock file beside a document: who has it open.

``.~lock.NAME#`` holds the user, the host, the process and the time as JSON. It appears with
its content in one step, so nobody ever reads half of one. A lock whose process is gone
(on this host; of another host nobody can tell) is stale and is taken over.
"""

from __future__ import annotations

import contextlib
import getpass
import os
import secrets
import socket
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Final, Self

import msgspec

from bozzetto.errors import UserError
from bozzetto.storage import explain

__all__ = ["FileLock", "Holder", "Locked", "document_lock_path", "holder"]


FRESH_SECONDS: Final = 2.0
"""How long a lock file may be without content."""
POLL_SECONDS: Final = 0.05


class Holder(msgspec.Struct, frozen=True):
    """Who holds a lock.

    Attributes
    ----------
    user, host : str
    pid : int
    since : float
        Seconds since 1970.
    token : str
        Tells one lock from another of the same process.
    born : str
        Tells its process from another one that got the same number later, after a restart
        of the machine for instance; "" where the system does not say.
    """

    user: str
    host: str
    pid: int
    since: float
    token: str
    born: str = ""

    @property
    def is_gone(self) -> bool:
        """Whether its process ran on this host and does no longer."""
        if self.host != socket.gethostname():
            return False
        return not _is_running(self.pid) or (self.born != "" and _born(self.pid) != self.born)


class Locked(UserError):
    """Somebody has the document open.

    Attributes
    ----------
    holder : Holder
    """

    def __init__(self, name: str, holder: Holder) -> None:
        super().__init__(
            f"“{name}” is open already: {holder.user} on {holder.host} has had it since "
            f"{time.strftime('%H:%M', time.localtime(holder.since))}. Open a copy, or close it "
            "there first."
        )
        self.holder = holder


class FileLock:
    """A lock that this process holds, until `release` or the end of a ``with`` block."""

    def __init__(self, path: Path, mine: Holder) -> None:
        self.path = path
        self._mine = mine

    @classmethod
    def acquire(cls, path: str | os.PathLike[str], name: str, *, force: bool = False) -> Self:
        """Take a lock.

        Parameters
        ----------
        path : path
            The lock file itself; see `document_lock_path`.
        name : str
            What is locked, for the message.
        force : bool
            Take it even from a living holder: the person said so.

        Raises
        ------
        Locked
            If somebody who may still be there holds it.
        UserError
            If the folder cannot be written to.
        """
        place = Path(path)
        mine = Holder(
            _user(),
            socket.gethostname(),
            os.getpid(),
            time.time(),
            secrets.token_hex(8),
            _born(os.getpid()),
        )
        draft = place.with_name(f".bozzetto-{mine.token}.lock")
        try:
            draft.write_bytes(msgspec.json.encode(mine))
            try:
                while not _appear(draft, place) and not _taken_over(draft, place, name, force):
                    time.sleep(POLL_SECONDS)
            finally:
                with contextlib.suppress(FileNotFoundError):
                    draft.unlink()
        except OSError as problem:
            raise UserError(explain(problem, name)) from problem
        return cls(place, mine)

    def release(self) -> None:
        """Give the lock back; nothing happens if somebody took it over meanwhile."""
        with contextlib.suppress(OSError), _turn(self.path.parent):
            if holder(self.path) == self._mine:
                self.path.unlink()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.release()


def document_lock_path(document: str | os.PathLike[str]) -> Path:
    """Where the lock file of a document lies."""
    path = Path(os.path.realpath(document))
    return path.with_name(f".~lock.{path.name}#")


def holder(path: str | os.PathLike[str]) -> Holder | None:
    """Who holds a lock file; None if nobody does, or the file makes no sense."""
    try:
        return msgspec.json.decode(Path(path).read_bytes(), type=Holder)
    except (OSError, msgspec.MsgspecError, ValueError):
        return None


def _appear(draft: Path, place: Path) -> bool:
    """Let the lock file appear with its content; False if there is one."""
    try:
        os.link(draft, place)
    except FileExistsError:
        return False
    except OSError:  # a disk without second names: content follows a moment later
        try:
            with open(place, "xb") as file:
                file.write(draft.read_bytes())
        except FileExistsError:
            return False
    return True


def _taken_over(draft: Path, place: Path, name: str, force: bool) -> bool:
    """Put the new lock in the place of a stale one; False to try again from the start.

    Raises
    ------
    Locked
        If the lock is not stale.
    """
    with _turn(place.parent):
        found = holder(place)
        if found is not None and not (force or found.is_gone):
            raise Locked(name, found)
        try:
            age = time.time() - place.stat().st_mtime
        except FileNotFoundError:  # released meanwhile
            return False
        if found is None and age < FRESH_SECONDS:
            return False
        os.replace(draft, place)
        return True


@contextlib.contextmanager
def _turn(folder: Path) -> Iterator[None]:
    """One at a time on this host: two must not take over the same stale lock.

    The system ends a turn when its process dies. Where the disk knows no such locks the
    turn is not kept.
    """
    if sys.platform == "win32":
        import msvcrt

        flags = os.O_RDWR | os.O_CREAT | os.O_TEMPORARY
        handle = os.open(folder / ".bozzetto-turn", flags)
        with contextlib.suppress(OSError):
            msvcrt.locking(handle, msvcrt.LK_LOCK, 1)
    else:
        import fcntl

        handle = os.open(folder, os.O_RDONLY)
        with contextlib.suppress(OSError):
            fcntl.flock(handle, fcntl.LOCK_EX)
    try:
        yield
    finally:
        os.close(handle)


def _user() -> str:
    try:
        return getpass.getuser()
    except (OSError, KeyError):  # no such name on this system
        return "someone"


def _born(pid: int) -> str:
    """Which start of the machine, and when since then, a process was born; "" if unknown."""
    try:
        boot = Path("/proc/sys/kernel/random/boot_id").read_text().strip()
        # The name before the last bracket may hold blanks; the start is the 22nd field.
        ticks = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[19]
    except (OSError, IndexError, ValueError):
        return ""
    return f"{boot}/{ticks}"


def _is_running(pid: int) -> bool:
    if sys.platform == "win32":
        import ctypes

        query_limited_information, still_active = 0x1000, 259
        process = ctypes.windll.kernel32.OpenProcess(query_limited_information, False, pid)
        code = ctypes.c_ulong()
        known = ctypes.windll.kernel32.GetExitCodeProcess(process, ctypes.byref(code))
        ctypes.windll.kernel32.CloseHandle(process)
        return bool(known) and code.value == still_active
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    except (PermissionError, OverflowError):
        return True
    return True
