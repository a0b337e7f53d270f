from __future__ import annotations

import math

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QWheelEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from bozzetto.plugin import ViewAdvice
from bozzetto.scene import Layer, Lines, Scene
from bozzetto.scene.picking import cast_rays
from bozzetto.view.navigation import orbit, pan, zoom

MIDDLE = Qt.MouseButton.MiddleButton
ALT, SHIFT, CTRL = (
    Qt.KeyboardModifier.AltModifier,
    Qt.KeyboardModifier.ShiftModifier,
    Qt.KeyboardModifier.ControlModifier,
)


def same_view(one, other):
    np.testing.assert_allclose(one.eye, other.eye, atol=1e-6)
    np.testing.assert_allclose(one.axes, other.axes, atol=1e-9)
    assert one.visible_height == pytest.approx(other.visible_height)


@pytest.fixture
def on_box(session, canvas, box_scene):
    """The camera and a place of the canvas under which the box is hit, with that point."""
    session.scene.show(box_scene)
    place = (400.0, 330.0)
    hits = cast_rays(box_scene, session.view.camera.rays([place]))
    assert hits.hit[0]
    return session.view.camera, place, hits.points[0]


def test_middle_drag_orbits_about_the_surface_under_the_cursor(session, canvas, qtbot, on_box):
    camera, (x, y), pivot = on_box
    qtbot.mousePress(canvas, MIDDLE, pos=QPoint(int(x), int(y)))
    qtbot.mouseMove(canvas, QPoint(430, 350))
    qtbot.mouseMove(canvas, QPoint(460, 370))
    qtbot.mouseRelease(canvas, MIDDLE, pos=QPoint(460, 370))
    same_view(session.view.camera, orbit(camera, 60, 40, pivot))
    (seen,), _ = session.view.camera.project([pivot])
    np.testing.assert_allclose(seen, (x, y), atol=1e-6)
    assert session.strokes == []


def dragged(canvas, qtbot, start, end):
    qtbot.mousePress(canvas, MIDDLE, pos=QPoint(*start))
    qtbot.mouseMove(canvas, QPoint(*end))
    qtbot.mouseRelease(canvas, MIDDLE, pos=QPoint(*end))


def test_a_turn_beside_all_objects_goes_about_their_middle(session, canvas, qtbot, on_box):
    """About a place on the sheet far from them, they left the view."""
    camera, _, _ = on_box
    middle = session.scene.visible.bounds().mean(axis=0)
    before, _ = camera.project([middle])
    beside = (12, canvas.height() - 12)
    assert not cast_rays(session.scene.visible, camera.rays([beside])).hit[0]
    dragged(canvas, qtbot, beside, (412, canvas.height() - 32))
    after, _ = session.view.camera.project([middle])
    np.testing.assert_allclose(after, before, atol=1e-6)
    assert not np.allclose(session.view.camera.axes, camera.axes, atol=0.1)


def test_a_turn_where_the_objects_are_out_of_sight_goes_about_the_middle_of_the_view(
    session, canvas, qtbot, on_box
):
    session.view.set_camera(pan(session.view.camera, 5000.0, 0.0))
    target = session.view.camera.target
    dragged(canvas, qtbot, (12, 12), (212, 32))
    np.testing.assert_allclose(session.view.camera.target, target, atol=1e-9)


@pytest.mark.parametrize(
    ("keys", "expected"),
    [
        (ALT, lambda c, p: orbit(c, 60, 40, p)),
        (ALT | SHIFT, lambda c, p: pan(c, 60, 40, p)),
        (ALT | CTRL, lambda c, p: zoom(c, math.exp(-0.4), at=p)),
    ],
)
def test_the_pen_turns_the_view_with_alt(session, pen, on_box, keys, expected):
    camera, (x, y), pivot = on_box
    pen.modifiers = keys
    pen.press(x, y)
    pen.move(x + 30, y + 20)
    pen.move(x + 60, y + 40)
    pen.release(x + 60, y + 40)
    same_view(session.view.camera, expected(camera, pivot))
    assert session.strokes == []


def test_the_pen_turns_the_view_with_space(session, canvas, pen, on_box, qtbot):
    camera, (x, y), pivot = on_box
    qtbot.keyPress(canvas, Qt.Key.Key_Space)
    pen.press(x, y)
    pen.move(x + 60, y + 40)
    pen.release(x + 60, y + 40)
    qtbot.keyRelease(canvas, Qt.Key.Key_Space)
    same_view(session.view.camera, orbit(camera, 60, 40, pivot))
    pen.stroke([(100, 100, 0.5), (150, 100, 0.5), (200, 100, 0.5)])
    assert len(session.strokes) == 1


