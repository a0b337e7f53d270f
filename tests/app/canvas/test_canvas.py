from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from PySide6 import QtWidgets
from PySide6.QtCore import QMimeData, QPoint, QPointF, Qt, QUrl
from PySide6.QtGui import QDragEnterEvent, QDropEvent, QIcon
from PySide6.QtWidgets import QAbstractButton, QApplication, QWidget

from bozzetto.document.model import Document, Model
from bozzetto.ink.stroke import Stroke
from bozzetto.plugin import ViewAdvice
from bozzetto.scene import DARK, LIGHT, Layer, Scene
from bozzetto.view.navigation import fit_points
from bozzetto.view.standard_views import standard_view
from bozzetto_app.canvas.canvas import Canvas
from bozzetto_app.canvas.viewport.protocol import choose_backend
from bozzetto_app.canvas.viewport.software import SoftwareViewport
from bozzetto_app.session.notices import Notice
from bozzetto_app.settings import settings
from tests.app.seen import darkness

VIEWS = ("front", "back", "left", "right", "top", "bottom", "three-quarter")


def arrived(canvas, qtbot):
    qtbot.waitUntil(lambda: not canvas.motion.is_running, timeout=3000)


@pytest.mark.parametrize("name", VIEWS)
def test_standard_views(session, canvas, qtbot, name):
    begin = session.view.camera
    canvas.views.look(name)
    arrived(canvas, qtbot)
    np.testing.assert_allclose(session.view.camera.eye, standard_view(begin, name).eye, atol=1e-6)


def test_a_change_of_view_passes_through_the_views_between(session, canvas, qtbot):
    seen = []
    session.view.camera_changed.connect(lambda: seen.append(session.view.camera.axes[2][0]))
    canvas.views.look("right")
    arrived(canvas, qtbot)
    assert len(seen) >= 3
    assert seen == sorted(seen, reverse=True)
    assert seen[-1] == pytest.approx(-1)


def test_reduced_motion_goes_at_once_and_never_tilts(session, canvas):
    canvas.motion.reduced = True
    canvas.views.look("top")
    assert session.view.camera.axes[2][2] == pytest.approx(-1)
    before = session.view.camera
    session.solver.settled.emit("m1")
    assert session.view.camera == before
    assert not canvas.motion.is_running


def test_the_view_tilts_once_and_comes_back_exactly(session, canvas, qtbot):
    begin = session.view.camera
    seen = []
    session.view.camera_changed.connect(lambda: seen.append(session.view.camera))
    session.solver.settled.emit("m1")
    arrived(canvas, qtbot)
    assert session.view.camera == begin
    lean = max(np.degrees(np.arccos(np.clip(c.axes[2] @ begin.axes[2], -1, 1))) for c in seen)
    assert 3 < lean < 15
    session.solver.settled.emit("m2")
    assert not canvas.motion.is_running


def test_the_view_tilts_from_where_it_has_gone_to_the_shape(session, canvas, qtbot):
    """The sheet is told of shapes a moment later, and only then the view goes to them."""
    session.scene.busy = True
    session.solver.settled.emit("m1")
    qtbot.wait(30)
    assert not canvas.motion.is_running
    there = standard_view(session.view.camera, "right")
    session.view.set_camera(there)
    session.scene.busy = False
    qtbot.waitUntil(lambda: canvas.motion.is_running, timeout=3000)
    arrived(canvas, qtbot)
    assert session.view.camera == there


def test_the_view_tilts_from_where_it_goes_along(session, canvas, qtbot):
    """Advice on the first solid came while the view tilted, which it did not follow then."""
    session.advice.may_follow = True
    session.solver.settled.emit("m1")
    qtbot.wait(50)
    assert not canvas.motion.is_running
    there = standard_view(session.view.camera, "right")
    session.view.set_camera(there)
    session.advice.may_follow = False
    qtbot.waitUntil(lambda: canvas.motion.is_running, timeout=3000)
    arrived(canvas, qtbot)
    assert session.view.camera == there


