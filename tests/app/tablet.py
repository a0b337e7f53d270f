"""A stylus and a mouse for a whole window, and paths for them to follow."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from PySide6.QtCore import QEvent, QPointF, Qt
from PySide6.QtGui import QMouseEvent
from PySide6.QtWidgets import QApplication, QWidget

from bozzetto.ink.stroke import Stroke
from bozzetto.view.camera import Camera
from bozzetto_app.testing.stylus import Stylus as Stylus

NO_BUTTON, LEFT = Qt.MouseButton.NoButton, Qt.MouseButton.LeftButton
NO_KEY = Qt.KeyboardModifier.NoModifier


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


def draw(session, settle, *keepers, **more):
    """Draw a circle, or a part of one, and wait until it is taken and kept."""
    session.gestures.stroke_lifted(stroke_of(circle(**more), session.view.camera))
    settle(session, *keepers)
