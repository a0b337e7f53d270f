"""Parameters that say how a tool works are in the form while that tool is in the hand."""

from __future__ import annotations

from time import monotonic

import numpy as np
import pytest
from PySide6.QtTest import QTest

from bozzetto.parameters import Parameter
from bozzetto_app.panels.properties.form import ParametersPanel
from tests.app.tablet import stroke_of

BRUSH = {"brush_size", "brush_opacity", "brush_softness"}


def names_in(panel: ParametersPanel) -> set[str]:
    """The model's parameters in the form once it is whole."""
    end = monotonic() + 10.0
    while not panel.is_ready and monotonic() < end:
        QTest.qWait(1)
    return {name for owner, name in panel.form.rows if not owner}


@pytest.fixture
def panel(qtbot, make_session, settle):
    session = make_session("bozzetto.silhouette")
    settle(session)
    angles = np.linspace(0.0, 2.0 * np.pi, 60)
    circle = np.column_stack((400.0 + 90.0 * np.cos(angles), 300.0 + 90.0 * np.sin(angles)))
    session.gestures.stroke_lifted(stroke_of(circle, session.view.camera))
    settle(session)
    made = ParametersPanel(session)
    qtbot.addWidget(made)
    made.show()
    return made, session


def test_the_size_of_a_brush_is_shown_with_the_brush(panel):
    made, session = panel
    without = names_in(made)
    assert without
    assert not without & BRUSH
    session.toolbox.take_tool("brush")
    assert names_in(made) == without | BRUSH | {"paint"}
    session.toolbox.take_tool("paint")
    assert names_in(made) == without | {"paint"}
    session.toolbox.take_tool("draw")
    assert names_in(made) == without


def test_with_another_modeler_in_the_hand_it_is_not_shown(panel, settle):
    made, session = panel
    session.toolbox.take_tool("brush")
    session.toolbox.take_modeler("bozzetto.product")
    settle(session)
    assert not names_in(made) & BRUSH


def test_who_asks_for_it_by_name_gets_the_tool(panel):
    made, session = panel
    made.activateWindow()
    made.focus_parameter("brush_size")
    assert session.toolbox.tool == "brush"
    assert BRUSH <= names_in(made)
    assert made.form.rows["", "brush_size"].isAncestorOf(made.focusWidget())


def test_a_value_set_meanwhile_is_shown_later(panel, settle):
    made, session = panel
    session.objects.set_parameter("brush_size", 77.0)
    session.toolbox.take_tool("brush")
    assert names_in(made) >= BRUSH
    assert made.form.values["", "brush_size"] == 77.0


@pytest.mark.parametrize("tools", ["brush", ["brush"], (1,)])
def test_the_tools_of_a_parameter_are_ids(tools):
    with pytest.raises(TypeError, match="must be a tuple of ids"):
        Parameter("Size", tools=tools)
