"""Guard against PySide6 builds that lose a reference to None with every call.

PySide6 6.12.0 on Python 3.11 does, and Python then aborts with ``none_dealloc`` after
some thousand calls, in the middle of a drawing. A short test run survives that, so it
is counted here. From Python 3.12 on None is immortal, and what its count does says nothing.
"""

from __future__ import annotations

import sys
import tomllib
from collections.abc import Callable
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from PySide6.QtCore import QEvent
from PySide6.QtGui import QPainterPath, QTransform
from pytestqt.qtbot import QtBot

CALLS = 1000
NOISE = 100
"""References to None that the interpreter itself may take or drop meanwhile."""


def path_grows() -> Callable[[], object]:
    path = QPainterPath()
    return lambda: path.lineTo(1.0, 2.0)


def transform_resets() -> Callable[[], object]:
    return QTransform().reset


def event_is_accepted() -> Callable[[], object]:
    event = QEvent(QEvent.Type.User)
    return event.accept


@pytest.mark.skipif(sys.version_info >= (3, 12), reason="None is immortal")
@pytest.mark.parametrize("kind", [path_grows, transform_resets, event_is_accepted])
def test_calls_keep_their_references_to_none(
    qtbot: QtBot, kind: Callable[[], Callable[[], object]]
) -> None:
    act = kind()
    act()
    before = sys.getrefcount(None)
    for _ in range(CALLS):
        act()
    lost = before - sys.getrefcount(None)
    assert abs(lost) < NOISE, f"{lost} references to None lost in {CALLS} calls"


def test_the_builds_known_to_lose_them_are_excluded() -> None:
    root = Path(__file__).resolve().parents[2]
    project = tomllib.loads((root / "pyproject.toml").read_text())["project"]
    requirements = {each.name: each for each in map(Requirement, project["dependencies"])}
    allowed = requirements["PySide6-Essentials"].specifier
    assert not allowed.contains("6.12.0")
    assert allowed.contains("6.11.3")
    assert "pyside6" not in {name.lower() for name in requirements}
