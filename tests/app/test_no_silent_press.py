"""Whatever is pressed, something changes that can be seen, or the program says why nothing did.

Every action of the menus, every key, every button, every entry of the radial menu, and every tool
on nothing and on an object: in every state that the sheet can be in.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import pytest
from PySide6.QtCore import QMimeData, QPoint, QPointF, Qt
from PySide6.QtGui import QClipboard, QDropEvent, QKeySequence
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QAbstractButton, QApplication, QFileDialog

from bozzetto_app.panels.history import HistoryPanel
from tests.app import seen
from tests.app.tablet import Stylus, circle
from tests.sizes import FULL

SAMPLES = {
    "bozzetto.silhouette": 2,
    "bozzetto.symmetry": 0,
    "bozzetto.car": 0,
    "bozzetto.product": 0,
    "bozzetto.polyhedron": 0,
}
MODELERS = tuple(SAMPLES)

STATES = ("empty", "object", "hidden", "locked", "nothing selected", "waiting ink")
PRESSED = (
    [(modeler, state) for modeler in MODELERS for state in STATES]
    if FULL
    else [(MODELERS[(place - 1) % len(MODELERS)], state) for place, state in enumerate(STATES)]
)
"""A press of everything takes a minute in each: every state once, the modelers in turn."""

LEFT_ALONE = ("file.quit",)
"""Ends the test, too."""

WATCHED = "help.watch."
"""Recordings of which one of each modeler is watched: the others do the same, for seconds each."""

SHEET = 8
"""How many of the things that are watched are the sheet's: the others are views and dialogs."""

NOTHING = (60.0, 500.0)
"""Where nothing is drawn."""


class Watch:
    """What a person can notice of a window, before and after a press."""

    def __init__(self, window, asked):
        self.window, self.session, self.asked = window, window.session, asked
        self.before = self.seen()
        self.count = len(self.session.heard)

    def seen(self):
        session, window = self.session, self.window
        return (
            session.drawing.document.models,
            session.drawing.document.underlays,
            session.drawing.document.views,
            session.drawing.history.position,
            session.selection.id,
            tuple(model.state for model in session.drawing.document.models),
            [id(stroke) for stroke in session.drawing.pending],
            (session.toolbox.modeler, session.toolbox.tool),
            session.view.camera,
            (session.view.shading, session.view.show_grid, session.view.show_ghost_ink),
            (window.panels_shown, window.is_dark, window.welcome.isVisible()),
            window.canvas.menu.isVisible(),
            window.replays.current is not None,
            {id(w) for w in QApplication.topLevelWidgets() if w.isVisible()},
            len(self.asked),
        )

    @property
    def said(self):
        """What was said since, in words of which there are some."""
        return [notice.text for notice in self.session.heard[self.count :] if notice.text.strip()]

    @property
    def is_as_before(self):
        """Whether the sheet is in the state in which it was: only views and dialogs differ."""
        pairs = zip(self.before[:SHEET], self.seen()[:SHEET], strict=True)
        return all(_same(one, two) for one, two in pairs)

    @property
    def is_silent(self):
        pairs = zip(self.before, self.seen(), strict=True)
        return not self.said and all(_same(one, two) for one, two in pairs)


def _same(one, two):
    """Whether two sights are the same; models are compared by identity, not by value."""
    if isinstance(one, tuple) and isinstance(two, tuple) and one and not _is_plain(one[0]):
        return len(one) == len(two) and all(a is b for a, b in zip(one, two, strict=True))
    return one is two or bool(one == two)


def _is_plain(value):
    return isinstance(value, str | bool | int | float | None)


@pytest.fixture
def asked(monkeypatch):
    """The files that were asked for; every question is answered with Cancel."""
    asked = []

    def cancel(*args, **more):
        asked.append(args)
        return "", ""

    monkeypatch.setattr(QFileDialog, "getOpenFileName", cancel)
    monkeypatch.setattr(QFileDialog, "getOpenFileNames", cancel)
    monkeypatch.setattr(QFileDialog, "getSaveFileName", cancel)
    return asked


def close_dialogs(window):
    window.replays.stop()
    window.canvas.menu.close_menu()
    for widget in QApplication.topLevelWidgets():
        if widget is not window and widget.isVisible() and widget.objectName() != "window":
            widget.close()
    QApplication.processEvents()


