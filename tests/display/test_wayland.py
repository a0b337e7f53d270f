"""The program in a real window of a Wayland compositor."""

from __future__ import annotations

import signal
from pathlib import Path

import numpy as np
import pytest

from tests.display.program import Program
from tests.display.screens import Screen, wait_until
from tests.display.strokes import SAMPLES, draw_with_mouse, draw_with_stylus, only_stroke
from tests.display.test_xcb import ENOUGH, IDLE_SHARE

pytestmark = pytest.mark.display


def test_it_opens_is_painted_rests_and_is_closed_by_ctrl_c(
    headless_screen: Screen, tmp_path: Path
) -> None:
    from PIL import Image

    with Program(headless_screen) as program:
        program.wait_painted()
        assert program.ask("facts")["platform"] == "wayland"
        share, wakeups = program.idle_share(5.0)
        assert share <= IDLE_SHARE
        assert wakeups < 20
        program.ask("look", path=str(tmp_path / "window.png"))
        with Image.open(tmp_path / "window.png") as seen:
            colours = seen.convert("RGB").getcolors(1 << 24)
            assert len(colours) > 100  # letters, icons and the view cube
        program.process.send_signal(signal.SIGINT)
        assert program.process.wait(30) == 0


@pytest.mark.parametrize("busy", [0, 150])
def test_the_stylus_draws_without_any_input_device(headless_program: Program, busy: int) -> None:
    drawn = draw_with_stylus(headless_program, busy=busy)
    assert headless_program.ask("volume") > 0
    stroke = np.array(only_stroke(headless_program))
    assert len(stroke) == SAMPLES
    assert stroke[:, :2] == pytest.approx(np.array(drawn), abs=0.01)


def test_a_file_is_dropped(headless_program: Program, tmp_path: Path) -> None:
    mesh = tmp_path / "tetrahedron.obj"
    corners = "v 0 0 0\nv 30 0 0\nv 0 30 0\nv 0 0 30\n"
    mesh.write_text(corners + "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n")
    before = headless_program.ask("facts")["models"]
    headless_program.ask("drop", path=str(mesh))
    wait_until(lambda: headless_program.ask("facts")["models"] == before + 1, "the mesh")
    headless_program.wait_calm()
    assert headless_program.ask("volume") == pytest.approx(30.0**3 / 6.0, rel=1e-6)


def test_without_a_clipboard_pasting_does_no_harm(headless_program: Program) -> None:
    """Nobody has the focus, so the compositor gives no clipboard to anybody."""
    headless_program.ask("copy_picture")
    headless_program.ask("run", action="edit.paste_under")
    headless_program.wait_calm()
    draw_with_stylus(headless_program)
    assert len(only_stroke(headless_program)) == SAMPLES


@pytest.mark.parametrize("busy", [0, 100, 150])
def test_every_movement_of_the_mouse_arrives(wayland_program: Program, busy: int) -> None:
    drawn = draw_with_mouse(wayland_program, busy=busy)
    stroke = np.array(only_stroke(wayland_program))
    assert len(stroke) >= ENOUGH
    assert stroke[[0, -1], :2] == pytest.approx(np.array(drawn)[[0, -1]], abs=2.0)


def test_a_copied_picture_is_pasted(wayland_program: Program) -> None:
    draw_with_mouse(wayland_program)  # only who was pressed may copy
    only_stroke(wayland_program)
    before = wayland_program.ask("facts")["underlays"]
    wayland_program.ask("copy_picture")
    wayland_program.ask("run", action="edit.paste_under")
    wait_until(lambda: wayland_program.ask("facts")["underlays"] == before + 1, "the picture")


def test_copied_words_are_on_the_clipboard(wayland_program: Program) -> None:
    assert wayland_program.ask("clipboard", text="80 × 40 mm") == "80 × 40 mm"
    assert wayland_program.ask("clipboard") == "80 × 40 mm"
