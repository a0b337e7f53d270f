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

from tests.benchmarks.timing import Row

REPEATS = 9

HEAVY = ("scipy", "skimage", "manifold3d", "pyqtgraph", "shapely")
"""What must not be loaded before the first paint."""

EAGER = """
import scipy.optimize, scipy.sparse.linalg, scipy.spatial
import skimage.measure, manifold3d, pyqtgraph.opengl, shapely
"""
"""The same program with everything imported at the start, as it would be without care."""

OPEN = """
import json, sys, time
from PySide6.QtCore import QEvent, QObject
from PySide6.QtWidgets import QApplication

class Watch(QObject):
    # The sheet's own paint event comes last; when the call below returns it is painted.
    def eventFilter(self, watched, event):
        if event.type() == QEvent.Type.Paint and type(watched).__name__ == "SoftwareViewport":
            self.loaded = sorted({name.partition(".")[0] for name in sys.modules})
        return False

def until_painted(*_):
    application = QApplication.instance()
    watch = Watch()
    watch.loaded = None
    application.installEventFilter(watch)
    while watch.loaded is None:
        application.processEvents()
    print(json.dumps({
        "painted": time.time(), "processor": time.process_time(), "loaded": watch.loaded
    }), flush=True)
    import os
    os._exit(0)

QApplication.exec = until_painted
from bozzetto_app.__main__ import main
main([])
"""


def opened(code: str) -> dict[str, Any]:
    """Open the window in a fresh process with an empty home; what it says, and the time in ms."""
    with tempfile.TemporaryDirectory() as home:
        places = {
            name: str(Path(home, name))
            for name in ("HOME", "XDG_CONFIG_HOME", "XDG_DATA_HOME", "XDG_STATE_HOME")
        }
        ours = {"QT_QPA_PLATFORM": "offscreen", "BOZZETTO_VIEWPORT": "software"}
        started = time.time()
        done = subprocess.run(
            [sys.executable, "-c", code], env={**os.environ, **places, **ours}, cwd=home,
            capture_output=True, text=True, timeout=60, check=True,
        )  # fmt: skip
    said: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return {
        "ms": 1000.0 * (said["painted"] - started),
        "processor": 1000.0 * said["processor"],
        "loaded": set(said["loaded"]),
    }


def rows(repeats: int = REPEATS) -> Iterator[Row]:
    """The window, warm: the files have been read before."""
    ours, processor, eager = [], [], []
    heavy: set[str] = set()
    for turn in range(repeats + 1):
        found, other = opened(OPEN), opened(EAGER + OPEN)
        heavy |= found["loaded"] & set(HEAVY)
        if turn:
            ours.append(found["ms"])
            processor.append(found["processor"])
            eager.append(other["ms"])
    yield Row(
        "window", "process started to window painted, warm", statistics.median(ours),
        budget="≤ 500 ms", alternative=f"with {', '.join(HEAVY)} imported first",
        other=statistics.median(eager),
    )  # fmt: skip
    yield Row("window", "the same, processor time", statistics.median(processor), budget="≤ 500 ms")
    yield Row("window", f"of {', '.join(HEAVY)} loaded before the first paint", len(heavy), "", "0")