def test_panning_keeps_what_was_gripped_under_the_pen(session, pen, on_box):
    _, (x, y), pivot = on_box
    pen.modifiers = ALT | SHIFT
    pen.press(x, y)
    pen.move(x + 77, y - 31)
    pen.release(x + 77, y - 31)
    (seen,), _ = session.view.camera.project([pivot])
    np.testing.assert_allclose(seen, (x + 77, y - 31), atol=1e-6)


def test_escape_turns_back(session, canvas, pen, on_box, qtbot):
    camera, (x, y), _ = on_box
    pen.modifiers = ALT
    pen.press(x, y)
    pen.move(x + 60, y + 40)
    assert session.view.camera != camera
    qtbot.keyClick(canvas, Qt.Key.Key_Escape)
    assert session.view.camera == camera


def wheel(canvas, x, y, angle):
    place = QPointF(x, y)
    event = QWheelEvent(
        place, QPointF(canvas.mapToGlobal(place)), QPoint(), QPoint(0, angle),
        Qt.MouseButton.NoButton, Qt.KeyboardModifier.NoModifier,
        Qt.ScrollPhase.NoScrollPhase, False,
    )  # fmt: skip
    QApplication.sendEvent(canvas, event)


def test_the_wheel_zooms_to_a_curve_that_is_nearer_than_the_sheet(session, canvas):
    """The eye went past a curve under the cursor, which was behind it then."""
    camera = session.view.camera
    near = np.asarray(camera.eye) + 0.4 * camera.distance * camera.axes[2]
    right = camera.axes[0]
    curve = Lines(np.array([near - 20.0 * right, near + 20.0 * right]))
    session.scene.show(Scene((Layer("curves", (curve,)),)))
    (x, y), _ = (row[0] for row in camera.project([near]))
    for _ in range(20):
        wheel(canvas, x, y + 5.0, 120)
    (seen,), depth = session.view.camera.project([near])
    assert depth[0] > 0.0
    np.testing.assert_allclose(seen, (x, y), atol=1e-6)
    assert depth[0] < 0.05 * camera.project([near])[1][0]


def test_the_wheel_zooms_to_the_cursor_and_back(session, canvas, on_box):
    camera, (x, y), pivot = on_box
    wheel(canvas, x, y, 240)
    closer = session.view.camera
    (seen,), depth = closer.project([pivot])
    np.testing.assert_allclose(seen, (x, y), atol=1e-6)
    assert depth[0] < camera.project([pivot])[1][0]
    wheel(canvas, x, y, -240)
    same_view(session.view.camera, camera)


SCREEN = []


@pytest.fixture
def screen(qapp):
    """A touch screen; Qt keeps a bare pointer to it, so it is made once and never dropped."""
    if not SCREEN:
        SCREEN.append(QTest.createTouchDevice())
    return SCREEN[0]


def test_one_finger_orbits_and_never_inks(session, canvas, on_box, screen):
    camera, (x, y), pivot = on_box
    QTest.touchEvent(canvas, screen).press(0, QPoint(int(x), int(y)), canvas).commit()
    QTest.touchEvent(canvas, screen).move(0, QPoint(int(x) + 60, int(y) + 40), canvas).commit()
    QTest.touchEvent(canvas, screen).release(0, QPoint(int(x) + 60, int(y) + 40), canvas).commit()
    same_view(session.view.camera, orbit(camera, 60, 40, pivot))
    assert session.strokes == []


def test_two_fingers_pan_and_zoom(session, canvas, on_box, screen):
    camera, _, _ = on_box
    QTest.touchEvent(canvas, screen).press(0, QPoint(350, 300), canvas).press(
        1, QPoint(450, 300), canvas
    ).commit()
    QTest.touchEvent(canvas, screen).move(0, QPoint(300, 300), canvas).move(
        1, QPoint(500, 300), canvas
    ).commit()
    QTest.touchEvent(canvas, screen).release(0, QPoint(300, 300), canvas).release(
        1, QPoint(500, 300), canvas
    ).commit()
    same_view(session.view.camera, zoom(camera, 2.0, (400, 300)))


