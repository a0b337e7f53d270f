"""The document on the sheet: its snapshots, its history, its file name and the waiting ink."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Signal

from bozzetto.document.applied_ink import take
from bozzetto.document.history import History
from bozzetto.document.links import with_sources_added
from bozzetto.document.model import Document, Model
from bozzetto.document.waiting_ink import Waiting, WaitingStroke, strokes_of
from bozzetto_app.i18n import tr

if TYPE_CHECKING:
    from bozzetto.ink.stroke import Stroke

__all__ = ["DocumentModel"]


class DocumentModel(QObject):
    """One document with its history.

    Attributes
    ----------
    history : History
        Another object for each document that is opened.
    path : Path, optional
        The file of the document.
    read_only : bool
        Whether the file must not be overwritten.
    is_dragging : bool
        Whether a value is being dragged, so that the document changes again in a moment.

    Signals
    -------
    models_changed
        The models may differ. Emitted for every value of a drag, and before `changed`, so
        that the selection and the scene are up to date when `changed` arrives.
    changed
        The snapshot, the file name or the saved state differs. While a value is dragged it is
        not emitted for every value, but once the drag ends or pauses: most listeners have
        nothing to show of a value that is replaced in a moment.
    waiting_changed
        The waiting ink differs, or what is known about it.
    taken : str, tuple of Stroke
        Waiting ink is part of a model (id) now; before `applied`.
    applied : str
        A gesture or a command has produced this model (id).
    jumped : list of str, bool
        The person moved in the history; ids of the models that came back, and whether any model
        is another one than before.
    closing : Document
        This document is about to replace the one on the sheet.
    opened
        Another document is on the sheet.
    """

    models_changed = Signal()
    changed = Signal()
    waiting_changed = Signal()
    taken = Signal(str, object)
    applied = Signal(str)
    jumped = Signal(object, bool)
    closing = Signal(object)
    opened = Signal()

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.history = History(Document())
        self.path: Path | None = None
        self.read_only = False
        self.is_dragging = False
        self._recovered = False
        self._reported: Waiting = ()

    @property
    def document(self) -> Document:
        """The snapshot that is shown now."""
        return self.history.document

    @property
    def title(self) -> str:
        """Name of the document for the title of the window."""
        return self.path.stem if self.path else tr("Session", "Untitled")

    @property
    def is_modified(self) -> bool:
        """Whether closing would lose something."""
        return self._recovered or self.history.is_modified

    @property
    def pending(self) -> tuple[Stroke, ...]:
        """Strokes that no modeler has taken yet; see `Document.waiting`."""
        return strokes_of(self.document.waiting)

    @property
    def marked_ink(self) -> Waiting:
        """Waiting ink that was refused, or whose plugin failed."""
        return tuple(one for one in self.document.waiting if one.is_marked)

    # -- changing --

    def commit(
        self,
        label: str,
        document: Document,
        merge_key: str | None = None,
        *,
        is_back: Callable[[Document], bool] = lambda before: False,
    ) -> None:
        """Replace the snapshot, as one step of the history.

        Parameters
        ----------
        label : str
            Name of the step.
        document : Document
            The new snapshot.
        merge_key : str, optional
            Steps with the same key become one; it marks the values of a drag.
        is_back : callable
            Whether the value that is dragged is the one in the snapshot before the drag: then
            that one is taken again, and no step is left.
        """
        before = self.history.before_merge(merge_key)
        if before is not None and is_back(before):
            document = before
        self.history.apply(label, document, merge_key)
        self._models_replaced(dragging=merge_key is not None)

    def amend(self, document: Document) -> None:
        """Replace the snapshot without a step of the history."""
        self.history.amend(document)
        self._models_replaced()

    def set_waiting(self, label: str, waiting: Waiting, *, drawn: bool = False) -> None:
        """Replace the waiting ink, as one step of the history; no model changes.

        Parameters
        ----------
        label : str
            Name of the step.
        waiting : tuple of WaitingStroke
            All ink that waits now.
        drawn : bool
            Whether a new stroke is among it; see `History.apply`.
        """
        self.history.apply(label, self.document.with_waiting(waiting), drawn=drawn)
        self._snapshot_replaced()

    def revise_waiting(self, change: Callable[[Waiting], Waiting]) -> None:
        """Note what is known about waiting ink in every snapshot; no step of the history."""
        self.history.revise(lambda document: document.with_waiting(change(document.waiting)))
        self._report_waiting()

    def apply_model(
        self,
        label: str,
        model: Model,
        *,
        is_new: bool,
        only_chosen: bool = False,
        used: tuple[Stroke, ...] = (),
        hidden: Sequence[str] = (),
    ) -> None:
        """Put the result of a gesture or command into the document.

        A gesture that only chose another part is no step of the history.

        Parameters
        ----------
        label : str
            Name of the step.
        model : Model
            The result; it replaces the model with its id.
        is_new : bool
            Whether the document does not hold it yet; it then gets a name of its own.
        only_chosen : bool
            Whether only the choice of a part differs.
        used : tuple of Stroke
            Waiting ink that is part of the model now; see `bozzetto.document.applied_ink.take`.
        hidden : sequence of str
            Ids of objects and underlays that are hidden in the same step.
        """
        if only_chosen and not used:
            self.amend(self.document.with_model(model))
            return
        there = self.document
        if is_new:
            there = with_sources_added(there, model)
            model = replace(model, name=there.unused_name(model.name))
        if hidden or there is not self.document:
            document = there.with_model(model)
            for other in self.document:
                if other.id in hidden:
                    document = document.with_model(replace(other, visible=False))
            under = tuple(
                replace(one, visible=False) if one.id in hidden else one
                for one in document.underlays
            )
            self.history.apply(label, replace(document, underlays=under))
        else:
            take(self.history, label, model, used)
        self._models_replaced()
        if used:
            self.taken.emit(model.id, used)
        self.applied.emit(model.id)

    def undo(self) -> None:
        """Go one step back in the history."""
        self.go_to(self.history.position - 1)

    def redo(self) -> None:
        """Go one step forward in the history."""
        self.go_to(self.history.position + 1)

    def go_to(self, index: int) -> None:
        """Jump to a step of the history."""
        before = self.document.models
        self.history.go_to(index)
        self._models_replaced()
        known = {model.id for model in before}
        returned = [model.id for model in self.document if model.id not in known]
        self.jumped.emit(returned, self.document.models is not before)

    def end_drag(self) -> None:
        """Note that the drag of a value has ended, or pauses."""
        if self.is_dragging:
            self.is_dragging = False
            self._snapshot_replaced()

    def _models_replaced(self, *, dragging: bool = False) -> None:
        self.is_dragging = dragging
        self.models_changed.emit()
        if not dragging:
            self._snapshot_replaced()

    def _snapshot_replaced(self) -> None:
        self.changed.emit()
        self._report_waiting()

    def _report_waiting(self) -> None:
        if self.document.waiting is not self._reported:
            self._reported = self.document.waiting
            self.waiting_changed.emit()

    # -- files --

    def show(
        self,
        document: Document,
        path: Path | None,
        *,
        read_only: bool = False,
        saved: bool = True,
        pending: tuple[Stroke, ...] = (),
    ) -> None:
        """Put another document on the sheet.

        Parameters
        ----------
        document : Document
            The document to show.
        path : Path, optional
            The file of the document.
        read_only : bool
            Whether the file must not be overwritten.
        saved : bool
            False for a recovered document, which differs from its file.
        pending : tuple of Stroke
            Strokes that join the waiting ink of the document.
        """
        if pending:
            more = tuple(map(WaitingStroke, pending))
            document = document.with_waiting((*document.waiting, *more))
        self.closing.emit(document)
        self.history = History(document)
        self._recovered = not saved
        self.path = path
        self.read_only = read_only
        self._models_replaced()
        self.opened.emit()

    def saved_as(self, path: Path, snapshot: Document) -> None:
        """Note that a snapshot is safe in a file."""
        self.path = path
        self.read_only = False
        self.history.mark_saved(snapshot)
        self._recovered = False
        self.changed.emit()

    def allow_saving(self) -> None:
        """Allow the file of the document to be overwritten from now on."""
        self.read_only = False
        self.changed.emit()
