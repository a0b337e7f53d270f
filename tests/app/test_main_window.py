"""The window as a person meets it: pen and mouse on the sheet, keys, questions, its end."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import QMimeData, QPointF, Qt, QUrl
from PySide6.QtGui import QDropEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import (
    QApplication,
    QFileDialog,
    QLineEdit,
    QMenuBar,
    QMessageBox,
    QPushButton,
)

from bozzetto.document.storage.bozz_file import read_document
from bozzetto.document.waiting_ink import strokes_of
from bozzetto.exchange.formats import find, writers
from bozzetto.exchange.mesh.manifold_check import bounds_volume
from bozzetto.scene.display_list import Shaded
from bozzetto_app.panels.objects.object_row import ModelRow
from bozzetto_app.widgets.text_field import TextField
from bozzetto_app.workers.channel import Request
from tests.app.seen import colour, darkness, part
from tests.app.tablet import Mouse, Stylus, circle
from tests.app.troublemaker import MODELER

ROOT = Path(__file__).parents[2]


@pytest.fixture
def window(make_window, boxes):
    """A window in which boxes are drawn."""
    return make_window(MODELER, extra=[boxes.package])


@pytest.fixture
def draw(settle):
    def with_pen(window, **more):
        Stylus(window.canvas).draw(circle(**more))
        settle(window.session, window.keeper)

    return with_pen


def solids(window):
    return [
        item.mesh for _, item in window.session.scene.visible.items() if isinstance(item, Shaded)
    ]


def press(window, keys, modifier=Qt.KeyboardModifier.NoModifier):
    window.activateWindow()
    window.canvas.setFocus()
    QTest.keyClick(window.canvas, keys, modifier)


def question(window):
    return window.findChild(QMessageBox, "unsaved")


def answer(window, words):
    box = question(window)
    next(b for b in box.findChildren(QPushButton) if words in b.text().replace("&", "")).click()
    QApplication.processEvents()


CTRL = Qt.KeyboardModifier.ControlModifier


# -- drawing -----------------------------------------------------------------------------------


@pytest.mark.parametrize("tool", [Stylus, Mouse])
def test_a_closed_outline_stands_as_a_watertight_solid(make_window, settle, qtbot, tool):
    window = make_window()
    blank = window.canvas.grab_picture()
    tool(window.canvas).draw(circle(radius=150, wave=0.2))
    settle(window.session, window.keeper)
    (solid,) = solids(window)
    assert bounds_volume(solid)
    assert window.session.solver.report["parts"][0]["watertight"]
    after = window.canvas.grab_picture()
    middle = after.width() * 640 // window.canvas.width(), after.height() * 360 // 727
    assert after.pixelColor(*middle) != blank.pixelColor(*middle)
    stroke = window.session.drawing.document.models[0].state.parts[0].strokes[0]
    assert stroke.has_pressure == (tool is Stylus)
    assert stroke.tool == ("pen" if tool is Stylus else "mouse")
    assert len(stroke) >= 85


def test_the_shape_swells_while_the_pen_is_down(make_window, qtbot):
    window = make_window()
    stylus = Stylus(window.canvas)
    stylus.draw(circle(share=0.9, radius=150), lift=False)
    qtbot.waitUntil(lambda: bool(window.session.scene.live.layers), timeout=10_000)
    assert len(window.session.drawing.document) == 0


def test_enter_commits_backspace_drops_and_enter_again_begins_a_new_object(window, draw, settle):
    session = window.session
    draw(window, share=0.6)
    draw(window, share=0.6, radius=60)
    assert len(session.drawing.pending) == 2
    press(window, Qt.Key.Key_Backspace)
    assert len(session.drawing.pending) == 1
    press(window, Qt.Key.Key_Return)
    settle(session)
    assert (len(session.drawing.pending), len(session.drawing.document)) == (0, 1)
    press(window, Qt.Key.Key_Return)
    assert session.selection.id is None
    draw(window)
    assert len(session.drawing.document) == 2


def test_keys_undo_and_redo_also_while_work_is_under_way(window, boxes, draw, settle, qtbot):
    draw(window)
    gate = threading.Event()

    def slow(state, job):
        while not gate.wait(0.002):
            job.checkpoint(0.1, "step")
        del boxes.misdeeds["solve"]
        return boxes.solve(state, job)

    boxes.misdeeds["solve"] = slow
    count = boxes.calls["solve"]
    Stylus(window.canvas).draw(circle(radius=70))
    qtbot.waitUntil(lambda: boxes.calls["solve"] > count)
    press(window, Qt.Key.Key_Z, CTRL)
    assert len(window.session.drawing.document.models[0].state.strokes) == 1
    press(window, Qt.Key.Key_Y, CTRL)
    gate.set()
    settle(window.session)
    assert len(window.session.drawing.document.models[0].state.strokes) == 2
    assert len(solids(window)) == 2


def test_the_eraser_takes_a_part_away_and_undo_brings_it_back(make_window, draw, settle):
    window = make_window()
    draw(window, radius=150)
    Stylus(window.canvas, eraser=True).draw([(600 + 2 * k, 360) for k in range(40)])
    settle(window.session)
    assert window.session.drawing.document.models[0].state.parts == ()
    assert solids(window) == []
    window.session.drawing.undo()
    settle(window.session)
    assert len(solids(window)) == 1


def test_a_camera_key_turns_the_view_but_not_the_drawing(window, draw):
    draw(window)
    document, eye = window.session.drawing.document, window.session.view.camera.eye
    window.canvas.views.look("right")
    QApplication.processEvents()
    assert window.session.view.camera.eye != eye
    assert window.session.drawing.document is document


def test_hints_and_title_follow_what_is_done(window, draw, settle, tmp_path):
    assert window.windowTitle().startswith("Untitled")
    assert not window.isWindowModified()
    draw(window, share=0.6)
    assert part(window.status, "status-words").text() == "Close the box, or press Enter."
    assert window.isWindowModified()
    window.session.gestures.commit()
    settle(window.session)
    window.session.files.save(tmp_path / "cat.bozz")
    settle(window.session)
    assert window.windowTitle().startswith("cat")
    assert not window.isWindowModified()
    draw(window)
    assert window.isWindowModified()


def test_a_drawing_goes_on_while_the_welcome_strip_closes(window, draw):
    width = window.canvas.width()
    assert window.welcome.isVisible()
    draw(window)
    assert not window.welcome.isVisible()
    assert window.canvas.width() == width


def test_a_window_that_waits_for_its_document_asks_for_no_stroke(window, settle):
    settle(window.session)
    window.expect_document()
    assert not window.welcome.isVisible()
    assert not window.canvas.empty_hint.isVisible()


def test_progress_does_not_move_the_sheet(window, boxes, settle, qtbot):
    gate, size = threading.Event(), window.canvas.size()
    sizes = set()

    def slow(state, job):
        while not gate.wait(0.01):
            job.checkpoint(0.3, "inflating")
        return []

    boxes.misdeeds["solve"] = slow
    Stylus(window.canvas).draw(circle())
    qtbot.waitUntil(lambda: part(window.status, "status-cancel").isVisible(), timeout=10_000)
    sizes.add((window.canvas.width(), window.canvas.height()))
    qtbot.waitUntil(
        lambda: part(window.status, "status-step").text() == "inflating", timeout=10_000
    )
    part(window.status, "status-cancel").click()
    settle(window.session)
    assert not part(window.status, "status-cancel").isVisible()
    gate.set()
    assert sizes == {(size.width(), size.height())}


@pytest.mark.parametrize("end", ["shown", "stopped", "undone"])
def test_ink_stays_on_the_sheet_until_its_shape_is_shown(window, boxes, settle, qtbot, end):
    """A second stroke must not be gone while the modeler works on what it was taken for."""
    session, gate = window.session, threading.Event()

    def inked():
        overlay = window.canvas.overlay
        return bool(((darkness(overlay) > 0.3) & (colour(overlay) < 0.1)).any())

    def slow(state, job):
        while not gate.wait(0.01):
            job.checkpoint(0.3, "inflating")
        return []

    Stylus(window.canvas).draw(circle())
    settle(session)
    assert not inked()
    boxes.misdeeds["solve"] = slow
    Stylus(window.canvas).draw(circle(radius=40.0))
    qtbot.waitUntil(lambda: not session.drawing.pending and session.solver.busy, timeout=10_000)
    assert inked()
    if end == "stopped":
        session.cancel_work()
    elif end == "undone":
        session.drawing.undo()
        assert not inked()
    gate.set()
    settle(session)
    assert not inked()


def test_slow_work_on_a_gesture_is_shown_and_can_be_stopped(window, boxes, settle, qtbot):
    gate = threading.Event()
    boxes.misdeeds["apply"] = lambda *args: gate.wait(20.0)
    Stylus(window.canvas).draw(circle())
    qtbot.waitUntil(lambda: part(window.status, "status-cancel").isVisible(), timeout=10_000)
    assert part(window.status, "status-step").text() == "Draw"
    part(window.status, "status-cancel").click()
    gate.set()
    settle(window.session)
    assert not part(window.status, "status-cancel").isVisible()
    assert not len(window.session.drawing.document)
    assert len(window.session.drawing.pending) == 1, "the ink waits"


def test_what_is_said_of_slow_work_goes_when_it_has_ended(window, settle, qtbot):
    """Of a plugin's import too, which nothing else shows: it stood there until it was closed."""
    channel, gate = window.session.toolbox.channel, threading.Event()
    channel.time_limit = 0.2
    channel.submit(Request(lambda job: gate.wait(20.0), lambda answer: None, lambda problem: None))
    faults = window.status.faults
    qtbot.waitUntil(lambda: faults.isVisible(), timeout=10_000)
    gate.set()
    qtbot.waitUntil(lambda: not channel.busy, timeout=10_000)
    assert not faults.isVisible()


