"""How often a value that is dragged is taken: more often than it can be shown is in its way.

A mouse tells of sixty places in a second and more, and each value that is taken is checked,
recorded and shown in every panel, which leaves no processor for the shape itself. So the first
value is taken at once, the newest one at each beat, and the last one when the drag ends.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

from PySide6.QtCore import QObject, QTimer

__all__ = ["DragPace"]

BEAT: Final = 40
"""Time between two values that are taken, milliseconds."""


class DragPace(QObject):
    """Hands on the values of one row.

    Parameters
    ----------
    take : callable
        Called with a value, and with whether more of the same drag come.
    parent : QObject
    """

    def __init__(self, take: Callable[[Any, bool], None], parent: QObject) -> None:
        super().__init__(parent)
        self._take = take
        self._waiting: tuple[Any, ...] = ()
        self._beat = QTimer(self, interval=BEAT)
        self._beat.timeout.connect(self._hand_on)

    def change(self, value: Any, going: bool) -> None:
        """Take a value now, or with the next beat if it is not the last one."""
        if going and self._beat.isActive():
            self._waiting = (value,)
            return
        self.forget()
        if going:
            self._beat.start()
        self._take(value, going)

    def end(self) -> None:
        """Take what waits: the drag has ended."""
        waiting = self._waiting
        self.forget()
        for value in waiting:
            self._take(value, True)

    def forget(self) -> None:
        """Drop what waits: it was meant for something else."""
        self._waiting = ()
        self._beat.stop()

    def _hand_on(self) -> None:
        waiting, self._waiting = self._waiting, ()
        if not waiting:
            self._beat.stop()
        for value in waiting:
            self._take(value, True)
