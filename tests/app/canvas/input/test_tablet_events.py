from __future__ import annotations

import math
from time import perf_counter

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QMouseEvent
from PySide6.QtWidgets import QApplication

from bozzetto.plugin.gesture import Tap
from bozzetto.scene import Scene
from bozzetto_app.canvas.input.stroke_samples import PressureCurve
from bozzetto_app.canvas.overlay.wet_ink import PEN_TIP
from tests.app.seen import colour, darkness

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
    assert stroke.camera == session.view.camera
    assert stroke.camera.viewport == (800, 600)


def test_five_thousand_samples_are_all_kept_in_order(session, pen):
    points = arc(5000)
    pen.step = 1
    pen.stroke(points)
    (stroke,) = session.strokes
    assert len(stroke) == 5000
    np.testing.assert_allclose(stroke.points, [p[:2] for p in points], atol=1e-4)
    np.testing.assert_allclose(np.diff(stroke.t), 0.001, atol=1e-4)


def test_reports_come_at_most_thirty_times_a_second(session, pen, qtbot):
    pen.press(100, 100)
    begun = perf_counter()
    for i in range(40):
        pen.move(100 + 5 * i, 100)
        qtbot.wait(5)
    lasted = perf_counter() - begun
    reports = session.first("gestures.stroke_moved")
    assert 2 <= len(reports) <= 30 * lasted + 2
    lengths = [len(stroke) for stroke in reports]
    assert lengths == sorted(lengths)
    qtbot.waitUntil(
        lambda: len(session.first("gestures.stroke_moved")[-1]) == 41
    )  # the last one, too


def test_the_pressure_curve_is_in_the_stroke(session, canvas, pen):
    canvas.hand.curve = PressureCurve(2.0)
    pen.stroke([(100, 100, 0.5), (200, 100, 0.5), (300, 100, 1.0)])
    np.testing.assert_allclose(session.strokes[0].pressure, [0.25, 0.25, 1.0], atol=1e-6)


def test_a_release_elsewhere_is_a_sample_as_wide_as_the_last(session, pen):
    pen.press(100, 100, 0.6)
    pen.move(200, 100, 0.6)
    pen.release(250, 100)
    (stroke,) = session.strokes
    assert stroke.x[-1] == 250
    assert stroke.pressure[-1] == pytest.approx(0.6)


def test_the_eraser_end_makes_an_eraser_stroke(session, eraser):
    eraser.stroke(arc(20))
    assert session.strokes[0].tool == "eraser"


def test_every_tablet_event_is_accepted(pen):
    assert pen.move(50, 50)
    assert pen.press(100, 100)
    assert pen.move(120, 100)
    assert pen.release(120, 100)
    assert pen.press(100, 100, button=MIDDLE)
    assert pen.release(100, 100, button=MIDDLE)


def test_the_mouse_draws_without_pressure(session, canvas, qtbot):
    qtbot.mousePress(canvas, LEFT, pos=QPoint(100, 100))
    for x in range(110, 200, 10):
        qtbot.mouseMove(canvas, QPoint(x, 120))
    qtbot.mouseRelease(canvas, LEFT, pos=QPoint(200, 120))
    (stroke,) = session.strokes
    assert stroke.tool == "mouse"
    assert not stroke.has_pressure
    assert (stroke.x[0], stroke.y[0]) == (100, 100)
    assert (stroke.x[-1], stroke.y[-1]) == (200, 120)


def mouse_event(canvas, kind, x, y, buttons, source=Qt.MouseEventSource.MouseEventNotSynthesized):
    place = QPointF(x, y)
    button = buttons if kind != QMouseEvent.Type.MouseMove else Qt.MouseButton.NoButton
    event = QMouseEvent(
        kind, place, place, QPointF(canvas.mapToGlobal(place)), button, buttons,
        Qt.KeyboardModifier.NoModifier, source,
    )  # fmt: skip
    QApplication.sendEvent(canvas, event)


def mouse_stroke(canvas, **more):
    mouse_event(canvas, QMouseEvent.Type.MouseButtonPress, 100, 100, LEFT, **more)
    mouse_event(canvas, QMouseEvent.Type.MouseMove, 200, 100, LEFT, **more)
    mouse_event(canvas, QMouseEvent.Type.MouseButtonRelease, 200, 100, LEFT, **more)


@pytest.mark.parametrize(
    "source",
    [
        Qt.MouseEventSource.MouseEventSynthesizedByQt,
        Qt.MouseEventSource.MouseEventSynthesizedBySystem,
        Qt.MouseEventSource.MouseEventSynthesizedByApplication,
    ],
)
def test_synthesised_mouse_events_never_draw(session, canvas, source):
    mouse_stroke(canvas, source=source)
    assert session.strokes == []


def test_a_pen_stroke_is_not_drawn_twice_by_unmarked_mouse_echoes(session, canvas, pen):
    pen.press(100, 100)
    mouse_event(canvas, QMouseEvent.Type.MouseButtonPress, 100, 100, LEFT)
    pen.move(150, 100)
    mouse_event(canvas, QMouseEvent.Type.MouseMove, 150, 100, LEFT)
    pen.move(200, 100)
    pen.release(200, 100)
    mouse_event(canvas, QMouseEvent.Type.MouseButtonRelease, 200, 100, LEFT)
    mouse_stroke(canvas)  # and at once after it
    assert [stroke.tool for stroke in session.strokes] == ["pen"]
    assert len(session.strokes[0]) == 3


def test_the_mouse_draws_again_once_the_pen_has_been_away(session, canvas, pen, qtbot):
    pen.stroke(arc(10))
    pen.leaves()
    qtbot.wait(450)
    mouse_stroke(canvas)
    assert [stroke.tool for stroke in session.strokes] == ["pen", "mouse"]