# -- questions -------------------------------------------------------------------------------------


def test_closing_with_unsaved_changes_asks_and_cancel_stays(window, draw, qtbot):
    draw(window)
    window.close()
    qtbot.waitUntil(lambda: question(window) is not None)
    window.close()
    QApplication.processEvents()
    assert len(window.findChildren(QMessageBox)) == 1
    answer(window, "Cancel")
    assert window.isVisible()
    window.close()
    qtbot.waitUntil(lambda: question(window) is not None)
    answer(window, "Don’t save")
    qtbot.waitUntil(lambda: not window.isVisible())


def test_saving_at_the_question_saves_and_then_closes(window, draw, qtbot, tmp_path, monkeypatch):
    target = tmp_path / "last"
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(target), ""))
    draw(window)
    window.close()
    qtbot.waitUntil(lambda: question(window) is not None)
    answer(window, "Save")
    qtbot.waitUntil(lambda: not window.isVisible(), timeout=10_000)
    assert target.with_name("last.bozz").exists()


@pytest.mark.parametrize(("ending", "asks"), [(".stl", True), (".3mf", True), (".obj", False)])
def test_what_does_not_print_is_asked_about_before_it_is_exported_for_a_printer(
    window, draw, settle, tmp_path, monkeypatch, ending, asks
):
    draw(window)
    target = tmp_path / f"thing{ending}"
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(target), ""))
    window.session.solver.report = {"print": {"ready": False, "problems": ["It is thin."]}}
    window.files.ask_place_of_export([find(f"a{ending}", writers())])
    box = window.findChild(QMessageBox, "printable")
    assert (box is not None) == asks
    if box is not None:
        assert "It is thin." in box.informativeText()
        settle(window.session)
        assert not target.exists()
        next(b for b in box.buttons() if "anyway" in b.text()).click()
    settle(window.session)
    assert target.exists()


