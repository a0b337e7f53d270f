"""Parts of a workshop: what hangs at a smaller part, and lines that could meet otherwise."""

from __future__ import annotations

import itertools
from dataclasses import replace

import pytest

from bozzetto_polyhedron.graph.health import told
from bozzetto_polyhedron.graph.live import searched
from bozzetto_polyhedron.graph.planar_embedding import components, neighbors_of
from bozzetto_polyhedron.reconstruction.answers import answers_of
from bozzetto_polyhedron.reconstruction.drawing import drawing_of
from bozzetto_polyhedron.reconstruction.hanging_parts import hanging_order
from bozzetto_polyhedron.reconstruction.lifting import liftings
from bozzetto_polyhedron.reconstruction.parallel_classes import LOOSE, parallel_classes
from bozzetto_polyhedron.solve.line_readings import decided
from tests.plugins.polyhedron.cad_parts import part
from tests.plugins.polyhedron.graph_truth import is_right as is_right_graph
from tests.plugins.polyhedron.objects import (
    CAMERA,
    View,
    graph_of,
    in_eye_frame,
    is_right,
    view,
)
from tests.plugins.polyhedron.untidy_parts import untidy
from tests.plugins.polyhedron.workshop_parts import workshop_part


def seen_part(name: str, seed: int) -> View:
    solid = workshop_part(name, seed)
    assert solid is not None
    found = view(solid, seed)
    assert found is not None
    return found


@pytest.mark.parametrize("seed", range(3))
def test_a_long_shaft_hangs_at_its_short_head(seed):
    seen = seen_part("hexagonal bolt", seed)
    graph, _ = graph_of(seen, 0.005, seed, marks=0.0)
    first = answers_of(graph, CAMERA)[0]
    rings = {frozenset(frozenset(ring) for ring in face) for face in first.faces}
    assert rings == seen.solid.face_sets()
    assert is_right(seen, in_eye_frame(first.vertices, CAMERA), 0.01, mirrored=False)


@pytest.mark.parametrize("name", ["hexagonal bolt", "block with step hole", "cupboard"])
def test_the_order_in_which_parts_are_found_does_not_matter(name):
    seen = next(each for k in range(9) if (each := view(workshop_part(name, k), k)) is not None)
    drawing = drawing_of(graph_of(seen, 0.0, 1)[0])
    neighbors = neighbors_of(drawing.lines)
    classes = parallel_classes(drawing, LOOSE)
    parts = [liftings(drawing, classes, neighbors, each)[0] for each in components(neighbors)]
    assert len(parts) > 1
    bodies = {hanging_order(drawing, order)[0].corners for order in itertools.permutations(parts)}
    assert len(bodies) == 1


@pytest.mark.slow
def test_the_better_solid_decides_between_lines_that_could_meet_in_two_ways():
    strokes, places, edges = untidy(workshop_part("obelisk", 5133), 5133)
    live = searched(strokes)
    assert [each.what for each in live.graph.health] == ["second reading"]
    assert not is_right_graph(live.graph, places, edges)
    found = decided(live, CAMERA, lambda *_: None)
    assert is_right_graph(found.graph, places, edges)
    assert found.strokes is live.strokes


@pytest.mark.slow
def test_what_is_right_stays_and_a_graph_that_looks_wrong_is_left_alone():
    strokes, places, edges = untidy(part("octagon with boss", 300), 300)
    live = searched(strokes)
    assert is_right_graph(live.graph, places, edges)
    assert is_right_graph(decided(live, CAMERA, lambda *_: None).graph, places, edges)
    for health in ((), (*live.graph.health, told(places[0], "loose end"))):
        other = replace(live, graph=replace(live.graph, health=health))
        found = decided(other, CAMERA, lambda *_: None)
        assert found.draft is other.draft
        assert found.graph.lines is other.graph.lines
        assert found.graph.places is other.graph.places
        assert found.graph.health == health
