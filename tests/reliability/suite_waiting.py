"""Strokes that were lifted, and undo.

Random lives of a session: ink that is taken, refused, or whose plugin fails; Enter, Esc, the
eraser, undo, redo, other tools and modelers, deleted objects, files, crashes. After everything
that is done, undo has to reach every stroke that was lifted.
"""

from __future__ import annotations

import logging
import os
import random
import tempfile
from collections.abc import Iterator
from pathlib import Path

from tests.reliability.figures import Row

LIVES = 2_000
ACTS = 25
"""Most that is done in one life."""


def rows(share: float) -> Iterator[Row]:
    """Live, and count what is lost."""
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    from PySide6.QtWidgets import QApplication

    from tests.app.waiting_life import life_in, random_act

    app = QApplication.instance() or QApplication([])
    count = max(1, round(share * LIVES))
    lifted, lost = 0, []
    logging.disable(logging.ERROR)  # thousands of faults are meant, and the log names each
    with tempfile.TemporaryDirectory() as folder, life_in(Path(folder)) as life:
        for seed in range(count):
            rng = random.Random(seed)
            acts = [random_act(rng) for _ in range(rng.randrange(ACTS + 1))]
            before = life.drawn
            try:
                life.live(acts)
            except AssertionError as problem:
                lost.append(f"{seed}: {problem}")
            lifted += life.drawn - before
        app.processEvents()
    logging.disable(logging.NOTSET)
    yield Row(
        f"{count} random lives: strokes lifted that undo does not reach",
        f"{len(lost)} lives of {count}, {lifted} strokes" if lost else f"0 of {lifted}",
        "0",
        not lost,
    )