def test_a_save_that_fails_at_the_question_keeps_the_window(
    window, draw, qtbot, settle, tmp_path, monkeypatch
):
    monkeypatch.setattr(
        QFileDialog, "getSaveFileName", lambda *_: (str(tmp_path / "no" / "x.bozz"), "")
    )
    draw(window)
    window.close()
    qtbot.waitUntil(lambda: question(window) is not None)
    answer(window, "Save")
    settle(window.session)
    assert window.isVisible()
    assert window.session.drawing.is_modified


def test_waiting_ink_is_unsaved_work_that_is_saved_at_the_question(
    window, draw, qtbot, settle, tmp_path, monkeypatch
):
    target = tmp_path / "last.bozz"
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(target), ""))
    draw(window, share=0.6)
    drawn = window.session.drawing.pending
    assert window.isWindowModified()
    window.close()
    qtbot.waitUntil(lambda: question(window) is not None)
    answer(window, "Save")
    qtbot.waitUntil(lambda: not window.isVisible(), timeout=10_000)
    document, _ = read_document(target, window.session.registry)
    assert strokes_of(document.waiting) == drawn


@pytest.mark.parametrize("road", ["drop", "open", "new", "sample"])
def test_no_road_to_another_document_goes_past_the_question(
    window, draw, settle, qtbot, tmp_path, road
):
    draw(window)
    window.session.files.save(tmp_path / "a.bozz")
    settle(window.session)
    draw(window)
    before = window.session.drawing.document
    if road == "drop":
        data = QMimeData()
        data.setUrls([QUrl.fromLocalFile(str(tmp_path / "a.bozz"))])
        window.canvas.dropEvent(
            QDropEvent(
                QPointF(500, 300), Qt.DropAction.CopyAction, data, Qt.MouseButton.LeftButton,
                Qt.KeyboardModifier.NoModifier,
            )
        )  # fmt: skip
    elif road == "open":
        window.open(tmp_path / "a.bozz")
    elif road == "new":
        window.files.ask_new()
    else:
        info = next(info for info in window.session.toolbox.modelers if info.samples)
        window.watch(info.id, info.samples[0])
    settle(window.session)
    assert question(window) is not None
    assert window.session.drawing.document is before
    answer(window, "Cancel")
    assert window.session.drawing.document is before


