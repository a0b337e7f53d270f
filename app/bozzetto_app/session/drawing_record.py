"""The recovery data of one drawing, from when it comes onto the sheet until it leaves it.

The law: recovery data go only when all that is in them is safe elsewhere (in a saved file,
or in other recovery data that reached the disk), or when the person said that it may go.
"""

from __future__ import annotations

import errno
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Final, NamedTuple

from bozzetto.errors import UserError
from bozzetto_app.i18n import tr

if TYPE_CHECKING:
    from bozzetto.atomic_files import FileStamp
    from bozzetto.document.model import Document
    from bozzetto.document.recovery.recovery import CrashedSession, RecoverySession, RecoveryStore

__all__ = ["BroughtBack", "DrawingRecord", "NotKept", "Snapshot", "State"]

NO_ROOM: Final = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
"""How systems say that a disk is full."""


class NotKept(UserError):
    """Error: the drawing is in no recovery data, for their disk is full or fails."""


def _not_kept(problem: UserError, folder: Path) -> NotKept:
    """Return what a person must know: not which file of ours it is, but what a crash would take."""
    cause = problem.__cause__
    if not isinstance(cause, OSError):
        return NotKept(problem.message)
    if cause.errno in NO_ROOM:
        reason = tr("Recovery", "its disk is full")
    else:
        reason = cause.strerror or str(cause)
    return NotKept(
        tr(
            "Recovery",
            "A crash would take what you draw now: “{folder}” cannot be written ({reason}). Save "
            "the drawing, and make room there; each step tries again.",
            folder=folder,
            reason=reason,
        )
    )


class Snapshot(NamedTuple):
    """A drawing at a moment."""

    name: str
    path: Path | None
    stamp: FileStamp | None
    document: Document


class BroughtBack(NamedTuple):
    """Recovery data that were read after a crash; `is_whole` if nothing of them is missing."""

    session: CrashedSession
    is_whole: bool


class State(Enum):
    """Where a drawing is, beside the memory of this process."""

    NOWHERE = "nowhere"
    """Nothing of it was written yet, or could be."""
    IN_OLD_DATA = "in old data"
    """In what the crash left, of which this process keeps others off."""
    IN_OWN_DATA = "in own data"
    """In recovery data of its own, which hold all of it."""
    LEFT = "left"
    """It left the sheet: saved, given up, or set aside to be offered again."""


class DrawingRecord:
    """Keeps one drawing safe; used by one thread.

    Parameters
    ----------
    store : RecoveryStore
    brought_back : BroughtBack, optional
        Where the drawing comes from, if a crash left it behind.

    Attributes
    ----------
    state : State
    """

    def __init__(self, store: RecoveryStore, brought_back: BroughtBack | None = None) -> None:
        self._store = store
        self._old = brought_back
        self._own: RecoverySession | None = None
        self.state = State.NOWHERE if brought_back is None else State.IN_OLD_DATA

    def write(self, now: Snapshot) -> None:
        """Keep a snapshot; what it was brought back from goes once that is safe.

        Raises
        ------
        NotKept
            If the disk is full or fails. What was kept before is still kept.
        UserError
            If what it was brought back from cannot go.
        """
        if self.state is State.LEFT:
            return
        try:
            self._keep(now)
        except UserError as problem:
            raise _not_kept(problem, self._store.folder) from problem.__cause__
        if self._old is not None:
            old, self._old = self._old, None
            self.state = State.IN_OWN_DATA
            self._part_with(old)
        self.state = State.IN_OWN_DATA

    def _keep(self, now: Snapshot) -> None:
        """Write a snapshot, to new recovery data where there are none any more."""
        if self._own is not None and self._own.is_gone:
            self._own.set_aside()
            self._own = None
            self.state = State.NOWHERE if self._old is None else State.IN_OLD_DATA
        if self._own is None:
            self._own = self._store.begin(now.name, now.path, now.document, now.stamp)
        self._own.record(now.document)
        if self._old is not None:
            self._own.sync()

    def saved(self, now: Snapshot, saved: Document) -> None:
        """Start afresh from what is in the person's file now.

        Raises
        ------
        NotKept
            As `write`.
        """
        if self._own is None or now.path is None or self._own.is_gone:
            return
        try:
            self._own.saved(saved, now.name, now.path, now.stamp)
        except UserError as problem:
            raise _not_kept(problem, self._store.folder) from problem.__cause__

    def give_up(self) -> None:
        """Forget everything: it is in the person's file, or they said that it may go.

        Raises
        ------
        UserError
            If what a crash left cannot be deleted; it is offered again.
        """
        old, self._old = self._old, None
        self.state = State.LEFT
        if self._own is not None:
            self._own.close()
        if old is not None:
            self._part_with(old)

    def set_aside(self) -> None:
        """Leave everything to be offered again: nobody has said that it may go."""
        old, self._old = self._old, None
        self.state = State.LEFT
        if self._own is not None:
            self._own.set_aside()
        if old is not None:
            self._store.keep(old.session)

    def _part_with(self, old: BroughtBack) -> None:
        """Delete what a crash left, unless something in it could not be read."""
        if not old.is_whole:
            self._store.keep(old.session)
            raise UserError(
                f"Not all of “{old.session.name}” could be read. What the crash left stays in "
                f"{self._store.folder / old.session.id}, and is offered again."
            )
        self._store.discard(old.session)
