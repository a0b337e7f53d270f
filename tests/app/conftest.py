from __future__ import annotations

import importlib.util
import os
import sys
from pathlib import Path

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

import pytest
from PySide6.QtCore import QSettings

_FAKE = Path(__file__).with_name("fake_session.py")


@pytest.fixture(autouse=True)
def _settings_apart(tmp_path):
    """No test reads or writes what the person's own program remembers."""
    QSettings.setPath(
        QSettings.Format.IniFormat, QSettings.Scope.UserScope, str(tmp_path / "settings")
    )


@pytest.fixture(scope="session")
def fakes():
    """The module with the fake session (tests are no package)."""
    spec = importlib.util.spec_from_file_location("fake_session", _FAKE)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look their module up there
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def fake_session(fakes, qapp):
    from bozzetto_app.icons import FOLDER

    return fakes.FakeSession(FOLDER)