# -- the end ---------------------------------------------------------------------------------------


def test_twenty_documents_leave_no_widget_and_no_thread(window, draw, settle, qtbot, tmp_path):
    draw(window)
    session = window.session
    session.files.save(tmp_path / "a.bozz")
    settle(session, window.keeper)
    session.files.new()
    settle(session, window.keeper)
    widgets = len(QApplication.topLevelWidgets())
    threads = threading.active_count()
    inside = len(window.findChildren(object))
    for _ in range(20):
        session.files.open_safely(tmp_path / "a.bozz")
        settle(session)
        draw(window, radius=70)
        session.drawing.history.mark_saved()
        session.files.new()
    settle(session, window.keeper)
    qtbot.wait(50)
    QApplication.sendPostedEvents(None, 52)
    assert len(QApplication.topLevelWidgets()) <= widgets
    assert len(window.findChildren(object)) <= inside + 10
    qtbot.waitUntil(lambda: threading.active_count() <= threads, timeout=5000)


def test_a_window_closed_during_work_ends_quietly(make_window, boxes, qtbot, settle):
    begun = threading.Event()

    def endless(state, job):
        begun.set()
        while True:
            job.checkpoint(0.5, "on and on")

    boxes.misdeeds["solve"] = endless
    window = make_window(MODELER, extra=[boxes.package])
    Stylus(window.canvas).draw(circle())
    qtbot.waitUntil(begun.is_set, timeout=10_000)
    window.close_without_asking()
    assert not window.isVisible()
    settle(window.session)

    def is_written():
        return not any(thread.name == "bozzetto-journal" for thread in threading.enumerate())

    qtbot.waitUntil(is_written, timeout=10_000)


def run(*arguments, home, **more):
    env = {
        **os.environ, "QT_QPA_PLATFORM": "offscreen", "HOME": str(home),
        "XDG_CONFIG_HOME": f"{home}/config", "XDG_DATA_HOME": f"{home}/data", **more,
    }  # fmt: skip
    return subprocess.run(
        [sys.executable, *arguments], cwd=ROOT, env=env, capture_output=True, text=True, timeout=120
    )


PROBE = """
import sys, threading
from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QApplication
import bozzetto_app.main_window as w

class Probed(w.Window):
    def __init__(self, *arguments):
        super().__init__(*arguments)
        self.look = QTimer(self, interval=20)
        self.look.timeout.connect(self.seen)
        self.look.start()

    def seen(self):
        {seen}

    def finish(self):
        self.look.stop()
        self.close_without_asking()

import bozzetto_app.startup as start
start.Window = Probed
from bozzetto_app.__main__ import main
code = main(sys.argv[1:])
print("code", code)
sys.exit(code)
"""


