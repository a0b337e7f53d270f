"""Real windows on real platforms; every screen and program is started and ended here."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.display.program import Program
from tests.display.screens import Screen, absent, headless_weston, nested_weston, xvfb


@pytest.fixture(autouse=True)
def home() -> None:
    """The programs have homes of their own; those who start them need none."""


def _needs(*programs: str) -> None:
    reason = absent(*programs)
    if reason:
        pytest.skip(reason)


@pytest.fixture(scope="session")
def x_screen(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Screen]:
    """An X server with a window manager."""
    _needs("Xvfb", "openbox", "xdotool")
    with xvfb(tmp_path_factory.mktemp("x")) as screen:
        yield screen


@pytest.fixture(scope="session")
def headless_screen(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Screen]:
    """A Wayland compositor without any input device."""
    _needs("weston")
    with headless_weston(tmp_path_factory.mktemp("headless")) as screen:
        yield screen


@pytest.fixture(scope="session")
def wayland_screen(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Screen]:
    """A Wayland compositor with the pointer and the keys of an X server."""
    _needs("weston", "Xvfb", "openbox", "xdotool")
    with nested_weston(tmp_path_factory.mktemp("nested")) as screen:
        yield screen


@pytest.fixture(scope="session")
def clipboard_owner() -> str:
    """Another program with a clipboard."""
    _needs("xclip")
    return "xclip"


@pytest.fixture
def picture(tmp_path: Path) -> Path:
    """A picture file of 64 × 48 pixels."""
    from PIL import Image

    path = tmp_path / "picture.png"
    Image.new("RGB", (64, 48), (200, 80, 30)).save(path)
    return path


def opened(screen: Screen, *words: str, **variables: str) -> Program:
    """The program, painted and with nothing to do."""
    program = Program(screen, *words, **variables)
    program.wait_painted()
    return program


@pytest.fixture(scope="module")
def x_program(x_screen: Screen) -> Iterator[Program]:
    with opened(x_screen) as program:
        yield program


@pytest.fixture(scope="module")
def headless_program(headless_screen: Screen) -> Iterator[Program]:
    with opened(headless_screen) as program:
        yield program


@pytest.fixture(scope="module")
def wayland_program(wayland_screen: Screen) -> Iterator[Program]:
    with opened(wayland_screen) as program:
        yield program