def test_the_first_shape_does_not_tilt_where_a_picture_comes(session, canvas, qtbot):
    """It was about to when the view had gone to the picture before the sheet was told."""
    session.scene.busy = True
    session.pictures.taken.emit("m1")
    session.solver.settled.emit("m1")
    session.drawing.document = Document((Model("m1", "Sketch", "test.sketch", None),))
    session.selection.id = "m1"
    session.advice.about = session.selection.model
    session.advice.changed.emit()  # the view has gone there
    session.scene.busy = False
    qtbot.wait(50)
    assert not canvas.motion.is_running


def test_no_tilt_interrupts_a_view_on_its_way(session, canvas, qtbot):
    canvas.views.look("right")
    assert canvas.motion.is_running
    session.solver.settled.emit("m1")
    arrived(canvas, qtbot)
    np.testing.assert_allclose(
        session.view.camera.axes, standard_view(session.view.camera, "right").axes
    )


def test_the_ink_of_a_replay_is_shown_with_what_waits(session, canvas):
    stroke = Stroke([10.0, 60.0, 90.0], [10.0, 20.0, 70.0], camera=session.view.camera)
    canvas.waiting.follow(stroke)
    down, across = np.nonzero(darkness(canvas.overlay) > 0.2)
    assert np.allclose((across.min(), down.min()), (10, 10), atol=4)
    assert np.allclose((across.max(), down.max()), (90, 70), atol=4)
    canvas.waiting.follow(None)
    assert not darkness(canvas.overlay).any()


def test_the_tilt_is_a_setting(session, canvas):
    settings().setValue("view/settle_tilt", False)
    canvas.read_settings()
    session.solver.settled.emit("m1")
    assert not canvas.motion.is_running


def test_ink_ends_a_motion_first(session, canvas, pen):
    begin = session.view.camera
    canvas.views.look("right")
    pen.stroke([(100, 100, 0.5), (150, 100, 0.5), (200, 100, 0.5)])
    assert not canvas.motion.is_running
    (stroke,) = session.strokes
    np.testing.assert_allclose(stroke.camera.eye, standard_view(begin, "right").eye, atol=1e-6)


def test_the_projection_changes_and_the_scale_stays(session, canvas, qtbot):
    scale = session.view.camera.pixels_per_mm
    canvas.views.toggle_projection()
    arrived(canvas, qtbot)
    assert session.view.camera.kind == "orthographic"
    assert session.view.camera.pixels_per_mm == pytest.approx(scale)
    canvas.views.toggle_projection()
    arrived(canvas, qtbot)
    assert session.view.camera.kind == "perspective"
    assert session.view.camera.pixels_per_mm == pytest.approx(scale)


def test_framing_the_selection_and_everything(session, canvas, qtbot, box_scene):
    far = Scene((Layer("other", (box_scene.layers[0].items[1],), owner="m2"),))
    session.scene.show(box_scene + far)
    begin = session.view.camera
    session.selection.id = "m2"
    canvas.views.frame_selection()
    arrived(canvas, qtbot)
    np.testing.assert_allclose(session.view.camera.eye, fit_points(begin, far.points()).eye)
    canvas.views.fit()
    arrived(canvas, qtbot)
    pixels, _ = session.view.camera.project(session.scene.visible.points())
    share = pixels / session.view.camera.viewport
    assert share.min() > 0
    assert share.max() < 1
    assert np.ptp(share, axis=0).max() > 0.8


def test_fitting_an_empty_scene_is_no_accident(session, canvas, qtbot):
    canvas.views.fit()
    arrived(canvas, qtbot)
    assert np.isfinite(session.view.camera.eye).all()


def test_the_camera_follows_the_size_of_the_canvas(session, canvas, qtbot):
    canvas.resize(640, 480)
    qtbot.waitUntil(lambda: session.view.camera.viewport == (640, 480))


# -- view cube ---------------------------------------------------------------------------------


