"""Ink on the sheet: strokes that wait for a modeler, and those whose shape is not shown yet."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

from PySide6.QtCore import QObject

from bozzetto_app.canvas.overlay.waiting_ink import MarkedLine

if TYPE_CHECKING:
    from bozzetto.ink.stroke import Stroke
    from bozzetto_app.canvas.overlay.wet_ink import InkOverlay
    from bozzetto_app.session.session import Session

__all__ = ["InkOnSheet"]


class _Taken(NamedTuple):
    """A stroke that is part of a state of a model (id) now."""

    model: str
    state: Any
    stroke: Stroke


class InkOnSheet(QObject):
    """Shows the ink that waits on the overlay, and after that until its shape is shown.

    Without that a stroke would be gone for as long as the modeler works on what it was taken for.

    Parameters
    ----------
    session : Session
    overlay : InkOverlay
    """

    def __init__(self, session: Session, overlay: InkOverlay) -> None:
        super().__init__(overlay)
        self._session, self._overlay = session, overlay
        self._marked = 0
        self._taken: list[_Taken] = []
        session.drawing.taken.connect(self._take)
        session.drawing.jumped.connect(self._drop_taken)
        session.drawing.closing.connect(self._drop_taken)
        session.solver.changed.connect(self._shown)
        session.solver.busy_changed.connect(self._worked)

    @property
    def is_empty(self) -> bool:
        """Whether no ink is shown."""
        return not (self._taken or self._session.drawing.pending)

    def show(self) -> None:
        """Show all that waits as it is now."""
        marked = self._marked_ink()
        if len(marked) < self._marked:
            self._overlay.light_up(())  # what was wrong is gone, or was mended
        self._marked = len(marked)
        self._overlay.set_pending(self._good_ink(), self._session.view.camera, marked)

    def follow(self, stroke: Stroke | None) -> None:
        """Show the ink of a stroke that no hand draws here; None when its pen is up."""
        strokes = self._good_ink() if stroke is None else (*self._good_ink(), stroke)
        self._overlay.set_pending(strokes, self._session.view.camera, self._marked_ink())

    def _take(self, model_id: str, strokes: tuple[Stroke, ...]) -> None:
        if self._session.solver.busy:
            state = self._session.drawing.document.model(model_id).state
            self._taken += (_Taken(model_id, state, stroke) for stroke in strokes)
            self.show()

    def _shown(self, model_id: str, is_newest: bool) -> None:
        """Let go of the ink that is in the shape which is shown now."""
        if not self._taken:
            return
        shown = self._session.solver.shown(model_id)
        own = [one for one in self._taken if one.model == model_id]
        last = max(
            (place for place, one in enumerate(own, 1) if shown and one.state is shown.state),
            default=0,
        )
        gone = own if is_newest else own[:last]
        self._taken = [one for one in self._taken if all(one is not other for other in gone)]
        self.show()

    def _worked(self, is_busy: bool) -> None:
        if not is_busy:
            self._drop_taken()

    def _drop_taken(self, *_: Any) -> None:
        if self._taken:
            self._taken = []
            self.show()

    def _good_ink(self) -> tuple[Stroke, ...]:
        return *(one.stroke for one in self._taken), *(
            stroke
            for stroke in self._session.drawing.pending
            if all(stroke is not one.stroke for one in self._session.drawing.marked_ink)
        )

    def _marked_ink(self) -> list[MarkedLine]:
        """Ink with which something is wrong, lit where the tool that said so is in the hand."""
        session = self._session
        hand = session.toolbox.modeler, session.toolbox.tool
        return [
            MarkedLine.of(one, session.view.camera, is_lit=one.is_for(*hand))
            for one in session.drawing.marked_ink
        ]
