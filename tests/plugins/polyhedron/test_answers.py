"""Answers to drawings: what is right, what stays the same, and what must never happen."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from manifold3d import Manifold, Mesh, triangulate

from bozzetto.errors import Cancelled
from bozzetto.view import Camera
from bozzetto_polyhedron.graph.line_graph import LineGraph
from bozzetto_polyhedron.reconstruction.answer import Answer
from bozzetto_polyhedron.reconstruction.answers import answers_of
from tests.plugins.polyhedron.objects import (
    CAMERA,
    OBJECTS,
    SPAN,
    Polyhedron,
    View,
    errors,
    graph_of,
    in_eye_frame,
    is_right,
    made,
    newell,
    perspective_camera,
    prism,
    view,
)


def seen(name: str, seed: int = 1, distance: float | None = None) -> View:
    found = view(OBJECTS[name], seed, distance)
    assert found is not None
    return found


def face_sets(answer: Answer) -> set[frozenset[frozenset[int]]]:
    return {frozenset(frozenset(ring) for ring in face) for face in answer.faces}


def volume(answer: Answer) -> float:
    """The volume inside the faces, triangulated by another library."""
    triangles = []
    for face in answer.faces:
        ids = [corner for ring in face for corner in ring]
        normal = newell(answer.vertices[list(face[0])])
        frame = np.linalg.svd(normal[None])[2][1:]
        if np.linalg.det(np.vstack((frame, normal))) < 0:
            frame = frame[::-1]
        rings = [answer.vertices[list(ring)] @ frame.T for ring in face]
        triangles += [[ids[k] for k in each] for each in np.asarray(triangulate(rings))]
    solid = Manifold(
        Mesh(
            vert_properties=answer.vertices.astype(np.float32),
            tri_verts=np.array(triangles, np.uint32),
        )
    )
    return float(solid.volume())


@pytest.mark.parametrize("name", sorted(OBJECTS))
def test_exact_drawings_are_read_right(name: str) -> None:
    shown = seen(name)
    graph, _ = graph_of(shown, 0.0, 1, marks=0.0)
    answers = answers_of(graph, CAMERA)
    right = [is_right(shown, in_eye_frame(each.vertices, CAMERA), 0.0) for each in answers]
    assert any(right[:3])
    assert face_sets(answers[right.index(True)]) == OBJECTS[name].face_sets()


@pytest.mark.parametrize("name", ["box", "L", "hole", "notch", "five stairs"])
def test_orthogonal_drawings_without_noise_are_exact(name: str) -> None:
    shown = seen(name, 2)
    graph, _ = graph_of(shown, 0.0, 2, marks=0.0)
    first = answers_of(graph, CAMERA)[0]
    distance, angle = errors(shown, in_eye_frame(first.vertices, CAMERA), mirrored=False)
    assert distance < 0.01
    assert angle < 2.0


@pytest.mark.parametrize("name", ["box", "U", "house", "hole"])
def test_faces_run_round_the_outside(name: str) -> None:
    shown = seen(name)
    graph, _ = graph_of(shown, 0.005, 4, marks=0.0)
    for answer in answers_of(graph, CAMERA)[:2]:
        assert answer.closed
        assert volume(answer) > 0.0


@pytest.mark.parametrize("name", ["L", "wedge", "hole"])
def test_vertices_are_seen_at_their_corners(name: str) -> None:
    shown = seen(name)
    graph, _ = graph_of(shown, 0.01, 5)
    for answer in answers_of(graph, CAMERA):
        pixels, depth = CAMERA.project(answer.vertices)
        assert np.abs(pixels - graph.places).max() < 1e-6
        assert answer.residual < 1e-6
        assert abs(depth.mean() - CAMERA.distance) < 1e-6


def test_a_perspective_camera_sees_the_vertices_at_their_corners() -> None:
    shown = seen("L", 3, 2.0)
    camera = perspective_camera(shown)
    graph, _ = graph_of(shown, 0.0, 3)
    first = answers_of(graph, camera)[0]
    assert np.abs(camera.project(first.vertices)[0] - graph.places).max() < 1e-6
    assert is_right(shown, in_eye_frame(first.vertices, camera), 0.0, mirrored=False)


def test_perspective_drawn_by_feel_is_found_and_told() -> None:
    shown = seen("stairs", 3, 1.5)
    graph, _ = graph_of(shown, 0.002, 3)
    first = answers_of(graph, CAMERA)[0]
    assert is_right(shown, in_eye_frame(first.vertices, CAMERA), 0.002, mirrored=False)
    assert any("perspective" in each for each in first.warnings)


def test_unmarked_drawings_are_seen_from_above_and_offer_the_mirrored_one() -> None:
    graph, _ = graph_of(seen("L"), 0.0, 1)
    answers = answers_of(graph, CAMERA)
    first = in_eye_frame(answers[0].vertices, CAMERA)
    away = first[:, 2] - first[:, 2].mean()
    assert is_right(seen("L"), first, 0.0, mirrored=False)
    mirrored = [
        np.abs(in_eye_frame(each.vertices, CAMERA)[:, 2] + away).max() for each in answers[1:]
    ]
    off = [m - abs(in_eye_frame(answers[0].vertices, CAMERA)[:, 2].mean()) for m in mirrored]
    assert min(off) < 1e-6
    assert any("mirrored" in each for each in answers[0].warnings)


@pytest.mark.parametrize("recedes", [(120, 90), (-120, 90), (100, 100), (150, 60), (40, 90)])
def test_a_box_with_a_flat_front_that_recedes_upwards_is_seen_from_above(
    recedes: tuple[int, int],
) -> None:
    """As most people draw a box: its upright lines have no depth, but for the hand's tremor."""
    box = prism(((0, 0), (300, 0), (300, 250), (0, 250)), 1.0, "box")
    far = box.vertices[:, 2] > box.vertices[:, 2].mean()
    plane = box.vertices[:, :2] + far[:, None] * recedes
    plane = (plane - plane.mean(0)) / np.linalg.norm(np.ptp(plane, axis=0))
    for seed in range(5):
        graph, _ = graph_of(View(box, box.vertices, plane), 0.0005 * seed, seed)
        depths = in_eye_frame(answers_of(graph, CAMERA)[0].vertices, CAMERA)[:, 2]
        assert depths[far].mean() > depths[~far].mean(), seed


