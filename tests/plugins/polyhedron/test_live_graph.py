"""The graph while it is drawn."""

from __future__ import annotations

from bozzetto.ink import Strokes
from bozzetto_polyhedron.graph import live
from bozzetto_polyhedron.graph.live import continued, searched
from bozzetto_polyhedron.solve.pipeline import graph_of_ink, graph_while_drawn, never
from tests.plugins.polyhedron.drawn_bodies import fitted
from tests.plugins.polyhedron.drawn_bodies import strokes_of as ink_of
from tests.plugins.polyhedron.graph_truth import is_right
from tests.plugins.polyhedron.hand import CLEAN, SIZE, strokes_of
from tests.plugins.polyhedron.objects import OBJECTS as SOLIDS
from tests.plugins.polyhedron.simple_objects import OBJECTS, view


def drawn(name: str, seed: int):
    body = OBJECTS[name]
    places = view(body, seed)
    assert places is not None
    return strokes_of(places, body.edges, CLEAN, seed), places * SIZE + 200.0, body.edges


def test_stroke_by_stroke_the_graph_comes_about() -> None:
    strokes, places, edges = drawn("wedge", 21)
    known = searched([])
    for count in range(1, len(strokes) + 1):
        known = continued(known, strokes[:count])
        counted = {k for each in known.graph.strokes for k in each} | set(known.graph.dropped)
        assert counted == set(range(count))
    assert is_right(known.graph, places, edges)
    assert known.graph.health == ()


def test_with_nothing_to_start_from_all_is_searched() -> None:
    strokes, *_ = drawn("box", 22)
    known = continued(searched([]), strokes)
    whole = searched(strokes).graph
    assert (known.graph.lines == whole.lines).all()
    assert (known.graph.places == whole.places).all()


def test_an_erased_stroke_leaves_its_corners_and_may_come_back() -> None:
    strokes, places, edges = drawn("box", 23)
    whole = searched(strokes)
    without = continued(whole, strokes[:4] + strokes[5:])
    assert len(without.graph.lines) == len(edges) - 1
    assert [each.what for each in without.graph.health] == ["corner of two lines"] * 2
    again = continued(without, strokes)
    assert is_right(again.graph, places, edges)


def test_all_strokes_may_be_erased() -> None:
    strokes, *_ = drawn("box", 23)
    known = continued(searched(strokes), [])
    assert len(known.graph.lines) == 0


def test_what_came_before_is_not_changed() -> None:
    strokes, *_ = drawn("box", 24)
    before = searched(strokes[:8])
    lines = before.graph.lines.copy()
    first, second = continued(before, strokes), continued(before, strokes)
    assert (before.graph.lines == lines).all()
    assert (first.graph.places == second.graph.places).all()


def test_a_preview_continues_what_was_found_before_its_last_stroke(monkeypatch) -> None:
    solid = SOLIDS["house"]
    ink = Strokes(ink_of(fitted(solid), solid.edges, jitter=1.0, seed=31))
    earlier = graph_of_ink(ink[:-1], "clear", never)

    def search_again(*_: object) -> None:
        raise AssertionError("the whole search is not for previews")

    monkeypatch.setattr(live, "best_draft", search_again)
    shown = graph_while_drawn(ink, "clear", never)
    assert len(shown.lines) == len(earlier.lines) + 1 == len(solid.edges)