def test_clicking_a_face_of_the_cube_looks_at_it(session, canvas, qtbot):
    session.view.set_camera(standard_view(session.view.camera, "three-quarter"))
    cube = canvas.cube
    places = {
        cube.direction_under(QPointF(x, y)): QPoint(x, y) for x in range(84) for y in range(84)
    }
    assert (0.0, 0.0, 1.0) in places
    qtbot.mouseClick(cube, Qt.MouseButton.LeftButton, pos=places[0.0, 0.0, 1.0])
    arrived(canvas, qtbot)
    assert session.view.camera.axes[2][2] == pytest.approx(-1)


def test_faces_edges_and_corners_of_the_cube_can_be_hit(session, canvas):
    canvas.motion.reduced = True
    cube = canvas.cube
    found = set()
    for view in ("front", "back", "three-quarter", "top", "bottom", "left", "right"):
        session.view.set_camera(standard_view(session.view.camera, view))
        found |= {
            cube.direction_under(QPointF(x, y)) for x in range(0, 84, 2) for y in range(0, 84, 2)
        }
    kinds = [sum(abs(v) for v in d) for d in found - {None}]
    assert {1.0, 2.0, 3.0} == set(kinds)
    assert len(found - {None}) == 26


def test_dragging_the_cube_turns_the_view_and_chooses_nothing(session, canvas, qtbot):
    cube, before = canvas.cube, session.view.camera
    qtbot.mousePress(cube, Qt.MouseButton.LeftButton, pos=QPoint(42, 42))
    qtbot.mouseMove(cube, QPoint(62, 42))
    qtbot.mouseRelease(cube, Qt.MouseButton.LeftButton, pos=QPoint(62, 42))
    assert not canvas.motion.is_running
    assert session.view.camera.axes[2][0] != pytest.approx(before.axes[2][0])
    assert session.strokes == []


def test_the_buttons_beneath_the_cube(session, canvas, qtbot):
    cube = canvas.cube
    name = cube.projection_button.accessibleName()
    qtbot.mouseClick(cube.projection_button, Qt.MouseButton.LeftButton)
    arrived(canvas, qtbot)
    assert session.view.camera.kind == "orthographic"
    assert cube.projection_button.accessibleName() not in ("", name)


def test_every_button_has_a_name(canvas):
    buttons = canvas.findChildren(QAbstractButton)
    assert buttons
    assert all(b.accessibleName() and b.toolTip() for b in buttons)
    assert canvas.accessibleName()


# -- radial menu -------------------------------------------------------------------------------


@dataclass
class Entry:
    title: str
    enabled: bool = True
    icon: QIcon = None
    count: int = 0

    def trigger(self):
        self.count += 1


@pytest.fixture
def entries(canvas):
    made = [Entry(name) for name in ("up", "right", "down", "left")]
    canvas.menu_entries = lambda: made
    return made


def test_a_flick_with_the_barrel_button_chooses(session, canvas, pen, entries):
    pen.press(400, 300, button=Qt.MouseButton.RightButton)
    assert canvas.menu.isVisible()
    pen.move(420, 301)
    pen.move(450, 302)
    pen.release(450, 302, button=Qt.MouseButton.RightButton)
    assert [entry.count for entry in entries] == [0, 1, 0, 0]
    assert not canvas.menu.isVisible()
    assert session.strokes == []


def test_a_short_press_leaves_the_menu_open_for_a_click(canvas, pen, entries, qtbot):
    pen.press(400, 300, button=Qt.MouseButton.RightButton)
    pen.release(400, 300, button=Qt.MouseButton.RightButton)
    menu = canvas.menu
    assert menu.isVisible()
    middle = menu.rect().center()
    qtbot.mouseClick(menu, Qt.MouseButton.LeftButton, pos=middle + QPoint(0, 80))
    assert [entry.count for entry in entries] == [0, 0, 1, 0]
    assert not menu.isVisible()


