"""Dashes of hidden lines that run close together, and drawings that can be read in two ways."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.arrays import Array
from bozzetto.ink import Stroke
from bozzetto_polyhedron.graph.build import normalized, size_of
from bozzetto_polyhedron.graph.dashes import rows_of_dashes
from bozzetto_polyhedron.graph.live import searched
from bozzetto_polyhedron.graph.segments import Segments, pieces_of
from bozzetto_polyhedron.solve.line_readings import decided
from tests.plugins.polyhedron.graph_truth import graph_of, is_right
from tests.plugins.polyhedron.hand import SIZE, Hand, owned_strokes_of, strokes_of
from tests.plugins.polyhedron.objects import CAMERA, TO_CANVAS, made, view

HAND = Hand(jitter=0.01)

PARALLEL = np.array([(0.0, 0.0), (0.7, 0.3), (0.01, 0.03), (0.71, 0.33)])
CROSSING = np.array([(0.0, 0.0), (0.7, 0.3), (0.1, 0.5), (0.6, 0.0)])
MEETING = np.array([(0.0, 0.0), (0.5, 0.1), (0.5, 0.1), (0.8, 0.6)])
ON_ONE_LINE = np.array([(0.0, 0.0), (0.3, 0.1), (0.45, 0.15), (0.75, 0.25)])


def two_rows(places: Array, seed: int) -> tuple[Segments, set[frozenset[int]]]:
    """Dashes of two lines between places, and which ones belong together."""
    strokes, owners = owned_strokes_of(places, [(0, 1), (2, 3)], HAND, seed, (0, 1))
    size = size_of(strokes)
    segments, _ = normalized([pieces_of(each, size, np.zeros((0, 2))) for each in strokes], size)
    return segments, {frozenset(np.flatnonzero(np.equal(owners, k)).tolist()) for k in (0, 1)}


def rows_of(segments: Segments) -> set[frozenset[int]]:
    found = rows_of_dashes(segments, np.ones(len(segments), bool), 0.012)
    assert sorted(k for row in found for k in row) == list(range(len(segments)))
    return {frozenset(row) for row in found}


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(
    "places", [PARALLEL, CROSSING, MEETING, ON_ONE_LINE], ids=["parallel", "cross", "meet", "gap"]
)
def test_dashes_of_two_lines_are_two_rows(places: Array, seed: int) -> None:
    segments, meant = two_rows(places, seed)
    found = rows_of(segments)
    for line in meant:
        longest = max(found, key=lambda row: len(row & line))
        assert longest <= line
        assert len(longest) >= len(line) - 2


def test_rows_do_not_depend_on_the_order_of_dashes() -> None:
    segments, _ = two_rows(CROSSING, 5)
    order = np.random.default_rng(1).permutation(len(segments))
    shuffled = Segments(
        segments.ends[order][:, ::-1],
        segments.pressure[order],
        segments.strokes[order],
        segments.bow[order],
    )
    found = {frozenset(int(order[k]) for k in row) for row in rows_of(shuffled)}
    assert found == rows_of(segments)


def drawing(seed: int) -> tuple[tuple[Stroke, ...], Array, list[tuple[int, int]]]:
    """A solid with its hidden lines dashed; places in px."""
    seen = view(made(seed), seed)
    assert seen is not None
    edges = [(int(a), int(b)) for a, b in seen.solid.edges]
    hidden = np.flatnonzero(seen.hidden > 0.5).tolist()
    strokes = strokes_of(seen.plane * TO_CANVAS, edges, HAND, seed, hidden)
    return strokes, seen.plane * TO_CANVAS * SIZE + 200.0, edges


@pytest.mark.parametrize("seed", [304, 413, 526, 538, 543, 578, 596, 695])
def test_hidden_lines_that_run_close_are_told_apart(seed: int) -> None:
    strokes, places, edges = drawing(seed)
    assert is_right(graph_of(strokes), places, edges)


@pytest.mark.parametrize("seed", [1008])
def test_a_wrong_graph_with_a_right_one_as_likely_says_so(seed: int) -> None:
    strokes, places, edges = drawing(seed)
    graph = graph_of(strokes)
    assert not is_right(graph, places, edges)
    assert [each.what for each in graph.health] == ["second reading"]
    away = np.linalg.norm(graph.places - graph.health[0].place, axis=1)
    assert away.min() < 0.1 * SIZE


@pytest.mark.parametrize("seed", [990, 1299])
def test_lines_that_leave_faces_open_are_told(seed: int) -> None:
    """Three lines or more at every corner, and yet some are wrong: only space tells it."""
    strokes, places, edges = drawing(seed)
    live = searched(strokes)
    assert not live.graph.health
    assert not is_right(live.graph, places, edges)
    found = decided(live, CAMERA, lambda *_: None)
    assert [each.what for each in found.graph.health] == ["open faces"]
    middles = found.graph.places[found.graph.lines].mean(axis=1)
    assert np.linalg.norm(middles - found.graph.health[0].place, axis=1).min() < 1.0
