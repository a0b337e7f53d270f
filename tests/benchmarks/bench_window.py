"""From the start of the process to the painted window."""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from tests.benchmarks import many_objects
from tests.benchmarks.timing import Row

REPEATS = 9

HEAVY = ("scipy", "skimage", "manifold3d", "pyqtgraph", "shapely")
"""What must not be loaded before the first paint."""

BARE = """
import json, os, sys, time
import numpy
from PySide6.QtCore import QEvent, QObject
from PySide6.QtWidgets import QApplication, QMainWindow, QWidget

class Sheet(QWidget):
    painted = False
    def paintEvent(self, event):
        self.painted = True

application = QApplication([])
window = QMainWindow()
sheet = Sheet()
window.setCentralWidget(sheet)
window.resize(1280, 800)
window.show()
while not sheet.painted:
    application.processEvents()
print(json.dumps({
    "painted": time.time(), "processor": time.process_time(), "loaded": []
}), flush=True)
os._exit(0)
"""
"""The least that a window costs: PySide6, numpy, and one widget that paints itself."""

OPEN = """
import json, sys, time
from PySide6.QtWidgets import QApplication

loaded = []

def until_painted(*_):
    # Neither an event filter nor a search among the widgets: PySide would make wrappers and
    # classes for all that passes, which costs what is measured.
    from bozzetto_app.canvas.viewport.software import SoftwareViewport

    paint = SoftwareViewport.paintEvent

    def paint_and_note(viewport, event):
        paint(viewport, event)
        loaded.extend(sorted({name.partition(".")[0] for name in sys.modules}))

    SoftwareViewport.paintEvent = paint_and_note
    application = QApplication.instance()
    while not loaded:
        application.processEvents()
    print(json.dumps({
        "painted": time.time(), "processor": time.process_time(), "loaded": loaded,
    }), flush=True)
    import os
    os._exit(0)

QApplication.exec = until_painted
from bozzetto_app.__main__ import main
main([])
"""


DEAREST = 10
"""How many of the dearest imports are named."""


def opened(code: str, *options: str) -> dict[str, Any]:
    """Open a window in a fresh process with an empty home.

    Returns
    -------
    dict
        "ms" to the first paint and "processor" time, milliseconds; packages "loaded" by then;
        and what the process wrote as "errors".
    """
    with tempfile.TemporaryDirectory() as home:
        places = {
            name: str(Path(home, name))
            for name in ("HOME", "XDG_CONFIG_HOME", "XDG_DATA_HOME", "XDG_STATE_HOME")
        }
        ours = {"QT_QPA_PLATFORM": "offscreen", "BOZZETTO_VIEWPORT": "software"}
        # An installed program is compiled once, not at every start.
        usual = {name: v for name, v in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
        started = time.time()
        done = subprocess.run(
            [sys.executable, *options, "-c", code], env={**usual, **places, **ours}, cwd=home,
            capture_output=True, text=True, timeout=120, check=True,
        )  # fmt: skip
    said: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return {
        "ms": 1000.0 * (said["painted"] - started),
        "processor": 1000.0 * said["processor"],
        "loaded": set(said["loaded"]),
        "errors": done.stderr,
    }


def dearest_imports(report: str, count: int = DEAREST) -> list[tuple[str, float]]:
    """Return the modules whose own code took longest, with milliseconds.

    Parameters
    ----------
    report : str
        Written by ``python -X importtime``: lines of own time, time with imports, and name.
    count : int
    """
    found = []
    for line in report.splitlines():
        own, _, rest = line.removeprefix("import time:").partition("|")
        if line.startswith("import time:") and own.strip().isdigit():
            found.append((rest.rpartition("|")[2].strip(), int(own) / 1000.0))
    return sorted(found, key=lambda pair: -pair[1])[:count]


def rows(repeats: int = REPEATS) -> Iterator[Row]:
    """The window in turn with a bare one, warm; and with hundreds of objects."""
    yield from many_objects.rows()
    yield from _starts(repeats)


def _starts(repeats: int) -> Iterator[Row]:
    """From the start to the first paint; the files have been read before."""
    ours, bare = [], []
    heavy: set[str] = set()
    for turn in range(repeats + 1):
        found, other = opened(OPEN), opened(BARE)
        heavy |= found["loaded"] & set(HEAVY)
        if turn:
            ours.append(found)
            bare.append(other)

    def middle(runs: list[dict[str, Any]], what: str) -> float:
        return statistics.median(run[what] for run in runs)

    for what, words in (("ms", "process started to window painted"), ("processor", "the same")):
        mine, least = middle(ours, what), middle(bare, what)
        kind = ", processor time" if what == "processor" else ", warm"
        yield Row(
            "window", words + kind, mine, budget="≤ 2 × bare",
            alternative="a bare PySide6 window with numpy", other=least,
        )  # fmt: skip
        yield Row("window", f"times the bare window{kind}", mine / least, "", "≤ 2")
    yield Row("window", f"of {', '.join(HEAVY)} loaded before the first paint", len(heavy), "", "0")
    for name, ms in dearest_imports(opened(OPEN, "-X", "importtime")["errors"]):
        yield Row("window", f"dear import: {name}", ms)
