"""A plugin's own panel: made for its objects only, and able to change them."""

from __future__ import annotations

import importlib
import sys
from dataclasses import replace
from time import monotonic

import pytest
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QPushButton

from bozzetto.errors import UserError
from bozzetto.plugin.guard.guard import MOST_FAULTS
from bozzetto.plugin.host.registry import Registry
from bozzetto_app.panels import plugin_panel
from bozzetto_app.panels.plugin_panel import PluginPanel
from bozzetto_app.session.session import Session
from bozzetto_app.session.window_faults import watch_window_faults

MANIFEST = """
id = "paneled.plugin"
title = "Paneled"
version = "1.0"
api = ">=2,<3"

[[modeler]]
id = "paneled.modeler"
title = "Paneled"
icon = "icon.svg"
hint = "Draw."
abilities = ["panel"]
"""

CODE = """
from dataclasses import dataclass, replace
from bozzetto.geometry import Shapes
from bozzetto.plugin import Modeler, hookimpl
from bozzetto.scene import Scene

seen = []
made = None

@dataclass(frozen=True)
class State:
    turns: int = 0

class Paneled(Modeler):
    id, state_type = "paneled.modeler", State
    def solve(self, state, job): return ()
    def scene(self, state, result): return Scene()
    def shapes(self, state, result): return Shapes()

@hookimpl
def bozzetto_modelers():
    return [Paneled()]

raised = [KeyError("here")]

def failing(host):
    from PySide6.QtWidgets import QPushButton
    button = QPushButton("Fail")
    def fail():
        raise raised[0]
    button.clicked.connect(fail)
    return button

@hookimpl
def bozzetto_panel(modeler_id, parent, host):
    from PySide6.QtWidgets import QPushButton
    if made is not None:
        return made(host)
    button = QPushButton("Turn", parent)
    def turn():
        host.change(replace(host.state, turns=host.state.turns + 1), "Turn")
    button.clicked.connect(turn)
    host.on_change(lambda: seen.append(host.state.turns if host.state else None))
    return button
"""


@pytest.fixture
def plugin(tmp_path, monkeypatch):
    folder = tmp_path / "packages" / "paneled"
    folder.mkdir(parents=True)
    (folder / "__init__.py").write_text(CODE)
    (folder / "plugin.toml").write_text(MANIFEST)
    (folder / "icon.svg").write_text("<svg/>")
    monkeypatch.syspath_prepend(folder.parent)
    importlib.invalidate_caches()
    yield importlib.import_module("paneled")
    del sys.modules["paneled"]


@pytest.fixture
def session(qtbot, plugin):
    made = Session(Registry(extra=["paneled"]))
    yield made
    made.cancel_all()
    qtbot.waitUntil(lambda: not made.solver.busy)


@pytest.fixture
def panel(qtbot, session):
    session.shown = made = PluginPanel(session)
    qtbot.addWidget(made)
    return made


def draw(session, modeler="paneled.modeler"):
    """A new object, selected."""
    model = session.workbench.create(modeler, session.gestures.context.now())
    session.drawing.commit("new", session.drawing.document.with_model(model))
    choose(session, model.id)
    return model.id


def choose(session, model_id):
    """Select an object, and leave the panel time for its widget."""
    session.selection.select(model_id)
    end = monotonic() + 10.0
    while not session.shown.is_ready and monotonic() < end:
        QTest.qWait(1)


def test_only_its_own_objects_have_it(session, panel):
    titles = []
    panel.changed.connect(titles.append)
    assert not panel.is_filled
    own = draw(session)
    assert panel.findChild(QPushButton) is not None
    draw(session, "bozzetto.mesh")
    assert not panel.is_filled
    choose(session, own)
    session.selection.select(None)
    assert not panel.is_filled
    assert titles == ["Paneled", "", "Paneled", ""]


def test_it_changes_the_selected_object_in_one_step(session, panel, plugin):
    draw(session)
    before = session.drawing.history.position
    panel.findChild(QPushButton).click()
    assert session.selection.model.state.turns == 1
    assert session.drawing.history.position == before + 1
    session.drawing.undo()
    assert session.selection.model.state.turns == 0
    assert plugin.seen == [0, 1, 0]


def test_what_is_next_is_told_by_its_own_modeler(session, panel, plugin, monkeypatch):
    hosts = []
    monkeypatch.setattr(plugin, "made", lambda host: hosts.append(host) or QPushButton("Turn"))
    session.toolbox.take_modeler("paneled.modeler")
    draw(session)
    (host,) = hosts
    assert host.next_step == session.hints.step
    session.toolbox.take_modeler("bozzetto.silhouette")
    assert host.next_step.sentence == "Take Paneled at the top right to go on."


