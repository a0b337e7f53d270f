"""Hundreds of objects on the sheet: how long the window stands still for what a hand does."""

from __future__ import annotations

import os
import statistics
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

from tests.benchmarks.timing import Row

COUNT: Final = 600
"""Objects: half silhouettes, half polyhedra, each with shapes and parts of its own."""

ROW: Final = 25
"""Objects beside one another."""

APART: Final = 300.0
"""mm from one to the next."""

TURNS: Final = 5
"""Times that each thing is done, with different objects."""

REST: Final = 0.5
"""Seconds without work after which the window is at rest."""

BUDGET: Final = "≤ 50 ms"


def rows() -> Iterator[Row]:
    """Choose, move, hide, duplicate, delete and undo, in one window."""
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    from PySide6.QtWidgets import QApplication

    from bozzetto.plugin.host.registry import Registry
    from bozzetto_app.main_window import Window
    from bozzetto_app.session.session import Session
    from tests.slider_drags import close, settle

    application = QApplication.instance() or QApplication([])
    assert isinstance(application, QApplication)  # it lives as long as this does
    with tempfile.TemporaryDirectory() as folder:
        session = Session(Registry())
        window = Window(session, Path(folder) / "recovery")
        window.resize(1280, 800)
        window.show()
        settle(session)
        session.drawing.commit("Add", _document(session.workbench))
        _busy_turns(session)
        for what, deed in _deeds(session):
            longest = []
            for number in range(TURNS):
                begun = time.thread_time()
                deed(number)
                took = time.thread_time() - begun
                longest.append(1000.0 * max([took, *_busy_turns(session)]))
            middle = statistics.median(longest)
            said = f"{COUNT} objects, one {what}: longest turn of the window, processor time"
            yield Row("window", said, middle, "ms", BUDGET)
        close(window)


def _busy_turns(session: Any) -> list[float]:
    """Let the window work until it has nothing to do for a while; processor times of its turns."""
    from PySide6.QtWidgets import QApplication

    took, until = [], time.monotonic() + REST
    while session.busy or time.monotonic() < until:
        begun = time.thread_time()
        QApplication.processEvents()
        took.append(time.thread_time() - begun)
        until = time.monotonic() + REST if session.busy else until
        time.sleep(0.002)
    return took


def _document(bench: Any) -> Any:
    from bozzetto.document.model import Document
    from bozzetto.exchange.import_file import read_drawing
    from bozzetto.geometry.placement import Placement

    plugins = Path(__file__).parents[2] / "plugins"
    made = [
        bench.sources.from_drawing(
            f"bozzetto.{modeler}",
            read_drawing(plugins / f"bozzetto_{modeler}" / "samples" / f"{name}.json"),
            {},
        )
        for modeler, name in (("silhouette", "key"), ("polyhedron", "house"))
    ]
    models = []
    for number in range(COUNT):
        one = made[number % len(made)]
        new = bench.new_model(one.modeler, one.state, f"{one.name} {number}")
        down, along = divmod(number, ROW)
        place = Placement(offset=(APART * along, 0.0, APART * down))
        models.append(replace(new, placement=place))
    return Document(tuple(models))


def _deeds(session: Any) -> Iterator[tuple[str, Callable[[int], object]]]:
    from bozzetto.geometry.placement import Placement

    ids = [model.id for model in session.drawing.document]
    objects = session.objects
    yield "chosen", lambda number: session.selection.select(ids[7 * number])
    yield (
        "moved",
        lambda number: objects.set_placement(ids[number], Placement(offset=(5.0, 0.0, 0.0))),
    )
    yield "hidden", lambda number: objects.set_visible(ids[number], False)
    yield "renamed", lambda number: objects.rename(ids[number], f"Name {number}")
    yield "duplicated", lambda number: objects.duplicate(ids[number])
    yield "deleted", lambda number: objects.delete(ids[number])
    yield "brought back by undo", lambda number: session.drawing.undo()
