"""A double click counts as one touch: what the first touch switched on, the second would undo."""

from __future__ import annotations

from dataclasses import replace

import pytest
from PySide6.QtGui import QGuiApplication

from bozzetto.plugin import Tool
from bozzetto_app.testing.stylus import Stylus
from tests.app.tablet import Mouse, circle

X, Y = 640.0, 360.0


class Switches(Tool):
    """Every touch hides the first part, or shows it."""

    id, title, icon, hint, gesture = "switch", "Switch", "", "Touch.", "tap"

    def tap(self, state, tap, context):
        first, *others = state.nodes
        return replace(state, nodes=(replace(first, visible=not first.visible), *others))


class Chooses(Switches):
    """Every touch chooses another part."""

    def tap(self, state, tap, context):
        ids = [node.id for node in state.nodes]
        return replace(state, selected=ids[(ids.index(state.selected) + 1) % len(ids)])


@pytest.fixture
def window(make_window, settle):
    window = make_window()
    for x in (400.0, 640.0, 880.0):
        Mouse(window.canvas).draw(circle(x, radius=60.0))  # beside a pen it would not count
        settle(window.session, window.keeper)
    window.session.toolbox.take_tool("mirror")
    return window


def touches(window, settle, monkeypatch, hand, tool, *begins):
    """Touch at times (s) and places (px); return how many steps came of it."""
    session = window.session
    monkeypatch.setattr(session.workbench, "tool", lambda modeler, name: tool)
    before, first = session.drawing.history.position, hand.stamp
    for seconds, away in begins:
        hand.stamp = first + int(1000 * seconds)
        hand.draw([(X + away, Y)] * 2)
    settle(session, window.keeper)
    return session.drawing.history.position - before


@pytest.mark.parametrize("device", [Stylus, Mouse])
def test_a_double_click_is_one_touch(window, settle, monkeypatch, device):
    assert QGuiApplication.styleHints().mouseDoubleClickInterval() in range(200, 1000)
    hand = device(window.canvas)
    for begins, steps in (
        ([(0.0, 0.0), (0.15, 2.0)], 1),
        ([(0.0, 0.0), (0.15, 2.0), (0.3, 0.0)], 2),
        ([(0.0, 0.0), (0.15, 30.0)], 2),
        ([(0.0, 0.0), (1.0, 0.0)], 2),
    ):
        hand.stamp += 10_000
        assert touches(window, settle, monkeypatch, hand, Switches(), *begins) == steps, begins


def test_a_double_click_goes_on_choosing(window, settle, monkeypatch):
    """As with a group: its first touch chooses the group, the next one what is in it."""
    (model,) = window.session.drawing.document
    ids = [node.id for node in model.state.nodes]
    assert model.state.selected == ids[-1]
    hand = Stylus(window.canvas)
    assert touches(window, settle, monkeypatch, hand, Chooses(), (0.0, 0.0), (0.15, 0.0)) == 0
    (model,) = window.session.drawing.document
    assert model.state.selected == ids[1]
