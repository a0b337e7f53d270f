"""The program in a real window of an X server."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from tests.display.program import Program
from tests.display.screens import Screen, wait_until
from tests.display.strokes import (
    SAMPLES,
    circle,
    draw_with_mouse,
    draw_with_stylus,
    only_stroke,
)

pytestmark = pytest.mark.display

IDLE_SHARE = 0.02
"""Of one processor, at most, while nobody touches the program."""

ENOUGH = 55
"""Samples that must arrive of 60 movements, at least."""


def test_a_window_at_rest_costs_nothing_and_ctrl_c_closes_it(x_screen: Screen) -> None:
    with Program(x_screen, module="bozzetto_app") as program:
        pid = program.process.pid
        x_screen.xdotool("search", "--sync", "--onlyvisible", "--pid", pid)
        share, wakeups = program.idle_share(5.0)
        assert share <= IDLE_SHARE
        assert wakeups < 20
        program.process.send_signal(signal.SIGINT)
        assert program.process.wait(30) == 0


def test_the_window_manager_closes_it(x_screen: Screen) -> None:
    with Program(x_screen) as program:
        program.wait_painted()
        wait_until(lambda: program.ask("facts")["active"], "the focus")
        x_screen.xdotool("key", "alt+F4")
        assert program.process.wait(30) == 0


@pytest.mark.parametrize("busy", [0, 100, 150])
def test_every_movement_of_the_mouse_arrives(x_program: Program, busy: int) -> None:
    drawn = draw_with_mouse(x_program, busy=busy)
    stroke = np.array(only_stroke(x_program))
    assert len(stroke) >= ENOUGH
    assert stroke[[0, -1], :2] == pytest.approx(np.array(drawn)[[0, -1]], abs=1.0)
    assert (np.diff(stroke[:, 2]) >= 0).all()


@pytest.mark.parametrize("busy", [0, 100, 150])
def test_every_movement_of_the_stylus_arrives(x_program: Program, busy: int) -> None:
    drawn = draw_with_stylus(x_program, busy=busy)
    stroke = np.array(only_stroke(x_program))
    assert len(stroke) == SAMPLES
    assert stroke[:, :2] == pytest.approx(np.array(drawn), abs=0.01)
    # the times are the pen's, whatever the window did meanwhile
    assert stroke[:, 2] == pytest.approx(0.005 * np.arange(SAMPLES), abs=0.002)


def test_a_stroke_drawn_fast_makes_the_solid_of_one_drawn_slowly(x_program: Program) -> None:
    made = []
    for busy, pace in ((0, 0.02), (150, 0.004)):
        draw_with_mouse(x_program, busy=busy, pace=pace)
        made.append((x_program.ask("volume"), np.array(only_stroke(x_program))[:, :2]))
    (slow, slow_places), (fast, fast_places) = made
    assert slow > 0
    assert fast == pytest.approx(slow, rel=0.005)
    assert min(len(slow_places), len(fast_places)) >= ENOUGH
    assert distances(fast_places, slow_places).max() <= 1.0
    assert distances(slow_places, fast_places).max() <= 1.0


def distances(places: np.ndarray, others: np.ndarray) -> np.ndarray:
    """How far every place is from the nearest of others, pixels."""
    return np.linalg.norm(places[:, None] - others, axis=2).min(1)


@pytest.mark.parametrize("scale", ["1.25", "2"])
def test_ink_is_under_the_pointer_on_a_scaled_screen(x_screen: Screen, scale: str) -> None:
    with Program(x_screen, QT_SCALE_FACTOR=scale) as program:
        program.wait_painted()
        assert program.ask("facts")["scale"] == float(scale)
        drawn = draw_with_mouse(program, busy=100, radius=120.0)
        stroke = np.array(only_stroke(program))
        assert len(stroke) >= ENOUGH
        assert distances(stroke[:, :2], np.array(drawn)).max() <= 1.0


# -- what can come between the press and the lift ------------------------------------------------


def half_drawn(program: Program) -> list[tuple[float, float]]:
    """Press and draw one half of a circle; the places of the other half."""
    facts = program.ask("facts")
    x, y = (c + 0.5 * s for c, s in zip(facts["corner"], facts["size"], strict=True))
    places = circle((x, y))
    program.screen.press(places[0])
    wait_until(lambda: program.ask("facts")["mode"] == "INKING", "the press")
    program.screen.move(places[1 : SAMPLES // 2 + 1])
    return places[SAMPLES // 2 + 1 :]


@pytest.fixture
def x_button(x_screen: Screen) -> Iterator[None]:
    """The mouse's button is up again however the test ends: the next one may hope for that."""
    yield
    x_screen.lift()


