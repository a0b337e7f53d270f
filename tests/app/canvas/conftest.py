"""A pen that can be moved by a test, and a session that only takes notes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from PySide6.QtCore import QEvent, QObject, QPointF, Qt, Signal
from PySide6.QtGui import QInputDevice, QPointingDevice, QTabletEvent
from PySide6.QtWidgets import QApplication

from bozzetto.geometry.mesh import Mesh
from bozzetto.scene import LIGHT, Handle, Layer, Lines, Scene, Shaded
from bozzetto.view.camera import Camera
from bozzetto_app.canvas.canvas import Canvas

Cap = QInputDevice.Capability


@dataclass(frozen=True)
class FakeTool:
    id: str
    gesture: str
    aims: bool = False


class FakeAdvising(QObject):
    """What a modeler says of the view: whatever a test wants."""

    changed = Signal()

    def __init__(self):
        super().__init__()
        self.advice = None
        self.about = None
        self.scene = Scene()

    def holds_eye(self, camera):
        return self.advice is not None and self.advice.pinned

    def say(self, advice):
        self.advice = advice
        self.changed.emit()


class FakePicturing(QObject):
    """Notes which pictures come."""

    taken = Signal(str)

    def __init__(self, calls):
        super().__init__()
        self.calls = calls

    def take_file(self, path, *, under=False):
        self.calls.append(("take_file", path, under))

    def take_image(self, image, name, *, under=False):
        self.calls.append(("take_image", image, under))


class FakeSession(QObject):
    """The names of the real session that the canvas uses; every call is noted."""

    scene_changed = Signal()
    live_changed = Signal()
    pending_changed = Signal()
    tool_changed = Signal()
    camera_changed = Signal()
    view_style_changed = Signal()
    noticed = Signal(object)
    settled = Signal(str)

    def __init__(self):
        super().__init__()
        self.camera = Camera()
        self.advising = FakeAdvising()
        self.scene = Scene()
        self.live_scene = Scene()
        self.pending = self.marked_ink = ()
        self.active_modeler = ""
        self.tools = (FakeTool("draw", "ink"), FakeTool("mark", "tap"), FakeTool("edit", "drag"))
        self.active_tool = "draw"
        self.shading = "clay"
        self.show_grid = self.is_dragging = False
        self.show_ghost_ink = True
        self.selected = self.selected_model = None
        self.calls = []
        self.picturing = FakePicturing(self.calls)

    def set_camera(self, camera):
        self.camera = camera
        self.camera_changed.emit()

    def set_scene(self, scene):
        self.scene = scene
        self.scene_changed.emit()

    def named(self, name):
        return [call for call in self.calls if call[0] == name]

    @property
    def strokes(self):
        return [call[1] for call in self.named("pen_lifted")]

    def pen_moved(self, stroke):
        self.calls.append(("pen_moved", stroke))

    def pen_lifted(self, stroke):
        self.calls.append(("pen_lifted", stroke))

    def escape(self):
        self.calls.append(("escape",))
        return bool(self.pending)

    def pen_cancelled(self):
        self.calls.append(("pen_cancelled",))

    def tapped(self, x, y, *, shift, ctrl):
        self.calls.append(("tapped", x, y, shift, ctrl))

    def tap_moved(self, x, y, *, shift, ctrl):
        self.calls.append(("tap_moved", x, y, shift, ctrl))

    def handle_moved(self, handle, path, *, shift, ctrl):
        self.calls.append(("handle_moved", handle, path, shift, ctrl))

    def handle_released(self, handle, path, *, shift, ctrl):
        self.calls.append(("handle_released", handle, path, shift, ctrl))

    def explain_gesture(self, meant):
        self.calls.append(("explain_gesture", meant))

    def tell(self, text):
        self.calls.append(("tell", text))

    def complain(self, problem):
        self.calls.append(("complain", str(problem)))

    def import_file(self, path):
        self.calls.append(("import_file", path))

    def open(self, path):
        self.calls.append(("open", path))


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
    return FakeSession()


@pytest.fixture
def canvas(qtbot, session):
    made = Canvas(session, LIGHT)
    qtbot.addWidget(made)
    made.resize(800, 600)
    made.show()
    return made


@pytest.fixture
def pen(canvas):
    return Pen(canvas)


@pytest.fixture
def eraser(canvas):
    return Pen(canvas, eraser=True)
