"""Pen that draws recorded strokes again, in their time: the base of all replays."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, QTimer, Signal

from bozzetto_app.session.replay_ink import PAUSE, TICK_MS, beginning, samples_after

if TYPE_CHECKING:
    from bozzetto.ink.drawing import Drawing
    from bozzetto.ink.stroke import Stroke
    from bozzetto_app.session.session import Session

__all__ = ["PenReplay"]


class PenReplay(QObject):
    """Draws strokes one after the other; classes derived from it say what becomes of them.

    Parameters
    ----------
    session : Session
    drawing : Drawing
    speed : float
        2 is twice as fast as the drawing was made.

    Attributes
    ----------
    strokes : list of Stroke
        Those that are still to be drawn.

    Signals
    -------
    finished
        After the last stroke or step, or when the replay was stopped.
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
        self.session, self.drawing = session, drawing
        self.strokes: list[Stroke] = []
        self._speed = speed
        self._pen_down = 0.0
        self._whole = False
        self._runs = False
        self._timer = QTimer(self)
        self._timer.setInterval(TICK_MS)
        self._timer.timeout.connect(self._tick)

    def start(self) -> None:
        """Begin."""
        raise NotImplementedError

    def stop(self) -> None:
        """Take the pen away; what was drawn stays."""
        raise NotImplementedError

    def draw(self) -> None:
        """Put the pen down for the first of the strokes."""
        self._pen_down = time.monotonic()
        self._whole = False
        self._timer.start()

    def take_pen_away(self) -> None:
        """Draw no further."""
        self._timer.stop()
        self.inked.emit(None)

    def moved(self, stroke: Stroke) -> None:
        """Do what is to be done when the pen has moved."""

    def lifted(self, stroke: Stroke) -> None:
        """Do what is to be done with a stroke that is whole."""

    def all_lifted(self) -> None:
        """Do what is to be done after the last of the strokes."""

    def _tick(self) -> None:
        if not self.strokes:
            self._timer.stop()
            self.all_lifted()
            return
        passed = (time.monotonic() - self._pen_down) * self._speed
        if passed < 0.0:
            return
        stroke = self.strokes[0]
        if self._whole:
            self._whole = False
            self.strokes.pop(0)
            self._pen_down = time.monotonic() + PAUSE
            self.lifted(stroke)
            return
        shown = samples_after(stroke, passed)
        if shown > 1 or shown >= len(stroke):
            # A slow machine sees every stroke as well, if only once and whole.
            self._whole = shown >= len(stroke)
            so_far = beginning(stroke, shown)
            self.moved(so_far)
            self.inked.emit(so_far)
