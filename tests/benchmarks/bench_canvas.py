"""The pen's way to the screen: cost of an event, and of a sample of ink."""

from __future__ import annotations

import math
import statistics
import time

import numpy as np
from PySide6.QtCore import QEvent, QPoint, QPointF, Qt
from PySide6.QtGui import (
    QColor,
    QImage,
    QInputDevice,
    QPainter,
    QPaintEvent,
    QPen,
    QPointingDevice,
    QPolygonF,
    QRegion,
    QTabletEvent,
)
from PySide6.QtWidgets import QApplication, QWidget

from bozzetto.scene import LIGHT, Image, Layer, Lines, Scene
from bozzetto.view.camera import Camera
from bozzetto_app.canvas.canvas import Canvas
from bozzetto_app.canvas.overlay.loupe import Loupe
from bozzetto_app.canvas.overlay.wet_ink import InkOverlay
from tests.app.fake_session import EmptySession
from tests.benchmarks.timing import Row, in_turn

EVENTS = 5000
SAMPLES = 2500
LATE = 2000
"""Samples after which a stroke counts as long."""


class Repainted(QWidget):
    """What a first attempt does: paint the whole polyline for every sample."""

    def __init__(self) -> None:
        super().__init__()
        self.points: list[QPointF] = []

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(QPen(QColor(*LIGHT.ink), 3))
        painter.drawPolyline(QPolygonF(self.points))
        painter.end()


def curve(i: int) -> tuple[float, float, float]:
    """A long lively stroke on a sheet of 1920 × 1080."""
    return (
        960 + 800 * math.sin(0.013 * i) * math.cos(0.0031 * i),
        540 + 480 * math.sin(0.0111 * i),
        0.5 + 0.4 * math.sin(0.05 * i),
    )


def pen_events(widget: QWidget) -> tuple[QPointingDevice, list[QTabletEvent]]:
    """A stroke as a tablet sends it; the device must outlive the events."""
    capability = QInputDevice.Capability
    device = QPointingDevice(
        "bench pen", 7, QInputDevice.DeviceType.Stylus, QPointingDevice.PointerType.Pen,
        capability.Position | capability.Pressure, 1, 3,
    )  # fmt: skip
    kinds = [QEvent.Type.TabletPress] + [QEvent.Type.TabletMove] * EVENTS
    left, none = Qt.MouseButton.LeftButton, Qt.MouseButton.NoButton
    made = []
    for i, kind in enumerate(kinds):
        x, y, pressure = curve(i)
        place = QPointF(x, y)
        event = QTabletEvent(
            kind, device, place, place, pressure, 3.0, 5.0, 0.0, 0.0, 0.0,
            Qt.KeyboardModifier.NoModifier, left if i == 0 else none, left,
        )  # fmt: skip
        event.setTimestamp(1000 + i)
        made.append(event)
    return device, made


def handler() -> Row:
    """Microseconds from Qt's call of the handler to its return, per event."""
    canvas = Canvas(EmptySession(), LIGHT)
    canvas.resize(1920, 1080)
    canvas.show()
    QApplication.processEvents()
    _device, (press, *moves) = pen_events(canvas)
    QApplication.sendEvent(canvas, press)
    times = []
    for begin in range(0, EVENTS, 100):
        started = time.perf_counter()
        for event in moves[begin : begin + 100]:
            QApplication.sendEvent(canvas, event)
        times.append((time.perf_counter() - started) / 100 * 1e6)
        QApplication.processEvents()
    canvas.hand.cancel()
    canvas.close()
    return Row("canvas", "Pen event, sent and taken", statistics.median(times), "µs", "≤ 10 µs")


def ink() -> Row:
    """Milliseconds per sample, painted, late in a long stroke; against repainting it all."""
    wet, whole = InkOverlay(), Repainted()
    for widget in (wet, whole):
        widget.resize(1920, 1080)
        widget.show()
    QApplication.processEvents()
    wet.begin()
    ours, theirs = [], []
    for i in range(SAMPLES):
        sample = curve(i)
        started = time.perf_counter()
        wet.extend([sample])
        QApplication.processEvents()
        middle = time.perf_counter()
        whole.points.append(QPointF(*sample[:2]))
        if i >= LATE and i % 10 == 0:
            begun = time.perf_counter()
            whole.update()
            QApplication.processEvents()
            theirs.append(1e3 * (time.perf_counter() - begun))
        if i >= LATE:
            ours.append(1e3 * (middle - started))
    for widget in (wet, whole):
        widget.close()
    return Row(
        "canvas", f"Ink, one sample after {LATE}, 1920 × 1080", statistics.median(ours), "ms",
        "≤ 0.1 ms", "repainting the polyline", statistics.median(theirs),
    )  # fmt: skip


def loupe() -> Row:
    """Milliseconds of a repaint, over a picture of full size under a car's edges."""
    shown = QImage(1200, 900, QImage.Format.Format_RGB32)
    glass = Loupe(lambda: shown, QWidget())
    rng = np.random.default_rng(3)
    turn = np.linspace(0.0, 1.5, 24)
    arcs = np.column_stack((np.cos(turn), 0.0 * turn, np.sin(turn)))
    lines = tuple(
        Lines((rng.uniform(-200, 200, 3) + rng.uniform(20, 120) * arcs).astype(np.float32))
        for _ in range(66)
    )
    page = rng.integers(0, 256, (3000, 4096, 4), np.uint8)
    hung = Image(page, (-200.0, 5.0, 150.0), (400.0, 0.0, 0.0), (0.0, 0.0, -300.0))
    glass.show_scene(Scene((Layer("sketch", (hung, *lines)),)), Camera(viewport=(1200.0, 900.0)))
    whole = QImage(page.tobytes(), 4096, 3000, QImage.Format.Format_RGBA8888)
    image = QImage(glass.size(), QImage.Format.Format_RGB888)

    def repaint() -> None:
        glass.point(600.0, 450.0)
        glass.render(image, QPoint(), QRegion(), QWidget.RenderFlag.DrawChildren)

    ours, theirs = in_turn(
        repaint, lambda: whole.scaledToWidth(3600, Qt.TransformationMode.SmoothTransformation)
    )
    return Row("canvas", "Loupe over 4096 × 3000 px, one repaint", ours, "ms", "≤ 4 ms",
               "scaling the picture", theirs)  # fmt: skip


def rows() -> list[Row]:
    """All rows of this room."""
    application = QApplication.instance() or QApplication([])
    made = [handler(), ink(), loupe()]
    application.processEvents()
    return made
