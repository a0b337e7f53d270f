"""A stylus for a window under test."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import count
from typing import Final

from PySide6.QtCore import QEvent, QPointF, Qt
from PySide6.QtGui import QInputDevice, QPointingDevice, QTabletEvent
from PySide6.QtWidgets import QApplication, QWidget

__all__ = ["Stylus"]

Place = Sequence[float]
"""Canvas pixels (x, y)."""

FIRM: Final = 0.5
"""Pressure where none is given."""

NO_BUTTON: Final = Qt.MouseButton.NoButton
LEFT: Final = Qt.MouseButton.LeftButton
NO_KEY: Final = Qt.KeyboardModifier.NoModifier
Can = QInputDevice.Capability

_BEGINNINGS = count(1000, 20_000)
"""When styluses come near, ms: long after one another, so touches of two are no double click."""


class Stylus:
    """Draws on a widget as a tablet would, one event after the other.

    Parameters
    ----------
    widget : QWidget
        What is drawn on.
    eraser : bool
        Whether the pen is held the wrong way round.
    keys : Qt.KeyboardModifier
        Keys that are held.
    """

    def __init__(
        self, widget: QWidget, *, eraser: bool = False, keys: Qt.KeyboardModifier = NO_KEY
    ) -> None:
        self.widget = widget
        self.keys = keys
        self.stamp = next(_BEGINNINGS)
        # Events hold a bare pointer to the device: it lives as long as the stylus.
        self.device = QPointingDevice(
            "test stylus",
            7,
            QInputDevice.DeviceType.Stylus,
            QPointingDevice.PointerType.Eraser if eraser else QPointingDevice.PointerType.Pen,
            Can.Position | Can.Pressure | Can.XTilt | Can.YTilt | Can.Hover,
            1,
            3,
        )

    def hover(self, place: Place) -> None:
        """Hold the pen near, without a touch."""
        self._send(QEvent.Type.TabletMove, place, 0.0, NO_BUTTON, NO_BUTTON)

    def press(self, place: Place, pressure: float = FIRM) -> None:
        """Put the pen down."""
        self._send(QEvent.Type.TabletPress, place, pressure, LEFT, LEFT)

    def move(self, place: Place, pressure: float = FIRM) -> None:
        """Move the pen that is down."""
        self._send(QEvent.Type.TabletMove, place, pressure, NO_BUTTON, LEFT)

    def lift(self, place: Place) -> None:
        """Lift the pen."""
        self._send(QEvent.Type.TabletRelease, place, 0.0, LEFT, NO_BUTTON)

    def draw(
        self,
        points: Iterable[Place],
        *,
        pressure: Sequence[float] | None = None,
        lift: bool = True,
    ) -> None:
        """Draw along places (canvas pixels), and lift the pen at the last one.

        `pressure` (0 … 1) has a value for each place; even where it is not given.
        """
        first, *rest = points
        firm, *further = pressure if pressure is not None else [FIRM] * (1 + len(rest))
        self.press(first, firm)
        for place, firmness in zip(rest, further, strict=True):
            self.move(place, firmness)
        QApplication.processEvents()
        if lift:
            self.lift(rest[-1] if rest else first)

    def _send(
        self,
        kind: QEvent.Type,
        place: Place,
        pressure: float,
        button: Qt.MouseButton,
        buttons: Qt.MouseButton,
    ) -> None:
        here = QPointF(*map(float, place))
        self.stamp += 5
        event = QTabletEvent(
            kind, self.device, here, QPointF(self.widget.mapToGlobal(here)), pressure,
            0.0, 0.0, 0.0, 0.0, 0.0, self.keys, button, buttons,
        )  # fmt: skip
        event.setTimestamp(self.stamp)
        QApplication.sendEvent(self.widget, event)
