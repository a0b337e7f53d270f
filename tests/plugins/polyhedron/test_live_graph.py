"""The graph while it is drawn."""

from __future__ import annotations

from bozzetto_polyhedron.graph.build import graph_of
from bozzetto_polyhedron.graph.live import LiveGraph, continued
from tests.plugins.polyhedron.graph_truth import is_right
from tests.plugins.polyhedron.hand import CLEAN, SIZE, strokes_of
from tests.plugins.polyhedron.simple_objects import OBJECTS, view


def drawn(name: str, seed: int):
    body = OBJECTS[name]
    places = view(body, seed)
    assert places is not None
    return strokes_of(places, body.edges, CLEAN, seed), places * SIZE + 200.0, body.edges


def test_stroke_by_stroke_the_graph_comes_about() -> None:
    strokes, places, edges = drawn("wedge", 21)
    known: LiveGraph | None = None
    for count in range(1, len(strokes) + 1):
        known = continued(known, strokes[:count])
        counted = {k for each in known.graph.strokes for k in each} | set(known.graph.dropped)
        assert counted == set(range(count))
    assert known is not None
    assert is_right(known.graph, places, edges)
    assert known.graph.health == ()


def test_a_thorough_search_is_the_graph_of_the_strokes() -> None:
    strokes, *_ = drawn("box", 22)
    known = continued(continued(None, strokes[:5]), strokes, thorough=True)
    whole = graph_of(strokes)
    assert (known.graph.lines == whole.lines).all()
    assert (known.graph.places == whole.places).all()


def test_an_erased_stroke_leaves_its_corners_and_may_come_back() -> None:
    strokes, places, edges = drawn("box", 23)
    whole = continued(None, strokes)
    without = continued(whole, strokes[:4] + strokes[5:])
    assert len(without.graph.lines) == len(edges) - 1
    assert [each.what for each in without.graph.health] == ["corner of two lines"] * 2
    again = continued(without, strokes)
    assert is_right(again.graph, places, edges)


def test_all_strokes_may_be_erased() -> None:
    strokes, *_ = drawn("box", 23)
    known = continued(continued(None, strokes), [])
    assert len(known.graph.lines) == 0


def test_what_came_before_is_not_changed() -> None:
    strokes, *_ = drawn("box", 24)
    before = continued(None, strokes[:8])
    lines = before.graph.lines.copy()
    first, second = continued(before, strokes), continued(before, strokes)
    assert (before.graph.lines == lines).all()
    assert (first.graph.places == second.graph.places).all()
