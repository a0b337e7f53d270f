"""What starting the program may load: the slow libraries wait for their first use."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from bozzetto_app.__main__ import PLAIN, make_parser

SLOW = {"scipy", "skimage", "manifold3d", "shapely", "pyqtgraph", "OpenGL"}
QT = {"PySide6", "shiboken6"}
UNUSED_BY_LISTS = {"numpy", "PIL", "pluggy"}

LATER = {
    "bozzetto.cli.main",
    "bozzetto.exchange.handover",
    "bozzetto.geometry.shapes",
    "bozzetto.ink.steps",
    "bozzetto.plugin.context",
    "bozzetto.plugin.guard.guarded_modeler",
    "bozzetto.scene.picking",
    "bozzetto.scene.renderer",
    "bozzetto.scene.thickness_view",
    "bozzetto_app.panels.objects.object_row",
    "bozzetto_app.panels.properties.parameter_row",
    "bozzetto_app.session.autosave",
    "bozzetto_app.session.step_replay",
    "importlib.metadata",
    "logging.handlers",
}
"""Modules that are dear, or bring many others, and that an empty sheet can do without."""

MOST_DATACLASSES = 60
"""Dataclasses made before the first paint; each takes a third of a millisecond."""

COUNT_DATACLASSES = """
import dataclasses, sys
make, sys.made = dataclasses._process_class, 0
def counted(*given):
    sys.made += not hasattr(sys, "loaded_at_first_paint")
    return make(*given)
dataclasses._process_class = counted
"""

NOTE_ALL = """
import json, pathlib, sys
pathlib.Path(sys.argv[-1]).with_name("all.json").write_text(
    json.dumps([sys.made, sorted(sys.loaded_at_first_paint)])
)
"""

REPORT = """
import json, pathlib, sys
names = getattr(sys, "loaded_at_first_paint", sys.modules)
packages = sorted({name.partition(".")[0] for name in names})
pathlib.Path(sys.argv[-1]).write_text(json.dumps(packages))
"""

CALL_MAIN = """
import sys
report, sys.argv = sys.argv[-1], ["bozzetto", *sys.argv[1:-1]]
from bozzetto_app.__main__ import main
try:
    code = main()
except SystemExit as exit:
    code = exit.code
assert not code, f"bozzetto ended with {code}"
sys.argv.append(report)
"""

OPEN_WINDOW = """
import sys, time
from PySide6.QtCore import QEvent, QObject
from PySide6.QtWidgets import QApplication

class FirstPaint(QObject):
    def eventFilter(self, watched, event):
        if event.type() == QEvent.Type.Paint and not hasattr(sys, "loaded_at_first_paint"):
            sys.loaded_at_first_paint = set(sys.modules)
        return False

def look_a_while(*_):
    application = QApplication.instance()
    eye = FirstPaint(application)
    application.installEventFilter(eye)
    end = time.monotonic() + 1.0
    while time.monotonic() < end:
        application.processEvents()
    assert any(w.isVisible() for w in application.topLevelWidgets()), "no window was opened"
    assert hasattr(sys, "loaded_at_first_paint"), "nothing was painted"
    application.closeAllWindows()
    application.processEvents()
    return 0

QApplication.exec = look_a_while
"""


NAMES = """
import bozzetto.cli.main
from bozzetto.geometry import *
from bozzetto.ink import *
from bozzetto.plugin import *
from bozzetto.scene import *
from bozzetto.view import *
"""


def loaded(folder: Path, code: str, *arguments: str) -> set[str]:
    """Return the top-level packages that a fresh Python has loaded after `code`."""
    report = folder / "loaded.json"
    done = subprocess.run(
        [sys.executable, "-c", code + REPORT, *arguments, str(report)],
        env={**os.environ, "QT_QPA_PLATFORM": "offscreen"},
        cwd=folder,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return set(json.loads(report.read_text()))


def bundled_plugins(packages: set[str]) -> set[str]:
    return {name for name in packages if name.startswith("bozzetto_")} - {"bozzetto_app"}


def test_the_entry_point_imports_next_to_nothing(tmp_path: Path) -> None:
    packages = loaded(tmp_path, "import bozzetto_app.__main__")
    assert not packages & (SLOW | QT)
    assert not bundled_plugins(packages)


def test_the_core_imports_no_slow_library(tmp_path: Path) -> None:
    packages = loaded(tmp_path, NAMES)
    assert "bozzetto" in packages
    assert not packages & (SLOW | QT)


@pytest.mark.parametrize("arguments", [["plugins"], ["--help"]], ids=" ".join)
def test_the_command_line_does_without_qt_and_plugin_code(
    tmp_path: Path, arguments: list[str]
) -> None:
    packages = loaded(tmp_path, CALL_MAIN, *arguments)
    assert "bozzetto" in packages
    assert not packages & (SLOW | QT | UNUSED_BY_LISTS)
    assert not bundled_plugins(packages)


def test_no_arguments_mean_what_the_parser_says():
    assert PLAIN == make_parser().parse_args([])


def test_opening_the_window_imports_no_slow_library(tmp_path: Path) -> None:
    packages = loaded(tmp_path, COUNT_DATACLASSES + OPEN_WINDOW + CALL_MAIN + NOTE_ALL)
    assert "PySide6" in packages
    assert not packages & SLOW
    made, names = json.loads((tmp_path / "all.json").read_text())
    assert "bozzetto_app.main_window" in names
    assert not LATER.intersection(names)
    assert 0 < made <= MOST_DATACLASSES


def test_pyside_reads_no_source_of_what_is_imported(tmp_path):
    count = "\nimport linecache, json, pathlib, sys" + (
        "\nread = [name for name in linecache.cache if 'bozzetto_app/session' in name]"
        "\npathlib.Path(sys.argv[-1]).with_name('read.json').write_text(json.dumps(read))"
    )
    found = loaded(tmp_path, OPEN_WINDOW + CALL_MAIN + count)
    assert "bozzetto_app" in found
    assert json.loads((tmp_path / "read.json").read_text()) == []