def test_escape_takes_the_stroke_back(session, canvas, pen, qtbot):
    pen.press(100, 100)
    for x in range(110, 300, 10):
        pen.move(x, 100)
    qtbot.keyClick(canvas, Qt.Key.Key_Escape)
    pen.move(350, 100)
    pen.release(350, 100)
    assert session.strokes == []
    assert session.calls.named("gestures.cancel")
    assert not canvas.overlay.has_wet_ink
    pen.stroke(arc(10))
    assert len(session.strokes) == 1


def test_a_dot_is_dropped_silently(session, pen):
    pen.press(100, 100)
    pen.move(101, 101)
    pen.release(101, 101)
    assert session.strokes == []
    assert session.calls.named("gestures.cancel")


def test_leaving_proximity_without_a_release_ends_the_stroke(session, pen):
    pen.press(100, 100)
    for x in range(110, 200, 10):
        pen.move(x, 100)
    pen.leaves()
    assert len(session.strokes) == 1
    pen.release(200, 100)
    assert len(session.strokes) == 1


def test_a_tap_tool_takes_taps_only(session, pen):
    session.toolbox.tool = "mark"
    pen.press(100, 100)
    pen.move(102, 101)
    pen.release(102, 101)
    pen.stroke(arc(30))
    assert session.first("gestures.tap") == [Tap(100.0, 100.0, session.view.camera, False, False)]
    assert session.strokes == []


def test_a_tap_knows_shift_and_ctrl(session, pen):
    session.toolbox.tool = "mark"
    pen.modifiers = Qt.KeyboardModifier.ShiftModifier
    pen.press(100, 100)
    pen.release(100, 100)
    (*_, last) = session.first("gestures.tap")
    assert (last.shift, last.ctrl) == (True, False)


def test_hovering_shows_the_ring_and_pressing_takes_it_away(canvas, pen):
    def ring_at(x, y):
        """How dark it is on the ring that hovering shows about a place, on its four sides."""
        ink, away = darkness(canvas.overlay), round(0.5 * max(PEN_TIP.size, 7.0))
        sides = ((x - away, y), (x + away, y), (x, y - away), (x, y + away))
        return min(ink[y - 1 : y + 2, x - 1 : x + 2].max() for x, y in sides)

    pen.move(200, 200)
    assert ring_at(200, 200) > 0.1
    pen.press(200, 200)
    assert ring_at(200, 200) == 0.0
    pen.release(200, 200)
    pen.move(210, 200)
    assert ring_at(210, 200) > 0.1
    pen.leaves()
    assert ring_at(210, 200) == 0.0


def test_no_light_stays_where_a_handle_was(session, canvas, pen, box_scene):
    """After a quick drag a ring stood at the place from which the handle had gone."""
    session.scene.show(box_scene)
    session.toolbox.tool = "edit"
    ((x, y),), _ = session.view.camera.project([(50.0, -50.0, 50.0)])
    pen.move(x, y)
    assert colour(canvas.overlay).max() > 0.2
    pen.press(x, y)
    pen.move(x + 60, y)
    pen.release(x + 60, y)
    session.scene.show(Scene())
    assert colour(canvas.overlay).max() < 0.05


def test_a_handle_lights_up_and_is_dragged(session, canvas, pen, box_scene):
    session.scene.show(box_scene)
    session.toolbox.tool = "edit"
    ((x, y),), _ = session.view.camera.project([(50.0, -50.0, 50.0)])
    assert colour(canvas.overlay).max() < 0.05
    pen.move(x + 15, y)
    assert colour(canvas.overlay).max() > 0.2
    pen.press(x + 15, y)
    for step in range(5):
        pen.move(x + 20 + 10 * step, y)
    pen.modifiers = Qt.KeyboardModifier.ShiftModifier
    pen.release(x + 70, y)
    assert session.strokes == []
    (drag,) = session.first("gestures.handle_released")
    handle, path, shift, ctrl = drag.handle, drag.path, drag.shift, drag.ctrl
    assert (handle, shift, ctrl) == ("corner", True, False)
    assert path.x[-1] == pytest.approx(x + 70, abs=1e-3)
    assert session.first("gestures.handle_moved")
    assert not session.first("gestures.stroke_moved")


def test_ink_may_start_beside_a_handle(session, pen, box_scene):
    session.scene.show(box_scene)
    ((x, y),), _ = session.view.camera.project([(50.0, -50.0, 50.0)])
    pen.stroke([(x + 15, y, 0.5), (x + 40, y, 0.5), (x + 80, y, 0.5)])
    assert len(session.strokes) == 1
    pen.stroke([(x + 5, y, 0.5), (x + 40, y, 0.5), (x + 80, y, 0.5)])
    assert len(session.first("gestures.handle_released")) == 1


def test_escape_gives_a_dragged_handle_back(session, canvas, pen, box_scene, qtbot):
    session.scene.show(box_scene)
    ((x, y),), _ = session.view.camera.project([(50.0, -50.0, 50.0)])
    pen.press(x, y)
    pen.move(x + 50, y)
    qtbot.keyClick(canvas, Qt.Key.Key_Escape)
    pen.release(x + 60, y)
    assert session.first("gestures.handle_released") == []
    assert session.calls.named("gestures.cancel")


def test_a_second_press_during_a_stroke_changes_nothing(session, canvas, pen):
    camera = session.view.camera
    pen.press(100, 100)
    pen.move(150, 100)
    pen.press(150, 100, button=MIDDLE)
    pen.move(200, 200)
    pen.release(200, 200, button=MIDDLE)
    pen.move(250, 100)
    pen.release(250, 100)
    assert session.view.camera == camera
    assert len(session.strokes) == 1
