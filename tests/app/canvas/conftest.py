"""A pen that can be moved by a test, and a session that only takes notes."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QEvent, QPointF, Qt
from PySide6.QtGui import QInputDevice, QPointingDevice, QTabletEvent
from PySide6.QtWidgets import QApplication

from bozzetto.geometry.mesh import Mesh
from bozzetto.scene import LIGHT, Handle, Layer, Lines, Scene, Shaded
from bozzetto_app.canvas.canvas import Canvas
from tests.app.fake_session import EmptySession, ToolInfo

Cap = QInputDevice.Capability


def FakeTool(id, gesture, aims=False):
    return ToolInfo(id, id, None, "", gesture, aims=aims)


class Pen:
    """Sends tablet events to a widget like a stylus would.

    The device is kept alive by this object: events hold a bare pointer to it.
    """

    def __init__(self, widget, *, eraser=False):
        self.widget = widget
        self.stamp = 1000
        self.step = 5
        self.buttons = Qt.MouseButton.NoButton
        self.modifiers = Qt.KeyboardModifier.NoModifier
        end = QPointingDevice.PointerType.Eraser if eraser else QPointingDevice.PointerType.Pen
        self.device = QPointingDevice(
            "test pen",
            7,
            QInputDevice.DeviceType.Stylus,
            end,
            Cap.Position | Cap.Pressure | Cap.XTilt | Cap.YTilt | Cap.Rotation | Cap.Hover,
            1,
            3,
        )

    def event(self, kind, x, y, pressure=0.0, button=Qt.MouseButton.NoButton, tilt=(0.0, 0.0),
              twist=0.0):  # fmt: skip
        place = QPointF(x, y)
        event = QTabletEvent(
            kind, self.device, place, QPointF(self.widget.mapToGlobal(place)), float(pressure),
            float(tilt[0]), float(tilt[1]), 0.0, float(twist), 0.0, self.modifiers, button,
            self.buttons,
        )  # fmt: skip
        self.stamp += self.step
        event.setTimestamp(self.stamp if self.step else 0)
        return event

    def send(self, *args, **kwargs):
        event = self.event(*args, **kwargs)
        QApplication.sendEvent(self.widget, event)
        return event.isAccepted()

    def press(self, x, y, pressure=0.5, button=Qt.MouseButton.LeftButton, **more):
        self.buttons |= button
        return self.send(QEvent.Type.TabletPress, x, y, pressure, button, **more)

    def move(self, x, y, pressure=0.5, **more):
        return self.send(QEvent.Type.TabletMove, x, y, pressure, **more)

    def release(self, x, y, button=Qt.MouseButton.LeftButton):
        self.buttons &= ~button
        return self.send(QEvent.Type.TabletRelease, x, y, 0.0, button)

    def stroke(self, points, button=Qt.MouseButton.LeftButton):
        (x, y, pressure), *rest = points
        self.press(x, y, pressure, button)
        for x, y, pressure in rest:
            self.move(x, y, pressure)
        self.release(x, y, button)

    def comes(self):
        event = self.event(QEvent.Type.TabletEnterProximity, 0, 0)
        QApplication.sendEvent(QApplication.instance(), event)

    def leaves(self):
        event = self.event(QEvent.Type.TabletLeaveProximity, 0, 0)
        QApplication.sendEvent(QApplication.instance(), event)


def box_mesh(half):
    x, y, z = half
    corners = [(sx * x, sy * y, sz * z) for sx in (-1, 1) for sy in (-1, 1) for sz in (-1, 1)]
    faces = [
        (0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1),
        (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3),
    ]  # fmt: skip
    vertices = np.array(corners, np.float32)[np.array(faces).ravel()]
    return Mesh(vertices, np.arange(len(vertices), dtype=np.int32).reshape(-1, 3))


@pytest.fixture
def box_scene():
    """A clay box of 100 mm, with an ink line behind it and a handle before it."""
    line = Lines(np.array([(-120, 80, 0), (120, 80, 0)], np.float32), width=3.0)
    items = (Shaded(box_mesh((50, 50, 50))), line, Handle("corner", (50.0, -50.0, 50.0)))
    return Scene((Layer("box", items, owner="m1"),))


@pytest.fixture
def session(qapp):
    return EmptySession()


@pytest.fixture
def canvas(qtbot, session):
    made = Canvas(session, LIGHT)
    qtbot.addWidget(made)
    made.resize(800, 600)
    made.show()
    made.viewports.first_painted.emit()  # nobody waits for it in each test
    return made


@pytest.fixture
def pen(canvas):
    return Pen(canvas)


@pytest.fixture
def eraser(canvas):
    return Pen(canvas, eraser=True)
