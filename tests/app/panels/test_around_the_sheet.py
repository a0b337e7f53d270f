"""Rail, modelers' row, history, status line, welcome strip."""

from __future__ import annotations

import itertools
from pathlib import Path
from types import SimpleNamespace

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from msgspec import structs
from PySide6.QtCore import QPoint, QSize, Qt
from PySide6.QtGui import QColor, QContextMenuEvent, QImage
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QLabel, QMenu, QMenuBar, QPushButton, QWidget

from bozzetto.document.model import Document
from bozzetto.plugin import NextStep
from bozzetto.scene.palette import DARK, LIGHT
from bozzetto_app.panels import status_line
from bozzetto_app.panels.history import HistoryPanel
from bozzetto_app.panels.modeler_bar import ModelerBar
from bozzetto_app.panels.status_line import StatusLine
from bozzetto_app.panels.tool_rail import ToolRail
from bozzetto_app.panels.welcome_strip import WelcomeStrip
from bozzetto_app.style.theme import apply_theme
from bozzetto_app.widgets.icon_button import IconButton
from tests.app import fake_session as fakes
from tests.app.seen import button, buttons, chosen, part


@pytest.fixture
def shown(qtbot):
    def show(widget):
        qtbot.addWidget(widget)
        widget.show()
        return widget

    return show


# -- rail --


def test_tools_are_taken_by_their_buttons(shown, fake_session):
    rail = shown(ToolRail(fake_session))
    button(rail, "Cut").click()
    assert fake_session.calls.named("toolbox.take_tool") == [(("cut",), {})]
    assert button(rail, "Outline").isChecked()
    assert "(3)" in button(rail, "Cut").toolTip()


def test_the_active_tool_is_the_sessions(shown, fake_session):
    rail = shown(ToolRail(fake_session))
    fake_session.toolbox.tool = "erase"
    fake_session.toolbox.tool_changed.emit()
    assert chosen(rail) == ["Erase"]


def test_another_modeler_brings_other_tools(shown, fake_session):
    rail = shown(ToolRail(fake_session))
    fake_session.toolbox.tools = (fakes.ToolInfo("spine", "Spine", None, "Draw."),)
    fake_session.toolbox.tool = "spine"
    fake_session.toolbox.modeler_changed.emit()
    QApplication.processEvents()
    assert [b.accessibleName() for b in buttons(rail)] == ["Spine"]
    assert button(rail, "Spine").isChecked()


def test_the_tenth_tool_has_a_key_and_the_eleventh_none(shown, fake_session):
    fake_session.toolbox.tools = tuple(
        fakes.ToolInfo(f"t{k}", f"T{k}", None, "") for k in range(11)
    )
    rail = shown(ToolRail(fake_session))
    assert "(0)" in button(rail, "T9").toolTip()
    assert button(rail, "T10").toolTip() == "T10"


def test_waiting_ink_can_be_finished_or_dropped(shown, fake_session):
    rail = shown(ToolRail(fake_session))
    assert not part(rail, "waiting").isVisible()
    fake_session.drawing.pending = (object(), object())
    fake_session.drawing.marked_ink = (SimpleNamespace(reason="It crosses itself."),)
    fake_session.drawing.waiting_changed.emit()
    assert part(rail, "waiting").isVisible()
    assert part(rail, "waiting-count").text() == "2"
    assert part(rail, "waiting-count").toolTip().endswith("It crosses itself.")
    part(rail, "waiting-finish").click()
    part(rail, "waiting-drop").click()
    assert len(fake_session.calls.named("gestures.commit")) == 1
    assert len(fake_session.calls.named("gestures.clear")) == 1
    fake_session.drawing.pending = ()
    fake_session.drawing.waiting_changed.emit()
    assert not part(rail, "waiting").isVisible()


def test_waiting_ink_does_not_make_a_low_window_higher(shown, fake_session):
    fake_session.toolbox.tools = tuple(
        fakes.ToolInfo(f"t{k}", f"T{k}", None, "") for k in range(11)
    )
    rail = shown(ToolRail(fake_session))
    rail.resize(rail.width(), 500)
    fake_session.drawing.pending = (object(),)
    fake_session.drawing.waiting_changed.emit()
    assert rail.minimumSizeHint().height() <= 500
    assert rail.height() == 500
    buttons = [b for b in rail.findChildren(IconButton) if b.parent() is rail and b.isVisible()]
    places = [b.geometry() for b in buttons]
    assert len(places) == 11
    assert not any(a.intersects(b) for a, b in itertools.pairwise(places))


