"""Strokes whose nodes follow them have a say in cameras and shape; marks stay a person's own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from bozzetto.ink import Stroke, Strokes
from bozzetto_car.body.build import body_of
from bozzetto_car.body.stroke_distances import stroke_distances
from bozzetto_car.dimensions import Dimensions
from bozzetto_car.marks_file import car_from_facts
from bozzetto_car.solver import pipeline
from bozzetto_car.solver.pipeline import solve_car
from bozzetto_car.solver.stroke_ends import sharpened
from bozzetto_car.state import CarState, MovedNode, TracedEdges
from bozzetto_car.template.loader import TEMPLATES, bundled
from tests.plugins.car.drawn_cars import drawn, marks_in
from tests.plugins.car.sketched import FRONT_QUARTER, REAR_QUARTER, apart, rms


@pytest.fixture(scope="module")
def car() -> CarState:
    return car_from_facts(marks_in("sedan") | {"styling": []}, {})


def moved(state: CarState, edits: list[TracedEdges]) -> dict[str, float]:
    """How far each mark of the first sketch is moved, px."""
    own = state.sketches[0]
    marks = zip(own.marks, sharpened(own, edits).marks, strict=True)
    return {a.node: float(np.hypot(a.u - b.u, a.v - b.v)) for a, b in marks}


def strokes(state: CarState) -> list[TracedEdges]:
    return [edit for edit in state.edits if isinstance(edit, TracedEdges)]


def along(edit: TracedEdges, line: NDArray[np.float64]) -> TracedEdges:
    """The same stroke at other places, (k, 2) px."""
    stroke = Stroke(line[:, 0], line[:, 1], edit.strokes[0].camera)
    return replace(edit, strokes=Strokes((stroke,)))


def test_marks_go_most_of_the_way_to_the_ends_of_strokes_and_not_to_far_ones(car: CarState) -> None:
    sketch = car.sketches[0]
    first = next(e for e in strokes(car) if e.sketch == sketch.id)
    one, other = first.edges[0].split("-")
    places = {mark.node: np.array((mark.u, mark.v)) for mark in sketch.marks}
    for away, least, most in ((3.0, 2.0, 2.4), (300.0, 0.0, 0.01)):
        line = np.linspace(places[one] + (0.0, away), places[other] + (0.0, away), 20)
        drawn_on, turned = (along(first, row) for row in (line, line[::-1]))
        found = moved(car, [drawn_on])
        assert least <= found[one] <= most
        assert least <= found[other] <= most
        assert not any(px for node, px in found.items() if node not in (one, other))
        assert moved(car, [turned]) == found


def test_only_strokes_that_nodes_follow_on_this_sketch_and_this_body_count(car: CarState) -> None:
    sketch, rows = car.sketches[0], strokes(car)
    assert max(moved(car, rows).values()) > 0.5
    for wrong in (
        [replace(e, nodes_follow=False) for e in rows],
        [replace(e, sketch="") for e in rows],
        [replace(e, edges=()) for e in rows],
        [replace(e, dimensions=Dimensions(length=4000.0)) for e in rows],
        [],
    ):
        assert sharpened(sketch, wrong) is sketch
    drag = MovedNode(node="C4", by=(0.0, 0.0, 10.0))
    assert sharpened(sketch, [drag, *rows]) is sketch
    assert sharpened(sketch, [*rows, drag]).marks == sharpened(sketch, rows).marks
    assert sharpened(sketch, rows[::-1]).marks == sharpened(sketch, rows).marks


def test_marks_of_a_solved_car_are_those_that_a_person_has_set(car: CarState) -> None:
    solved = solve_car(car)
    for sketch in car.sketches:
        placed = solved.placed[sketch.id]
        assert placed.sketch is sketch
        assert placed.missed is not None
        through = placed.sketch_camera
        for mark in sketch.marks:
            seen = through.pixels(solved.positions[[solved.template.node[mark.node]]])[0]
            off = float(np.hypot(*(seen - (mark.u, mark.v))))
            assert placed.missed[mark.node] == pytest.approx(off, abs=1e-9)


def test_steady_strokes_tell_the_car_better_than_unsteady_marks() -> None:
    """Of cars that no constant was chosen with: marks of 4 px, strokes that end at the nodes."""
    ratios = []
    for number, name in enumerate(TEMPLATES):
        made = drawn(bundled(name), 1300 + number, (FRONT_QUARTER, REAR_QUARTER), hand=4.0)
        told = car_from_facts(made.marks_file(), {})
        errors = [
            rms(apart(solve_car(state).positions, made.positions))
            for state in (replace(told, edits=()), told)
        ]
        ratios.append(errors[1] / errors[0])
    assert np.median(ratios) < 0.95, ratios


@pytest.mark.slow
@pytest.mark.parametrize(("number", "name"), list(enumerate(TEMPLATES)))
def test_no_stroke_is_met_worse_by_more_than_a_pixel(
    number: int, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of cars that no constant was chosen with, drawn with the hand of the tables."""
    made = drawn(bundled(name), 1420 + number, (FRONT_QUARTER, REAR_QUARTER))
    state = car_from_facts(made.marks_file(), {})
    worst = []
    for told in (sharpened, lambda sketch, _: sketch):
        monkeypatch.setattr(pipeline, "sharpened", told)
        body = body_of(state)
        rows = [stroke_distances(body, state.edits, sketch.id) for sketch in state.sketches]
        worst.append(max(px for row in rows for px in row.values()))
    assert worst[0] != worst[1]
    assert worst[0] <= worst[1] + 1.0


def test_a_mark_that_is_dragged_moves_the_body_without_a_leap(car: CarState) -> None:
    """Also where its strokes cease to reach it."""
    sketch = car.sketches[0]
    first = next(e for e in strokes(car) if e.sketch == sketch.id)
    node = first.edges[0].split("-")[0]
    at = next(k for k, mark in enumerate(sketch.marks) if mark.node == node)
    before = None
    for step in range(0, 60, 2):
        mark = sketch.marks[at]
        marks = list(sketch.marks)
        marks[at] = replace(mark, v=mark.v + step)
        there = sharpened(replace(sketch, marks=tuple(marks)), [first]).marks[at]
        place = np.array((there.u, there.v))
        if before is not None:
            assert np.linalg.norm(place - before) < 3.0 * 2.0
        before = place
    assert body_of(car).troubles == ()
