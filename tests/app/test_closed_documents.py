"""What a person drew is let go of when its document is closed: a day's memory stays flat."""

from __future__ import annotations

import gc
import weakref

import pytest

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("modeler", ["silhouette", "symmetry", "car"])
def test_nothing_holds_a_model_of_a_closed_document(make_window, settle, qtbot, modeler):
    window = make_window(f"bozzetto.{modeler}")
    session = window.session
    settle(session, window.keeper)
    info = session.registry.info(f"bozzetto.{modeler}")
    session.files.exchange.import_file(sorted(info.samples)[0])
    settle(session, window.keeper)
    (state,) = (weakref.ref(model.state) for model in session.drawing.document)
    window.canvas.views.fit()
    settle(session, window.keeper)
    for _ in range(2):  # the next document may still be compared with the last one
        session.files.given_up.emit()
        session.files.new()
        settle(session, window.keeper)

    def is_gone():
        gc.collect()
        return state() is None

    qtbot.waitUntil(is_gone, timeout=20_000)