def test_tools_have_their_full_size_where_there_is_room(shown, fake_session):
    fake_session.toolbox.tools = tuple(
        fakes.ToolInfo(f"t{k}", f"T{k}", None, "") for k in range(11)
    )
    rail = shown(ToolRail(fake_session))
    rail.resize(rail.width(), 900)
    assert {(b.width(), b.height()) for b in rail.findChildren(IconButton) if b.isVisible()} == {
        (44, 44)
    }


def grouped_tools():
    groups = ("", "Edges", "", "Edges", "Edges")
    return tuple(
        fakes.ToolInfo(f"t{k}", f"T{k}", None, f"Hint {k}.", group=group)
        for k, group in enumerate(groups)
    )


@pytest.fixture
def grouped(shown, fake_session):
    """A rail of three buttons, the second one for three tools."""
    fake_session.toolbox.tools = grouped_tools()
    fake_session.toolbox.tool = "t0"
    return shown(ToolRail(fake_session))


def taken(session):
    return [args[0] for args, _ in session.calls.named("toolbox.take_tool")]


def flyout(rail):
    menu = rail.findChild(QMenu, "tool-group")
    return None if menu is None or not menu.isVisible() else menu


def test_a_group_is_one_button_that_shows_the_last_used_tool(grouped, fake_session):
    assert [b.accessibleName() for b in buttons(grouped)] == ["T0", "T1", "T2"]
    assert button(grouped, "T1").toolTip() == "T1  (2)\nEdges: T1, T3, T4"
    fake_session.toolbox.last_used["Edges"] = "t3"
    fake_session.toolbox.tool_changed.emit()
    assert [b.accessibleName() for b in buttons(grouped)] == ["T0", "T3", "T2"]
    assert chosen(grouped) == ["T0"]
    button(grouped, "T3").click()
    assert taken(fake_session) == ["t3"]


def test_a_group_in_the_hand_opens_when_it_is_pressed_again(grouped, fake_session):
    fake_session.toolbox.tool = "t4"
    fake_session.toolbox.tool_changed.emit()
    assert chosen(grouped) == ["T4"]
    button(grouped, "T4").click()
    menu = flyout(grouped)
    assert [each.text() for each in menu.actions()] == ["T1", "T3", "T4"]
    assert menu.activeAction().text() == "T4"
    QTest.keyClick(menu, Qt.Key.Key_Up)
    QTest.keyClick(menu, Qt.Key.Key_Return)
    assert taken(fake_session) == ["t3"]


@pytest.mark.parametrize("way", ["right key", "right button", "hold"])
def test_other_ways_to_open_a_group_take_no_tool(qtbot, grouped, fake_session, way):
    one = button(grouped, "T1")
    if way == "right key":
        QTest.keyClick(one, Qt.Key.Key_Right)
    elif way == "right button":
        middle = one.rect().center()
        reason = QContextMenuEvent.Reason.Mouse
        event = QContextMenuEvent(reason, middle, one.mapToGlobal(middle))
        QApplication.sendEvent(one, event)
    else:
        QTest.mousePress(one, Qt.MouseButton.LeftButton)
        qtbot.waitUntil(lambda: flyout(grouped) is not None)
        QTest.mouseRelease(one, Qt.MouseButton.LeftButton)
    assert flyout(grouped) is not None
    assert taken(fake_session) == []
    flyout(grouped).close()


def test_a_button_of_one_tool_does_not_open(grouped):
    QTest.keyClick(button(grouped, "T0"), Qt.Key.Key_Right)
    assert flyout(grouped) is None


def test_the_next_tool_comes_to_the_front_of_its_group(grouped, fake_session):
    fake_session.hints.step = NextStep("Touch an edge.", tool="t4")
    fake_session.hints.changed.emit()
    front = button(grouped, "T4")
    assert front.is_next
    assert front.accessibleDescription() == "Touch an edge."


def test_eighteen_tools_in_eight_groups_keep_their_size_in_a_low_window(shown, fake_session):
    fake_session.toolbox.tools = tuple(
        fakes.ToolInfo(f"t{k}", f"T{k}", None, "", group=f"G{k // 2}") for k in range(16)
    )
    rail = shown(ToolRail(fake_session))
    rail.resize(rail.width(), 400)
    assert {b.height() for b in buttons(rail)} == {44}


# -- modelers --


