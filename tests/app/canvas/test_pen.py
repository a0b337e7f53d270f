from __future__ import annotations

import math

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QMouseEvent
from PySide6.QtWidgets import QApplication

LEFT, RIGHT, MIDDLE = (
    Qt.MouseButton.LeftButton,
    Qt.MouseButton.RightButton,
    Qt.MouseButton.MiddleButton,
)


def arc(count, radius=150.0):
    return [
        (
            400 + radius * math.cos(0.02 * i),
            300 + radius * math.sin(0.02 * i),
            0.5 + 0.4 * math.sin(0.1 * i),
        )
        for i in range(count)
    ]


def test_a_pen_stroke_arrives_as_it_was_drawn(session, canvas, pen):
    points = arc(50)
    pen.press(*points[0], tilt=(10, -20), twist=30)
    for point in points[1:]:
        pen.move(*point, tilt=(10, -20), twist=30)
    pen.release(*points[-1][:2])
    (stroke,) = session.strokes
    assert len(stroke) == 50
    np.testing.assert_allclose(stroke.points, [p[:2] for p in points], atol=1e-4)
    np.testing.assert_allclose(stroke.pressure, [p[2] for p in points], atol=1e-6)
    np.testing.assert_allclose(stroke.t, 0.005 * np.arange(50), atol=1e-6)
    assert set(stroke.tilt_x) == {10}
    assert set(stroke.tilt_y) == {-20}
    assert set(stroke.twist) == {30}
    assert stroke.tool == "pen"
    assert stroke.has_pressure
    assert stroke.has_time
    assert stroke.camera == session.camera
    assert stroke.camera.viewport == (800, 600)
