"""Replays of recorded drawings on the sheet, one at a time."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Signal

from bozzetto.errors import UserError

if TYPE_CHECKING:
    from bozzetto.ink.drawing import Drawing
    from bozzetto_app.session.pen_replay import PenReplay
    from bozzetto_app.session.session import Session

__all__ = ["Replays"]


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
        from bozzetto_app.session.step_replay import StepReplay
        from bozzetto_app.session.stroke_replay import StrokeReplay

        self.stop()
        view = self._session.view
        view.set_camera(drawing.camera.with_viewport(*view.camera.viewport))
        self.began.emit()
        kind = StepReplay if drawing.steps else StrokeReplay
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