@pytest.fixture
def put(make_window, settle, asked):
    """A function that makes a window for a modeler, and one that brings a state back."""

    def make(modeler):
        window = make_window(modeler)
        session = window.session
        (info,) = [one for one in session.toolbox.modelers if one.id == modeler]
        session.files.exchange.import_file(info.samples[SAMPLES[modeler]])
        settle(session, window.keeper)
        drawn = session.drawing.document
        if modeler == "bozzetto.silhouette":
            # What is pressed is the same on a coarse solid, which is there again at once.
            coarse = [replace(model, state=replace(model.state, resolution=32)) for model in drawn]
            drawn = replace(drawn, models=tuple(coarse))

        def restore(state):
            close_dialogs(window)
            document = drawn
            if state == "empty" or state == "waiting ink":
                document = replace(drawn, models=())
            if state in ("hidden", "locked"):
                change = {"visible": False} if state == "hidden" else {"locked": True}
                document = replace(drawn, models=tuple(replace(m, **change) for m in drawn))
            session.drawing.show(document, None)
            session.toolbox.take_modeler(modeler)
            settle(session, window.keeper)
            if state == "nothing selected":
                session.selection.select(None)
            if state == "waiting ink":
                Stylus(window.canvas).draw([(300.0, 300.0), (420.0, 330.0), (520.0, 300.0)])
            window.canvas.views.fit()
            settle(session, window.keeper)
            session.drawing.history.mark_saved(session.drawing.document)

        return window, restore

    return make


def silent_actions(window, restore, settle, asked, state):
    restore(state)
    session = window.session
    names = [action.id for action in window.actions_.actions()]
    recordings = {name.rpartition(".")[0]: name for name in names if name.startswith(WATCHED)}
    alike = {name for name in names if name.startswith(WATCHED)} - set(recordings.values())
    for name in [name for name in names if name not in LEFT_ALONE and name not in alike]:
        if name not in {a.id for a in window.actions_.actions()}:
            continue
        watch = Watch(window, asked)
        window.actions_.run(name)
        settle(session, window.keeper)
        if watch.is_silent:
            yield name
        close_dialogs(window)
        if not watch.is_as_before:
            restore(state)


@pytest.mark.slow
@pytest.mark.parametrize(("modeler", "state"), PRESSED)
def test_no_action_is_silent(put, settle, asked, modeler, state):
    window, restore = put(modeler)
    assert list(silent_actions(window, restore, settle, asked, state)) == []


@pytest.mark.slow
@pytest.mark.parametrize(("modeler", "state"), PRESSED)
def test_no_tool_is_silent_on_nothing_or_on_an_object(put, settle, asked, modeler, state):
    window, restore = put(modeler)
    restore(state)
    session, canvas = window.session, window.canvas
    middle = (canvas.width() / 2, canvas.height() / 2)
    silent = []
    for tool in [tool.id for tool in session.toolbox.tools]:
        restore(state)
        session.toolbox.take_tool(tool)
        settle(session)
        for place, eraser, way in product((NOTHING, middle), (False, True), ("tap", "drag")):
            # Twice: the second press finds what the first one left.
            for time in (1, 2):
                watch = Watch(window, asked)
                stylus, end = Stylus(canvas, eraser=eraser), (place[0] + 50.0, place[1] - 20.0)
                if way == "drag":
                    stylus.draw([place, (place[0] + 20.0, place[1] - 10.0), end])
                else:
                    stylus.press(place)
                    stylus.lift(place)
                settle(session)
                if watch.is_silent:
                    silent.append((tool, place, eraser, way, time))
    assert silent == []


@pytest.mark.parametrize("state", ["empty", "locked"])
def test_no_key_and_no_entry_of_the_radial_menu_is_silent(put, settle, asked, state):
    window, restore = put("bozzetto.silhouette")
    restore(state)
    session = window.session
    silent = []
    for action in window.actions_.actions():
        enabled = action.enabled()
        if enabled or not action.keys:
            continue  # those that can be done are pressed above
        window.activateWindow()
        window.canvas.setFocus()
        watch = Watch(window, asked)
        keys = QKeySequence(action.keys[0])[0]
        QTest.keyClick(window.canvas, keys.key(), keys.keyboardModifiers())
        settle(session)
        if watch.is_silent:
            silent.append(action.id)
    for index, entry in enumerate(window.canvas.menu_entries()):
        window.canvas.open_menu(QPointF(400.0, 300.0))
        QApplication.processEvents()
        watch = Watch(window, asked)
        watch.before = (*watch.before[:11], False, *watch.before[12:])
        QTest.keyClick(window.canvas.menu, Qt.Key(Qt.Key.Key_1 + index))
        settle(session, window.keeper)
        opened = window.canvas.menu.isVisible()
        window.canvas.menu.close_menu()
        if watch.is_silent:
            silent.append((entry.title, opened))
    assert silent == []


