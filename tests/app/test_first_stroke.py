"""A stroke in the first moments of the program: it becomes a shape, and the window goes on."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

BOUND = 0.050
"""Longest pause that a person does not notice, s."""

DRAWN = """
import json, sys, time
from pathlib import Path
from PySide6.QtCore import QTimer
import bozzetto_app.main_window as main_window
import bozzetto_app.startup as startup
from tests.app.tablet import Stylus, circle

SCHEDULING = Path("/proc/thread-self/schedstat")

def now():
    # Without the time in which the machine had no core for the window.
    queued = int(SCHEDULING.read_text().split()[1]) * 1e-9 if SCHEDULING.exists() else 0.0
    return time.perf_counter() - queued

class Drawn(main_window.Window):
    def __init__(self, *arguments):
        super().__init__(*arguments)
        self.path = list(circle(x=500.0, y=320.0, samples=60))
        self.count, self.pauses, self.last = len(self.path), [], None
        self.canvas.viewports.first_painted.connect(self.begin)

    def begin(self):
        self.stylus = Stylus(self.canvas)
        self.stylus.press(self.path.pop(0))
        self.pulse = QTimer(self, interval=5)
        self.pulse.timeout.connect(self.beat)
        self.pulse.start()

    def beat(self):
        if self.last is not None:
            self.pauses.append(now() - self.last)
        if len(self.path) > 1:
            self.stylus.move(self.path.pop(0))
        elif self.path:
            self.lifted_with = self.session.toolbox.tools
            self.stylus.lift(self.path.pop())
        elif len(self.session.drawing.document) and not self.session.busy:
            self.pulse.stop()
            (model,) = self.session.drawing.document
            strokes = [s for part in model.state.parts for s in part.strokes]
            print(json.dumps({
                "samples": [len(stroke) for stroke in strokes],
                "waiting": len(self.session.drawing.pending),
                "pauses": self.pauses,
            }))
            self._closing = True
            self.close()
        self.last = now()

startup.Window = Drawn
from bozzetto_app.__main__ import main
sys.exit(main([]))
"""


def first_stroke(home):
    places = {
        name: str(home / name)
        for name in ("HOME", "XDG_CONFIG_HOME", "XDG_DATA_HOME", "XDG_STATE_HOME")
    }
    ours = {"QT_QPA_PLATFORM": "offscreen", "BOZZETTO_VIEWPORT": "software"}
    done = subprocess.run(
        [sys.executable, "-c", DRAWN], cwd=ROOT, env={**os.environ, **places, **ours},
        capture_output=True, text=True, timeout=180,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "Traceback" not in done.stderr
    return json.loads(done.stdout.splitlines()[-1])


def test_a_stroke_right_after_the_first_paint_becomes_a_shape(tmp_path):
    found = first_stroke(tmp_path)
    assert found["samples"] == [60]
    assert found["waiting"] == 0


@pytest.mark.quiet
def test_meanwhile_the_window_does_not_pause(tmp_path):
    pauses = sorted(first_stroke(tmp_path)["pauses"][:60])
    assert pauses[int(0.95 * len(pauses))] <= BOUND
