"""A touch on a mark mends the ink of a drawing where its lines look wrong."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from bozzetto.cli.main import main
from bozzetto.errors import UserError
from bozzetto.exchange.ink.ink_json import write_drawing
from bozzetto.ink import Drawing, Stroke, Strokes
from bozzetto.plugin import Context, Tap
from bozzetto.view import Camera
from bozzetto_polyhedron.graph.health import told
from bozzetto_polyhedron.graph.line_graph import LineGraph
from bozzetto_polyhedron.model.assign_stroke import new_body
from bozzetto_polyhedron.model.state import Body, PolyhedronState
from bozzetto_polyhedron.solve.mending import mended
from bozzetto_polyhedron.solve.pipeline import graph_of_ink, never
from bozzetto_polyhedron.tools.draw_lines import DrawLines
from bozzetto_polyhedron.tools.mend import Mend
from tests.plugins.polyhedron.hand import stroke

EDGES = (
    *((0, 1), (1, 3), (3, 2), (2, 0), (4, 5), (5, 7)),
    *((7, 6), (6, 4), (0, 4), (1, 5), (2, 6), (3, 7)),
)
SEEDS = range(5)


def corners(seed: int) -> np.ndarray:
    """Return the corners of a block in some view, (8, 2) px."""
    rng = np.random.default_rng([seed, 5])
    ways = np.array([(260.0, 40.0), (150.0, -90.0), (0.0, -240.0)]) + rng.uniform(-25, 25, (3, 2))
    bits = np.array([[k & 1, k >> 1 & 1, k >> 2] for k in range(8)])
    return np.array([300.0, 600.0]) + bits @ ways


def line(begin: np.ndarray, end: np.ndarray, first: float = 0.0, last: float = 1.0) -> Stroke:
    shares = np.linspace(first, last, 40)[:, None]
    return stroke(begin + shares * (end - begin))


def block(seed: int, *parts: tuple[float, float], edge: int = 9) -> list[Stroke]:
    """Return the ink of a block of which one edge is drawn in parts of it."""
    places = corners(seed)
    whole = [line(places[a], places[b]) for k, (a, b) in enumerate(EDGES) if k != edge]
    begin, end = places[list(EDGES[edge])]
    return [*whole, *(line(begin, end, *part) for part in parts)]


def graph_of(ink) -> LineGraph:
    return graph_of_ink(Strokes(ink), "clear", never)


def is_block(graph: LineGraph, seed: int) -> bool:
    """Whether a graph is that of a block, and all is well with it."""
    away = np.linalg.norm(graph.places[:, None] - corners(seed), axis=2)
    same = away.argmin(axis=1)
    lines = {tuple(sorted(pair)) for pair in same[graph.lines].tolist()}
    right = lines == {tuple(sorted(pair)) for pair in EDGES}
    return right and len(graph.lines) == len(EDGES) and not graph.health


def state_of(ink) -> PolyhedronState:
    return new_body(PolyhedronState(), ink)


def touched(state: PolyhedronState, kind: str) -> PolyhedronState:
    """Return the state after a touch on the first mark of a kind."""
    (body,) = state.of_kind(Body)
    place = next(each.place for each in graph_of(body.strokes).health if each.what == kind)
    return Mend().tap(state, Tap(place[0] + 3.0, place[1] - 2.0, Camera()), Context())


def ink_of(state: PolyhedronState) -> Strokes:
    (body,) = state.of_kind(Body)
    return body.strokes


@pytest.mark.parametrize("seed", SEEDS)
def test_a_touch_on_a_gap_draws_the_line_across_it(seed):
    begin, end = corners(seed)[list(EDGES[9])]
    half = 27.0 / np.linalg.norm(end - begin)
    ink = block(seed, (0.0, 0.7 - half), (0.7 + half, 1.0))
    after = ink_of(touched(state_of(ink), "gap"))
    assert len(after) == len(ink) + 1
    assert after[-1].pressure == pytest.approx(0.8)
    assert is_block(graph_of(after), seed)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_touch_on_a_tick_erases_it_and_nothing_else(seed):
    ink = block(seed, (0.0, 1.0))
    tick = line(np.array([850.0, 200.0]), np.array([875.0, 208.0]))
    after = ink_of(touched(state_of([*ink[:4], tick, *ink[4:]]), "tick"))
    assert [one.points.tolist() for one in after] == [one.points.tolist() for one in ink]
    assert is_block(graph_of(after), seed)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("edge", [1, 9])
def test_a_touch_on_a_loose_end_draws_the_line_on_to_its_corner(seed, edge):
    ink = block(seed, (0.0, 0.8), edge=edge)
    after = ink_of(touched(state_of(ink), "loose end"))
    assert len(after) == len(ink)
    assert is_block(graph_of(after), seed)


def test_a_loose_end_goes_on_to_a_line_where_no_corner_is_near():
    """A line from the middle of the front that stops before the upper edge: a T."""
    places = corners(0)
    begin = 0.5 * (places[0] + places[1])
    end = 0.5 * (places[4] + places[5])
    ink = [*block(0, (0.0, 1.0)), line(begin, end, 0.0, 0.9)]
    after = ink_of(touched(state_of(ink), "loose end"))
    assert after[-1].points[-1] == pytest.approx(end, abs=3.0)
    assert not [each for each in graph_of(after).health if each.what == "loose end"]


def test_close_corners_become_one():
    """The graph is given: strokes that end so near to one another are mostly one corner."""
    places = corners(1)
    aside = places[5] + np.array([9.0, 5.0])
    ink = Strokes([*block(1, edge=9), line(places[1], aside)])
    graph = graph_of(block(1, (0.0, 1.0)))
    at = np.linalg.norm(graph.places - places[5], axis=1).argmin()
    far = np.linalg.norm(graph.places - places[1], axis=1).argmin()
    own = int(np.flatnonzero((graph.lines == (min(at, far), max(at, far))).all(axis=1))[0])
    lines = graph.lines.copy()
    lines[own] = (far, len(graph.places))
    told_here = told((graph.places[at] + aside) / 2, "close corners")
    split = replace(
        graph, places=np.vstack((graph.places, aside)), lines=lines, health=(told_here,)
    )
    after = mended(Body(id="a", strokes=ink), split, told_here).strokes
    assert after[-1].points[-1] == pytest.approx(graph.places[at], abs=0.5)
    assert is_block(graph_of(after), 1)


def test_what_only_a_person_knows_is_told():
    state = state_of(block(2))
    with pytest.raises(UserError, match="Only two lines meet here"):
        touched(state, "corner of two lines")
    far = state_of(block(2, (0.0, 0.2)))
    with pytest.raises(UserError, match="nothing near this end"):
        touched(far, "loose end")
    with pytest.raises(UserError, match="marked here"):
        Mend().tap(state, Tap(5.0, 5.0, Camera()), Context())
    with pytest.raises(UserError, match="marked here"):
        Mend().tap(PolyhedronState(), Tap(5.0, 5.0, Camera()), Context())


def test_the_next_step_leads_to_the_mark_and_away_once_all_is_well():
    state = state_of(block(3, (0.0, 0.8)))
    assert "“Mend”" in DrawLines().next_step(state).sentence
    assert Mend().next_step(state).place is not None
    mended_state = touched(state, "loose end")
    assert Mend().next_step(mended_state).tool == "turn"
    assert Mend().next_step(state_of(block(3))).tool == "draw"


def test_a_step_of_an_ink_file_mends_and_the_solid_is_closed(tmp_path):
    ink = block(4, (0.0, 0.8))
    place = next(each.place for each in graph_of(ink).health if each.what == "loose end")
    source, report = tmp_path / "block.json", tmp_path / "r.json"
    said = json.loads(write_drawing(Drawing(Strokes(ink), Camera())))
    said["steps"] = [
        {"tool": "draw", "strokes": list(range(len(ink)))},
        {"tool": "mend", "tap": list(place)},
        {"tool": "turn", "tap": corners(4)[0].tolist()},
    ]
    source.write_text(json.dumps(said))
    words = ["build", "polyhedron", str(source), "-o", str(tmp_path / "x.stl")]
    assert main([*words, "--report", str(report)]) == 0
    assert '"closed": true' in report.read_text() or '"closed":true' in report.read_text()