@pytest.mark.parametrize("turned", [False, True])
def test_marks_decide_the_near_side(turned: bool) -> None:
    shown = seen("L")
    graph, _ = graph_of(shown, 0.0, 1, marks=0.0)
    if turned:
        graph = replace(graph, light=1.0 - graph.light)
    first = in_eye_frame(answers_of(graph, CAMERA)[0].vertices, CAMERA)
    assert is_right(shown, first, 0.0, mirrored=False) != turned


def test_confidence_falls_and_sums_to_one_at_most() -> None:
    for name in ("wedge", "frustum", "house", "hole"):
        graph, _ = graph_of(seen(name), 0.01, 8)
        shares = [each.confidence for each in answers_of(graph, CAMERA)]
        assert sum(shares) <= 1.0 + 1e-9
        assert all(0.0 <= share <= 1.0 for share in shares)
        assert shares[0] == max(shares)


def test_the_same_drawing_gives_the_same_answers() -> None:
    graph, _ = graph_of(seen("house"), 0.01, 2)
    once, again = answers_of(graph, CAMERA), answers_of(graph, CAMERA)
    assert len(once) == len(again)
    for first, second in zip(once, again, strict=True):
        assert np.array_equal(first.vertices, second.vertices)
        assert first.faces == second.faces
        assert first.confidence == second.confidence


@pytest.mark.parametrize("factor", [0.001, 1000.0])
def test_size_does_not_matter(factor: float) -> None:
    graph, _ = graph_of(seen("house"), 0.01, 2)
    large = replace(graph, places=graph.places * factor, noise=graph.noise * factor)
    width, height = CAMERA.viewport
    wide = CAMERA.with_viewport(width * factor, height * factor)
    for one, other in zip(answers_of(graph, CAMERA), answers_of(large, wide), strict=True):
        assert np.allclose(one.vertices, other.vertices, atol=1e-5)


def test_the_order_of_corners_and_lines_does_not_matter() -> None:
    graph, _ = graph_of(seen("U"), 0.005, 2, marks=0.0)
    rng = np.random.default_rng(3)
    moved = rng.permutation(len(graph.places))
    order = rng.permutation(len(graph.lines))
    back = np.argsort(moved)
    mixed = replace(
        graph,
        places=graph.places[moved],
        lines=np.sort(back[graph.lines], axis=1)[order],
        light=graph.light[order],
    )
    one, other = answers_of(graph, CAMERA)[0], answers_of(mixed, CAMERA)[0]
    assert np.allclose(one.vertices[moved], other.vertices, atol=0.05)
    renamed = {
        frozenset(frozenset(int(moved[c]) for c in ring) for ring in face) for face in other.faces
    }
    assert renamed == face_sets(one)


