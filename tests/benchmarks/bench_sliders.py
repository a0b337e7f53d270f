"""Frames shown while a slider is dragged at 60 values in a second."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from pathlib import Path

from tests.benchmarks.timing import Row

DRAGS = (
    ("bozzetto.silhouette", "horse", ("part", "inflation")),
    ("bozzetto.symmetry", "boat", ("", "length")),
    ("bozzetto.car", "hatchback", ("", "length")),
)
SECONDS = 3.0


def rows() -> Iterator[Row]:
    """Each drag in a window of its own; 0 frames in 4 s it was before."""
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    from PySide6.QtWidgets import QApplication

    from tests.slider_drags import close, drag, open_sample

    application = QApplication.instance() or QApplication([])
    for modeler, stem, key in DRAGS:
        with tempfile.TemporaryDirectory() as folder:
            window = open_sample(modeler, stem, Path(folder))
            found = drag(window, key, SECONDS)
            close(window)
        yield Row(
            "sliders", f"{stem}, {found.label} dragged: frames shown", found.frames / SECONDS,
            "/s", "≥ 10 /s",
        )  # fmt: skip
        yield Row(
            "sliders", f"{stem}, {found.label}: pictures painted", found.painted / SECONDS, "/s",
        )  # fmt: skip
        yield Row(
            "sliders", f"{stem}, {found.label}: frames for a second of processor time",
            found.frames / max(found.processor, 1e-3), "/s",
        )  # fmt: skip
    application.processEvents()
