"""Hidden edges that were not drawn: guesses, and the command that draws them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.ink import Stroke, Strokes
from bozzetto.plugin import Context
from bozzetto_polyhedron.commands.hidden_edges import draw_hidden_edges
from bozzetto_polyhedron.graph.line_graph import LineGraph
from bozzetto_polyhedron.graph.live import searched
from bozzetto_polyhedron.model.assign_stroke import new_body
from bozzetto_polyhedron.model.state import PolyhedronState
from bozzetto_polyhedron.reconstruction.drawing import LEAST_NOISE, Drawing, drawing_of
from bozzetto_polyhedron.reconstruction.hidden_lines import MOST_OTHERWISE, NEAR, hidden_lines
from bozzetto_polyhedron.reconstruction.outline import outline_of
from bozzetto_polyhedron.reconstruction.soundness import seen_otherwise
from bozzetto_polyhedron.reconstruction.visible_regions import with_passing_lines
from bozzetto_polyhedron.solve.pipeline import solved
from tests.plugins.polyhedron.figures_hidden_lines import drawing, outcome, visible_lines
from tests.plugins.polyhedron.fine_parts import fine_part
from tests.plugins.polyhedron.graph_truth import graph_of, is_right
from tests.plugins.polyhedron.hand import SIZE, Hand, strokes_of
from tests.plugins.polyhedron.objects import (
    CAMERA,
    OBJECTS,
    Polyhedron,
    View,
    box,
    frustum,
    made,
    polyhedron_of,
    view,
)

SNAPPED = NEAR + 3.0 * LEAST_NOISE
"""Distance within which a guessed corner is put on a drawn one, diagonals."""

STEADY = Hand(jitter=0.0, wobble=0.0, tremble=0.0)


def seen_graph(
    solid: Polyhedron, seed: int, distance: float | None = None
) -> tuple[View, LineGraph]:
    """The visible lines of a solid as a graph without noise."""
    seen = view(solid, seed, distance)
    assert seen is not None
    places, lines = visible_lines(seen)
    used, numbers = np.unique(np.array(lines), return_inverse=True)
    numbers = np.sort(numbers.reshape(-1, 2), axis=1)
    count = len(numbers)
    strokes = tuple((k,) for k in range(count))
    graph = LineGraph(places[used] * SIZE, numbers, np.zeros(count), strokes, (), 0.1, ())
    return seen, graph


@pytest.mark.parametrize("name", ["box", "L", "stairs", "house", "hexagonal prism"])
@pytest.mark.parametrize("seed", [1, 2])
def test_hidden_lines_of_a_prism_are_those_of_the_solid(name: str, seed: int) -> None:
    seen, graph = seen_graph(OBJECTS[name], seed)
    guess = hidden_lines(graph, CAMERA)[0]
    corners = seen.plane * (1.0, -1.0) * SIZE
    away = np.linalg.norm(guess.ends.reshape(-1, 1, 2) - corners, axis=2)
    assert away.min(1).max() < 0.02 * SIZE
    found = {tuple(sorted(pair)) for pair in away.argmin(1).reshape(-1, 2).tolist()}
    edges = {tuple(sorted(pair)) for pair in seen.solid.edges.tolist()}
    hidden = {
        tuple(sorted(pair))
        for pair, share in zip(seen.solid.edges.tolist(), seen.hidden, strict=True)
        if share == 1.0
    }
    assert hidden <= found <= edges


def pyramid() -> Polyhedron:
    base = [(-1.0, -0.8, 0.0), (1.0, -0.8, 0.0), (1.0, 0.8, 0.0), (-1.0, 0.8, 0.0)]
    rings = [(0, 3, 2, 1), *((k, (k + 1) % 4, 4) for k in range(4))]
    edges = np.array([(k, (k + 1) % 4) for k in range(4)] + [(k, 4) for k in range(4)])
    faces = tuple((ring,) for ring in rings)
    return Polyhedron(np.array([*base, (0.0, 0.0, 1.7)]), edges, faces)


@pytest.mark.parametrize("solid", [pyramid(), frustum(4)], ids=["pyramid", "frustum"])
@pytest.mark.parametrize("seed", [1, 2, 4, 5, 6])
def test_mirror_images_are_among_the_guesses(solid: Polyhedron, seed: int) -> None:
    seen, graph = seen_graph(solid, seed)
    hidden = {tuple(sorted(p)) for p, s in zip(solid.edges.tolist(), seen.hidden, strict=True) if s}
    corners = seen.plane * (1.0, -1.0) * SIZE
    found = []
    for guess in hidden_lines(graph, CAMERA):
        away = np.linalg.norm(guess.ends.reshape(-1, 1, 2) - corners, axis=2)
        if away.min(1).max() < 0.02 * SIZE:
            found.append({tuple(sorted(p)) for p in away.argmin(1).reshape(-1, 2).tolist()})
    assert hidden in found


@pytest.mark.parametrize("name", ["box", "L", "stairs"])
@pytest.mark.parametrize(("seed", "distance"), [(1, 1.5), (2, 2.0), (4, 3.0)])
def test_in_perspective_hidden_lines_of_a_prism_are_those_of_the_solid(
    name: str, seed: int, distance: float
) -> None:
    seen, graph = seen_graph(OBJECTS[name], seed, distance)
    guess = hidden_lines(graph, CAMERA)[0]
    corners = seen.plane * (1.0, -1.0) * SIZE
    away = np.linalg.norm(guess.ends.reshape(-1, 1, 2) - corners, axis=2)
    assert away.min(1).max() < 0.02 * SIZE
    found = {tuple(sorted(pair)) for pair in away.argmin(1).reshape(-1, 2).tolist()}
    hidden = {
        tuple(sorted(pair))
        for pair, share in zip(seen.solid.edges.tolist(), seen.hidden, strict=True)
        if share == 1.0
    }
    assert hidden <= found


@pytest.mark.parametrize("distance", [None, 2.0])
@pytest.mark.parametrize("seed", [1, 3, 5])
def test_a_hole_through_the_visible_face_is_completed(seed: int, distance: float | None) -> None:
    solid = polyhedron_of(box((3.0, 2.4, 1.6)) - box((1.6, 1.2, 4.0), (0.7, 0.6, -1.0)), "frame")
    assert solid is not None
    seen, graph = seen_graph(solid, seed, distance)
    corners = seen.plane * (1.0, -1.0) * SIZE
    edges = {tuple(sorted(pair)) for pair in seen.solid.edges.tolist()}
    complete = []
    for guess in hidden_lines(graph, CAMERA):
        away = np.linalg.norm(guess.ends.reshape(-1, 1, 2) - corners, axis=2)
        found = {tuple(sorted(pair)) for pair in away.argmin(1).reshape(-1, 2).tolist()}
        hidden = {
            tuple(sorted(p)) for p, s in zip(solid.edges.tolist(), seen.hidden, strict=True) if s
        }
        complete.append(away.min(1).max() < SNAPPED * SIZE and hidden <= found <= edges)
    assert any(complete)


def guessed_pairs(seen: View, graph: LineGraph) -> list[set[tuple[int, int]] | None]:
    """The lines of each guess as pairs of corners of the solid; None where a corner is none."""
    corners = seen.plane * (1.0, -1.0) * SIZE
    found: list[set[tuple[int, int]] | None] = []
    for guess in hidden_lines(graph, CAMERA):
        away = np.linalg.norm(guess.ends.reshape(-1, 1, 2) - corners, axis=2)
        one, two = np.sort(away.argmin(1).reshape(-1, 2), axis=1).T.tolist()
        known = away.min(1).max() < SNAPPED * SIZE
        found.append(set(zip(one, two, strict=True)) if known else None)
    return found


def of_boxes(seeds: range) -> list[tuple[View, LineGraph]]:
    solids = [(seed, made(seed, ("boxes", "notched box"))) for seed in seeds]
    return [seen_graph(solid, seed) for seed, solid in solids if view(solid, seed) is not None]


def test_hidden_corners_of_several_boxes_are_those_of_the_solid() -> None:
    right = []
    for seen, graph in of_boxes(range(700, 714)):
        edges = {tuple(sorted(pair)) for pair in seen.solid.edges.tolist()}
        hidden = {
            tuple(sorted(pair))
            for pair, share in zip(seen.solid.edges.tolist(), seen.hidden, strict=True)
            if share == 1.0
        }
        found = guessed_pairs(seen, graph)
        right.append(bool(found and found[0] is not None and hidden <= found[0] <= edges))
    assert len(right) > 10
    assert np.mean(right) >= 0.7


def test_no_hidden_line_leaves_the_drawing() -> None:
    solids = [(seed, made(seed)) for seed in range(720, 735)]
    graphs = [seen_graph(each, seed)[1] for seed, each in solids if view(each, seed) is not None]
    for graph in graphs:
        drawing = drawing_of(graph)
        outline = outline_of(drawing, SNAPPED)
        for guess in hidden_lines(graph, CAMERA):
            ends = (guess.ends - drawing.center) / drawing.diagonal * (1.0, -1.0)
            share = np.linspace(0.0, 1.0, 7)[:, None]
            places = ends[:, None, 0] + share * (ends[:, None, 1] - ends[:, None, 0])
            assert outline.cover(places.reshape(-1, 2)).all()


def test_the_order_of_corners_and_lines_changes_no_guess() -> None:
    rng = np.random.default_rng(5)
    for seen, graph in of_boxes(range(714, 719)):
        turn = rng.permutation(len(graph.places))
        lines = np.sort(np.argsort(turn)[graph.lines], axis=1)[rng.permutation(len(graph.lines))]
        other = replace(graph, places=graph.places[turn], lines=lines)
        first, again = guessed_pairs(seen, graph), guessed_pairs(seen, other)
        assert first[:1] == again[:1]


def whole_picture(name: str, seed: int) -> tuple[LineGraph, np.ndarray, np.ndarray, np.ndarray]:
    """The visible lines of a solid without cut ones, all its corners and lines, what is hidden."""
    seen = view(OBJECTS[name], seed)
    assert seen is not None
    hidden = (seen.hidden == 1.0).astype(float)
    drawn = np.sort(seen.solid.edges[hidden == 0.0], axis=1)
    used, numbers = np.unique(drawn, return_inverse=True)
    places = seen.plane * (1.0, -1.0) * SIZE
    count = len(drawn)
    strokes = tuple((k,) for k in range(count))
    lines = numbers.reshape(-1, 2)
    graph = LineGraph(places[used], lines, np.zeros(count), strokes, (), 0.1, ())
    drawing = drawing_of(graph)
    points = (places - drawing.center) / drawing.diagonal * (1.0, -1.0)
    return graph, points, np.sort(seen.solid.edges, axis=1), hidden


@pytest.mark.parametrize("name", ["box", "L", "stairs", "house", "frustum"])
def test_a_solid_shows_its_lines_as_drawn_and_not_others(name: str) -> None:
    graph, points, lines, hidden = whole_picture(name, 1)
    drawing = drawing_of(graph)
    right = seen_otherwise(drawing, points, lines, hidden)
    assert right is not None
    assert right < 0.05
    swapped = seen_otherwise(drawing, points, lines, 1.0 - hidden)
    assert swapped is not None
    assert swapped > MOST_OTHERWISE
    moved = points.copy()
    unseen = np.setdiff1d(np.arange(len(points)), lines[hidden == 0.0])
    moved[unseen[0] if len(unseen) else 0] += (0.25, -0.2)
    bent = seen_otherwise(drawing, moved, lines, hidden)
    assert bent is not None
    assert bent > MOST_OTHERWISE


def test_lines_that_cross_in_every_picture_are_no_solid() -> None:
    graph, points, _, _ = whole_picture("box", 1)
    every = np.array([(a, b) for a in range(5) for b in range(a + 1, 5)])
    assert seen_otherwise(drawing_of(graph), points[:5], every, np.zeros(10)) == 1.0


def test_lines_in_two_parts_tell_nothing() -> None:
    graph, points, lines, hidden = whole_picture("box", 1)
    both = np.concatenate((points, points + 3.0)), np.concatenate((lines, lines + len(points)))
    assert seen_otherwise(drawing_of(graph), *both, np.tile(hidden, 2)) is None


def test_an_outline_closes_small_gaps_and_no_large_ones() -> None:
    square = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
    for gap, closed in ((0.02, True), (0.3, False)):
        places = np.concatenate((square, [(0.0, gap)]))
        lines = np.array([(0, 1), (1, 2), (2, 3), (3, 4)])
        drawing = Drawing(places, lines, np.zeros(4), 0.002, np.zeros(2), 1.0)
        outline = outline_of(drawing, 0.02)
        assert outline.covers(np.array((0.5, 0.5))) is closed
        assert outline.covers(np.array((0.5, 0.01)))
        assert not outline.covers(np.array((1.1, 0.5)))


def test_a_line_that_ends_where_two_go_straight_on_goes_behind_them() -> None:
    places = np.array([(0.0, 0.0), (300.0, 4.0), (140.0, 2.0), (160.0, 200.0), (0.0, 210.0)])
    lines = np.array([(0, 2), (1, 2), (2, 3), (3, 4)])
    strokes = tuple((k,) for k in range(4))
    graph = LineGraph(places, lines, np.zeros(4), strokes, (), 1.0, ())
    made = with_passing_lines(drawing_of(graph))
    assert sorted(map(tuple, made.lines.tolist())) == [(0, 1), (2, 3), (3, 4)]
    bent = replace(graph, places=places + np.array([(0, 0), (0, 90), (0, 0), (0, 0), (0, 0)]))
    assert len(with_passing_lines(drawing_of(bent)).lines) == 4


def visible_is_right(seed: int, only_visible: bool) -> bool | None:
    """Whether the visible lines of a thin angle are found as they were drawn."""
    solid = fine_part("thin_angle", seed)
    seen = None if solid is None else view(solid, seed)
    if seen is None:
        return None
    places, lines = visible_lines(seen)
    strokes = strokes_of(places, lines, Hand(jitter=0.004, wobble=0.002), seed)
    used = np.unique(np.array(lines))
    numbers = {int(corner): k for k, corner in enumerate(used)}
    pairs = [(numbers[a], numbers[b]) for a, b in lines]
    graph = searched(strokes, only_visible=only_visible).graph
    return is_right(graph, places[used] * SIZE + 200.0, pairs)


def test_thin_sides_stay_two_lines_where_hidden_ones_are_left_out() -> None:
    every = [[visible_is_right(seed, each) for each in (True, False)] for seed in range(30, 42)]
    visible, whole = np.array([each for each in every if each[0] is not None]).T
    assert visible.mean() >= 0.6
    assert visible.sum() >= whole.sum()


def test_a_drawing_with_all_lines_has_none_to_guess() -> None:
    seen = view(OBJECTS["L"], 3)
    assert seen is not None
    lines = np.sort(seen.solid.edges, axis=1)
    strokes = tuple((k,) for k in range(len(lines)))
    places = seen.plane * (1.0, -1.0) * SIZE
    graph = LineGraph(places, lines, np.zeros(len(lines)), strokes, (), 0.1, ())
    assert hidden_lines(graph, CAMERA) == ()


@pytest.mark.parametrize(
    "lines", [[], [(0, 1)], [(0, 1), (1, 2), (2, 3)], [(0, 1), (0, 2), (0, 3)]]
)
def test_little_ink_gives_no_guess(lines: list[tuple[int, int]]) -> None:
    places = np.array([(0.0, 0.0), (90.0, 5.0), (80.0, 70.0), (10.0, 60.0)])
    pairs = np.array(lines, np.intp).reshape(-1, 2)
    strokes = tuple((k,) for k in range(len(pairs)))
    graph = LineGraph(places, pairs, np.zeros(len(pairs)), strokes, (), 1.0, ())
    assert hidden_lines(graph, CAMERA) == ()


def test_most_prisms_drawn_by_hand_are_guessed() -> None:
    found = [outcome(seed, Hand(jitter=0.01)) for seed in range(100, 110)]
    right = [any(each[0]) for each in found if each is not None]
    assert np.mean(right) >= 0.7


def test_most_holes_drawn_by_hand_are_holes_at_first() -> None:
    """And no wedges over some corners of the rim, which have fewer lines."""
    hand = Hand(jitter=0.01, wobble=0.006)
    found = [outcome(seed, hand, kind="blocks with a hole") for seed in range(23_000, 23_010)]
    right = [each[0][:1] == [True] for each in found if each is not None]
    assert np.mean(right) >= 0.6


def drawn(seed: int = 101) -> tuple[PolyhedronState, tuple[Stroke, ...]]:
    made = drawing(seed, STEADY)
    assert made is not None
    return new_body(PolyhedronState(), made[1]), made[1]


def test_the_command_draws_light_edges_that_make_a_solid() -> None:
    state, strokes = drawn()
    after = draw_hidden_edges(state, Context())
    body = after.nodes[0]
    assert tuple(body.strokes)[: len(strokes)] == tuple(state.nodes[0].strokes)
    guessed = tuple(body.strokes)[len(strokes) :]
    firm = min(float(np.mean(each.pressure)) for each in strokes)
    assert guessed
    assert all(float(np.max(each.pressure)) < 0.75 * firm for each in guessed)
    made = solved(body, after)
    assert made.body is not None
    assert made.body.closed
    assert graph_of(body.strokes).health == ()


def test_once_more_takes_the_guess_back_first() -> None:
    state, strokes = drawn()
    once = draw_hidden_edges(state, Context())
    assert once.nodes[0].drawn == state.nodes[0].strokes
    twice = draw_hidden_edges(once, Context())
    guesses = hidden_lines(searched(strokes, only_visible=True).graph, strokes[0].camera)
    assert twice.nodes[0].guess == (1 if len(guesses) > 1 else 0)
    assert len(twice.nodes[0].strokes) == len(strokes) + len(twice.nodes[0].guessed)


def test_what_a_person_changed_among_guessed_edges_stays() -> None:
    state, strokes = drawn()
    body = draw_hidden_edges(state, Context()).nodes[0]
    fewer = replace(body, strokes=Strokes(tuple(body.strokes)[:-1]))
    more = replace(body, strokes=Strokes((*body.strokes, strokes[0])))
    for each in (fewer, more):
        assert each.drawn == each.strokes


def test_a_drawing_that_tells_nothing_is_refused_with_advice() -> None:
    _, strokes = drawn()
    state = new_body(PolyhedronState(), strokes[:2])
    with pytest.raises(UserError, match="Draw one face"):
        draw_hidden_edges(state, Context())


def refusal(strokes: tuple[Stroke, ...]) -> str:
    state = new_body(PolyhedronState(), strokes)
    with pytest.raises(UserError) as told:
        draw_hidden_edges(state, Context())
    return str(told.value)


def test_where_nothing_is_guessed_the_reason_is_told() -> None:
    seen = view(OBJECTS["L"], 3)
    assert seen is not None
    places, edges = seen.plane * (1.0, -1.0), [(int(a), int(b)) for a, b in seen.solid.edges]
    assert "No edge is missing" in refusal(strokes_of(places, edges, STEADY, 1))
    zigzag = np.array([(0.0, 0.0), (0.5, 0.1), (0.1, 0.3), (0.6, 0.4), (0.0, 0.6), (0.5, 0.9)])
    rows = [(k, k + 1) for k in range(5)]
    assert "ends alone" in refusal(strokes_of(zigzag, rows, STEADY, 1))
    places, lines = visible_lines(seen)
    turn = np.linspace(0.0, 5.0, 40)
    arc = strokes_of(places, lines[:-3], STEADY, 1)
    ring = Stroke(
        400.0 + 90.0 * np.cos(turn), 300.0 + 60.0 * np.sin(turn), arc[0].camera, group=arc[0].group
    )
    assert "curved" in refusal((*arc, ring))