@pytest.mark.usefixtures("x_button")
def test_losing_the_focus_loses_no_ink(x_screen: Screen, x_program: Program) -> None:
    rest = half_drawn(x_program)
    with subprocess.Popen(
        [sys.executable, "-c", OTHER_WINDOW], env=dict(x_screen.environment)
    ) as other:
        try:
            # as a taskbar does it; a window that only asks for the focus may be refused it
            found = ("search", "--sync", "--onlyvisible", "--name", "Somebody else")
            x_screen.xdotool(*found, "windowactivate")
            wait_until(lambda: not x_program.ask("facts")["active"], "the other window")
            x_screen.move(rest)
            x_screen.lift()
            wait_until(lambda: x_program.ask("lifted"), "the lift")
        finally:
            other.terminate()
    assert len(only_stroke(x_program)) >= ENOUGH
    wait_until(lambda: x_program.ask("facts")["active"], "the focus again")


OTHER_WINDOW = """
from PySide6.QtWidgets import QApplication, QWidget
app = QApplication([])
window = QWidget()
window.setWindowTitle("Somebody else")
window.setGeometry(20, 20, 150, 100)
window.show()
window.activateWindow()
app.exec()
"""


@pytest.mark.usefixtures("x_button")
def test_putting_the_window_away_loses_no_ink(x_screen: Screen, x_program: Program) -> None:
    half_drawn(x_program)
    x_program.ask("minimise")
    wait_until(lambda: x_program.ask("lifted"), "the end of the stroke")
    x_screen.lift()
    assert x_program.ask("facts")["mode"] == "IDLE"
    (stroke,) = x_program.ask("strokes")
    assert len(stroke) >= SAMPLES // 2
    x_program.ask("restore")
    wait_until(lambda: x_program.ask("facts")["active"], "the window")
    x_program.ask("run", action="edit.drop")
    x_program.wait_calm()
    draw_with_mouse(x_program)
    assert len(only_stroke(x_program)) >= ENOUGH


@pytest.mark.usefixtures("x_button")
def test_a_question_in_the_middle_of_a_stroke_loses_no_ink(
    x_screen: Screen, x_program: Program
) -> None:
    rest = half_drawn(x_program)
    x_program.ask("ask")
    x_screen.move(rest)
    x_screen.lift()
    x_program.ask("answer")
    x_screen.xdotool("mousemove_relative", "--", -5, -5, "sleep", 0.05)
    wait_until(lambda: x_program.ask("lifted"), "the end of the stroke")
    (stroke,) = x_program.ask("strokes")
    assert len(stroke) >= SAMPLES // 2
    x_program.ask("run", action="edit.drop")
    x_program.wait_calm()
    draw_with_mouse(x_program)
    assert len(only_stroke(x_program)) >= ENOUGH


@pytest.mark.usefixtures("x_button")
def test_a_stroke_may_leave_the_window(x_screen: Screen, x_program: Program) -> None:
    facts = x_program.ask("facts")
    x, y = facts["corner"][0] + 50, facts["corner"][1] + 300
    way = [*range(x, 5, -25), *range(5, x, 25)]
    x_screen.press((x, y))
    wait_until(lambda: x_program.ask("facts")["mode"] == "INKING", "the press")
    x_screen.move([(place, y + 3.0 * k) for k, place in enumerate(way)])
    x_screen.lift()
    wait_until(lambda: x_program.ask("lifted"), "the lift")
    stroke = np.array(only_stroke(x_program))
    assert len(stroke) >= len(way) - 2
    assert stroke[:, 0].min() == pytest.approx(min(way) - facts["corner"][0], abs=1.0)


# -- other programs ------------------------------------------------------------------------------


def test_a_picture_comes_over_from_another_program(
    x_screen: Screen, x_program: Program, clipboard_owner: str, picture: Path
) -> None:
    before = x_program.ask("facts")["underlays"]
    words = [clipboard_owner, "-selection", "clipboard", "-t", "image/png", "-i", str(picture)]
    subprocess.run(words, env=dict(x_screen.environment), check=True, timeout=30)
    x_program.ask("run", action="edit.paste_under")
    wait_until(lambda: x_program.ask("facts")["underlays"] == before + 1, "the picture")


def test_words_go_over_to_another_program(
    x_screen: Screen, x_program: Program, clipboard_owner: str
) -> None:
    x_program.ask("clipboard", text="80 × 40 mm")
    taken = subprocess.run(
        [clipboard_owner, "-selection", "clipboard", "-o"],
        env=dict(x_screen.environment),
        check=True,
        capture_output=True,
        timeout=30,
    )
    assert taken.stdout.decode() == "80 × 40 mm"
