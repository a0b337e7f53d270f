"""Fixture of the real window, loaded by pytest wherever the program is installed."""

from __future__ import annotations

import gc
import os
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from bozzetto_app.testing.window_shell import WindowShell

HOMES = ("HOME", "USERPROFILE", "XDG_CONFIG_HOME", "XDG_DATA_HOME", "XDG_STATE_HOME",
         "XDG_CACHE_HOME", "APPDATA", "LOCALAPPDATA")  # fmt: skip
"""Where the program looks for what a person keeps."""


@pytest.fixture
def window(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[WindowShell]:
    """Open the real window without a screen, with all installed plugins; see `WindowShell`.

    It has a home of its own: no settings, drawings or recovery data are read or written.
    """
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    for name in HOMES:
        monkeypatch.setenv(name, str(tmp_path))
    from bozzetto.plugin.host.registry import Registry
    from bozzetto_app.testing.window_shell import WindowShell

    collects = gc.isenabled()
    gc.disable()  # in a worker's thread it would take widgets along; see `gc_on_main_thread`
    shell = WindowShell(Registry(), tmp_path)
    yield shell
    shell.close()
    if collects:
        gc.enable()
