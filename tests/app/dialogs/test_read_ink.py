"""The dialog “Read this ink as …”."""

from __future__ import annotations

import pytest
from PySide6.QtWidgets import QLabel, QPushButton

from bozzetto_app.dialogs.read_ink import ReadInkDialog
from tests.app.tablet import circle, stroke_of


@pytest.fixture
def session(make_session, settle):
    made = make_session()
    made.gestures.stroke_lifted(stroke_of(circle(), made.view.camera))
    settle(made)
    return made


def opened(qtbot, session):
    dialog = ReadInkDialog(session, session.readings.ink)
    qtbot.addWidget(dialog)
    dialog.show()
    return dialog


def test_each_reading_has_a_picture_and_buttons_with_names(qtbot, session, settle):
    dialog = opened(qtbot, session)
    assert dialog.state.isVisible()
    settle(session)
    assert not dialog.state.isVisible()
    names = {button.accessibleName() for button in dialog.findChildren(QPushButton)}
    assert {"New object, read as Symmetry", "Read as Symmetry in its place"} <= names
    shown = [one for one in dialog.findChildren(QLabel) if not one.pixmap().isNull()]
    told = " ".join(one.accessibleName() for one in shown)
    assert len(shown) == 2
    assert "Symmetry" in told
    assert "Product" in told
    assert dialog.width() < 600


def test_a_choice_is_taken_and_closes_it(qtbot, session, settle):
    dialog = opened(qtbot, session)
    settle(session)
    wanted = "Read as Symmetry in its place"
    (button,) = [one for one in dialog.findChildren(QPushButton) if one.accessibleName() == wanted]
    button.click()
    assert not dialog.isVisible()
    assert [model.modeler for model in session.drawing.document] == ["bozzetto.symmetry"]


def test_closing_it_stops_the_asking(qtbot, session, settle):
    dialog = opened(qtbot, session)
    heard = []
    session.readings.found.connect(heard.append)
    dialog.reject()
    settle(session)
    assert heard == []
    assert len(session.drawing.history.entries) == 2


def test_where_nobody_can_read_it_that_is_said(qtbot, session, settle, monkeypatch):
    readings = session.workbench.readings
    monkeypatch.setattr(type(readings), "readers", lambda self, *, without=(): ("bozzetto.car",))
    dialog = opened(qtbot, session)
    settle(session)
    assert "No other modeler" in dialog.state.text()
