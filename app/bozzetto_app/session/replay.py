"""Replay of a recorded drawing: its ink takes the same way as that of a person."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Signal

from bozzetto.errors import UserError
from bozzetto_app.session.pen_replay import PenReplay
from bozzetto_app.session.step_replay import StepReplay

if TYPE_CHECKING:
    from bozzetto.ink.drawing import Drawing
    from bozzetto.ink.stroke import Stroke
    from bozzetto_app.session.session import Session

__all__ = ["Replay", "Replays"]


class Replay(PenReplay):
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


class Replays(QObject):
    """Replays drawings on the sheet of a session, one at a time.

    Attributes
    ----------
    current : PenReplay, optional
        The replay that began last, until it is stopped.
    speed : float
        Of the next replay; see `PenReplay`.

    Signals
    -------
    began
        A replay is about to begin.
    inked : Stroke or None
        See `PenReplay`.
    finished
        A replay has ended, or was stopped.
    """

    began = Signal()
    inked = Signal(object)
    finished = Signal()

    def __init__(self, session: Session, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.current: PenReplay | None = None
        self.speed = 2.0
        self._session = session

    def watch(self, modeler_id: str, path: Path) -> None:
        """Replay a sample of a plugin on an empty sheet; open it if it has no strokes."""
        from bozzetto.exchange.import_file import read_drawing

        session = self._session
        try:
            drawing = read_drawing(path, trusted=True)
        except UserError as problem:
            session.notices.complain(problem)
            return
        session.files.new()
        session.toolbox.take_modeler(modeler_id)
        if len(drawing.strokes):
            self.play(drawing)
        else:
            session.files.exchange.import_file(path)

    def play(self, drawing: Drawing) -> None:
        """Replay a drawing on the sheet, seen as it was drawn."""
        self.stop()
        view = self._session.view
        view.set_camera(drawing.camera.with_viewport(*view.camera.viewport))
        self.began.emit()
        kind = StepReplay if drawing.steps else Replay
        self.current = kind(self._session, drawing, speed=self.speed, parent=self)
        self.current.inked.connect(self.inked)
        self.current.finished.connect(self.finished)
        self.current.start()

    def stop(self) -> None:
        """Stop the replay; finished strokes stay."""
        replay, self.current = self.current, None
        if replay is not None:
            replay.stop()
            replay.deleteLater()
