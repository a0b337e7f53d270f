"""From strokes to the graph: laws, drawings of a simulated hand, and hostile ink."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from bozzetto.arrays import Array
from bozzetto.ink import Stroke
from bozzetto.view import Camera
from bozzetto_polyhedron.graph.line_graph import LineGraph
from bozzetto_polyhedron.graph.live import searched
from tests.plugins.polyhedron.graph_truth import graph_of, is_right
from tests.plugins.polyhedron.hand import CLEAN, SIZE, UNTIDY, Hand, stroke, strokes_of
from tests.plugins.polyhedron.simple_objects import OBJECTS, three_bars, view

Edges = Sequence[tuple[int, int]]


def drawing(name: str, seed: int, hand: Hand = CLEAN) -> tuple[tuple[Stroke, ...], Array, Edges]:
    body = OBJECTS[name]
    places = view(body, seed)
    assert places is not None
    return strokes_of(places, body.edges, hand, seed), places * SIZE + 200.0, body.edges


def polyline(*corners: tuple[float, float], count: int = 30) -> Array:
    """Samples along straight lines from corner to corner."""
    at = np.linspace(0, 1, count)[:, None]
    parts = [np.array(a) + at * (np.array(b) - np.array(a)) for a, b in pairwise(corners)]
    return np.concatenate(parts)


def turned(strokes: Sequence[Stroke], matrix: Array, shift: Array) -> list[Stroke]:
    return [
        Stroke(*(each.points @ matrix.T + shift).T, Camera(), pressure=each.pressure)
        for each in strokes
    ]


@pytest.mark.parametrize("name", ["box", "wedge", "L", "house", "frustum", "notch"])
def test_a_tidy_drawing_gives_its_graph(name: str) -> None:
    strokes, places, edges = drawing(name, 3)
    graph = graph_of(strokes)
    assert is_right(graph, places, edges)
    assert graph.health == ()
    assert graph.dropped == ()
    assert sorted(k for each in graph.strokes for k in each) == list(range(len(strokes)))


def test_where_three_bars_meet_six_lines_have_one_corner() -> None:
    body, right = three_bars(), []
    assert len(body.edges) == 27
    for seed in range(12):
        places = view(body, seed)
        if places is not None:
            graph = graph_of(strokes_of(places, body.edges, Hand(jitter=0.01), seed))
            right.append(is_right(graph, places * SIZE + 200.0, body.edges))
    assert len(right) > 5
    assert np.mean(right) > 0.8


def test_what_was_drawn_again_and_in_pieces_is_one_line() -> None:
    strokes, places, edges = drawing("house", 4, Hand(retraced=0.6, split=0.3))
    assert len(strokes) > len(edges)
    assert is_right(graph_of(strokes), places, edges)


def test_corners_are_where_overshooting_lines_cross() -> None:
    steady = Hand(jitter=0.0, wobble=0.0, tremble=0.0, overshot=1.0)
    strokes, places, edges = drawing("box", 5, steady)
    graph = graph_of(strokes)
    assert is_right(graph, places, edges)
    away = np.linalg.norm(graph.places[:, None] - places, axis=2).min(1)
    assert away.max() < 0.003 * SIZE


def test_stray_marks_are_left_out() -> None:
    strokes, places, edges = drawing("box", 6, replace(CLEAN, ticks=2))
    graph = graph_of(strokes)
    assert is_right(graph, places, edges)
    lengths = [np.linalg.norm(np.ptp(strokes[k].points, axis=0)) for k in graph.dropped]
    assert all(each < 0.021 * SIZE for each in lengths)


def test_dashed_lines_are_light_and_the_others_are_not() -> None:
    body = OBJECTS["L"]
    places = view(body, 7)
    assert places is not None
    hidden = {0, 5, 9}
    graph = graph_of(strokes_of(places, body.edges, CLEAN, 7, hidden))
    assert is_right(graph, places * SIZE + 200.0, body.edges)
    nearest = np.linalg.norm(graph.places[:, None] - places * SIZE - 200.0, axis=2).argmin(1)
    light = {
        tuple(sorted(pair))
        for pair, each in zip(nearest[graph.lines].tolist(), graph.light, strict=True)
        if each > 0.5
    }
    assert light == {body.edges[k] for k in hidden}


def test_dashes_of_a_mouse_are_told_by_their_gaps() -> None:
    body = OBJECTS["box"]
    places = view(body, 8)
    assert places is not None
    drawn = strokes_of(places, body.edges, CLEAN, 8, {2, 7})
    graph = graph_of([Stroke(*each.points.T, Camera()) for each in drawn])
    assert is_right(graph, places * SIZE + 200.0, body.edges)
    assert (graph.light > 0.5).sum() == 2


def test_a_rectangle_in_one_stroke_has_four_lines() -> None:
    ring = polyline((100, 100), (500, 130), (480, 400), (90, 380), (100, 100))
    graph = graph_of([stroke(ring)])
    assert len(graph.places) == len(graph.lines) == 4
    assert {each.what for each in graph.health} == {"corner of two lines"}
    assert set(graph.strokes) == {(0,)}


def test_a_stroke_with_a_corner_is_two_lines() -> None:
    graph = graph_of([stroke(polyline((100, 100), (500, 120), (450, 500)))])
    assert len(graph.lines) == 2
    assert sorted(each.what for each in graph.health) == [
        "corner of two lines",
        "loose end",
        "loose end",
    ]


def bent_at_its_middle(turn: float) -> Stroke:
    """Return two bowed lines in one stroke that nowhere turns sharply."""
    at = np.linspace(-1.0, 1.0, 81)
    sagging = np.sqrt(at**2 + 0.1) * np.tan(np.radians(turn) / 2.0)
    return stroke(np.column_stack([400.0 + 200.0 * at, 300.0 + 200.0 * sagging]))


def test_a_slight_bend_is_a_corner_where_another_line_ends() -> None:
    bent = bent_at_its_middle(24.0)
    place = bent.points[40]
    down = stroke(polyline((place[0], place[1] + 3.0), (place[0] + 20.0, place[1] + 200.0)))
    graph = graph_of([bent, down])
    assert len(graph.lines) == 3
    assert np.linalg.norm(graph.places - place, axis=1).min() < 10.0
    assert len(graph_of([bent]).lines) == 1


def test_a_bow_is_no_corner_where_another_line_ends() -> None:
    bow = bent_at_its_middle(9.0)
    place = bow.points[40]
    down = stroke(polyline((place[0], place[1] + 3.0), (place[0] + 20.0, place[1] + 200.0)))
    assert len(graph_of([bow, down]).lines) == 2


@pytest.mark.parametrize("turn", [1.5, 3.0, 6.2])
def test_a_curved_stroke_is_set_aside_and_said(turn: float) -> None:
    strokes, places, edges = drawing("box", 3)
    at = np.linspace(0, turn, 80)
    arc = stroke(np.column_stack([400 + 150 * np.cos(at), 400 + 150 * np.sin(at)]))
    graph = graph_of([*strokes, arc])
    assert is_right(graph, places, edges)
    assert [each.what for each in graph.health] == ["curved stroke"]
    assert graph.dropped == (len(strokes),)


def test_a_forgotten_line_is_pointed_at() -> None:
    body = OBJECTS["box"]
    places = view(body, 9)
    assert places is not None
    graph = graph_of(strokes_of(places, body.edges[1:], CLEAN, 9))
    ends = places[list(body.edges[0])] * SIZE + 200.0
    assert len(graph.health) == 2
    for each in graph.health:
        assert np.linalg.norm(ends - each.place, axis=1).min() < 0.03 * SIZE
        assert each.sentence.endswith(".")


def same_up_to_numbers(one: LineGraph, other: LineGraph, places: Array) -> bool:
    """Whether two graphs are equal if the first one's corners are moved to `places`."""
    away = np.linalg.norm(places[:, None] - other.places, axis=2)
    number = away.argmin(1)
    if len(one.places) != len(other.places) or len(set(number.tolist())) != len(number):
        return False
    lines = {tuple(sorted(pair)) for pair in number[one.lines].tolist()}
    return lines == {tuple(pair) for pair in other.lines.tolist()}


