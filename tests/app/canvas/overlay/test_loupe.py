"""Places that must be met exactly: a tap that is aimed, and the loupe over it."""

from __future__ import annotations

import time

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QColor, QImage, QMouseEvent, QRegion
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QWidget

from bozzetto.plugin.gesture import Tap
from bozzetto.scene import DARK, LIGHT, Handle, Image, Layer, Lines, Points, Scene
from bozzetto.view import Camera
from bozzetto_app.canvas.input.state_machine import Mode
from bozzetto_app.canvas.overlay.loupe import DIAMETER, MAGNIFICATION, Loupe, place_beside
from bozzetto_app.canvas.screen_limits import pieces_within
from tests.app.canvas.conftest import FakeTool, Pen

FRONT = Camera("orthographic", eye=(0.0, -900.0, 0.0), height=600.0, viewport=(800.0, 600.0))
"""A pixel of the canvas is a millimetre, and the middle is the origin."""

AIMING = (FakeTool("mark", "tap", True), FakeTool("edit", "drag", True), FakeTool("draw", "ink"))


@pytest.fixture
def loupe(canvas, session):
    session.toolbox.tools, session.toolbox.tool = AIMING, "mark"
    session.view.set_camera(FRONT)
    return canvas.loupe


# -- the gesture --------------------------------------------------------------------------------


def test_the_place_is_where_the_pen_lifts_however_long_it_takes(session, canvas, pen, loupe):
    pen.press(200, 200)
    assert canvas.hand.machine.mode is Mode.AIMING
    for k in range(40):
        pen.move(200 + 5 * k, 200 + 2 * k)
    time.sleep(0.3)
    pen.release(400, 281)
    assert session.first("gestures.tap") == [Tap(400.0, 281.0, session.view.camera, False, False)]
    first = session.first("gestures.tap_moved")[0]
    assert (first.x, first.y) == (200.0, 200.0)
    assert not session.strokes


def test_without_a_movement_it_is_a_tap_too(session, canvas, pen, loupe):
    pen.press(321, 123)
    pen.release(321, 123)
    assert session.first("gestures.tap") == [Tap(321.0, 123.0, session.view.camera, False, False)]


def test_the_mouse_aims_and_keys_come_along(session, canvas, loupe):
    QTest.mousePress(canvas, Qt.MouseButton.LeftButton, Qt.KeyboardModifier.ShiftModifier,
                     QPointF(100, 100).toPoint())  # fmt: skip
    place = QPointF(250, 222)
    move = QMouseEvent(
        QMouseEvent.Type.MouseMove, place, canvas.mapToGlobal(place), Qt.MouseButton.NoButton,
        Qt.MouseButton.LeftButton, Qt.KeyboardModifier.ShiftModifier,
    )  # fmt: skip
    QApplication.sendEvent(canvas, move)
    QTest.mouseRelease(canvas, Qt.MouseButton.LeftButton, pos=place.toPoint())
    assert session.first("gestures.tap") == [Tap(250.0, 222.0, session.view.camera, True, False)]


def test_previews_come_at_most_thirty_times_a_second(session, canvas, pen, loupe, qtbot):
    pen.press(100, 100)
    begun = time.perf_counter()
    for k in range(200):
        pen.move(100 + k, 100)
    lasted = time.perf_counter() - begun
    assert len(session.first("gestures.tap_moved")) <= 2 + 30 * lasted
    qtbot.waitUntil(lambda: session.first("gestures.tap_moved")[-1].x == 299.0, timeout=2000)
    pen.release(299, 100)


def test_escape_drops_it(session, canvas, pen, loupe):
    pen.press(100, 100)
    pen.move(150, 150)
    QTest.keyClick(canvas, Qt.Key.Key_Escape)
    pen.release(150, 150)
    assert not session.first("gestures.tap")
    assert session.calls.named("gestures.cancel")
    assert not loupe.isVisible()


