"""The lock file beside a document: who has it open.

``.~lock.NAME#`` names the user, the host, the process and the time as JSON, and its holder
keeps the file locked by the operating system. That lock ends with the process, whatever
the host is called by then and whoever has the number of the process. Where the disk has no
such locks, the process that the file names is looked for instead.
"""

from __future__ import annotations

import contextlib
import errno
import os
import time
from pathlib import Path
from typing import Final, Self

import msgspec

from bozzetto.atomic_files import explain
from bozzetto.errors import UserError
from bozzetto.file_locks import Taken, take, untake
from bozzetto.processes import birth, host_name, is_running, machine_id
from bozzetto.typed_data import decode_json

WAIT_SECONDS: Final = 0.25
"""Time for which a busy lock is tried again: somebody may just be looking at it."""

FRESH_SECONDS: Final = 2.0
"""Time that a lock file may be empty, and that one without a living holder may be busy.

A holder writes its name at once, and nobody looks for long.
"""

POLL_SECONDS: Final = 0.02
LARGEST: Final = 4096
"""Bytes of a lock file that are looked at."""

READ_WRITE: Final = os.O_RDWR | getattr(os, "O_BINARY", 0)


class Holder(msgspec.Struct, frozen=True):
    """Holder of a lock.

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
    machine : str
        Tells the machine from others, whatever its name is; "" in files of earlier versions.
    """

    user: str
    host: str
    pid: int
    since: float
    token: str
    born: str = ""
    machine: str = ""

    @property
    def is_elsewhere(self) -> bool:
        """Whether it is of another machine, of which nobody here can tell if it is alive."""
        if self.machine:
            return self.machine != machine_id()
        return self.host != host_name()

    @property
    def is_gone(self) -> bool:
        """Whether its process ran on this machine and does no longer."""
        if self.is_elsewhere:
            return False
        return not is_running(self.pid) or (self.born != "" and birth(self.pid) != self.born)


class Locked(UserError):
    """Somebody has the document open.

    Attributes
    ----------
    holder : Holder
    """

    def __init__(self, name: str, holder: Holder) -> None:
        super().__init__(
            f"“{name}” is open already: {holder.user} on {holder.host} has had it since "
            f"{_clock(holder.since)}. Open a copy, take it over, or close it there first."
        )
        self.holder = holder


class FileLock:
    """A lock that this process holds, until `release` or the end of a ``with`` block."""

    def __init__(self, path: Path, handle: int) -> None:
        self.path = path
        self._handle = handle

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
        end = time.monotonic() + WAIT_SECONDS
        try:
            while True:
                handle = _made(place)
                if handle is not None:
                    return cls(place, handle)
                blocking = _cleared(place, force)
                late = time.monotonic() - end
                if blocking is not None and late > (0.0 if _lives(blocking) else FRESH_SECONDS):
                    raise Locked(name, blocking)
                if late > FRESH_SECONDS:  # a link to nowhere, for instance
                    raise FileExistsError(errno.EEXIST, f"{place.name} is in the way")
                time.sleep(POLL_SECONDS if blocking is not None else 0.0)
        except OSError as problem:
            raise UserError(explain(problem, name)) from problem

    @property
    def is_held(self) -> bool:
        """Whether nobody has taken it over."""
        return self._handle >= 0 and _is_file(self._handle, self.path)

    def release(self) -> None:
        """Give the lock back; nothing happens to the file if somebody took it over meanwhile."""
        handle, self._handle = self._handle, -1
        if handle < 0:
            return
        with contextlib.suppress(OSError):
            mine = _is_file(handle, self.path)
            if os.name == "nt":  # where no open file can be deleted
                _close(handle)
            if mine:
                self.path.unlink()
        if os.name != "nt":
            _close(handle)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.release()


def document_lock_path(document: str | os.PathLike[str]) -> Path:
    """Return where the lock file of a document lies."""
    path = Path(os.path.realpath(document))
    return path.with_name(f".~lock.{path.name}#")


def holder(path: str | os.PathLike[str]) -> Holder | None:
    """Return the holder that a lock file names; None if nobody is, or the file makes no sense."""
    try:
        with open(path, "rb") as file:
            return _named(file.read(LARGEST))
    except OSError:
        return None