def test_the_menu_opens_by_key_and_closes_by_escape(canvas, entries, qtbot):
    qtbot.keyClick(canvas, Qt.Key.Key_Q)
    assert canvas.menu.isVisible()
    qtbot.keyClick(canvas.menu, Qt.Key.Key_Escape)
    assert not canvas.menu.isVisible()
    assert not any(entry.count for entry in entries)


def test_what_is_disabled_cannot_be_chosen(canvas, entries, pen):
    entries[1].enabled = False
    pen.press(400, 300, button=Qt.MouseButton.RightButton)
    pen.move(460, 300)
    pen.release(460, 300, button=Qt.MouseButton.RightButton)
    assert entries[1].count == 0


@pytest.mark.parametrize("place", [(0, 0), (799, 599), (2, 400)])
def test_the_ring_stays_inside_the_canvas(canvas, entries, place):
    canvas.open_menu(QPointF(*place))
    assert canvas.rect().contains(canvas.menu.geometry())


def test_escape_during_a_flick_chooses_nothing(canvas, entries, pen, qtbot):
    pen.press(400, 300, button=Qt.MouseButton.RightButton)
    pen.move(460, 300)
    qtbot.keyClick(canvas.menu, Qt.Key.Key_Escape)
    pen.move(470, 300)
    pen.release(470, 300, button=Qt.MouseButton.RightButton)
    assert not any(entry.count for entry in entries)


def test_ink_closes_the_menu(session, canvas, entries, pen):
    canvas.open_menu(QPointF(600, 400))
    pen.stroke([(100, 100, 0.5), (150, 100, 0.5), (200, 100, 0.5)])
    assert not canvas.menu.isVisible()
    assert len(session.strokes) == 1


# -- the rest ----------------------------------------------------------------------------------


def test_the_hint_fades_with_the_first_ink(canvas, pen, qtbot):
    canvas.show_hint("Draw a closed outline.")
    assert canvas.empty_hint.isVisible()
    pen.stroke([(100, 100, 0.5), (150, 100, 0.5), (200, 100, 0.5)])
    qtbot.waitUntil(lambda: not canvas.empty_hint.isVisible(), timeout=2000)


def test_places_of_a_notice_are_lit_and_a_plain_hint_does_not_put_them_out(session, canvas):
    session.notices.noticed.emit(Notice("error", "It crosses itself here.", ((100.0, 120.0),)))
    session.hints.say("Draw a closed outline.")
    assert canvas.overlay.lit.places == ((100.0, 120.0),)
    assert canvas.overlay.lit.words == "It crosses itself here."


def test_lifted_ink_stays_while_it_is_pending(session, canvas, pen):
    def keep(stroke):
        session.calls.made.append(("gestures.stroke_lifted", (stroke,), {}))
        session.drawing.pending = (stroke,)
        session.drawing.waiting_changed.emit()

    session.gestures.stroke_lifted = keep
    pen.stroke([(100, 100, 0.9), (200, 100, 0.9), (300, 100, 0.9), (400, 100, 0.9)])
    assert not canvas.overlay.has_wet_ink
    assert canvas.overlay.grab().toImage().pixelColor(250, 100).alpha() > 200
    session.drawing.pending = ()
    session.drawing.waiting_changed.emit()
    assert canvas.overlay.grab().toImage().pixelColor(250, 100).alpha() == 0


def drop(canvas, paths, keys=Qt.KeyboardModifier.NoModifier):
    data = QMimeData()
    data.setUrls([QUrl.fromLocalFile(str(path)) for path in paths])
    copy, left = Qt.DropAction.CopyAction, Qt.MouseButton.LeftButton
    enter = QDragEnterEvent(QPoint(10, 10), copy, data, left, keys)
    enter.ignore()
    QApplication.sendEvent(canvas, enter)
    if enter.isAccepted():
        QApplication.sendEvent(canvas, QDropEvent(QPointF(10, 10), copy, data, left, keys))
    return enter.isAccepted()


