"""Replay of a recorded drawing: its ink takes the same way as that of a person."""

from __future__ import annotations

import time

from PySide6.QtCore import QObject, QTimer, Signal

from bozzetto.ink.drawing import Drawing
from bozzetto.ink.stroke import COLUMNS, Stroke
from bozzetto_app.session.session import Session

__all__ = ["Replay"]

TICK_MS = 33
"""Milliseconds between two steps of the pen."""

UNTIMED_SAMPLES_PER_SECOND = 200.0
"""Speed of strokes that were recorded without time."""

PAUSE = 0.35
"""Seconds between two strokes."""


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
        self._context = session.context
        self._strokes = list(drawing.strokes)
        self._facts, self._pictures = drawing.extra, drawing.pictures
        self._speed = speed
        self._pen_down = 0.0
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
        if stroke.has_time:
            shown = int((stroke.t <= stroke.t[0] + passed).sum())
        else:
            shown = int(passed * UNTIMED_SAMPLES_PER_SECOND)
        if shown >= len(stroke):
            self._strokes.pop(0)
            self._pen_down = time.monotonic() + PAUSE
            self._gestures.stroke_lifted(stroke)
            self.inked.emit(None)
        elif shown > 1:
            beginning = _beginning(stroke, shown)
            self._gestures.stroke_moved(beginning)
            self.inked.emit(beginning)


def _beginning(stroke: Stroke, count: int) -> Stroke:
    """Return the first samples of a stroke."""
    columns = {name: getattr(stroke, name)[:count] for name in COLUMNS}
    if not stroke.has_pressure:
        del columns["pressure"]
    if not stroke.has_time:
        del columns["t"]
    return Stroke(camera=stroke.camera, tool=stroke.tool, color=stroke.color, **columns)