def test_tools_that_do_not_aim_tap_as_ever(session, canvas, pen, loupe):
    session.toolbox.tools, session.toolbox.tool = (FakeTool("pick", "tap"),), "pick"
    pen.press(100, 100)
    assert canvas.hand.machine.mode is Mode.TAPPING
    assert not loupe.isVisible()
    pen.move(160, 100)
    pen.release(160, 100)
    assert not session.first("gestures.tap")


def test_ink_and_the_eraser_are_never_aimed(session, canvas, pen, loupe):
    session.toolbox.tools, session.toolbox.tool = (FakeTool("draw", "ink", True),), "draw"
    pen.press(100, 100)
    assert canvas.hand.machine.mode is Mode.INKING
    pen.release(100, 100)
    session.toolbox.tools, session.toolbox.tool = AIMING, "mark"
    eraser = Pen(canvas, eraser=True)
    eraser.press(100, 100)
    assert canvas.hand.machine.mode is Mode.ERASING
    assert not loupe.isVisible()
    eraser.release(100, 100)


def test_the_view_turns_with_such_a_tool_too(session, canvas, pen, loupe):
    pen.modifiers = Qt.KeyboardModifier.AltModifier
    pen.press(100, 100)
    assert canvas.hand.machine.mode is Mode.NAVIGATING
    assert not loupe.isVisible()
    pen.release(100, 100)


@pytest.mark.parametrize(("tool", "shown"), [("edit", True), ("draw", False)])
def test_handles_are_dragged_under_the_loupe(session, canvas, pen, loupe, qtbot, tool, shown):
    session.toolbox.tool = tool
    handle = Handle("corner", (100.0, 0.0, 50.0))
    session.scene.show(Scene((Layer("marks", (handle,)),)))
    pen.press(500, 250)
    assert canvas.hand.machine.mode is Mode.DRAGGING
    pen.move(520, 260)
    qtbot.wait(30)
    assert loupe.isVisible() is shown
    pen.release(530, 270)
    assert not loupe.isVisible()
    (drag,) = session.first("gestures.handle_released")
    name, path = drag.handle, drag.path
    assert name == "corner"
    np.testing.assert_allclose(path.points[-1], (530, 270))


# -- where it is ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("place", "sides"),
    [((400, 300), (-1, -1)), ((60, 300), (1, -1)), ((400, 30), (-1, 1)), ((20, 20), (1, 1)),
     ((790, 590), (-1, -1))],
)  # fmt: skip
def test_it_stands_up_left_and_goes_over_at_the_borders(place, sides):
    assert place_beside(place, (800, 600)) == sides


def test_it_goes_over_only_where_there_is_no_room():
    assert place_beside((300, 300), (800, 600), (1, 1)) == (1, 1)
    assert place_beside((750, 300), (800, 600), (1, 1)) == (-1, 1)
    # A sheet too small for either side: it stays where it was.
    assert place_beside((100, 100), (200, 200), (1, -1)) == (1, -1)


@pytest.mark.parametrize("place", [(400, 300), (3, 3), (797, 597), (3, 597), (797, 3)])
def test_it_is_whole_and_never_under_the_pen(session, canvas, pen, loupe, place):
    pen.press(*place)
    area = loupe.geometry()
    assert canvas.rect().contains(area)
    middle = area.center()
    assert np.hypot(middle.x() - place[0], middle.y() - place[1]) > 0.5 * DIAMETER + 20
    pen.release(*place)


# -- what is in it ------------------------------------------------------------------------------


def seen(loupe):
    """What the loupe shows over a black sheet, (h, w, 3), with its middle."""
    image = QImage(loupe.size(), QImage.Format.Format_RGB888)
    image.fill(Qt.GlobalColor.black)
    loupe.render(image, QPoint(), QRegion(), QWidget.RenderFlag.DrawChildren)
    rows = np.frombuffer(image.constBits(), np.uint8).reshape(image.height(), -1)
    return rows[:, : 3 * image.width()].reshape(image.height(), image.width(), 3).astype(int)