def test_documents_are_opened_and_everything_else_imported(session, canvas, tmp_path):
    names = [tmp_path / name for name in ("a.bozz", "b.svg", "c.PNG")]
    for name in names:
        name.write_bytes(b"x")
    assert drop(canvas, names[1:])
    assert drop(canvas, names[:1])
    assert session.calls.made == [
        ("exchange.import_files", (names[1:],), {"under": False}),
        ("files.open_safely", (names[0],), {}),
    ]


def test_with_shift_pictures_go_under_the_sheet(session, canvas, tmp_path):
    names = [tmp_path / name for name in ("a.png", "b.svg")]
    for name in names:
        name.write_bytes(b"x")
    assert drop(canvas, names, Qt.KeyboardModifier.ShiftModifier)
    assert session.calls.made == [("exchange.import_files", (names,), {"under": True})]


def test_a_new_picture_is_gone_to_once_its_advice_is_there(session, canvas):
    canvas.motion.reduced = True
    model = Model("m1", "One", "test.none", None)
    session.drawing.document, session.selection.id = Document((model,)), "m1"
    better = standard_view(session.view.camera, "right")
    session.pictures.taken.emit("m1")
    session.advice.say(ViewAdvice("warn", "of an older state", better))
    assert session.view.camera != better
    session.advice.about = model
    session.advice.say(ViewAdvice("warn", "of this one", better))
    assert session.view.camera == better
    canvas.views.look("top")
    session.advice.say(ViewAdvice("warn", "later", better))
    assert session.view.camera.axes[2][2] == pytest.approx(-1)


def test_no_ground_lies_over_a_pinned_picture(session, canvas):
    session.view.show_grid = True
    styles = []
    canvas.viewports.current.set_style = lambda shading, grid: styles.append(grid)
    session.view.style_changed.emit()
    session.advice.say(ViewAdvice("good", "x", pinned=True))
    session.advice.say(ViewAdvice("good", "y", pinned=True))
    session.advice.say(ViewAdvice("good", "z"))
    assert styles == [True, False, True]


def test_the_first_shape_does_not_tilt_a_pinned_view_away(session, canvas):
    session.advice.say(ViewAdvice("good", "x", pinned=True))
    before = session.view.camera
    session.solver.settled.emit("m1")
    assert not canvas.motion.is_running
    assert session.view.camera == before


def test_what_is_no_file_is_not_taken(session, canvas, tmp_path):
    assert not drop(canvas, [tmp_path / "absent.svg", tmp_path])
    assert session.calls.made == []


def test_both_themes_are_shown(canvas, qtbot):
    for palette in (DARK, LIGHT):
        canvas.set_palette(palette)
        color = canvas.grab_picture().pixelColor(5, 5)
        assert (color.red(), color.green(), color.blue()) == palette.paper


WITHOUT_GL = """
import sys
from PySide6.QtWidgets import QApplication
app = QApplication([])
import bozzetto_app.canvas.canvas
slow = {"pyqtgraph", "OpenGL", "scipy", "skimage", "manifold3d", "PIL"} & set(sys.modules)
assert not slow, slow
"""


def test_the_canvas_is_imported_without_anything_slow():
    subprocess.run([sys.executable, "-c", WITHOUT_GL], check=True, timeout=60)


TWICE = """
import importlib.util, sys
spec = importlib.util.spec_from_file_location("canvas_conftest", sys.argv[1])
kit = importlib.util.module_from_spec(spec)
sys.modules["canvas_conftest"] = kit
spec.loader.exec_module(kit)
from PySide6.QtWidgets import QApplication
app = QApplication([])
session = kit.EmptySession()
canvas = kit.Canvas(session, kit.LIGHT)
canvas.resize(400, 300)
canvas.show()
assert canvas.devicePixelRatioF() == 2.0
pen = kit.Pen(canvas)
pen.press(100, 100, 1.0)
for x in range(105, 300, 5):
    pen.move(x, 100, 1.0)
app.processEvents()
picture = canvas.overlay.grab().toImage()
assert picture.width() == 800
dark = [y for y in range(600) if picture.pixelColor(400, y).alpha() > 128]
assert dark and 196 <= dark[0] and dark[-1] <= 204, dark
assert 7 <= len(dark) <= 9, dark
pen.release(300, 100)
assert session.strokes[0].camera.viewport == (400.0, 300.0)
assert abs(float(session.strokes[0].x[0]) - 100.0) < 1e-3
assert canvas.grab_picture().width() == 800
"""


