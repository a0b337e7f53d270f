"""Tests see no settings of the person's, and none of each other's."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from PySide6.QtCore import QSettings, QStandardPaths
from PySide6.QtGui import QGuiApplication
from pytestqt.qtbot import QtBot


@pytest.mark.parametrize("turn", [1, 2])
@pytest.mark.parametrize("kind", [QSettings.Format.IniFormat, QSettings.Format.NativeFormat])
def test_settings_do_not_outlive_a_test(home: Path, kind: QSettings.Format, turn: int) -> None:
    store = QSettings(kind, QSettings.Scope.UserScope, "Bozzetto", "Bozzetto")
    assert store.value("turn") is None
    store.setValue("turn", turn)
    store.sync()
    assert Path(store.fileName()).is_relative_to(home)
    assert Path(store.fileName()).is_file()


def test_home_is_empty_and_not_the_persons(home: Path, outside: dict[str, str]) -> None:
    assert Path.home() == home
    assert str(home) != outside.get("HOME")
    assert not [path for path in home.rglob("*") if path.is_file()]
    for place in (
        QStandardPaths.StandardLocation.AppDataLocation,
        QStandardPaths.StandardLocation.ConfigLocation,
    ):
        assert Path(QStandardPaths.writableLocation(place)).is_relative_to(home)


@pytest.mark.usefixtures("qtbot")
def test_no_window_reaches_a_screen() -> None:
    assert QGuiApplication.platformName() == os.environ["QT_QPA_PLATFORM"]


def test_qtbot_is_pyside6(qtbot: QtBot) -> None:
    from pytestqt.qt_compat import qt_api

    assert qt_api.pytest_qt_api == "pyside6"
