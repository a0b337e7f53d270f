"""A stylus and a mouse for a whole window, and paths for them to follow."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from PySide6.QtCore import QEvent, QPointF, Qt
from PySide6.QtGui import QInputDevice, QMouseEvent, QPointingDevice, QTabletEvent
from PySide6.QtWidgets import QApplication, QWidget

from bozzetto.ink.stroke import Stroke
from bozzetto.view.camera import Camera

NO_BUTTON, LEFT = Qt.MouseButton.NoButton, Qt.MouseButton.LeftButton
NO_KEY = Qt.KeyboardModifier.NoModifier
Can = QInputDevice.Capability


def circle(x=640.0, y=360.0, radius=120.0, samples=90, share=1.0, wave=0.0):
    """Points (n, 2) on a circle, or on a `share` of one; `wave` makes it a clover leaf."""
    turn = np.linspace(0.0, 2 * np.pi * share, samples)
    away = radius * (1.0 + wave * np.cos(3 * turn))
    return np.column_stack((x + away * np.cos(turn), y + away * np.sin(turn)))


def stroke_of(points, camera: Camera, tool="pen") -> Stroke:
    """A stroke as the canvas would make it, 200 samples a second."""
    points = np.asarray(points, float)
    return Stroke(
        x=points[:, 0],
        y=points[:, 1],
        pressure=np.full(len(points), 0.5),
        t=0.005 * np.arange(len(points)),
        camera=camera,
        tool=tool,
    )


class Stylus:
    """Draws on a widget as a tablet would, one event after the other."""

    def __init__(self, widget: QWidget, *, eraser: bool = False, keys=NO_KEY) -> None:
        self.widget = widget
        self.keys = keys
        self.stamp = 1000
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

    def press(self, place) -> None:
        self._send(QEvent.Type.TabletPress, place, 0.5, LEFT, LEFT)

    def move(self, place) -> None:
        self._send(QEvent.Type.TabletMove, place, 0.5, NO_BUTTON, LEFT)

    def lift(self, place) -> None:
        self._send(QEvent.Type.TabletRelease, place, 0.0, LEFT, NO_BUTTON)

    def draw(self, points: Iterable, *, lift: bool = True) -> None:
        first, *rest = points
        self.press(first)
        for place in rest:
            self.move(place)
        QApplication.processEvents()
        if lift:
            self.lift(place)

    def _send(self, kind, place, pressure, button, buttons) -> None:
        here = QPointF(*map(float, place))
        self.stamp += 5
        event = QTabletEvent(
            kind, self.device, here, QPointF(self.widget.mapToGlobal(here)), pressure,
            0.0, 0.0, 0.0, 0.0, 0.0, self.keys, button, buttons,
        )  # fmt: skip
        event.setTimestamp(self.stamp)
        QApplication.sendEvent(self.widget, event)


class Mouse:
    """Draws on a widget with the left button."""

    def __init__(self, widget: QWidget, *, keys=NO_KEY) -> None:
        self.widget = widget
        self.keys = keys
        self.stamp = 1000

    def draw(self, points: Iterable) -> None:
        first, *rest = points
        self._send(QEvent.Type.MouseButtonPress, first, LEFT, LEFT)
        for place in rest:
            self._send(QEvent.Type.MouseMove, place, NO_BUTTON, LEFT)
        self._send(QEvent.Type.MouseButtonRelease, place, LEFT, NO_BUTTON)

    def _send(self, kind, place, button, buttons) -> None:
        here = QPointF(*map(float, place))
        self.stamp += 5
        event = QMouseEvent(
            kind, here, QPointF(self.widget.mapToGlobal(here)), button, buttons, self.keys
        )
        event.setTimestamp(self.stamp)
        QApplication.sendEvent(self.widget, event)
