"""Every test runs without a screen and away from the person's own settings."""

from __future__ import annotations

import gc
import os
import sys
import tempfile
from collections.abc import Generator, Iterator, Mapping
from pathlib import Path

import pytest
from hypothesis import settings

from bozzetto_app.__main__ import ONE_THREAD
from tests.long_cases import long_ones, taken

# As the program itself has it, and before numpy is imported: on a busy machine the threads of
# the linear algebra wait for each other by spinning, and a second becomes half a minute.
for _name in ONE_THREAD:
    os.environ.setdefault(_name, "1")

# Before anything imports Qt: the X11 platform aborts the process where no X server is.
os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
os.environ.setdefault("PYOPENGL_ERROR_CHECKING", "0")  # as the program has it

OUTSIDE: Mapping[str, str] = dict(os.environ)
"""The environment as we found it: what a test hands to pip needs its caches and indexes."""

HOMES = {
    "HOME": ".",
    "USERPROFILE": ".",
    "XDG_CONFIG_HOME": "config",
    "XDG_DATA_HOME": "data",
    "XDG_STATE_HOME": "state",
    "XDG_CACHE_HOME": "cache",
    "APPDATA": "config",
    "LOCALAPPDATA": "data",
}
"""Where programs look for a person's files, and what stands in for it below a folder."""


def move_home(folder: Path) -> dict[str, str]:
    """Return the variables that make `folder` the home; the folders exist afterwards."""
    moved = {name: str(folder / place) for name, place in HOMES.items()}
    for place in moved.values():
        Path(place).mkdir(parents=True, exist_ok=True)
    return moved


# Qt remembers the settings folder of its first question, perhaps one asked while a
# test module is imported: so there is a home of our own from the start.
_first_home = tempfile.TemporaryDirectory(prefix="bozzetto-tests-")
os.environ.update(move_home(Path(_first_home.name)))

# Wall-clock limits say more about the machine than about the program.
settings.register_profile("bozzetto", deadline=None, print_blob=True)
settings.load_profile("bozzetto")


# Thousands of test cases are no garbage: to look for some among them takes a third of the
# time in which they are collected, and later a part of every test's.
gc.disable()


def pytest_collection_finish(session: pytest.Session) -> None:
    """Look for garbage from now on, but not among what was collected."""
    gc.freeze()
    gc.enable()


def pytest_addoption(parser: pytest.Parser) -> None:
    """Take the option for a part of the cases."""
    parser.addoption(
        "--share",
        default="1",
        metavar="PARTS[:NUMBER]",
        help="run one of so many cases; with another number others",
    )


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_collection_modifyitems(
    config: pytest.Config, items: list[pytest.Item]
) -> Generator[None]:
    """Mark what the default run leaves out; take a share of what pytest then chooses by marks."""
    for item, is_long in zip(items, long_ones(item.nodeid for item in items), strict=True):
        if is_long:
            item.add_marker("long")
    yield
    answers = taken([item.nodeid for item in items], config.getoption("share"))
    left = [item for item, is_taken in zip(items, answers, strict=True) if not is_taken]
    if left:
        items[:] = [item for item, is_taken in zip(items, answers, strict=True) if is_taken]
        config.hook.pytest_deselected(items=left)


@pytest.fixture(autouse=True)
def home(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Give each test an empty home, with no settings, recovery data or recent files in it."""
    folder = tmp_path_factory.mktemp("home")
    for name, place in move_home(folder).items():
        monkeypatch.setenv(name, place)
    if "PySide6.QtCore" in sys.modules:
        from PySide6.QtCore import QSettings

        for kind in (QSettings.Format.NativeFormat, QSettings.Format.IniFormat):
            QSettings.setPath(kind, QSettings.Scope.UserScope, str(folder / "config"))
    return folder


@pytest.fixture(autouse=True)
def _collect_here(request: pytest.FixtureRequest) -> Iterator[None]:
    """Collect no garbage in a worker's thread while there are widgets: it would take them along.

    The program does the same (`bozzetto_app.workers.gc_on_main_thread`). What a test has made is
    still young at its end; the rest is left alone.
    """
    if "qapp" not in request.fixturenames or not gc.isenabled():
        yield
        return
    gc.disable()
    yield
    gc.collect(0)
    gc.enable()


@pytest.fixture(scope="session")
def outside() -> dict[str, str]:
    """Return the environment of the person who runs the tests, for children that install."""
    return dict(OUTSIDE)


@pytest.fixture(scope="session")
def qapp_cls() -> type:
    """Return the class of the tests' application, which is the program's own."""
    from bozzetto_app.application import Application

    return Application