def test_the_camera_turns_the_answer_along() -> None:
    graph, _ = graph_of(seen("L"), 0.005, 2)
    other = Camera(kind="orthographic", eye=(0.0, -300.0, 0.0), height=200.0, viewport=(1200, 900))
    one = CAMERA.view_space(answers_of(graph, CAMERA)[0].vertices)
    two = other.view_space(answers_of(graph, other)[0].vertices)
    assert np.allclose(one - one.mean(0), two - two.mean(0), atol=1e-6)


def test_a_view_without_general_position_is_told() -> None:
    shown = seen("box", 1)
    turned = np.radians(3.0)
    axes = np.array([(1.0, 0.1), (np.cos(turned), np.sin(turned) + 0.1), (0.1, 1.0)])
    solid = shown.solid
    corners = (solid.vertices > solid.vertices.mean(0)).astype(float) * (1.0, 0.8, 0.9)
    places = 600.0 + 300.0 * corners @ axes
    graph, _ = graph_of(shown, 0.0, 1)
    answers = answers_of(replace(graph, places=places, noise=1.0), CAMERA)
    assert answers[0].warnings
    assert np.isfinite(answers[0].vertices).all()


def test_a_checkpoint_may_stop_it() -> None:
    def stop(fraction: float, step: str) -> None:
        raise Cancelled

    graph, _ = graph_of(seen("L"), 0.0, 1)
    with pytest.raises(Cancelled):
        answers_of(graph, CAMERA, checkpoint=stop)


# -- anything that a person may draw --


def graph(
    places: object, lines: object, noise: float = 2.0, light: object | None = None
) -> LineGraph:
    count = len(np.asarray(lines).reshape(-1, 2))
    return LineGraph(
        np.asarray(places, float).reshape(-1, 2),
        np.asarray(lines, np.intp).reshape(-1, 2),
        np.zeros(count) if light is None else np.asarray(light, float),
        tuple((k,) for k in range(count)),
        (),
        noise,
        (),
    )


SQUARE = ((400, 300), (800, 300), (800, 600), (400, 600))
HOSTILE = {
    "nothing": graph((), ()),
    "one corner": graph(((1, 1),), ()),
    "one line": graph(((0, 0), (100, 50)), ((0, 1),)),
    "open chain": graph(((0, 0), (100, 50), (160, 200), (300, 210)), ((0, 1), (1, 2), (2, 3))),
    "triangle": graph(((0, 0), (300, 20), (100, 200)), ((0, 1), (1, 2), (0, 2))),
    "square": graph(SQUARE, ((0, 1), (1, 2), (2, 3), (0, 3))),
    "square with one light side": graph(
        SQUARE, ((0, 1), (1, 2), (2, 3), (0, 3)), light=(1, 0, 0, 0)
    ),
    "all in one place": graph(((5, 5),) * 4, ((0, 1), (1, 2), (2, 3), (0, 3))),
    "all on one line": graph(
        ((0, 0), (100, 0), (200, 0), (300, 0)), ((0, 1), (1, 2), (2, 3), (0, 3))
    ),
    "five joined with all": graph(
        tuple((600 + 200 * np.cos(a), 450 + 200 * np.sin(a)) for a in np.arange(5) * 1.2566),
        tuple((i, j) for i in range(5) for j in range(i + 1, 5)),
    ),
    "two squares": graph(
        (*SQUARE, *((x + 30, y + 300) for x, y in SQUARE)),
        (*((0, 1), (1, 2), (2, 3), (0, 3)), *((4, 5), (5, 6), (6, 7), (4, 7))),
    ),
    "two boxes in a corner": graph(
        (*SQUARE, (900, 200), (500, 200)),
        ((0, 1), (1, 2), (2, 3), (0, 3), (1, 4), (4, 5), (0, 5), (3, 5)),
    ),
    "not a number": graph(((0, 0), (np.nan, 50), (160, np.inf)), ((0, 1), (1, 2), (0, 2))),
    "noise without end": graph(SQUARE, ((0, 1), (1, 2), (2, 3), (0, 3)), noise=np.inf),
    "no noise": graph(SQUARE, ((0, 1), (1, 2), (2, 3), (0, 3)), noise=0.0),
    "wrong numbers": graph(SQUARE, ((0, 1), (1, 9), (2, 2), (0, -3))),
}


