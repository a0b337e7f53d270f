"""Holes, pockets and bosses, and the light lines that tell them apart."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto_polyhedron.graph.planar_embedding import components, neighbors_of
from bozzetto_polyhedron.reconstruction.answers import answers_of
from bozzetto_polyhedron.reconstruction.drawing import drawing_of
from bozzetto_polyhedron.reconstruction.parallel_classes import parallel_classes
from bozzetto_polyhedron.reconstruction.part_depths import with_own_sides
from bozzetto_polyhedron.reconstruction.visibility import hidden_shares
from tests.plugins.polyhedron.cad_parts import regular
from tests.plugins.polyhedron.machine_parts import tapered
from tests.plugins.polyhedron.objects import (
    CAMERA,
    OBJECTS,
    Polyhedron,
    box,
    graph_of,
    in_eye_frame,
    is_right,
    polyhedron_of,
    view,
)

BLOCK = box((3.0, 2.6, 1.6))

PLATE = box((3.0, 2.6, 0.7))


def looped(kind: str) -> Polyhedron:
    size = (1.3, 1.0)
    solids = {
        "hole": BLOCK - box((*size, 3.0), (0.5, 0.4, -1.0)),
        "pocket": BLOCK - box((*size, 2.0), (0.5, 0.4, 0.7)),
        "boss": BLOCK + box((*size, 0.9), (0.5, 0.4, 1.6)),
        "two holes": BLOCK
        - box((0.7, 1.2, 3.0), (0.4, 0.5, -1.0))
        - box((0.8, 0.9, 3.0), (1.7, 1.2, -1.0)),
        "spool": PLATE + box((1.7, 1.3, 1.5), (0.6, 0.7, 0.7)) + PLATE.translate((0.0, 0.0, 2.2)),
    }
    found = polyhedron_of(solids[kind], kind, 0.04)
    assert found is not None
    return found


@pytest.mark.parametrize("noise", [0.0, 0.005])
@pytest.mark.parametrize(
    "kind",
    ["hole", "pocket", "boss", "two holes", "spool"],
)
def test_light_lines_tell_what_a_loop_is(kind: str, noise: float) -> None:
    shown = view(looped(kind), 4)
    assert shown is not None
    graph, _ = graph_of(shown, noise, 4, marks=0.0)
    first = answers_of(graph, CAMERA)[0]
    assert is_right(shown, in_eye_frame(first.vertices, CAMERA), noise, mirrored=False)
    sets = {frozenset(frozenset(ring) for ring in face) for face in first.faces}
    assert sets == shown.solid.face_sets()
    assert first.closed


def pierced_frustum(seed: int, through: bool) -> Polyhedron:
    """Return a frustum with a square hole or pocket along its axis, which no line of it runs."""
    rng = np.random.default_rng((34, seed))
    width, depth, height = rng.uniform((1.6, 1.4, 1.4), (2.2, 2.0, 2.2))
    share, half = rng.uniform(0.55, 0.75), rng.uniform(0.2, 0.25)
    outline = regular(4, 1.0) * (width, depth)
    low = -1.0 if through else 0.5 * height
    made = tapered(outline, height, share) - box((2.0 * half, 2.0 * half, 9.0), (-half, -half, low))
    found = polyhedron_of(made, "pierced frustum", 0.04)
    assert found is not None
    return found


@pytest.mark.parametrize("through", [True, False])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_what_is_sunk_into_a_frustum_along_its_axis_is_found(seed: int, through: bool) -> None:
    """How steep such a hole is, both faces tell that it ends in; it was a pocket before."""
    shown = view(pierced_frustum(seed, through), seed)
    assert shown is not None
    graph, _ = graph_of(shown, 0.005, seed, marks=0.0)
    first = answers_of(graph, CAMERA)[0]
    sets = {frozenset(frozenset(ring) for ring in face) for face in first.faces}
    assert sets == shown.solid.face_sets()
    assert is_right(shown, in_eye_frame(first.vertices, CAMERA), 0.005, mirrored=False)


def whole_answers(solid: Polyhedron, seed: int, noise: float) -> list[bool]:
    """Whether each of three answers has the faces and the shape of the solid; none without view."""
    shown = view(solid, seed)
    if shown is None:
        return []
    graph, _ = graph_of(shown, noise, seed, marks=0.0)
    return [
        {frozenset(frozenset(ring) for ring in face) for face in each.faces}
        == shown.solid.face_sets()
        and is_right(shown, in_eye_frame(each.vertices, CAMERA), noise, mirrored=False)
        for each in answers_of(graph, CAMERA)[:3]
    ]


@pytest.mark.long
def test_most_frusta_with_holes_are_read_first() -> None:
    """The hole's sides often look parallel to an edge by chance; half were pockets before."""
    every = [whole_answers(pierced_frustum(seed, True), seed, 0.005) for seed in range(300, 312)]
    found = [each for each in every if each]
    assert len(found) >= 8
    assert np.mean([each[0] for each in found]) >= 0.75
    assert np.mean([any(each) for each in found]) >= 0.9