def test_escape_turns_back_what_a_finger_turned(session, canvas, on_box, screen, qtbot):
    camera, (x, y), _ = on_box
    QTest.touchEvent(canvas, screen).press(0, QPoint(int(x), int(y)), canvas).commit()
    QTest.touchEvent(canvas, screen).move(0, QPoint(int(x) + 60, int(y)), canvas).commit()
    assert session.view.camera != camera
    qtbot.keyClick(canvas, Qt.Key.Key_Escape)
    assert session.view.camera == camera
    QTest.touchEvent(canvas, screen).release(0, QPoint(int(x) + 60, int(y)), canvas).commit()


def test_a_palm_beside_the_pen_does_nothing(session, canvas, pen, on_box, screen):
    camera, _, _ = on_box
    pen.comes()
    QTest.touchEvent(canvas, screen).press(0, QPoint(350, 300), canvas).commit()
    QTest.touchEvent(canvas, screen).move(0, QPoint(400, 350), canvas).commit()
    QTest.touchEvent(canvas, screen).release(0, QPoint(400, 350), canvas).commit()
    pen.leaves()
    QTest.touchEvent(canvas, screen).press(0, QPoint(350, 300), canvas).commit()
    QTest.touchEvent(canvas, screen).move(0, QPoint(400, 350), canvas).commit()
    QTest.touchEvent(canvas, screen).release(0, QPoint(400, 350), canvas).commit()
    assert session.view.camera == camera
    assert session.strokes == []


def test_the_pen_takes_over_from_the_palm(session, canvas, pen, on_box, screen):
    QTest.touchEvent(canvas, screen).press(0, QPoint(350, 300), canvas).commit()
    QTest.touchEvent(canvas, screen).move(0, QPoint(360, 300), canvas).commit()
    pen.press(100, 100)
    before = session.view.camera
    QTest.touchEvent(canvas, screen).move(0, QPoint(400, 350), canvas).commit()
    pen.move(150, 100)
    pen.move(200, 100)
    QTest.touchEvent(canvas, screen).release(0, QPoint(400, 350), canvas).commit()
    pen.release(200, 100)
    assert session.view.camera == before
    assert len(session.strokes) == 1


# -- a view that is pinned to a picture --------------------------------------------------------


@pytest.fixture
def pinned(session, canvas, on_box):
    session.advice.say(ViewAdvice("good", "From where it was drawn", pinned=True))
    return on_box


@pytest.mark.parametrize("keys", [ALT | SHIFT, ALT | CTRL])
def test_the_pen_moves_and_zooms_about_the_eye(session, pen, pinned, keys):
    camera, (x, y), pivot = pinned
    pen.modifiers = keys
    pen.press(x, y)
    for k in range(1, 7):
        pen.move(x + 10 * k, y + 5 * k)
    pen.release(x + 60, y + 30)
    assert session.view.camera.eye == camera.eye
    assert session.view.camera != camera
    (seen,), _ = session.view.camera.project([pivot])
    wanted = (x + 60, y + 30) if keys == ALT | SHIFT else (x, y)
    np.testing.assert_allclose(seen, wanted, atol=1e-6)


def test_the_wheel_narrows_the_view_and_widens_it_again(session, canvas, pinned):
    camera, (x, y), pivot = pinned
    wheel(canvas, x, y, 240)
    assert session.view.camera.eye == camera.eye
    assert session.view.camera.fov_y < camera.fov_y
    (seen,), _ = session.view.camera.project([pivot])
    np.testing.assert_allclose(seen, (x, y), atol=1e-6)
    wheel(canvas, x, y, -240)
    same_view(session.view.camera, camera)


def test_two_fingers_keep_the_eye(session, canvas, pinned, screen):
    camera, _, _ = pinned
    for places in (((350, 300), (450, 300)), ((330, 320), (500, 330)), ((280, 340), (520, 360))):
        event = QTest.touchEvent(canvas, screen)
        for number, place in enumerate(places):
            act = event.press if places[0] == (350, 300) else event.move
            act(number, QPoint(*place), canvas)
        event.commit()
    end = QTest.touchEvent(canvas, screen)
    end.release(0, QPoint(280, 340), canvas).release(1, QPoint(520, 360), canvas).commit()
    assert session.view.camera.eye == camera.eye
    assert session.view.camera.fov_y < camera.fov_y


def test_turning_leaves_the_place_as_ever(session, pen, pinned):
    camera, (x, y), pivot = pinned
    pen.modifiers = ALT
    pen.press(x, y)
    pen.move(x + 60, y + 40)
    pen.release(x + 60, y + 40)
    same_view(session.view.camera, orbit(camera, 60, 40, pivot))
