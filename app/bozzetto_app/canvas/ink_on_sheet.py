"""Ink on the sheet: strokes that no modeler has taken yet, and what is wrong with them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bozzetto_app.canvas.overlay.waiting_ink import MarkedLine

if TYPE_CHECKING:
    from bozzetto.ink.stroke import Stroke
    from bozzetto_app.canvas.overlay.wet_ink import InkOverlay
    from bozzetto_app.session.session import Session

__all__ = ["InkOnSheet"]


class InkOnSheet:
    """Shows the ink that waits on the overlay.

    Parameters
    ----------
    session : Session
    overlay : InkOverlay
    """

    def __init__(self, session: Session, overlay: InkOverlay) -> None:
        self._session, self._overlay = session, overlay
        self._marked = 0

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

    def _good_ink(self) -> tuple[Stroke, ...]:
        return tuple(
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