@pytest.mark.parametrize("seed", [1, 5])
def test_sides_that_look_parallel_cost_what_a_chance_is_worth(seed: int) -> None:
    """The ratio of both densities at the angle between sides and the closest edge of the body."""
    shown = view(looped("hole"), seed)
    assert shown is not None
    graph, _ = graph_of(shown, 0.005, seed)
    drawing = drawing_of(graph)
    classes = parallel_classes(drawing)
    parts = components(neighbors_of(drawing.lines))
    body = max(parts, key=lambda part: float(np.ptp(drawing.points[list(part)], axis=0).sum()))
    inner = ~np.isin(drawing.lines[:, 0], body)
    upright = classes.labels == np.bincount(classes.labels[inner]).argmax()
    sides = np.flatnonzero(inner & upright)
    own, cost = with_own_sides(drawing, classes, body, sides)
    spans = [drawing.spans[sides], drawing.spans[upright & ~inner]]
    angles = [0.5 * np.angle(((each @ (1.0, 1.0j)) ** 2).sum()) for each in spans]
    deviation = np.sqrt(
        sum(np.radians(0.7) ** 2 + drawing.noise**2 / (each**2).sum() for each in spans)
    )
    off = (angles[0] - angles[1] + np.pi / 2.0) % np.pi - np.pi / 2.0
    same = np.exp(-0.5 * (off / deviation) ** 2) / (deviation * np.sqrt(2.0 * np.pi))
    assert cost == pytest.approx(max(0.0, float(np.log(same * np.pi))))
    assert len(set(own.labels[sides].tolist())) == 1
    assert not set(own.labels[sides].tolist()) & set(
        own.labels[~np.isin(range(len(upright)), sides)]
    )


def test_without_marks_pocket_and_boss_are_both_offered() -> None:
    for kind in ("pocket", "boss"):
        shown = view(looped(kind), 4)
        assert shown is not None
        graph, _ = graph_of(shown, 0.0, 4)
        answers = answers_of(graph, CAMERA)
        assert any(
            is_right(shown, in_eye_frame(each.vertices, CAMERA), 0.0) for each in answers[:4]
        )


def test_a_loop_beside_the_body_is_told() -> None:
    shown = view(OBJECTS["box"], 1)
    assert shown is not None
    graph, _ = graph_of(shown, 0.0, 1)
    square = np.array([(1000.0, 60.0), (1060.0, 70.0), (1070.0, 130.0), (1010.0, 120.0)])
    lines = np.array([(8, 9), (9, 10), (10, 11), (8, 11)])
    joined = type(graph)(
        np.vstack((graph.places, square)),
        np.vstack((graph.lines, lines)),
        np.zeros(len(graph.lines) + 4),
        (*graph.strokes, (12,), (13,), (14,), (15,)),
        (),
        graph.noise,
        (),
    )
    answers = answers_of(joined, CAMERA)
    assert np.isfinite(answers[0].vertices).all()
    assert any("hangs in no face" in each for each in answers[0].warnings)


@pytest.mark.parametrize("name", ["L", "stairs", "house", "hole", "notch"])
def test_hidden_lines_are_those_behind_triangles(name: str) -> None:
    """The polygons of the faces hide what a ray through triangles says is hidden."""
    shown = view(OBJECTS[name], 3)
    assert shown is not None
    graph, _ = graph_of(shown, 0.0, 3)
    drawing = drawing_of(graph)
    order = np.lexsort(drawing.lines.T[::-1])
    near, far = hidden_shares(drawing, shown.space[:, 2], shown.solid.faces)
    given = np.lexsort(np.sort(shown.solid.edges, axis=1).T[::-1])
    assert np.array_equal(near[order] > 0.5, shown.hidden[given] > 0.5)
    turned, back = hidden_shares(drawing, -shown.space[:, 2], shown.solid.faces)
    assert np.array_equal(turned, far)
    assert np.array_equal(back, near)