def abandoned_holder(path: str | os.PathLike[str]) -> Holder | None:
    """Return a holder who is gone, or may be so on another machine; None if the lock is held.

    A lock file that does not exist, or makes no sense, was left by nobody in particular.
    """
    nobody = Holder("", "", 0, 0.0, "", machine=machine_id())
    try:
        handle = os.open(path, os.O_RDONLY | getattr(os, "O_BINARY", 0))
    except FileNotFoundError:
        return nobody
    except OSError:
        return None
    try:
        taken, found, age = _looked_at(handle)
        if taken is Taken.BUSY:
            return None
        if found is not None and found.is_elsewhere:
            return found
        return None if _stands_in_the_way(taken, found, age) else found or nobody
    finally:
        _close(handle)


def _made(place: Path) -> int | None:
    """Make the lock file, lock it and fill it; None if there is one, or it was taken away."""
    try:
        handle = os.open(place, READ_WRITE | os.O_CREAT | os.O_EXCL, 0o666)
    except FileExistsError:
        return None
    try:
        if take(handle) is not Taken.BUSY and _is_file(handle, place):
            mine = Holder(
                _user(),
                host_name(),
                os.getpid(),
                time.time(),
                os.urandom(8).hex(),
                birth(os.getpid()),
                machine_id(),
            )
            os.lseek(handle, 0, os.SEEK_SET)
            os.write(handle, msgspec.json.encode(mine))
            return handle
    except BaseException:
        with contextlib.suppress(OSError):
            os.unlink(place)
        os.close(handle)
        raise
    os.close(handle)
    return None


def _cleared(place: Path, force: bool) -> Holder | None:
    """Take a lock file away that nobody holds; who stands in the way, if anybody does."""
    try:
        handle = os.open(place, READ_WRITE)
    except FileNotFoundError:
        return None
    except PermissionError:  # another person's
        handle = os.open(place, os.O_RDONLY | getattr(os, "O_BINARY", 0))
    try:
        taken, found, age = _looked_at(handle)
        if not force and _stands_in_the_way(taken, found, age):
            return found or Holder("somebody", "this computer", 0, time.time(), "")
        is_there = _is_file(handle, place)
        if is_there and os.name != "nt":  # while nobody else can get it
            os.unlink(place)
    finally:
        _close(handle)
    if is_there and os.name == "nt":  # where no open file can be deleted
        os.unlink(place)
    return None


def _looked_at(handle: int) -> tuple[Taken, Holder | None, float]:
    """Whether a lock file could be locked, who is named in it, and its age, seconds."""
    taken, found = take(handle), _named(os.read(handle, LARGEST))
    # Clocks may go backwards.
    return taken, found, abs(time.time() - os.fstat(handle).st_mtime)


def _stands_in_the_way(taken: Taken, found: Holder | None, age: float) -> bool:
    """Whether a lock file has, or may have, a living holder."""
    if taken is Taken.BUSY:
        return True
    if found is None:
        return taken is Taken.UNKNOWN and age < FRESH_SECONDS
    return found.is_elsewhere or (taken is Taken.UNKNOWN and not found.is_gone)


def _lives(named: Holder) -> bool:
    """Whether a holder is more than somebody who looks at a file that others left."""
    return named.pid != 0 and not named.is_gone


def _close(handle: int) -> None:
    with contextlib.suppress(OSError):
        untake(handle)
    with contextlib.suppress(OSError):
        os.close(handle)


def _is_file(handle: int, path: Path) -> bool:
    """Whether a name still means the file that is open."""
    try:
        return os.path.samestat(os.fstat(handle), os.stat(path))
    except FileNotFoundError:
        return False


def _named(content: bytes) -> Holder | None:
    try:
        holder: Holder = decode_json(content, Holder)
        return holder
    except (msgspec.MsgspecError, ValueError):
        return None


def _clock(seconds: float) -> str:
    try:
        return time.strftime("%H:%M", time.localtime(seconds))
    except (OverflowError, ValueError, OSError):
        return "some time"


def _user() -> str:
    import getpass  # brings the terminal's modules with it: not for every start

    try:
        return getpass.getuser()
    except (OSError, KeyError):  # no such name on this system
        return "someone"