def test_it_is_told_of_another_object_of_its_kind(session, panel, plugin):
    draw(session)
    button = panel.findChild(QPushButton)
    button.click()
    draw(session)
    assert panel.findChild(QPushButton) is button
    assert plugin.seen[-1] == 0
    button.click()
    assert [model.state.turns for model in session.drawing.document] == [1, 1]


def test_what_a_panel_complains_of_is_told_where_every_refusal_is(session, panel, plugin):
    heard = []
    session.notices.noticed.connect(heard.append)

    def made(host):
        button = QPushButton("Refuse")
        button.clicked.connect(lambda: host.complain(UserError("Draw a limb first.")))
        return button

    plugin.made = made
    draw(session)
    panel.findChild(QPushButton).click()
    assert [(each.kind, each.text) for each in heard[-1:]] == [("error", "Draw a limb first.")]


def test_a_locked_object_stays_as_it_is(session, panel):
    model_id = draw(session)
    session.objects.set_locked(model_id, True)
    notices = []
    session.notices.noticed.connect(notices.append)
    panel.findChild(QPushButton).click()
    assert session.selection.model.state.turns == 0
    assert "locked" in notices[-1].text


WRONG = {
    "no widget": lambda host: 5,
    "raises": lambda host: {}["here"],
    "none": lambda host: None,
}


@pytest.mark.parametrize("name", WRONG)
def test_a_panel_that_fails_leaves_the_window_alone(session, panel, plugin, name):
    notices = []
    session.notices.noticed.connect(notices.append)
    plugin.made = WRONG[name]
    draw(session)
    assert not panel.is_filled
    faults = [notice for notice in notices if notice.plugin]
    assert len(faults) == (name != "none")


def test_what_it_does_wrong_is_told_and_changes_nothing(session, panel, plugin):
    hosts, notices = [], []
    session.notices.noticed.connect(notices.append)

    def made(host):
        hosts.append(host)
        host.on_change(lambda: {}["here"])
        return QPushButton()

    plugin.made = made
    draw(session)
    assert any("KeyError" in notice.text + notice.details for notice in notices)
    state = session.selection.model.state
    for wrong in (None, replace(state, turns=0.5)):
        told = len(notices)
        hosts[0].change(wrong, "Wrong")
        assert len(notices) > told
        assert session.selection.model.state is state


def test_what_a_panel_gives_wrongly_is_its_own_fault(session, panel, plugin):
    hosts, notices = [], []
    session.notices.noticed.connect(notices.append)
    plugin.made = lambda host: hosts.append(host) or QPushButton()
    draw(session)
    for method, wrong in (("complain", "text"), ("run", 5)):
        getattr(hosts[0], method)(wrong)
        assert notices[-1].plugin == "paneled.plugin"
        assert f"gave {method} {type(wrong).__name__} where" in notices[-1].text
        assert __file__ in notices[-1].details


@pytest.fixture
def watched(session):
    end = watch_window_faults(session)
    yield session
    end()


@pytest.mark.qt_no_exception_capture
def test_what_a_slot_of_a_panel_raises_reaches_the_person(watched, panel, plugin, capsys):
    notices = []
    watched.notices.noticed.connect(notices.append)

    plugin.made = plugin.failing
    draw(watched)
    for _ in range(9):
        panel.findChild(QPushButton).click()
    faults = [each for each in notices if each.kind == "fault"]
    assert len(faults) == MOST_FAULTS, "then it is switched off"
    notice = faults[0]
    assert notice.plugin == "paneled.plugin"
    assert "its panel failed (KeyError: 'here')" in notice.text
    assert "KeyError" in notice.details
    assert "KeyError" in capsys.readouterr().err, "printed as before"


@pytest.mark.qt_no_exception_capture
def test_what_the_program_raises_is_no_fault_of_a_plugin(watched, panel, plugin, monkeypatch):
    notices = []
    watched.notices.noticed.connect(notices.append)
    monkeypatch.setattr(watched.registry.guard, "blame", lambda *_: pytest.fail("wrong blame"))

    draw(watched)
    monkeypatch.setattr(plugin_panel, "with_state", None)  # the shell's own code then fails
    for _ in range(9):
        panel.findChild(QPushButton).click()
    assert [each.plugin for each in notices if each.kind == "fault"] == [""]
    assert "Bozzetto made a mistake" in notices[-1].text


@pytest.mark.qt_no_exception_capture
def test_a_refusal_in_a_slot_is_told_as_every_refusal(watched, panel, plugin):
    notices = []
    watched.notices.noticed.connect(notices.append)
    plugin.made, plugin.raised = plugin.failing, [UserError("Later.")]
    draw(watched)
    for _ in range(2):
        panel.findChild(QPushButton).click()
    assert [(each.kind, each.text) for each in notices[-2:]] == [("error", "Later.")] * 2
