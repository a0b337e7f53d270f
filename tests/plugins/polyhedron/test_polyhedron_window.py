"""The real window: drawing, turning at a touch, and the line that says what is next."""

from __future__ import annotations

import numpy as np

from bozzetto.testing import Pen
from tests.plugins.polyhedron.drawn_bodies import VIEW, fitted, strokes_of
from tests.plugins.polyhedron.objects import OBJECTS


def test_a_box_is_drawn_turned_and_moved(window):
    solid = OBJECTS["box"]
    vertices = fitted(solid)
    strokes = strokes_of(vertices, solid.edges, jitter=1.5, seed=9200)
    window.open("polyhedron")
    assert window.hint.startswith("Draw all edges")
    window.draw(*strokes[:-1])
    assert "lines" in {layer.name for layer in window.shown().layers}
    assert "two lines" in window.hint
    window.draw(strokes[-1])
    assert "Touch a corner" in window.hint
    places = VIEW.project(vertices)[0]
    window.take("turn")
    window.tap(*(places[0] + 4.0))
    assert window.state.nodes[0].choice is not None
    assert "solid" in {layer.name for layer in window.shown().layers}
    before = window.state.nodes[0].answer
    window.press("X")
    assert window.state.nodes[0].answer != before
    window.press("Ctrl+Z")
    assert window.state.nodes[0].answer == before
    window.take("move")
    window.tap(*places[0])
    assert len(window.state.nodes[0].anchors) == 1
    path = Pen(VIEW).along([places[6], places[6] + np.array([80.0, 30.0])])
    window.draw(path)
    assert window.state.moved is not None
    window.undo()
    assert window.state.moved is None
