"""Sliders of every bundled sample, dragged at 60 values in a second.

Offscreen, and where there is a display on it as well. Frames are different values that were
shown before the release. Where this machine cannot give a processor to the program for long,
figures by the clock are those of the machine: the last column of the figures is in frames for
each second of processor time.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator

from bozzetto_app.__main__ import ONE_THREAD
from tests.reliability.figures import Row

SECONDS = 3.0
"""How long each is dragged."""

PROMISED = 10.0
"""Frames in a second."""

FINAL = 0.3
"""Seconds from the release to the exact last picture."""

PLAY = """
import json, os, sys, tempfile
from dataclasses import asdict
from pathlib import Path
from PySide6.QtWidgets import QApplication
application = QApplication([])
from tests.slider_drags import drags
with tempfile.TemporaryDirectory() as folder:
    count = int(sys.argv[2]) or None
    for stem, found in drags(float(sys.argv[1]), Path(folder), count):
        print(json.dumps([stem, asdict(found)]), flush=True)
    os._exit(0)
"""


def rows(share: float) -> Iterator[Row]:
    """Drag all sliders, or with a small share the first ones, and for a shorter time."""
    platforms = ["offscreen", *(["xcb"] if os.environ.get("DISPLAY") else [])]
    for platform in platforms:
        yield from _on(platform, max(SECONDS * share, 1.0), 0 if share >= 0.5 else 2)


def _on(platform: str, seconds: float, count: int) -> Iterator[Row]:
    made = subprocess.run(
        [sys.executable, "-c", PLAY, str(seconds), str(count)],
        env={**os.environ, **dict.fromkeys(ONE_THREAD, "1"), "QT_QPA_PLATFORM": platform},
        capture_output=True,
        text=True,
        timeout=1800,
        check=False,
    )
    lines = [line for line in made.stdout.splitlines() if line.startswith("[")]
    for line in lines:
        stem, found = json.loads(line)
        rate = found["frames"] / found["seconds"]
        each = found["frames"] / max(found["processor"], 1e-3)
        sound = found["in_order"] and found["last_is_shown"] and found["steps"] == 1
        yield Row(
            f"{stem}, *{found['label']}*, {platform}",
            f"{rate:.0f} values and {found['painted'] / found['seconds']:.0f} pictures of them "
            f"a second, final {found['settled']:.2f} s after the release; "
            f"{each:.0f} values for a second of processor time",
            f"≥ {PROMISED:.0f} frames/s, final ≤ {FINAL:g} s, one step, the last value last",
            rate >= PROMISED and found["settled"] <= FINAL and sound,
        )
    if made.returncode or not lines:
        told = (made.stderr.strip().splitlines() or ["nothing was said"])[-1]
        yield Row(f"all drags end, {platform}", told[:120], "no crash", kept=False)
