"""Every bundled sample opens on an empty sheet, as it is read without a window."""

from __future__ import annotations

import pytest

from bozzetto.document.storage.state_codec import state_digest
from bozzetto.exchange.import_file import read_drawing
from bozzetto.plugin.host.registry import Registry

SAMPLES = [
    pytest.param(info.id, path, id=f"{info.id.partition('.')[2]}-{path.stem}")
    for info in Registry().modelers()
    for path in info.samples
]

PATIENCE = 240_000
"""The computer mouse takes half a minute on a busy machine, ms."""


@pytest.mark.long
@pytest.mark.parametrize(("modeler", "path"), SAMPLES)
def test_a_sample_opens_as_it_is_built(make_session, settle, qtbot, modeler, path):
    session = make_session()
    session.files.exchange.import_file(path)
    qtbot.waitUntil(lambda: not session.busy, timeout=PATIENCE)
    settle(session)
    assert [notice.text for notice in session.heard if notice.kind == "error"] == []
    (model,) = session.drawing.document.models
    assert model.modeler == modeler
    built = session.workbench.sources.from_drawing(modeler, read_drawing(path, trusted=True), {})
    assert state_digest(model.state) == state_digest(built.state)
