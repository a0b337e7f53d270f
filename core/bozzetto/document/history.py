"""Undo and redo: a row of snapshots, bounded by the bytes that only they hold."""

from __future__ import annotations

import weakref
from collections.abc import Callable
from typing import Final

import msgspec
from msgspec.structs import replace

from bozzetto.document.model import Document
from bozzetto.document.shared_bytes import difference

BYTE_LIMIT: Final = 256 << 20
"""Default bound of what old snapshots may hold that the present one does not, bytes."""


STEP_BYTES: Final = 4096
"""Bytes of a step beside its data: its share of the object list, a bit of everything."""


BACK: Final = "Undo"
"""Name of the step that leads back from what was undone and is kept."""


class _Step(msgspec.Struct, frozen=True):
    """A change: its name, what it led to, and what lies only on either side of it.

    `revision` is a number no other snapshot has, by which a save is recognised; `before`
    are the snapshots that `document` took the place of and that somebody still holds.
    `drawn` is true of what came from a hand on the sheet.
    """

    label: str
    document: Document
    revision: int
    merge_key: str | None = None
    removed: int = 0
    added: int = 0
    before: tuple[weakref.ref[Document], ...] = ()
    drawn: bool = False


class History:
    """The snapshots of a document, and where in them the person is.

    Nothing in here can fail: a step is two references changing places.

    Parameters
    ----------
    document : Document
        The first snapshot; counts as saved.
    origin : str
        What the first row of the history panel says.
    byte_limit : int
        When old (or undone) snapshots hold more than this beside the present one, the
        oldest are forgotten.
    """

    def __init__(
        self, document: Document, *, origin: str = "Start", byte_limit: int = BYTE_LIMIT
    ) -> None:
        self._steps = [_Step(origin, document, 0)]
        self._position = 0
        self._revision = 0
        self._saved = 0
        self._open = False
        self._byte_limit = byte_limit
        self._held = 0

    @property
    def document(self) -> Document:
        """The present snapshot."""
        return self._steps[self._position].document

    @property
    def entries(self) -> tuple[str, ...]:
        """Labels for the history panel: the origin, then one per step."""
        return tuple(step.label for step in self._steps)

    @property
    def position(self) -> int:
        """Index of the present one among the `entries`."""
        return self._position

    @property
    def undo_label(self) -> str | None:
        """Label of the step that `undo` would take back, or None."""
        return self._steps[self._position].label if self._position else None

    @property
    def redo_label(self) -> str | None:
        """Label of the step that `redo` would do again, or None."""
        after = self._steps[self._position + 1 :]
        return after[0].label if after else None

    @property
    def is_modified(self) -> bool:
        """Whether the present snapshot differs from the one last saved."""
        return self._steps[self._position].revision != self._saved

    @property
    def held_bytes(self) -> int:
        """Estimate of the bytes that other snapshots hold and the present one does not."""
        return self._held

    def apply(
        self,
        label: str,
        document: Document,
        merge_key: str | None = None,
        *,
        drawn: bool = False,
    ) -> None:
        """Make a new snapshot the present one.

        Steps that were undone are forgotten, unless one of them was drawn: then they stay in
        the row, with a step behind them that leads back to where the person is.

        Parameters
        ----------
        label : str
            For the menus: "Undo <label>".
        document : Document
            The new snapshot.
        merge_key : str, optional
            A step with the key of the step just before becomes one with it, until
            `end_merge`, an undo or a save: the drag of a slider is one step, and none if it
            ends with the snapshot before it (`before_merge`).
        drawn : bool
            It came from a hand on the sheet, and undo has to bring it back for ever.
        """
        if document is self.document:
            return
        if self.before_merge(merge_key) is not None and document is self.undo():
            self._held -= self._steps[-1].added
            del self._steps[-1]
            return
        undone = self._steps[self._position + 1 :]
        if any(step.drawn for step in undone):
            present = self._steps[self._position]
            self.go_to(len(self._steps) - 1)
            self._append(BACK, present.document, present.revision)
        else:
            self._held -= sum(step.added for step in undone)
            del self._steps[self._position + 1 :]
        self._revision += 1
        self._append(label, document, self._revision, merge_key, drawn)
        self._open = merge_key is not None
        while self._position > 0 and self._held > self._byte_limit:
            self._held -= self._steps[1].removed
            del self._steps[0]
            self._position -= 1

    def amend(self, document: Document) -> None:
        """Put another snapshot in the place of the present one, without a step of its own.

        For what nobody wants to take back, such as which part is chosen. What was undone
        can still be done again, and what was saved still counts as saved.
        """
        step = self._steps[self._position]
        before = (*(old for old in step.before if old() is not None), weakref.ref(step.document))
        self._steps[self._position] = replace(step, document=document, before=before)
        self._open = False

    def revise(self, change: Callable[[Document], Document]) -> None:
        """Change snapshots where they stand, without steps; what was saved still counts as saved.

        For what is known of a stroke only later. `change` gives the same object for a
        snapshot that it does not concern.
        """
        for place in range(len(self._steps)):
            self._put(place, change(self._steps[place].document), is_other=False)
        self._open = False

    def complete(self, first: int, label: str, change: Callable[[Document], Document]) -> None:
        """Let a step, and those that follow, lead to other snapshots: its outcome came later.

        Parameters
        ----------
        first : int
            Its place among the `entries`.
        label : str
            Its new name.
        change : callable
            Gives the same object for a snapshot that it does not concern.
        """
        self._steps[first] = replace(self._steps[first], label=label)
        for place in range(first, len(self._steps)):
            self._put(place, change(self._steps[place].document), is_other=True)
        self._open = False

    def before_merge(self, merge_key: str | None) -> Document | None:
        """Return the snapshot before the step that the next one with a key becomes one with.

        None if the next one is a step of its own.
        """
        key = self._steps[self._position].merge_key
        if not self._open or merge_key is None or merge_key != key or not self._position:
            return None
        return self._steps[self._position - 1].document

    def place_where(self, holds: Callable[[Document], bool]) -> int | None:
        """Return the first step from which, up to the present, something always holds."""
        found = None
        for place in range(self._position, 0, -1):
            if not holds(self._steps[place].document):
                break
            found = place
        return found

    def _append(
        self,
        label: str,
        document: Document,
        revision: int,
        merge_key: str | None = None,
        drawn: bool = False,
    ) -> None:
        """Add a step behind the present one, which is the last, and go there."""
        removed, added = (STEP_BYTES + count for count in difference(self.document, document))
        self._steps.append(_Step(label, document, revision, merge_key, removed, added, drawn=drawn))
        self._held += added
        self.redo()

    def _put(self, place: int, document: Document, *, is_other: bool) -> None:
        """Exchange the snapshot of a step, and count again what it and the next one hold."""
        step = self._steps[place]
        if document is step.document:
            return
        before: tuple[weakref.ref[Document], ...] = ()
        revision = step.revision
        if is_other:
            self._revision += 1
            revision = self._revision
        else:
            held = (old for old in step.before if old() is not None)
            before = (*held, weakref.ref(step.document))
        self._steps[place] = replace(step, document=document, revision=revision, before=before)
        for later in (place, place + 1):
            if 0 < later < len(self._steps):
                self._reckon(later)

    def _reckon(self, place: int) -> None:
        step = self._steps[place]
        pair = difference(self._steps[place - 1].document, step.document)
        removed, added = (STEP_BYTES + count for count in pair)
        is_past = place <= self._position
        self._held += removed - step.removed if is_past else added - step.added
        self._steps[place] = replace(step, removed=removed, added=added)

    def end_merge(self) -> None:
        """Let the next step stand by itself, whatever its key."""
        self._open = False

    def undo(self) -> Document:
        """Go one step back, where there is one, and return the present snapshot."""
        return self.go_to(self._position - 1)

    def redo(self) -> Document:
        """Go one step forward, where there is one, and return the present snapshot."""
        return self.go_to(self._position + 1)

    def go_to(self, position: int) -> Document:
        """Go to one of the `entries` (the nearest there is) and return the present snapshot."""
        self._open = False
        target = max(0, min(position, len(self._steps) - 1))
        for step in self._steps[self._position + 1 : target + 1]:
            self._held += step.removed - step.added
        for step in self._steps[target + 1 : self._position + 1]:
            self._held += step.added - step.removed
        self._position = target
        return self.document

    def mark_saved(self, document: Document | None = None) -> None:
        """Remember which snapshot is on the disk.

        Parameters
        ----------
        document : Document, optional
            What was written, where that was an earlier snapshot: a save in another thread
            ends after the person has drawn on.
        """
        self._open = False
        written = self.document if document is None else document
        for step in self._steps:
            if step.document is written or any(old() is written for old in step.before):
                self._saved = step.revision