def test_the_program_opens_the_document_it_is_given(window, draw, settle, tmp_path):
    draw(window)
    window.session.toolbox.take_modeler("bozzetto.silhouette")
    settle(window.session)
    draw(window)
    window.session.objects.rename(window.session.selection.id, "Cat")
    window.session.files.save(tmp_path / "cat.bozz")
    settle(window.session)
    window.session.files.close()
    seen = (
        "names = [m.name for m in self.session.drawing.document]\n"
        "        if names and not self.session.busy:\n"
        "            print(self.windowTitle(), names); self.finish()"
    )
    done = run("-c", PROBE.format(seen=seen), str(tmp_path / "cat.bozz"), home=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "cat[*] — Bozzetto ['Boxes', 'Cat']" in done.stdout
    assert "Traceback" not in done.stderr


def test_the_program_closed_in_the_middle_of_a_solve_ends_at_once(tmp_path):
    sample = next((ROOT / "plugins/bozzetto_silhouette/samples").glob("horse.json"))
    seen = "self.session.solver.busy and self.finish()"
    for _ in range(3):
        done = run("-c", PROBE.format(seen=seen), str(sample), home=tmp_path)
        assert done.returncode == 0, done.stderr
        assert "code 0" in done.stdout
        assert "Fatal" not in done.stderr
        assert "Traceback" not in done.stderr


def test_a_worker_that_never_ends_is_left_behind_and_not_taken_down_under(tmp_path):
    seen = (
        "threading.Thread(target=threading.Event().wait, name='bozzetto-hung', daemon=True).start()"
        "\n        import atexit; atexit.register(print, 'taken down')"
        "\n        self.finish()"
    )
    done = run("-c", PROBE.format(seen=seen), "--no-plugins", home=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "code 0" in done.stdout
    assert "taken down" not in done.stdout


@pytest.mark.slow
@pytest.mark.parametrize("turn", range(5))
def test_native_code_that_goes_on_at_the_end_does_not_bring_it_down(tmp_path, turn):
    """Workers compute and call the window, which is gone by then; nothing asks them to stop."""
    seen = (
        "import numpy as np\n"
        "        from bozzetto_app.workers.channel import Channel, Request\n"
        "        from bozzetto_app.workers.main_thread import call_on_main_thread\n"
        "        def work(job):\n"
        "            while True:\n"
        "                np.linalg.svd(np.random.rand(200, 200))\n"
        "                call_on_main_thread(self, self.windowTitle)\n"
        "        for name in ('one', 'other'):\n"
        "            Channel(name, parent=self).submit(Request(work, print, print))\n"
        "        self.look.stop()\n"
        "        QTimer.singleShot(200, self.finish)"
    )
    done = run("-c", PROBE.format(seen=seen), "--no-plugins", home=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "code 0" in done.stdout
    assert "Fatal" not in done.stderr


def test_without_plugins_the_window_opens_all_the_same(tmp_path):
    seen = "print('modelers', len(self.session.toolbox.modelers)); self.finish()"
    done = run("-c", PROBE.format(seen=seen), "--no-plugins", home=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "modelers 0" in done.stdout


@pytest.mark.skipif(sys.platform in ("win32", "darwin"), reason="there is always a screen")
def test_without_a_screen_it_says_so_and_what_to_do():
    env = {
        name: value
        for name, value in os.environ.items()
        if name not in ("DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM")
    }
    done = subprocess.run(
        [sys.executable, "-m", "bozzetto_app"], cwd=ROOT, env=env, capture_output=True, text=True
    )
    assert done.returncode == 2
    assert done.stderr.startswith("error: there is no screen here")
    assert done.stderr.count("\n") == 1


@pytest.mark.skipif(os.name == "nt", reason="signals")
def test_ctrl_c_in_the_terminal_closes_an_idle_window(tmp_path):
    import signal

    env = {
        **os.environ, "QT_QPA_PLATFORM": "offscreen", "HOME": str(tmp_path),
        "XDG_CONFIG_HOME": f"{tmp_path}/c", "XDG_DATA_HOME": f"{tmp_path}/d",
    }  # fmt: skip
    seen = "print('open', flush=True); self.look.stop()"
    process = subprocess.Popen(
        [sys.executable, "-c", PROBE.format(seen=seen)],
        cwd=ROOT,
        env=env,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout.readline() == "open\n"
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=60)
    assert process.returncode == 0, err
    assert "code 0" in out


@pytest.mark.skipif(sys.platform == "win32", reason="signals are others there")
def test_ctrl_c_in_the_midst_of_the_first_paint_closes_the_window(tmp_path):
    """Nobody listens yet; an exception there would be printed by Qt, and forgotten."""
    code = (
        "import os, signal, sys\n"
        "from bozzetto_app.canvas.viewport.software import SoftwareViewport\n"
        "paint = SoftwareViewport.paintEvent\n"
        "def interrupted(viewport, event):\n"
        "    SoftwareViewport.paintEvent = paint\n"
        "    os.kill(os.getpid(), signal.SIGINT)\n"
        "    paint(viewport, event)\n"
        "SoftwareViewport.paintEvent = interrupted\n"
        "from bozzetto_app.__main__ import main\n"
        "print('code', main([]))"
    )
    done = run("-c", code, home=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "code 0" in done.stdout
    assert "KeyboardInterrupt" not in done.stderr


# -- OpenGL ---------------------------------------------------------------------------------------

GL_PROBE = """
if not self.session.scene.visible.layers and not self.session.busy:
            from tests.app.tablet import Stylus, circle
            Stylus(self.canvas).draw(circle(640, 360, 150))
        elif self.session.scene.visible.layers and not self.session.busy:
            self.waited = getattr(self, "waited", 0) + 1
            if self.waited == 100:
                self.canvas.motion.finish()
                picture = self.canvas.grab_picture()
                ratio = picture.width() / self.canvas.width()
                inside = picture.pixelColor(int(640 * ratio), int(330 * ratio))
                outside = picture.pixelColor(int(900 * ratio), int(100 * ratio))
                print(self.canvas.describe_viewport())
                print("colours", inside.name(), outside.name())
                self.finish()
"""


@pytest.mark.gl
def test_the_opengl_window_shows_the_solid(tmp_path):
    import shutil

    if shutil.which("xvfb-run") is None:
        pytest.skip("no virtual X server here")
    env = {
        **os.environ, "HOME": str(tmp_path), "XDG_CONFIG_HOME": f"{tmp_path}/c",
        "XDG_DATA_HOME": f"{tmp_path}/d", "BOZZETTO_VIEWPORT": "gl", "QT_QPA_PLATFORM": "xcb",
    }  # fmt: skip
    done = subprocess.run(
        ["xvfb-run", "-a", "-s", "-screen 0 1600x1000x24", sys.executable, "-c",
         PROBE.format(seen=GL_PROBE.strip())],
        cwd=ROOT, env=env, capture_output=True, text=True, timeout=180,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "OpenGL" in done.stdout
    inside, outside = next(
        line.split()[1:] for line in done.stdout.splitlines() if line.startswith("colours")
    )
    far = np.abs(rgb(inside) - rgb(outside)).max()
    assert far > 20, done.stdout
    red, _, blue = rgb(inside)
    assert red > blue  # clay is warm


def rgb(name):
    return np.array([int(name[k : k + 2], 16) for k in (1, 3, 5)])


def _menus(menu):
    yield menu
    for action in menu.actions():
        if action.menu() is not None:
            yield from _menus(action.menu())


def test_no_two_entries_of_a_menu_have_the_same_letter(make_window, settle):
    """With a letter that is there twice the keyboard only moves between them."""
    window = make_window("bozzetto.product")
    settle(window.session, window.keeper)
    (bar,) = window.findChildren(QMenuBar)
    for menu in _menus(bar):
        letters = [
            text[text.index("&") + 1].lower()
            for action in menu.actions()
            if "&" in (text := action.text().replace("&&", ""))
        ]
        assert len(set(letters)) == len(letters), [action.text() for action in menu.actions()]


def test_enter_after_a_new_name_does_not_leave_the_object(window, draw, settle):
    draw(window)
    session = window.session
    chosen = session.selection.id
    assert chosen is not None
    row = next(one for one in window.findChildren(ModelRow) if one.isVisible())
    row.edit_name()
    QApplication.processEvents()
    assert row.rect().contains(row.editor.geometry())  # else its lower edge is cut off
    QTest.keyClicks(row.editor, "Pony")
    QTest.keyClick(row.editor, Qt.Key.Key_Return)
    settle(session, window.keeper)
    assert session.drawing.document.models[0].name == "Pony"
    assert session.selection.id == chosen


def test_enter_in_a_line_of_text_of_a_panel_does_not_leave_the_object(window, draw, settle):
    """Also in that of a plugin's panel, which is any line of Qt's."""
    draw(window)
    chosen = window.session.selection.id
    for made in (TextField, QLineEdit):
        line = made(window.centralWidget())
        line.show()
        line.setFocus()
        QTest.keyClicks(line, "Pony")
        QTest.keyClick(line, Qt.Key.Key_Return)
        settle(window.session, window.keeper)
        assert line.text() == "Pony"
        assert window.session.selection.id == chosen