def test_ink_is_sharp_and_in_place_on_a_dense_screen():
    environment = {**os.environ, "QT_SCALE_FACTOR": "2"}
    kit = Path(__file__).with_name("conftest.py")
    subprocess.run([sys.executable, "-c", TWICE, str(kit)], check=True, timeout=60, env=environment)


# -- OpenGL ------------------------------------------------------------------------------------


@pytest.mark.gl
def test_the_canvas_goes_over_to_opengl_without_making_its_window_anew(session, canvas, qtbot):
    if choose_backend() != "gl":
        pytest.skip("no OpenGL here; run with: xvfb-run -a pytest -m gl, QT_QPA_PLATFORM=xcb")
    window = canvas.winId()
    qtbot.waitUntil(lambda: "OpenGL" in canvas.describe_viewport(), timeout=15000)
    assert canvas.winId() == window
    assert not canvas.findChildren(SoftwareViewport) or not any(
        child.isVisible() for child in canvas.findChildren(SoftwareViewport)
    )


def test_opengl_that_does_not_come_leaves_the_software_viewport(qtbot, session, monkeypatch):
    if os.environ["QT_QPA_PLATFORM"] != "offscreen":
        pytest.skip("here OpenGL would come")
    monkeypatch.setenv("BOZZETTO_VIEWPORT", "gl")
    monkeypatch.setattr("bozzetto_app.canvas.viewport.switching.GL_PATIENCE", 200)
    canvas = Canvas(session, LIGHT)
    qtbot.addWidget(canvas)
    canvas.resize(300, 200)
    canvas.show()
    qtbot.waitUntil(lambda: canvas.viewports.is_proving, timeout=10000)
    qtbot.waitUntil(lambda: not canvas.viewports.is_proving, timeout=10000)
    assert "Software" in canvas.describe_viewport()
    assert canvas.grab_picture().width() == 300


def test_opengl_is_imported_when_no_class_of_qt_is_left_to_be_made(qtbot, session, monkeypatch):
    """Else the worker that imports it and the window would make some at the same time."""
    left, opengl = [], "bozzetto_app.canvas.viewport.opengl"

    class NoOpenGL:
        """Finds no module for OpenGL, and looks what is left to be made when it is asked."""

        @staticmethod
        def find_spec(name, path=None, target=None):
            if name == opengl:
                left.append([name for name in dir(QtWidgets) if name not in vars(QtWidgets)])
                raise ImportError("left out")

    monkeypatch.setenv("BOZZETTO_VIEWPORT", "gl")
    monkeypatch.delitem(sys.modules, opengl, raising=False)
    monkeypatch.setattr(sys, "meta_path", [NoOpenGL, *sys.meta_path])
    canvas = Canvas(session, LIGHT)
    qtbot.addWidget(canvas)
    canvas.show()
    qtbot.waitUntil(lambda: bool(left), timeout=20000)
    assert left == [[]]


def test_opengl_that_fails_later_gives_way_to_the_software(session, canvas, qtbot, box_scene):
    session.scene.show(box_scene)
    old = canvas.viewports.current
    canvas.viewports.current = FailedBackend(QWidget(canvas))
    canvas.viewports.current.widget.setGeometry(canvas.rect())
    old.widget.deleteLater()
    canvas.viewports.give_up_gl("the driver was reset")
    assert "Software" in canvas.describe_viewport()
    picture = canvas.grab_picture()
    assert picture.pixelColor(400, 330) != picture.pixelColor(5, 5)


class FailedBackend:
    def __init__(self, widget):
        self.widget = widget

    def ignore(self, *arguments, **options):
        pass

    set_scene = set_live = set_camera = set_palette = set_style = release = ignore