def checks(size, field):
    """Squares of `field` pixels, black and white."""
    y, x = np.mgrid[:size, :size]
    page = np.full((size, size, 4), 255, np.uint8)
    page[..., :3] = np.where((x // field + y // field) % 2, 255, 0)[..., None]
    return page


@pytest.fixture
def bare(qtbot, canvas):
    shown = QImage(800, 600, QImage.Format.Format_RGB32)
    shown.fill(QColor(10, 120, 200))
    made = Loupe(lambda: made.sheet, canvas)
    made.sheet = shown
    return made


def test_what_is_on_the_sheet_is_magnified_about_the_pen(bare):
    for y in range(300, 310):
        for x in range(400, 410):
            bare.sheet.setPixelColor(x, y, QColor(250, 250, 250))
    bare.show_scene(Scene(), FRONT)
    bare.point(400.0, 300.0)
    picture = seen(bare)
    middle = picture.shape[0] // 2
    inside = round(MAGNIFICATION * 8)
    assert picture[middle + inside, middle + inside].min() > 240
    for dx, dy in ((-inside, inside), (inside, -inside), (round(MAGNIFICATION * 12), inside)):
        np.testing.assert_allclose(picture[middle + dy, middle + dx], (10, 120, 200), atol=2)


def test_a_coarser_or_finer_frame_is_the_same_sheet(bare):
    for factor in (0.5, 2.0):
        frame = bare.sheet.scaled(round(800 * factor), round(600 * factor))
        side = round(40 * factor)
        for y in range(side):
            for x in range(side):
                frame.setPixelColor(
                    round(400 * factor) + x, round(300 * factor) + y, QColor("white")
                )
        bare.sheet = frame
        bare.point(400.0, 300.0)
        picture = seen(bare)
        middle = picture.shape[0] // 2
        assert picture[middle + 40, middle + 40].min() > 240
        np.testing.assert_allclose(picture[middle - 40, middle - 40], (10, 120, 200), atol=3)


def hung(page, size=400.0, opacity=1.0):
    return Image(page, (-size / 2, 5.0, size / 2), (size, 0.0, 0.0), (0.0, 0.0, -size), opacity)


def test_a_picture_is_as_sharp_as_its_file(bare):
    """Squares of half a pixel of the sheet, of which that shows but grey, are told apart."""
    scene = Scene((Layer("sketch", (hung(checks(800, 1)),)),))
    bare.show_scene(scene, FRONT)
    bare.point(400.0, 300.0)
    picture = seen(bare)
    middle = picture.shape[0] // 2
    row = picture[middle + 30, middle - 60 : middle + 60, 0]
    assert np.ptp(row) > 100
    # 1.5 pixels of the loupe are one of the picture: 80 squares in 120 pixels.
    changes = np.count_nonzero(np.diff(np.sign(row - 127.5)))
    assert 75 <= changes <= 82


def test_through_a_perspective_camera_the_crosshair_is_on_the_pixel(bare):
    camera = Camera(eye=(-300.0, -700.0, 260.0), target=(0, 0, 0), viewport=(800.0, 600.0))
    page = np.full((400, 400, 4), 255, np.uint8)
    page[200:, 200:, :3] = 0
    image = hung(page)
    (corner,), _ = camera.project([(0.0, 5.0, 0.0)])  # the middle of the picture
    bare.show_scene(Scene((Layer("sketch", (image,)),)), camera)
    bare.point(*corner.tolist())
    picture = seen(bare)
    middle = (picture.shape[0] - 1) // 2
    assert picture[middle + 30, middle + 30].max() < 30
    for dx, dy in ((-30, 30), (30, -30), (-30, -30)):
        assert picture[middle + dy, middle + dx].min() > 220, (dx, dy)


def test_lines_points_and_handles_lie_over_the_picture(bare):
    items = (
        hung(np.full((40, 40, 4), 255, np.uint8)),
        Lines(np.array([(-400, 0, -10), (400, 0, -10)], np.float32), color=(0, 0, 250)),
        Points(np.array([(15, 0, 10)], np.float32), color=(0, 250, 0), size=6.0),
        Handle("h", (-15.0, 0.0, 10.0), color=(250, 0, 0)),
    )
    bare.show_scene(Scene((Layer("a", items),)), FRONT)
    bare.point(400.0, 300.0)
    picture = seen(bare)
    middle = picture.shape[0] // 2

    def close(dx, dy, color):
        part = picture[middle + dy - 7 : middle + dy + 8, middle + dx - 7 : middle + dx + 8]
        return np.abs(part - color).max(2).min() < 80

    assert close(-40, 30, (0, 0, 250))
    assert close(45, -30, (0, 250, 0))
    assert close(-45, -30, (250, 0, 0))
    # The place of a handle itself is not covered.
    assert picture[middle - 30, middle - 45].min() > 200


@pytest.mark.parametrize("palette", [LIGHT, DARK])
def test_the_crosshair_leaves_the_place_free_in_both_themes(bare, palette):
    bare.set_colors(palette)
    bare.show_scene(Scene(), FRONT)
    bare.point(400.0, 300.0)
    picture = seen(bare)
    middle = picture.shape[0] // 2
    np.testing.assert_allclose(picture[middle, middle], (10, 120, 200), atol=6)
    arm = picture[middle - 1 : middle + 2, middle + 11]
    assert np.abs(arm - palette.ink).sum(1).min() < 120
    # Round: the corners are not touched.
    assert picture[2, 2].max() == 0


@pytest.mark.parametrize(
    "image",
    [
        hung(np.zeros((0, 0, 4), np.uint8)),
        hung(checks(8, 1), size=0.0),
        Image(checks(8, 1), (0.0, -5000.0, 0.0), (9.0, 0.0, 0.0), (0.0, 0.0, -9.0)),
    ],
    ids=["empty", "flat", "behind"],
)
def test_odd_scenes_are_survived(bare, image):
    odd = (
        image,
        Lines(np.zeros((0, 3), np.float32)),
        Lines(np.array([(0, -900, 0), (1e9, 0, 1e9)], np.float32)),
        Points(np.zeros((0, 3), np.float32)),
        Handle("h", (0.0, -900.0, 0.0)),
    )
    for camera in (FRONT, Camera(eye=(0.0, -900.0, 0.0), viewport=(800.0, 600.0))):
        bare.show_scene(Scene((Layer("a", (hung(checks(9, 3)), *odd)),)), camera)
        for place in ((400.0, 300.0), (-1e6, 1e6), (0.0, 0.0)):
            bare.point(*place)
            seen(bare)


def test_lines_are_cut_as_shapely_cuts_them():
    shapely = pytest.importorskip("shapely")
    rng = np.random.default_rng(7)
    begins, ends = rng.uniform(-300, 300, (2, 400, 2))
    ends[:20] = begins[:20] + np.array((50.0, 0.0))
    ends[20:40] = begins[20:40] + np.array((0.0, -80.0))
    square = shapely.box(-90, -90, 90, 90)
    wanted = [
        cut.length
        for pair in zip(begins, ends, strict=True)
        if (cut := shapely.LineString(pair).intersection(square)).length
    ]
    pieces = pieces_within(begins, ends, 90.0)
    np.testing.assert_allclose(np.hypot(*(pieces[:, 2:] - pieces[:, :2]).T), wanted)
    odd = np.array([(np.nan, 0.0), (np.inf, 5.0), (1e300, -1e300), (200.0, 200.0)])
    assert len(pieces_within(odd, odd, 90.0)) == 0
