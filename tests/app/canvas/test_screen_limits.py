"""Whatever is projected: Qt gets coordinates that it can take, and nothing else."""

from __future__ import annotations

import ast
import math
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PySide6.QtCore import QPointF
from PySide6.QtGui import QImage, QPainter

import bozzetto_app
from bozzetto.scene import LIGHT, Handle, Label, Layer, Scene
from bozzetto.view.camera import Camera
from bozzetto_app.canvas.overlay.wet_ink import PendingInk
from bozzetto_app.canvas.screen_limits import (
    FARTHEST,
    inside_runs,
    is_inside,
    limited,
    point_at,
    rect_about,
    rect_around,
    whole_point,
)
from bozzetto_app.canvas.viewport.label_overlay import paint_marks

PROJECT = Path(bozzetto_app.__file__).parents[2]
SEEN = 3_150_389_010.0
"""What once was handed to a QRect, at an extreme zoom."""

numbers = st.floats(allow_nan=True, allow_infinity=True)


@given(numbers, numbers, st.floats(0.0, 1e3))
def test_nothing_beyond_the_limits_comes_out(x, y, radius):
    assert abs(limited(x)) <= FARTHEST
    for place in (point_at(x, y), whole_point(x, y)):
        assert max(abs(place.x()), abs(place.y())) <= FARTHEST
    for rect in (rect_around(x, y, radius), rect_about([x, 0.0], [y], radius)):
        sides = (rect.left(), rect.top(), rect.right(), rect.bottom())
        assert max(map(abs, sides)) <= 2.1 * FARTHEST
        assert rect.width() >= 0
        assert rect.height() >= 0


@given(st.floats(-FARTHEST, FARTHEST), st.floats(-FARTHEST, FARTHEST))
def test_what_lies_within_them_stays_as_it_is(x, y):
    assert point_at(x, y) == QPointF(x, y)
    assert is_inside(x, y)


def test_no_place_at_all_has_no_area():
    assert rect_about([], [], 3.0).isEmpty()


@given(st.lists(st.tuples(numbers, numbers, st.floats(0, 9)), max_size=8))
def test_runs_of_any_line_lie_within_the_limits(line):
    for run in inside_runs(line):
        assert run
        assert all(is_inside(x, y) and math.isfinite(width) for x, y, width in run)


@given(st.lists(st.tuples(st.floats(-1e12, 1e12), st.floats(-1e12, 1e12)), min_size=2, max_size=6))
def test_a_line_that_is_cut_keeps_its_direction(line):
    """Against an oracle: every point of every run lies on one of the line's own pieces."""
    for run in inside_runs(line):
        for place in np.array(run):
            gaps = []
            for begin, end in zip(np.array(line[:-1]), np.array(line[1:]), strict=True):
                way = end - begin
                length = float(way @ way)
                share = min(max(float((place - begin) @ way) / length, 0.0), 1.0) if length else 0.0
                gaps.append(float(np.abs(begin + share * way - place).max()))
            assert min(gaps) <= 1e-3 + 1e-15 * np.abs(line).max() ** 2 / FARTHEST


def test_a_line_that_crosses_the_sheet_from_far_to_far_is_seen():
    (run,) = inside_runs([(-4e9, -4e9, 1.0), (4e9, 4e9, 3.0)])
    assert run[0] == pytest.approx((-FARTHEST, -FARTHEST, 2.0), rel=1e-3)
    assert run[-1] == pytest.approx((FARTHEST, FARTHEST, 2.0), rel=1e-3)


def test_a_line_is_torn_where_it_is_not_seen():
    runs = inside_runs([(0.0, 0.0), (5.0, 0.0), (math.nan, 0.0), (9.0, 0.0), (12.0, 0.0)])
    assert runs == [[(0.0, 0.0), (5.0, 0.0)], [(9.0, 0.0), (12.0, 0.0)]]


# -- the painters ------------------------------------------------------------------------------


@pytest.mark.parametrize("far", [SEEN, -SEEN, 1e300, math.inf, -math.inf, math.nan])
def test_marks_on_the_sheet_may_lie_anywhere(canvas, pen, session, far):
    """The once fatal one: lit far away, then the pen comes down."""
    overlay = canvas.overlay
    overlay.light_up([(far, 20.0), (30.0, far)], "It crosses itself here.")
    canvas.grab()
    overlay.set_hover((far, far))
    overlay.set_hot_handle((far, 3.0))
    canvas.grab()
    overlay.begin()
    overlay.extend([(10.0, 10.0, 0.5), (far, 12.0, 0.5), (14.0, far, 0.5), (20.0, 20.0, 0.5)])
    canvas.grab()
    overlay.clear_wet()
    canvas.loupe.point(far, far)
    canvas.grab()
    pen.press(400, 300)
    pen.release(400, 300)
    assert (
        session.first("gestures.stroke_lifted")
        or session.calls.named("gestures.cancel")
        or session.calls.made
    )


