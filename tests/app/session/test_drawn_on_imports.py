"""Ink files that name what they are drawn on: both objects come in one step, linked."""

from __future__ import annotations

import pytest

from bozzetto.exchange.import_file import read_drawing
from bozzetto_app.session.step_replay import StepReplay
from bozzetto_product.model.curves import Curve
from tests.plugins.product.test_drawn_on_objects import LINK, SIDES, STEPS, ink, lens


@pytest.fixture
def cap(tmp_path):
    lens(tmp_path, modeler="silhouette")
    return ink(tmp_path / "cap.json", SIDES, steps=STEPS, on=LINK, modeler="product")


@pytest.fixture
def session(make_session):
    return make_session("bozzetto.product")


def test_an_import_brings_what_it_is_drawn_on(session, settle, cap):
    session.files.exchange.import_file(cap)
    settle(session)
    under, drawn = session.drawing.document
    assert (under.name, drawn.name) == ("lens", "cap")
    assert drawn.sources == (under.id,)
    assert session.drawing.history.position == 1
    session.drawing.undo()
    settle(session)
    assert len(session.drawing.document) == 0


@pytest.mark.slow
def test_a_replay_draws_on_it(session, settle, qtbot, cap):
    replay = StepReplay(session, read_drawing(cap), speed=40.0)
    with qtbot.waitSignal(replay.finished, timeout=60_000):
        replay.start()
    settle(session)
    under, drawn = session.drawing.document
    assert drawn.sources == (under.id,)
    curves = drawn.state.of_kind(Curve)
    assert len(curves) == 4
    assert all(curve.laid is not None for curve in curves)
