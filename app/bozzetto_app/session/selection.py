"""The selected model."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Signal

from bozzetto_app.i18n import tr

if TYPE_CHECKING:
    from bozzetto.document.model import Document, Model
    from bozzetto_app.session.document_model import DocumentModel

__all__ = ["Selection", "target_of", "why_locked"]


def why_locked() -> str:
    """Return what is said where a locked object was to be changed."""
    return tr("Session", "This object is locked. Unlock it to change it.")


def target_of(model: Model | None, modeler_id: str) -> Model | None:
    """Return the selected model if the next gesture of a modeler changes it, else None.

    Parameters
    ----------
    model : Model, optional
        The selected model.
    modeler_id : str
        The modeler that the gesture is for.
    """
    if model is None or model.modeler != modeler_id or model.locked or not model.visible:
        return None
    return model


class Selection(QObject):
    """The model that is selected in a document.

    A model that leaves the document is no longer selected. A model that a gesture made is
    selected, and so is the last model of a document that is opened. Where undo takes away the
    selected model, the one that was selected before is so again, if it is of the same modeler.

    Attributes
    ----------
    id : str, optional
        Id of the selected model.

    Signals
    -------
    changed
        Another model is selected, or none; or the selected one belongs to another modeler now.
    """

    changed = Signal()

    def __init__(self, drawing: DocumentModel, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.id: str | None = None
        self._modeler = ""
        self._before: tuple[str | None, str] = (None, "")
        self._lost = ""
        self._drawing = drawing
        drawing.models_changed.connect(self._look_at_selected)
        drawing.applied.connect(self.select)
        drawing.jumped.connect(self._select_returned)
        drawing.closing.connect(self._clear)
        drawing.opened.connect(self._select_last)

    @property
    def model(self) -> Model | None:
        """The selected model itself."""
        for model in self._drawing.document:
            if model.id == self.id:
                return model
        return None

    def target(self, modeler_id: str) -> Model | None:
        """Return the model that the next gesture of a modeler changes; None for a new one."""
        return target_of(self.model, modeler_id)

    def select(self, model_id: str | None) -> None:
        """Select a model, or none."""
        self._lost = ""
        if model_id != self.id:
            self._before = self.id, self._modeler
            self.id = model_id
            self._note_modeler()
            self.changed.emit()

    def _look_at_selected(self) -> None:
        """Drop a model that was removed, and tell of one that another modeler has read."""
        model, before = self.model, self._modeler
        if model is None:
            earlier = self._before
            lost = "" if self.id is None else before
            self.select(None)
            self._before, self._lost = earlier, lost
            return
        self._modeler = model.modeler
        if before not in ("", model.modeler):
            self.changed.emit()

    def _note_modeler(self) -> None:
        model = self.model
        self._modeler = "" if model is None else model.modeler

    def _select_returned(self, returned: list[str]) -> None:
        """Select a model that undo brought back, or the one before, where nothing is selected."""
        earlier, modeler = self._before
        lost, self._lost = self._lost, ""
        if self.id is not None:
            return
        if returned:
            self.select(returned[-1])
        elif lost and lost == modeler and any(one.id == earlier for one in self._drawing.document):
            self.select(earlier)

    def _clear(self, coming: Document) -> None:
        self._before, self._lost = (None, ""), ""
        self.id = None  # `changed` follows when the next document is there

    def _select_last(self) -> None:
        models = self._drawing.document.models
        self.id = models[-1].id if models else None
        self._note_modeler()
        self.changed.emit()