def test_waiting_ink_is_painted_at_any_zoom(canvas, pen, session):
    pen.stroke([(x, 300.0, 0.5) for x in range(100, 700, 20)])
    (stroke,) = session.strokes
    for height in (200.0, 1e-5, 1e-9):
        camera = Camera("orthographic", (0.0, -500.0, 0.0), height=height, viewport=(800.0, 600.0))
        canvas.overlay.set_pending([stroke], camera)
        canvas.grab()
        lines = PendingInk.of(stroke, camera).lines
        assert all(is_inside(x, y) for line in lines for x, y, _ in line)


def test_handles_and_labels_that_are_far_away_are_left_out(qapp):
    items = (Handle("h", (5.0, 0.0, 3.0)), Label((0.0, 0.0, 9.0), "far"))
    near = Camera("orthographic", (0.0, -500.0, 0.0), height=1e-9, viewport=(80.0, 60.0))
    image = QImage(80, 60, QImage.Format.Format_ARGB32_Premultiplied)
    image.fill(0)
    painter = QPainter(image)
    paint_marks(painter, Scene((Layer("marks", items),)), near, LIGHT)
    painter.end()
    assert not any(image.pixel(x, y) for x in range(80) for y in range(60))


# -- nobody goes another way -------------------------------------------------------------------

WHOLE = {"round", "int", "floor", "ceil"}
MADE_OF_WHOLE = {"QPoint", "QRect", "move", "setGeometry"}


def _name(call):
    return getattr(call.func, "id", getattr(call.func, "attr", ""))


def test_no_other_module_of_the_canvas_makes_whole_coordinates_of_fractions():
    found = []
    for path in sorted((PROJECT / "app/bozzetto_app/canvas").glob("*.py")):
        if path.stem == "screen_limits":
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and _name(node) in MADE_OF_WHOLE:
                inner = {
                    _name(n) for a in node.args for n in ast.walk(a) if isinstance(n, ast.Call)
                }
                if inner & WHOLE or any("toPoint" in name for name in inner):
                    found.append(f"{path.name}:{node.lineno}")
    assert found == []


def test_nobody_overrides_event():
    """An exception without a value, passing through such an override, ends the process."""
    found = [
        f"{path}:{node.lineno}"
        for folder in ("app", "plugins")
        for path in (PROJECT / folder).rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.FunctionDef) and node.name in ("event", "viewportEvent", "notify")
    ]
    assert found == []


CHILD = """
import os, sys
from PySide6.QtCore import QPoint, QPointF, QRect, QTimer, Qt
from PySide6.QtTest import QTest
from bozzetto.scene import LIGHT
from bozzetto_app.canvas.canvas import Canvas
from bozzetto_app.startup import application
sys.path.insert(0, {root!r})
from tests.app.fake_session import EmptySession
app = application()
canvas = Canvas(EmptySession(), LIGHT)
canvas.resize(400, 300)
canvas.hand.mouse_pressed = lambda event: QRect(2**40, 0, 1, 1)
canvas.show()
handle = canvas.windowHandle()
app.postEvent(canvas, __import__("PySide6.QtGui").QtGui.QMouseEvent(
    __import__("PySide6.QtCore").QtCore.QEvent.Type.MouseButtonPress, QPointF(9, 9), QPointF(9, 9),
    Qt.MouseButton.LeftButton, Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier))
QTimer.singleShot(200, app.quit)
app.exec()
print("survived", flush=True)
os._exit(0)  # what is torn down at the end of a script is not asked
"""


def test_a_mistake_in_a_handler_does_not_end_the_program():
    """Even one of the kind that PySide cannot take through an override of `event`."""
    ended = subprocess.run(
        [sys.executable, "-c", CHILD.format(root=str(PROJECT))],
        capture_output=True, text=True, timeout=120, check=False,
    )  # fmt: skip
    assert "OverflowError" in ended.stderr
    assert (ended.returncode, ended.stdout.strip()) == (0, "survived")
