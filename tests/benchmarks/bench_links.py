"""Frames of a follower while a slider of its source is dragged at 60 values in a second."""

from __future__ import annotations

import importlib
import os
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from tests.benchmarks.timing import Row

SECONDS = 3.0
CHAIN = 4
"""Boxes that follow one another behind the one that is dragged."""


def rows() -> Iterator[Row]:
    """A box and a chain of followers, then a rough skin over a drawn boat; a window each."""
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    from PySide6.QtWidgets import QApplication

    application = QApplication.instance() or QApplication([])
    yield from _boxes()
    yield from _skin()
    application.processEvents()


def _boxes() -> Iterator[Row]:
    from bozzetto.document.model import Document
    from bozzetto.plugin.host.registry import Registry
    from bozzetto_app.main_window import Window
    from bozzetto_app.session.session import Session
    from tests import linked_boxes
    from tests.slider_drags import close, drag, settle

    with tempfile.TemporaryDirectory() as folder:
        linked_boxes.write_package(Path(folder), "made_up_linked_boxes")
        sys.path.insert(0, folder)
        importlib.invalidate_caches()
        session = Session(Registry(extra=["made_up_linked_boxes"]))
        window = Window(session, Path(folder) / "recovery")
        window.resize(1280, 800)
        window.show()
        settle(session)
        session.toolbox.take_modeler(linked_boxes.MODELER)
        source = session.workbench.new_model(
            linked_boxes.MODELER, linked_boxes.BoxState(10.0), "Body"
        )
        session.drawing.commit("Add", Document((source,)))
        session.selection.select(source.id)
        for _ in range(CHAIN):
            session.shapes.use_chosen(linked_boxes.MODELER)
            settle(session)
        session.selection.select(source.id)
        settle(session)
        found = drag(window, ("", "edge"), SECONDS)
        close(window)
        sys.path.remove(folder)
    each, work = found.followers / CHAIN, max(found.processor, 1e-3)
    what = f"a box dragged: frames of each of {CHAIN} followers in a row"
    yield Row("links", what, each / SECONDS, "/s", "≥ 10 /s")
    yield Row("links", f"{what}, for a second of processor time", each / work, "/s")


def _skin() -> Iterator[Row]:
    from tests.slider_drags import close, drag, open_sample, settle

    with tempfile.TemporaryDirectory() as folder:
        window = open_sample("bozzetto.symmetry", "boat", Path(folder))
        session = window.session
        source = session.selection.id
        session.shapes.use("bozzetto.skin", [source], {})
        settle(session)
        session.selection.select(source)
        settle(session)
        found = drag(window, ("", "length"), SECONDS)
        close(window)
    rate, work = found.followers / SECONDS, found.followers / max(found.processor, 1e-3)
    yield Row("links", "boat, Length dragged: frames of its rough skin", rate, "/s", "≥ 10 /s")
    yield Row("links", "boat: frames of its skin for a second of processor time", work, "/s")