@pytest.mark.parametrize("camera", [CAMERA, Camera(viewport=(1200.0, 900.0))])
@pytest.mark.parametrize("name", sorted(HOSTILE))
def test_whatever_is_drawn_is_answered(name: str, camera: Camera) -> None:
    answers = answers_of(HOSTILE[name], camera)
    assert answers
    for each in answers:
        assert each.vertices.shape == (len(HOSTILE[name].places), 3)
        assert np.isfinite(each.vertices).all()
        assert np.isfinite(each.residual)
        assert 0.0 <= each.confidence <= 1.0


def scribble(seed: int) -> LineGraph:
    rng = np.random.default_rng((17, seed))
    count = int(rng.integers(2, 16))
    places = rng.uniform(100, 800, (count, 2))
    lines = rng.integers(0, count, (int(rng.integers(1, 26)), 2))
    return graph(places, lines, float(rng.uniform(0, 20)), rng.uniform(0, 1, len(lines)))


def test_scribbles_are_answered() -> None:
    for seed in range(12):
        for each in answers_of(scribble(seed), CAMERA):
            assert np.isfinite(each.vertices).all()


@pytest.mark.slow
def test_many_scribbles_are_answered() -> None:
    for seed in range(1000, 1250):
        camera = CAMERA if seed % 2 else Camera()
        for each in answers_of(scribble(seed), camera):
            assert np.isfinite(each.vertices).all()
            assert np.isfinite(each.residual)


def test_an_open_box_is_a_sheet() -> None:
    """One line less leaves faces that are planar, and a gap: no face is bent over it."""
    shown = seen("box")
    drawn, _ = graph_of(shown, 0.0, 1)
    less = replace(drawn, lines=drawn.lines[1:], light=drawn.light[1:], strokes=drawn.strokes[1:])
    first = answers_of(less, CAMERA)[0]
    assert not first.closed
    for face in first.faces:
        corners = first.vertices[list(face[0])]
        flat = np.linalg.svd(corners - corners.mean(0), compute_uv=False)
        assert flat[2] < 0.02 * flat[0]


def test_made_solids_are_sound() -> None:
    for seed in range(60):
        solid: Polyhedron = made(5000 + seed)
        ends = np.sort(np.array([e for f in solid.faces for r in f for e in _sides(r)]), axis=1)
        _, counts = np.unique(ends, axis=0, return_counts=True)
        assert (counts == 2).all()
        for face in solid.faces:
            corners = solid.vertices[[corner for ring in face for corner in ring]]
            flat = np.linalg.svd(corners - corners.mean(0), compute_uv=False)
            assert flat[2] < 1e-4 * flat[0]


def _sides(ring: tuple[int, ...]) -> list[tuple[int, int]]:
    return list(zip(ring, (*ring[1:], ring[0]), strict=True))


def test_pixels_of_a_drawing_are_its_diagonals() -> None:
    shown = seen("U")
    graph_, plane = graph_of(shown, 0.0, 1)
    assert np.allclose((graph_.places - (600, 450)) / SPAN * (1, -1), plane)


@pytest.mark.parametrize("seed", [500, 501, 503, 507, 511, 519])
def test_a_right_angled_solid_drawn_without_noise_is_exact(seed: int) -> None:
    kinds = ("rectilinear prism", "stairs", "letter prism", "boxes", "notched box")
    shown = view(made(seed, kinds), seed)
    assert shown is not None
    graph, _ = graph_of(shown, 0.0, seed, 0.0)
    found = answers_of(graph, CAMERA)[0]
    distance, angle = errors(shown, in_eye_frame(found.vertices, CAMERA), mirrored=False)
    assert distance < 1e-9
    assert angle < 1e-4


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_house_drawn_without_noise_is_exact(seed: int) -> None:
    shown = view(OBJECTS["house"], seed)
    assert shown is not None
    graph, _ = graph_of(shown, 0.0, seed, 0.0)
    found = answers_of(graph, CAMERA)[0]
    distance, _ = errors(shown, in_eye_frame(found.vertices, CAMERA), mirrored=False)
    assert distance < 1e-9