@pytest.mark.parametrize("scale", [0.001, 1.0, 1000.0])
def test_turning_and_scaling_the_sheet_turns_and_scales_the_graph(scale: float) -> None:
    strokes, *_ = drawing("house", 11, UNTIDY)
    angle = 0.7
    matrix = scale * np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    shift = np.array([-300.0, 80.0]) * scale
    before, after = graph_of(strokes), graph_of(turned(strokes, matrix, shift))
    moved = before.places @ matrix.T + shift
    assert same_up_to_numbers(before, after, moved)
    # The box around the drawing turns too, and with it the unit in which spreads are tried.
    gap = np.linalg.norm(moved[:, None] - after.places, axis=2).min(1)
    assert gap.max() < 0.003 * SIZE * scale


def test_neither_order_nor_direction_of_strokes_matters() -> None:
    strokes, places, edges = drawing("L", 12)
    backwards = [
        Stroke(*each.points[::-1].T, Camera(), pressure=each.pressure) for each in strokes[::-1]
    ]
    one, other = graph_of(strokes), graph_of(backwards)
    assert is_right(one, places, edges)
    assert same_up_to_numbers(one, other, one.places)
    assert np.linalg.norm(one.places[:, None] - other.places, axis=2).min(1).max() < 1e-3


def test_the_same_strokes_give_the_same_graph() -> None:
    strokes, *_ = drawing("U", 5)
    one, other = graph_of(strokes), graph_of(strokes)
    assert np.array_equal(one.places, other.places)
    assert np.array_equal(one.lines, other.lines)
    assert one.noise == other.noise