def test_whatever_cannot_be_done_says_why_and_what_to_do_first(put, settle, asked):
    window, restore = put("bozzetto.silhouette")
    for state in STATES:
        restore(state)
        window.actions_.refresh()
        for action in window.actions_.actions():
            made = window.actions_.qaction(action.id)
            if not made.isEnabled():
                assert action.why_not().endswith("."), action.id
                assert made.toolTip() == made.statusTip() == action.why_not()


def buttons(window):
    """The buttons around the sheet that can be seen."""
    for each in window.findChildren(QAbstractButton):
        if each.isVisible() and each.window() is window:
            yield each


@pytest.mark.parametrize("state", ["empty", pytest.param("object", marks=pytest.mark.slow)])
def test_no_button_around_the_sheet_is_silent(put, settle, asked, state):
    window, restore = put("bozzetto.silhouette")
    restore(state)
    session = window.session

    def name(button):
        return button.accessibleName() or button.text() or button.objectName()

    silent = []
    for number in range(len(list(buttons(window)))):
        restore(state)
        now = list(buttons(window))
        if number >= len(now):
            break
        button = now[number]
        if not button.isEnabled():
            words = button.toolTip()
            assert words != name(button), "says why it cannot be pressed"
            continue
        owners = [button.parentWidget()]
        while owners[-1] is not None:
            owners.append(owners[-1].parentWidget())
        if any(w is not None and w.objectName() == "parameters" for w in owners):
            continue  # fields: what they do is shown by themselves
        before = window.grab().toImage()
        watch = Watch(window, asked)
        said = name(button)
        QTest.mouseClick(button, Qt.MouseButton.LeftButton, pos=button.rect().center())
        settle(session, window.keeper)
        if watch.is_silent and window.grab().toImage() == before:
            silent.append(said)
    assert silent == []


def test_a_step_a_modeler_or_a_view_that_is_there_already_says_so(put, settle, asked):
    window, restore = put("bozzetto.silhouette")
    restore("object")
    session = window.session
    history = window.findChild(HistoryPanel)
    for press in (
        lambda: history.itemClicked.emit(history.item(session.drawing.history.position)),
        lambda: seen.button(window.modelers, seen.chosen(window.modelers)[0]).click(),
        lambda: window.canvas.views.fit(),
        lambda: window.actions_.run("view.shading.clay"),
    ):
        watch = Watch(window, asked)
        press()
        settle(session)
        assert watch.said


def test_a_drop_or_paste_of_nothing_says_so(put, settle, asked, monkeypatch):
    window, restore = put("bozzetto.silhouette")
    restore("empty")
    data = QMimeData()
    data.setText("words")
    copy, left = Qt.DropAction.CopyAction, Qt.MouseButton.LeftButton
    watch = Watch(window, asked)
    none = Qt.KeyboardModifier.NoModifier
    window.canvas.dropEvent(QDropEvent(QPointF(200.0, 200.0), copy, data, left, none))
    assert watch.said
    for none in (None, QMimeData()):
        monkeypatch.setattr(QClipboard, "mimeData", lambda clipboard, mode=None, none=none: none)
        watch = Watch(window, asked)
        window.actions_.run("edit.paste")
        assert watch.said


def test_short_presses_say_what_is_wanted(put, settle, asked):
    window, restore = put("bozzetto.silhouette")
    restore("empty")
    canvas, session = window.canvas, window.session
    watch = Watch(window, asked)
    QTest.mouseClick(canvas, Qt.MouseButton.MiddleButton, pos=QPoint(300, 300))
    assert "turn the view" in watch.said[-1]
    watch = Watch(window, asked)
    Stylus(canvas).draw([(300.0, 300.0), (301.0, 300.0)])
    settle(session)
    assert "too short" in watch.said[-1]
    session.toolbox.take_tool("mirror")
    settle(session)
    watch = Watch(window, asked)
    Stylus(canvas).draw(circle())
    settle(session)
    assert "tap" in watch.said[-1]
