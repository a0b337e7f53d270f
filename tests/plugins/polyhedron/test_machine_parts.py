"""Machine parts: notches in the middle of edges, several bosses, lines over one another."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto_polyhedron.graph import steps
from bozzetto_polyhedron.graph.live import searched
from bozzetto_polyhedron.reconstruction.answers import answers_of
from bozzetto_polyhedron.solve.line_readings import decided
from tests.plugins.polyhedron.figures_end_to_end import outcome_of
from tests.plugins.polyhedron.graph_truth import is_right as is_right_graph
from tests.plugins.polyhedron.hand import CLEAN, SIZE, strokes_of
from tests.plugins.polyhedron.machine_parts import MACHINE, machine_part
from tests.plugins.polyhedron.objects import (
    CAMERA,
    TO_CANVAS,
    Polyhedron,
    View,
    box,
    graph_of,
    in_eye_frame,
    is_right,
    mesh_of,
    polyhedron_of,
    view,
)
from tests.plugins.polyhedron.untidy_parts import untidy


def seen_part(name: str, seed: int) -> View:
    solid = machine_part(name, seed)
    assert solid is not None
    found = view(solid, seed)
    assert found is not None
    return found


def assert_first_is_right(seen: View, noise: float, seed: int) -> None:
    graph, _ = graph_of(seen, noise, seed, marks=0.0)
    first = answers_of(graph, CAMERA)[0]
    rings = {frozenset(frozenset(ring) for ring in face) for face in first.faces}
    assert rings == seen.solid.face_sets()
    assert is_right(seen, in_eye_frame(first.vertices, CAMERA), noise, mirrored=False)


@pytest.mark.parametrize("name", MACHINE)
def test_every_kind_is_one_solid_with_planar_faces_the_same_each_time(name: str) -> None:
    solid = machine_part(name, 1)
    again = machine_part(name, 1)
    assert solid is not None
    assert again is not None
    assert np.array_equal(solid.vertices, again.vertices)
    assert mesh_of(solid).volume() > 0.0
    sides = sorted(
        tuple(sorted(pair))
        for face in solid.faces
        for ring in face
        for pair in zip(ring, (*ring[1:], ring[0]), strict=True)
    )
    assert sides[::2] == sides[1::2] == sorted(tuple(sorted(each)) for each in solid.edges.tolist())
    size = float(np.linalg.norm(np.ptp(solid.vertices, axis=0)))
    for face in solid.faces:
        corners = solid.vertices[[corner for ring in face for corner in ring]]
        flat = np.linalg.svd(corners - corners.mean(axis=0), compute_uv=False)[-1]
        assert flat < 1e-5 * size


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("name", ["hexagonal shaft with keyway", "wedge with slot"])
def test_a_notch_in_the_middle_of_an_edge_is_turned_the_right_way(name: str, seed: int) -> None:
    assert_first_is_right(seen_part(name, seed), 0.003, seed)


MOSTLY_SEEN = 0.45
"""Share of hidden lines below which bosses are on the near side of their plate."""


def plate_with_bosses(heights: tuple[float, float]) -> Polyhedron:
    """Bosses that are as high as the plate is thick could be holes, but for their marks."""
    made = box((3.4, 2.4, 0.7))
    for x, height in zip((0.4, 1.9), heights, strict=True):
        made += box((0.9, 1.1, height), (x, 0.5, 0.7))
    found = polyhedron_of(made)
    assert found is not None
    return found


@pytest.mark.parametrize("heights", [(0.7, 0.7), (0.9, 0.6), (0.4, 1.0)])
@pytest.mark.parametrize("seed", range(3))
def test_marks_tell_two_bosses_from_holes(heights: tuple[float, float], seed: int) -> None:
    solid = plate_with_bosses(heights)
    shown = [each for k in range(12) if (each := view(solid, k)) is not None]
    seen = [each for each in shown if each.hidden.mean() < MOSTLY_SEEN][seed]
    assert_first_is_right(seen, 0.003, seed)


WITH_SQUARE_ENDS = "hexagonal shaft with square ends", 400
NOTCHED = "hexagonal shaft with keyway", 401

CLOSE = [("octagonal ring", 404), ("t slot nut", 401)]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "seed"), CLOSE)
def test_hidden_lines_that_run_over_one_another_are_told_apart(
    name: str, seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen = seen_part(name, seed)
    edges = [(int(a), int(b)) for a, b in seen.solid.edges]
    hidden = np.flatnonzero(seen.hidden > 0.5).tolist()
    strokes = strokes_of(seen.plane * TO_CANVAS, edges, CLEAN, seed, hidden)
    places = seen.plane * TO_CANVAS * SIZE + 200.0
    assert is_right_graph(searched(strokes).graph, places, edges)
    monkeypatch.setattr(steps, "overlapping", lambda around, key: iter(()))
    assert not is_right_graph(searched(strokes).graph, places, edges)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["hook", "hat profile", "socket head", "boss with hole", "cover"])
def test_strokes_become_the_exact_solid(name: str) -> None:
    found = [
        outcome_of(solid, seed, CLEAN)
        for seed in range(410, 413)
        if (solid := machine_part(name, seed)) is not None
    ]
    right = [each.first for each in found if each is not None]
    assert len(right) >= 1
    assert all(right)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "seed"), [WITH_SQUARE_ENDS, NOTCHED])
def test_shafts_whose_lines_are_not_3_connected_are_right_and_nothing_is_told(
    name: str, seed: int
) -> None:
    """Of the first one segments of two lines were taken for one, and faces were left open."""
    strokes, places, edges = untidy(machine_part(name, seed), seed)
    right = decided(searched(strokes), CAMERA, lambda *_: None).graph
    assert is_right_graph(right, places, edges)
    assert right.health == ()
