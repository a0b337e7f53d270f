"""Underlays are moved, turned, scaled and aligned on the sheet, with a pen, and in the form."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QImage
from PySide6.QtTest import QTest

from bozzetto.scene import Handle
from tests.app.canvas.conftest import Pen
from tests.app.tablet import circle


@pytest.fixture
def window(make_window, settle):
    made = make_window()
    made.resize(1200, 820)
    made.welcome.hide()
    picture = QImage(800, 500, QImage.Format.Format_RGBA8888)
    picture.fill(0xFFFFFFFF)
    made.session.pictures.take_image(picture, "photo")
    settle(made.session)
    return made


@pytest.fixture
def pen(window):
    return Pen(window.canvas)


def underlay(session):
    (one,) = session.drawing.document.underlays
    return one


def place(session):
    return session.pictures.placing.place


def grips(session):
    """The handles that a pen can take, and where they are seen."""
    scene, camera = session.scene.advice, session.view.camera
    found = {item.id: item.point for _, item in scene.items() if isinstance(item, Handle)}
    return {name.rpartition(":")[2]: camera.project(point)[0][0] for name, point in found.items()}


def corners(session):
    one = underlay(session)
    corner, across, down = (np.array(v) for v in (one.corner, one.across, one.down))
    return np.array([corner, corner + across, corner + across + down, corner + down])


def dragged(pen, start, by, settle, session):
    pen.press(*start)
    for share in np.linspace(0.1, 1.0, 10):
        pen.move(*(np.array(start) + share * np.array(by)))
    pen.release(*(np.array(start) + np.array(by)))
    settle(session)


def seen(session, point):
    return session.view.camera.project(point)[0][0]


def test_a_picture_that_is_dropped_can_be_taken_by_its_handles(window, pen, settle):
    session = window.session
    before, camera = corners(session), session.view.camera
    start = grips(session)["1,0"]
    dragged(pen, start, (-80.0, 50.0), settle, session)
    assert session.view.camera == camera
    np.testing.assert_allclose(corners(session)[3], before[3], atol=1e-9)  # opposite: it stays
    assert place(session).width < 200.0
    assert session.drawing.history.entries[-2:] == (
        "Add underlay “photo”",
        "Change underlay “photo”",
    )
    session.drawing.undo()
    settle(session)
    np.testing.assert_array_equal(corners(session), before)


def test_the_lower_handle_moves_it_as_far_as_the_pen(window, pen, settle):
    session = window.session
    start = grips(session)["move"]
    middle = seen(session, place(session).middle)
    dragged(pen, start, (60.0, -70.0), settle, session)
    assert (place(session).width, place(session).turn) == (pytest.approx(200.0), pytest.approx(0.0))
    np.testing.assert_allclose(grips(session)["move"], np.add(start, (60.0, -70.0)), atol=0.6)
    assert np.hypot(*(seen(session, place(session).middle) - middle)) > 60.0


def test_the_upper_handle_turns_it_about_its_middle(window, pen, settle):
    session = window.session
    before, start = place(session), grips(session)["turn"]
    pen.modifiers = Qt.KeyboardModifier.ShiftModifier
    dragged(pen, start, (90.0, 60.0), settle, session)
    after = place(session)
    assert after.middle == pytest.approx(before.middle)
    assert after.width == pytest.approx(before.width)
    assert after.turn < 0.0
    assert after.turn / 15.0 == pytest.approx(round(after.turn / 15.0))  # with Shift in steps


def test_a_drag_that_is_given_up_leaves_it_and_no_step(window, pen, settle):
    session = window.session
    before, steps = corners(session), session.drawing.history.position
    x, y = grips(session)["move"]
    pen.press(x, y)
    for far in range(5, 60, 5):
        pen.move(x + far, y)
    QTest.keyClick(window.canvas, Qt.Key.Key_Escape)
    pen.release(x + 60, y)
    settle(session)
    np.testing.assert_array_equal(corners(session), before)
    assert session.drawing.history.position == steps


def test_four_touches_bring_two_places_where_they_belong(window, pen, settle):
    session, placing = window.session, window.session.pictures.placing
    one, two = corners(session)[0], corners(session)[2]
    goals = [np.array([-40.0, 0.0, 90.0]), np.array([30.0, 0.0, 40.0])]
    document, camera = session.drawing.document, session.view.camera
    placing.begin_alignment()
    wishes = []
    for place_of_touch in (one, goals[0], two, goals[1]):
        wishes.append(placing.wish)
        assert session.hints.step.sentence == placing.wish  # as every place of the window says it
        x, y = seen(session, place_of_touch)
        pen.press(x, y)
        pen.release(x, y)
        settle(session)
    assert len(set(wishes)) == 4
    assert not placing.is_aligning
    found = corners(session)
    np.testing.assert_allclose(found[[0, 2]], goals, atol=0.5)  # as far as a pen can touch
    assert len(session.drawing.document) == len(document) == 0  # no tool got the touches
    assert not session.drawing.pending
    assert session.view.camera == camera
    session.drawing.undo()
    assert session.drawing.document is document


def test_escape_ends_an_alignment_and_touches_are_the_tool_s_again(window, pen, settle):
    session, placing = window.session, window.session.pictures.placing
    placing.begin_alignment()
    pen.press(600, 300)
    pen.release(600, 300)
    QTest.keyClick(window.canvas, Qt.Key.Key_Escape)
    assert not placing.is_aligning
    assert placing.wish == ""
    assert session.hints.step.sentence == "Draw a closed outline."
    window.canvas.setFocus()
    pen.stroke([(x, y, 0.5) for x, y in circle(600, 380, 90)])
    settle(session)
    assert len(session.drawing.document) == 1


def test_handles_go_when_something_is_drawn_and_come_back_with_the_row(window, pen, settle):
    session = window.session
    assert set(grips(session)) == {"0,0", "1,0", "1,1", "0,1", "move", "turn"}
    pen.stroke([(x, y, 0.5) for x, y in circle(600, 380, 90)])
    settle(session)
    assert grips(session) == {}
    rows = window.docks.objects.list
    spot = rows.visualItemRect(rows.item(rows.count() - 1)).center()
    QTest.mouseClick(rows.viewport(), Qt.MouseButton.LeftButton, pos=spot)
    settle(session)
    assert len(grips(session)) == 6


def test_the_form_tells_and_takes_where_it_lies(window, settle):
    session = window.session
    form = window.docks.parameters.underlay
    assert form.width_field.value() == pytest.approx(200.0)
    form.width_field.edited.emit(320.0, False)
    form.turn.edited.emit(20.0, False)
    form.axes[0].edited.emit(-15.0, False)
    settle(session)
    found = place(session)
    assert (found.width, found.turn) == (pytest.approx(320.0), pytest.approx(20.0))
    assert found.middle[0] == pytest.approx(-15.0)
    session.drawing.undo()
    settle(session)
    assert form.axes[0].value() == pytest.approx(0.0)


def test_a_hidden_or_deleted_one_has_no_handles(window, settle):
    session = window.session
    one = underlay(session)
    session.objects.set_underlay_visible(one.id, False)
    settle(session)
    assert grips(session) == {}
    session.objects.set_underlay_visible(one.id, True)
    settle(session)
    assert len(grips(session)) == 6
    session.pictures.placing.begin_alignment()
    session.objects.delete_underlay(one.id)
    settle(session)
    assert grips(session) == {}
    assert not session.pictures.placing.is_aligning


def test_a_picture_that_is_seen_from_its_edge_is_told_so(window, pen, settle):
    session, placing = window.session, window.session.pictures.placing
    camera = session.view.camera
    x, y, z = place(session).middle
    session.view.set_camera(replace(camera, eye=(x + 500.0, y, z), target=(x, y, z)))
    settle(session)
    before = corners(session)
    placing.begin_alignment()
    heard = []
    session.notices.noticed.connect(lambda notice: heard.append(notice.text))
    middle = [0.5 * v for v in session.view.camera.viewport]
    pen.press(*middle)
    pen.release(*middle)
    settle(session)
    assert any("from its edge" in text for text in heard)
    assert placing.is_aligning
    np.testing.assert_array_equal(corners(session), before)
