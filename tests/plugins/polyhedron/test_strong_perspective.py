"""Oblique solids seen from near: the depths that perspective tells rank the readings."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto_polyhedron.reconstruction.answers import answers_of
from bozzetto_polyhedron.reconstruction.drawing import drawing_of
from bozzetto_polyhedron.reconstruction.perspective import OTHERWISE, ParallelView, parallel_view
from tests.plugins.polyhedron.objects import (
    CAMERA,
    graph_of,
    in_eye_frame,
    is_right,
    made,
    perspective_camera,
    view,
)

SLANTED = ("slanted prism", "slanted step", "tapered", "chamfered")


def drawn(seed: int, distance: float):
    seen = view(made(seed, SLANTED), seed, distance)
    assert seen is not None
    return seen, graph_of(seen, 0.01, seed, 0.1)[0], perspective_camera(seen)


@pytest.mark.parametrize(("seed", "distance"), [(620, 1.2), (620, 2.0), (657, 2.0)])
def test_the_reading_with_the_depths_of_the_perspective_is_first(seed: int, distance: float):
    seen, graph, camera = drawn(seed, distance)
    first = in_eye_frame(answers_of(graph, camera)[0].vertices, camera)
    assert is_right(seen, first, 0.01)


@pytest.mark.parametrize(("seed", "distance"), [(600, 1.2), (601, 2.0)])
def test_axes_of_half_of_the_lines_do_not_bend_the_drawing(seed: int, distance: float):
    _, graph, camera = drawn(seed, distance)
    drawing = drawing_of(graph)
    found = parallel_view(drawing, camera)
    assert found.perspective == 0.0
    assert np.array_equal(found.drawing.points, drawing.points)


@pytest.mark.parametrize(("seed", "distance"), [(34_502, 1.2), (34_503, 2.0), (34_504, 2.0)])
def test_loose_parts_lie_in_faces_where_nothing_but_the_lines_tells_the_perspective(
    seed: int, distance: float
) -> None:
    seen = view(made(seed, ("looped",)), seed, distance)
    assert seen is not None
    graph, _ = graph_of(seen, 0.01, seed, 0.1)
    first = answers_of(graph, CAMERA)[0]
    faces = {frozenset(frozenset(ring) for ring in face) for face in first.faces}
    assert faces == seen.solid.face_sets()
    assert is_right(seen, in_eye_frame(first.vertices, CAMERA), 0.01)


@pytest.fixture
def seen_near() -> ParallelView:
    _, graph, camera = drawn(620, 1.2)
    found = parallel_view(drawing_of(graph), camera)
    assert found.perspective > 0.5
    return found


def test_depths_are_doubted_the_more_the_farther_they_are_from_those_of_the_perspective(
    seen_near: ParallelView,
):
    off = np.random.default_rng(1).normal(0.0, 1.0, len(seen_near.depths))
    doubts = [seen_near.doubt(seen_near.depths + share * off) for share in np.linspace(0, 0.3, 9)]
    assert doubts[0] == 0.0
    assert (np.diff(doubts) > 0.0).all()
    assert doubts[-1] <= OTHERWISE


def test_neither_the_side_nor_the_mean_of_depths_is_doubted(seen_near: ParallelView):
    depths = seen_near.depths + np.linspace(0.0, 0.1, len(seen_near.depths))
    assert seen_near.doubt(-depths) == pytest.approx(seen_near.doubt(depths), abs=1e-12)
    assert seen_near.doubt(depths + 0.7) == pytest.approx(seen_near.doubt(depths), abs=1e-12)


def test_without_perspective_no_depths_are_doubted(seen_near: ParallelView):
    plain = replace(seen_near, perspective=0.0)
    assert plain.doubt(-3.0 * plain.depths) == 0.0