def test_noise_follows_the_hand() -> None:
    steady, _, _ = drawing("box", 13, Hand(jitter=0.005, wobble=0.002))
    shaky, _, _ = drawing("box", 13, Hand(jitter=0.03, wobble=0.01))
    assert graph_of(shaky).noise > 2 * graph_of(steady).noise


def test_the_search_can_be_ended() -> None:
    class Ended(Exception):
        pass

    def end(fraction: float, step: str) -> None:
        raise Ended

    strokes, *_ = drawing("box", 3)
    with pytest.raises(Ended):
        searched(strokes, checkpoint=end)


def test_nothing_gives_an_empty_graph() -> None:
    graph = graph_of([])
    assert len(graph.lines) == 0
    assert graph.places.shape == (0, 2)


HOSTILE = {
    "a dot": [np.array([[5.0, 5.0]])],
    "dots in one place": [np.array([[5.0, 5.0]])] * 4,
    "two dots": [np.array([[5.0, 5.0]]), np.array([[900.0, 5.0]])],
    "one line": [polyline((0, 0), (300, 200))],
    "one line many times": [polyline((0, 0), (300, 200))] * 15,
    "a line there and back": [polyline((0, 0), (300, 200), (0, 0))],
    "far away": [polyline((1e6, 1e6), (1e6 + 300, 1e6)), polyline((1e6, 1e6), (1e6, 1e6 + 90))],
    "a fan": [polyline((0, 0), (500 * np.cos(a), 500 * np.sin(a))) for a in np.arange(12) / 4],
    "a grid": [polyline((0, 40.0 * k), (400, 40.0 * k)) for k in range(8)]
    + [polyline((40.0 * k, 0), (40.0 * k, 400)) for k in range(8)],
    "tiny": [polyline((0, 0), (1e-3, 0)), polyline((1e-3, 0), (1e-3, 1e-3))],
    "a jump": [np.array([[0.0, 0.0], [1e6, 1e6], [0.0, 1.0]])],
}


@pytest.mark.parametrize("name", list(HOSTILE))
def test_hostile_ink_gives_a_finite_graph(name: str) -> None:
    graph = graph_of([stroke(each) for each in HOSTILE[name]])
    assert np.isfinite(graph.places).all()
    assert np.isfinite(graph.light).all()
    assert np.isfinite(graph.noise)
    assert (graph.lines[:, 0] < graph.lines[:, 1]).all()
    counted = {k for each in graph.strokes for k in each} | set(graph.dropped)
    assert counted == set(range(len(HOSTILE[name])))


def test_samples_that_are_not_finite_are_left_out() -> None:
    class Raw:
        def __init__(self, points: Array) -> None:
            self.points = points
            self.pressure = np.full(len(points), np.nan)
            self.t = np.zeros(len(points))

    points = polyline((0, 0), (300, 200))
    points[7] = np.nan
    graph = graph_of([Raw(points)])
    assert len(graph.lines) == 1
    assert np.isfinite(graph.places).all()


@pytest.mark.slow
def test_untidy_drawings_of_unseen_views_give_their_graphs() -> None:
    right = count = healthy = healthy_right = 0
    for number, name in enumerate(OBJECTS):
        for seed in (2000 + number, 2100 + number, 2200 + number):
            strokes, places, edges = drawing(name, seed, UNTIDY)
            graph = graph_of(strokes)
            good = is_right(graph, places, edges)
            count, right = count + 1, right + good
            healthy, healthy_right = (
                healthy + (not graph.health),
                healthy_right + (good and not graph.health),
            )
    assert right >= 0.92 * count
    assert healthy_right >= 0.95 * healthy
