"""Replay of a recorded drawing: its ink takes the same way as that of a person."""

from __future__ import annotations

import time
from pathlib import Path

from PySide6.QtCore import QObject, QTimer, Signal

from bozzetto.errors import UserError
from bozzetto.ink.drawing import Drawing
from bozzetto_app.session.replay_ink import PAUSE, TICK_MS, beginning, samples_after
from bozzetto_app.session.session import Session
from bozzetto_app.session.step_replay import StepReplay

__all__ = ["Replay", "Replays"]


class Replay(QObject):
    """Plays a drawing into a session, stroke by stroke.

    Parameters
    ----------
    session : Session
    drawing : Drawing
    speed : float
        2 is twice as fast as the drawing was made.

    Signals
    -------
    finished
        After the last stroke, or when the replay was stopped.
    inked : Stroke or None
        The stroke so far; None when its pen was lifted or taken away.
    """

    finished = Signal()
    inked = Signal(object)

    def __init__(
        self,
        session: Session,
        drawing: Drawing,
        *,
        speed: float = 2.0,
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self._drawing, self._gestures = session.drawing, session.gestures
        self._context = session.gestures.context
        self._strokes = list(drawing.strokes)
        self._facts, self._pictures = drawing.facts, drawing.pictures
        self._speed = speed
        self._pen_down = 0.0
        self._whole = False
        self._timer = QTimer(self)
        self._timer.setInterval(TICK_MS)
        self._timer.timeout.connect(self._step)

    def start(self) -> None:
        """Put the pen down."""
        self._context.facts, self._context.pictures = self._facts, self._pictures
        self._pen_down = time.monotonic()
        self._timer.start()

    def stop(self) -> None:
        """Take the pen away; finished strokes stay."""
        if self._timer.isActive():
            self._timer.stop()
            self._gestures.cancel()
            self.inked.emit(None)
            self._end()

    def _end(self) -> None:
        self._context.facts, self._context.pictures = {}, {}
        self.finished.emit()

    def _step(self) -> None:
        if not self._strokes:
            self._timer.stop()
            if self._drawing.pending:
                self._gestures.commit()
            self._end()
            return
        passed = (time.monotonic() - self._pen_down) * self._speed
        if passed < 0:
            return
        stroke = self._strokes[0]
        shown = samples_after(stroke, passed)
        if self._whole:
            self._whole = False
            self._strokes.pop(0)
            self._pen_down = time.monotonic() + PAUSE
            self._gestures.stroke_lifted(stroke)
            self.inked.emit(None)
        elif shown > 1 or shown >= len(stroke):
            # A slow machine sees every stroke as well, if only once and whole.
            self._whole = shown >= len(stroke)
            so_far = beginning(stroke, shown)
            self._gestures.stroke_moved(so_far)
            self.inked.emit(so_far)


class Replays(QObject):
    """Replays drawings on the sheet of a session, one at a time.

    Attributes
    ----------
    current : Replay or StepReplay, optional
        The replay that began last, until it is stopped.
    speed : float
        Of the next replay; see `Replay`.

    Signals
    -------
    began
        A replay is about to begin.
    inked : Stroke or None
        See `Replay`.
    finished
        A replay has ended, or was stopped.
    """

    began = Signal()
    inked = Signal(object)
    finished = Signal()

    def __init__(self, session: Session, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.current: Replay | StepReplay | None = None
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
            session.files.import_file(path)

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
