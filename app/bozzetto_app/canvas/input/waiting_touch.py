"""A touch of a drawing tool, which waits until it is known what is next."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QObject

if TYPE_CHECKING:
    from bozzetto.plugin.gesture import Tap
    from bozzetto_app.session.session import Session

__all__ = ["WaitingTouch"]


class WaitingTouch(QObject):
    """Gives a touch to the drawing tool in the hand, or to the tool whose touch is next.

    What is next after the last stroke may not be known yet: the touch waits for it, unless the
    hand goes on.

    Parameters
    ----------
    session : Session
    """

    def __init__(self, session: Session, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._session = session
        self._touched: tuple[Tap, bool] | None = None
        self._passed_over = False
        for channel in (session.gestures.edits, session.hints.channel):
            channel.busy_changed.connect(self._answer)

    def take(self, tap: Tap, again: bool) -> None:
        """Take a touch; `again` says whether it is the second one of a double click."""
        self._touched = tap, again and not self._passed_over
        self._session.toolbox.hold(False)  # it was no stroke, and the next tool may be taken
        self._answer()

    def forget(self) -> None:
        """Pass over a touch that still waits."""
        self._passed_over, self._touched = self._touched is not None, None

    def _answer(self) -> None:
        session = self._session
        if self._touched is None or session.gestures.edits.busy or session.hints.channel.busy:
            return
        (tap, again), self._touched = self._touched, None
        active, wanted = session.toolbox.active, session.hints.step.tool
        if active is not None and active.touches:
            session.gestures.tap(tap, again=again)
        elif any(tool.id == wanted and tool.gesture == "tap" for tool in session.toolbox.tools):
            session.toolbox.take_tool(wanted)
            session.gestures.tap(tap, again=again)
        else:
            session.gestures.explain("stroke")
