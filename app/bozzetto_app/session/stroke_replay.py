"""Replay of a recorded drawing: its ink takes the same way as that of a person."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bozzetto_app.session.pen_replay import PenReplay

if TYPE_CHECKING:
    from bozzetto.ink.stroke import Stroke

__all__ = ["StrokeReplay"]


class StrokeReplay(PenReplay):
    """Plays a drawing into a session, stroke by stroke."""

    def start(self) -> None:
        """Put the pen down."""
        context = self.session.gestures.context
        context.facts, context.pictures = self.drawing.facts, self.drawing.pictures
        self.strokes = list(self.drawing.strokes)
        self._runs = True
        self.draw()

    def stop(self) -> None:
        """Take the pen away; finished strokes stay."""
        if self._runs:
            self.session.gestures.cancel()
            self.take_pen_away()
            self._end()

    def moved(self, stroke: Stroke) -> None:
        self.session.gestures.stroke_moved(stroke)

    def lifted(self, stroke: Stroke) -> None:
        self.session.gestures.stroke_lifted(stroke)
        self.inked.emit(None)

    def all_lifted(self) -> None:
        if self.session.drawing.pending:
            self.session.gestures.commit()
        self._end()

    def _end(self) -> None:
        self._runs = False
        context = self.session.gestures.context
        context.facts, context.pictures = {}, {}
        self.finished.emit()
