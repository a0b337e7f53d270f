"""Drawings of files added to the selected object: one step, refused in words where of no use."""

from __future__ import annotations

from dataclasses import replace

import pytest

from bozzetto_product.model.emblems import Emblem
from bozzetto_product.model.patches import Patch
from tests.plugins.product.detail_kit import ball

RING = (
    '<svg xmlns="http://www.w3.org/2000/svg"><path d="M-5 0A5 5 0 1 0 5 0A5 5 0 1 0 -5 0Z"/></svg>'
)


@pytest.fixture
def logo(tmp_path):
    path = tmp_path / "logo.svg"
    path.write_text(RING, encoding="utf-8")
    return path


@pytest.fixture
def session(make_session, settle):
    made = make_session("bozzetto.product")
    state = ball()
    state = replace(state, selected=state.of_kind(Patch)[0].id)
    model = made.workbench.new_model("bozzetto.product", state, "ball")
    made.drawing.apply_model("Ball", model, is_new=True)
    made.selection.select(model.id)
    settle(made)
    return made


def emblems(session):
    (model,) = session.drawing.document
    return model.state.of_kind(Emblem)


def test_a_drawing_lies_on_the_selected_product_in_one_step(session, settle, logo):
    before = session.drawing.history.position
    assert session.files.exchange.drawings.is_wanted
    session.files.exchange.drawings.take_file(logo)
    settle(session)
    (emblem,) = emblems(session)
    assert emblem.name == "logo 1"
    assert session.drawing.history.position == before + 1
    assert session.drawing.history.undo_label == "Add drawing"
    session.drawing.undo()
    settle(session)
    assert emblems(session) == ()


def test_what_is_of_no_use_is_told_and_changes_nothing(session, settle, logo):
    before = session.drawing.document
    arc = RING.replace("A5 5 0 1 0 -5 0Z", "").replace("<path", '<path fill="none" stroke="red"')
    logo.write_text(arc, encoding="utf-8")
    session.files.exchange.drawings.take_file(logo)
    settle(session)
    assert session.drawing.document is before
    assert any("open" in notice.text for notice in session.heard)


def test_without_a_selection_or_a_use_none_is_wanted(session, make_session):
    session.selection.select(None)
    assert not session.files.exchange.drawings.is_wanted
    assert not make_session("bozzetto.silhouette").files.exchange.drawings.is_wanted