def test_modelers_are_chosen_by_name(shown, fake_session):
    bar = shown(ModelerBar(fake_session))
    button(bar, "Car").click()
    assert fake_session.calls.named("toolbox.take_modeler") == [(("bozzetto.car",), {})]
    fake_session.toolbox.modeler = "bozzetto.car"
    fake_session.toolbox.modeler_changed.emit()
    assert chosen(bar) == ["Car"]


def test_names_give_way_where_there_is_no_room(shown, fake_session):
    bar = shown(ModelerBar(fake_session))
    full = bar.sizeHint().width()
    bar.resize(full, bar.height())
    assert not any(b.compact for b in buttons(bar))
    bar.resize(full // 2, bar.height())
    assert all(b.compact for b in buttons(bar))
    assert bar.sizeHint().width() == full, "it would never grow back"


@pytest.mark.parametrize("times", [1, 2, 3])
def test_many_modelers_leave_the_menus_their_room(shown, fake_session, times):
    """With eight modelers of strangers the menus were folded to two, beside an empty half line."""
    from bozzetto_app.main_window import top_row

    own = fake_session.toolbox.modelers
    fake_session.toolbox.modelers = tuple(
        structs.replace(info, id=f"{info.id}{k}") for k in range(times) for info in own
    )
    menus = QMenuBar()
    for title in ("File", "Edit", "Object", "View", "Go", "Help"):
        menus.addMenu(title)
    bar = ModelerBar(fake_session)
    top = shown(top_row(menus, bar))
    room = menus.sizeHint().width() + 44 * len(buttons(bar)) + 60
    top.resize(max(room, 900), top.sizeHint().height())
    assert menus.width() >= menus.sizeHint().width()
    last = max(buttons(bar), key=lambda one: one.x())
    assert bar.x() + last.geometry().right() <= top.width()
    assert bar.width() - last.geometry().right() <= 8, "they stand on the right"


# -- history --


def test_a_click_goes_to_a_step(shown, fake_session):
    panel = shown(HistoryPanel(fake_session))
    panel.resize(200, 160)
    place = panel.visualItemRect(panel.item(0)).center()
    QTest.mouseClick(panel.viewport(), Qt.MouseButton.LeftButton, pos=place)
    assert fake_session.calls.named("drawing.go_to") == [((0,), {})]


def test_the_current_step_is_said(shown, fake_session):
    panel = shown(HistoryPanel(fake_session))
    said = [panel.item(i).data(Qt.ItemDataRole.AccessibleTextRole) for i in range(panel.count())]
    assert said == ["New drawing", "Outline", "Ear, current", "Inflation"]
    place = panel.visualItemRect(panel.item(2)).center()
    QTest.mouseClick(panel.viewport(), Qt.MouseButton.LeftButton, pos=place)
    assert fake_session.calls.named("drawing.go_to") == []
    assert fake_session.calls.named("notices.tell"), "and that it is shown already"


def test_the_current_step_stays_in_sight_when_the_panel_becomes_lower(shown, fake_session, qtbot):
    steps = tuple(f"Step {number}" for number in range(30))
    fake_session.drawing.history.entries, fake_session.drawing.history.position = steps, 17
    panel = shown(HistoryPanel(fake_session))
    for height in (600, 120, 300, 90):
        panel.resize(240, height)
        qtbot.wait(10)
        place = panel.visualItemRect(panel.item(17))
        assert 0 <= place.top() < place.bottom() <= panel.viewport().height()


def test_history_follows_the_document(shown, fake_session):
    panel = shown(HistoryPanel(fake_session))
    fake_session.drawing.history.entries, fake_session.drawing.history.position = (
        ("New drawing", "Fin"),
        1,
    )
    fake_session.drawing.changed.emit()
    assert [panel.item(i).text() for i in range(panel.count())] == ["New drawing", "Fin"]
    assert panel.currentRow() == 1


@given(
    lives=st.lists(
        st.lists(st.sampled_from("abc"), min_size=1, max_size=6).flatmap(
            lambda labels: st.tuples(st.just(tuple(labels)), st.integers(0, len(labels) - 1))
        ),
        max_size=8,
    )
)
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
def test_history_shows_the_same_however_it_came_about(qtbot, fake_session, lives):
    def told(panel):
        role = Qt.ItemDataRole.AccessibleTextRole
        return [
            (item.text(), item.toolTip(), item.data(role))
            for item in map(panel.item, range(panel.count()))
        ]

    history = fake_session.drawing.history
    panel = HistoryPanel(fake_session)
    qtbot.addWidget(panel)
    for history.entries, history.position in lives:
        panel.refresh()
        fresh = HistoryPanel(fake_session)
        assert told(panel) == told(fresh)
        assert panel.currentRow() == history.position
        fresh.deleteLater()


# -- status line --


@pytest.fixture
def status(shown, fake_session):
    return shown(StatusLine(fake_session))


def test_the_hint_is_always_there(status, fake_session):
    assert part(status, "status-words").text() == "Draw a closed outline."
    fake_session.hints.say("Draw the spine.")
    assert part(status, "status-words").text() == "Draw the spine."


def test_an_error_stays_until_the_next_gesture(status, fake_session):
    fake_session.notices.noticed.emit(fakes.Notice("error", "The outline crosses itself."))
    assert part(status, "status-words").text() == "The outline crosses itself."
    fake_session.hints.say("Draw the spine.")
    assert part(status, "status-words").text() == "The outline crosses itself.", (
        "a hint does not hide an error"
    )
    status.went_on()
    assert part(status, "status-words").text() == fake_session.hints.step.sentence


def test_an_error_has_been_read_once_something_was_done(status, fake_session):
    fake_session.notices.noticed.emit(fakes.Notice("error", "There is no underlay to project."))
    fake_session.drawing.changed.emit()
    assert part(status, "status-words").text() == fake_session.hints.step.sentence


def test_an_error_goes_by_itself(qtbot, monkeypatch, status, fake_session):
    monkeypatch.setattr(status_line, "ERROR_TIME", 20)
    fake_session.notices.noticed.emit(fakes.Notice("error", "No."))
    qtbot.waitUntil(lambda: part(status, "status-words").text() == fake_session.hints.step.sentence)
    assert status_line.INFO_TIME < 8000


def test_work_shows_only_if_it_lasts(qtbot, status, fake_session):
    fake_session.busy_changed.emit(True)
    fake_session.progressed.emit(0.4, "Finding the skeleton")
    assert not part(status, "status-cancel").isVisible()
    qtbot.waitUntil(part(status, "status-cancel").isVisible)
    assert part(status, "status-step").text() == "Finding the skeleton"
    part(status, "status-cancel").click()
    assert len(fake_session.calls.named("cancel_work")) == 1
    fake_session.busy_changed.emit(False)
    assert not part(status, "status-cancel").isVisible()
    assert not part(status, "status-progress").isVisible()


def test_short_work_never_shows(qtbot, status, fake_session):
    fake_session.busy_changed.emit(True)
    fake_session.busy_changed.emit(False)
    qtbot.wait(status_line.PATIENCE + 60)
    assert not part(status, "status-cancel").isVisible()


def fault(**more):
    return fakes.Notice("fault", "Silhouette stopped: no inside.", plugin="b.s", **more)


def test_a_fault_says_who_and_offers_details(qtbot, status, fake_session):
    notice = fault(details="Traceback …")
    fake_session.notices.noticed.emit(notice)
    assert status.faults.isVisible()
    assert "Silhouette stopped" in " ".join(x.text() for x in status.faults.findChildren(QLabel))
    with qtbot.waitSignal(status.details_wanted) as asked:
        button(status.faults, "Details").click()
    assert asked.args == [notice]
    assert part(status, "status-words").text() == fake_session.hints.step.sentence, "the hint stays"


def test_a_fault_can_be_switched_off(qtbot, status, fake_session):
    fake_session.notices.noticed.emit(fault())
    with qtbot.waitSignal(status.switched_off) as off:
        part(status.faults, "fault-switch-off").click()
    assert off.args == ["b.s"]
    assert fake_session.registry.disabled == {"b.s": True}
    assert not status.faults.isVisible()


def test_a_fault_can_be_closed_without_a_change(status, fake_session):
    fake_session.notices.noticed.emit(fault())
    button(status.faults, "Close").click()
    assert not status.faults.isVisible()
    assert fake_session.registry.disabled == {}


def test_a_fault_over_the_sheet_moves_nothing(qtbot, fake_session):
    sheet = QWidget()
    qtbot.addWidget(sheet)
    sheet.resize(400, 300)
    status = StatusLine(fake_session)
    qtbot.addWidget(status)
    status.faults.lie_over(sheet)
    sheet.show()
    status.show()
    before = status.sizeHint()
    status.show_notice(fakes.Notice("fault", "Silhouette stopped while it made the shape. " * 4))
    bar = status.faults.geometry()
    assert status.faults.isVisible()
    assert status.sizeHint() == before
    assert (bar.left(), bar.right(), bar.bottom()) == (0, 399, 299)
    words = status.faults.findChildren(QLabel)[0]
    assert words.height() >= words.heightForWidth(words.width())
    sheet.resize(700, 200)
    assert (status.faults.width(), status.faults.geometry().bottom()) == (700, 199)


def test_buttons_without_use_are_not_shown(status, fake_session):
    fake_session.notices.noticed.emit(fakes.Notice("fault", "Bozzetto made a mistake."))
    assert [b.text() for b in status.faults.findChildren(QPushButton) if b.isVisible()] == []


def test_long_words_do_not_widen_the_window(status, fake_session):
    before = status.minimumSizeHint().width()
    fake_session.notices.noticed.emit(fakes.Notice("error", "Very long. " * 60))
    assert status.minimumSizeHint().width() == before < 400


# -- welcome --


@pytest.fixture
def strip(qtbot, shown, fake_session):
    fake_session.drawing.document = Document()
    recent = [Path("/drawings/Lamp.bozz")]
    pictures = []

    def thumbnail(path):
        pictures.append(path)
        return QImage(4, 4, QImage.Format.Format_RGB32)

    made = shown(WelcomeStrip(fake_session, recent, thumbnail))
    qtbot.waitUntil(lambda: recent[0] in pictures)
    return made


def test_samples_and_recent_files_can_be_chosen(qtbot, strip):
    with qtbot.waitSignal(strip.sample_chosen) as sample:
        button(strip, "Glasses").click()
    assert sample.args == ["bozzetto.symmetry", Path("/samples/glasses.json"), "Glasses"]
    with qtbot.waitSignal(strip.sample_watched) as watched:
        button(strip, "Watch Fish being drawn").click()
    assert watched.args == ["bozzetto.silhouette", Path("/samples/fish.json")]
    with qtbot.waitSignal(strip.recent_chosen) as recent:
        button(strip, "Lamp").click()
    assert recent.args == [Path("/drawings/Lamp.bozz")]


def test_a_double_click_opens_one_sample(qtbot, strip):
    chosen = []
    strip.sample_chosen.connect(lambda *sample: chosen.append(sample))
    card = button(strip, "Glasses")
    qtbot.mouseClick(card, Qt.MouseButton.LeftButton, pos=QPoint(20, 20))
    qtbot.mouseDClick(card, Qt.MouseButton.LeftButton, pos=QPoint(20, 20))
    qtbot.mouseRelease(card, Qt.MouseButton.LeftButton, pos=QPoint(20, 20))
    assert len(chosen) == 1


def test_it_closes_by_drawing(qtbot, strip, fake_session):
    with qtbot.assertNotEmitted(strip.closed):
        fake_session.drawing.changed.emit()
    fake_session.drawing.pending = (object(),)
    with qtbot.waitSignal(strip.closed):
        fake_session.drawing.waiting_changed.emit()


def test_a_card_under_the_pointer_keeps_its_picture(qtbot, shown, fake_session):
    red = QImage(72, 54, QImage.Format.Format_RGB32)
    red.fill(Qt.GlobalColor.red)
    made = shown(WelcomeStrip(fake_session, [Path("/drawings/Lamp.bozz")], lambda path: red))
    card = button(made, "Lamp")
    card.setDown(True)
    wanted = QColor(Qt.GlobalColor.red)
    qtbot.waitUntil(lambda: card.grab().toImage().pixelColor(40, 31) == wanted)


def test_the_strip_takes_no_more_of_the_sheet_than_it_needs(shown, fake_session):
    few = shown(WelcomeStrip(fake_session))
    many = shown(WelcomeStrip(fake_session, [Path(f"/d/{n}.bozz") for n in range(10)]))
    for strip in (few, many):
        strip.lie_on(QSize(900, 600))
    assert few.height() < 600
    assert many.height() == 600
    assert few.verticalScrollBar().maximum() == 0


def test_pictures_of_ink_follow_the_theme(qapp, qtbot, shown, fake_session):
    asked = []
    apply_theme(qapp, LIGHT)
    shown(WelcomeStrip(fake_session, [Path("/d/Lamp.bozz")], asked.append))
    cards = 1 + sum(len(info.samples) for info in fake_session.toolbox.modelers)
    qtbot.waitUntil(lambda: len(asked) == cards)
    before = len(asked)
    apply_theme(qapp, DARK)
    qtbot.waitUntil(lambda: len(asked) == 2 * before)
    apply_theme(qapp, LIGHT)
