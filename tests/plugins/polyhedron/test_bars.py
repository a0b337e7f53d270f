"""Lines that end alone move as bars at the first touch of a tool that moves or joins them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.ink import Stroke, Strokes
from bozzetto.plugin import Context, Drag, Ink, Job
from bozzetto_polyhedron.model.fittings import Slider
from bozzetto_polyhedron.model.state import Body, PolyhedronState
from bozzetto_polyhedron.modeler import PolyhedronModeler
from bozzetto_polyhedron.report import OF_BARS
from bozzetto_polyhedron.tools.fittings import DrawLink, DrawSlider
from bozzetto_polyhedron.tools.move import Move
from tests.plugins.polyhedron.drawn_bodies import VIEW, fitted, strokes_of
from tests.plugins.polyhedron.linkages import (
    FOUR_BAR,
    FOUR_BAR_LINES,
    SHEET,
    linkage,
    straight,
    tapped,
)
from tests.plugins.polyhedron.objects import OBJECTS


def lines() -> PolyhedronState:
    """A four-bar as it was drawn: nobody said that it moves."""
    state = linkage(FOUR_BAR, FOUR_BAR_LINES)
    return state.with_node(replace(state.nodes[0], moves="whole"))


def box() -> PolyhedronState:
    solid = OBJECTS["box"]
    body = Body(id="b", name="Box", strokes=Strokes(strokes_of(fitted(solid), solid.edges)))
    return PolyhedronState(nodes=(body,))


def test_a_touch_holds_a_corner_of_bars():
    made = Move().tap(lines(), tapped(FOUR_BAR["a"]), Context())
    assert made.nodes[0].moves == "flat"
    assert len(made.nodes[0].anchors) == 1
    assert made == Move().tap(linkage(FOUR_BAR, FOUR_BAR_LINES), tapped(FOUR_BAR["a"]), Context())


def test_a_drag_pulls_bars():
    path = np.array(FOUR_BAR["b"]) + np.linspace(0.0, 1.0, 20)[:, None] * (10.0, -30.0)
    drag = Drag("", Stroke(*path.T, SHEET))
    made = Move().step(lines(), drag, 1 / 60, Context())
    assert made.nodes[0].moves == "flat"
    assert made.moved is not None
    same = Move().step(linkage(FOUR_BAR, FOUR_BAR_LINES), drag, 1 / 60, Context())
    assert np.array_equal(made.moved.places, same.moved.places)


def test_a_stroke_joins_bars():
    stroke = straight(FOUR_BAR["c"], (860, 420))
    made = DrawSlider().draw(lines(), Ink((stroke,)), Context())
    assert made.nodes[0].moves == "flat"
    assert made.of_kind(Slider)[0].turning == "free"


def test_the_lines_of_a_solid_are_asked_to_be_turned():
    x, y = VIEW.project(fitted(OBJECTS["box"]))[0][0]
    with pytest.raises(UserError, match="Touch a corner of a drawing to turn it"):
        Move().tap(box(), replace(tapped((x, y)), camera=VIEW), Context())
    with pytest.raises(UserError, match="There is nothing to join yet"):
        DrawLink().draw(box(), Ink((straight((x, y), (x + 90, y), VIEW),)), Context())
    assert Move().next_step(box()).tool == "turn"


def test_nothing_becomes_bars_where_nothing_is_touched():
    with pytest.raises(UserError, match="There is nothing to move yet"):
        Move().tap(lines(), tapped((100, 100)), Context())


def test_what_is_next_says_that_lines_move_as_bars():
    said = Move().next_step(lines())
    assert "as bars" in said.sentence
    assert said.tool != "turn"


def test_the_report_of_bars_asks_for_no_lines():
    modeler = PolyhedronModeler()
    for state, some in ((lines(), True), (linkage(FOUR_BAR, FOUR_BAR_LINES), False)):
        report = modeler.report(state, modeler.solve(state, Job()), Job())
        assert bool([each for each in report["health"] if each["what"] in OF_BARS]) is some
