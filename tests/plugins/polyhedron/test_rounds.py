"""Ellipses and arcs in line drawings: what is round, what is not, and what becomes of it."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as some

from bozzetto.errors import UserError
from bozzetto.exchange.mesh.manifold_check import check_solid
from bozzetto.geometry import Solid
from bozzetto.ink import Stroke, Strokes
from bozzetto.plugin import Job
from bozzetto.view import Camera
from bozzetto_polyhedron.drawing_on.circles import polygon_of
from bozzetto_polyhedron.drawing_on.cylinders import brep_with_cylinders, walls_of
from bozzetto_polyhedron.drawing_on.rounded_edges import rounded_end
from bozzetto_polyhedron.graph.line_graph import Finding
from bozzetto_polyhedron.model.state import Body, Choice, PolyhedronState
from bozzetto_polyhedron.modeler import PolyhedronModeler
from bozzetto_polyhedron.reconstruction.answer import Answer
from bozzetto_polyhedron.rounds.ellipses import TURN, Ellipse, ellipse_through, whole_ellipse
from bozzetto_polyhedron.rounds.reading import read
from bozzetto_polyhedron.rounds.straightened import straightened
from bozzetto_polyhedron.solid.exact import exact_body
from bozzetto_polyhedron.solid.face_rings import edges_of
from bozzetto_polyhedron.solid.triangulation import volume_of
from bozzetto_polyhedron.solve.mending import mended
from bozzetto_polyhedron.solve.pipeline import Solved, graph_of_ink, never, solved
from tests.plugins.polyhedron.figures_rounds import fault_of
from tests.plugins.polyhedron.hand import CLEAN, Hand, stroke
from tests.plugins.polyhedron.hand import strokes_of as straight_strokes
from tests.plugins.polyhedron.objects import OBJECTS, TO_CANVAS, view
from tests.plugins.polyhedron.round_parts import PARTS, round_view, strokes_of
from tests.plugins.polyhedron.test_drawing_on_bodies import block
from tests.plugins.polyhedron.test_exact_planes import off_planes
from tests.plugins.polyhedron.true_bodies import prism

CAMERA = Camera(kind="orthographic")
STEADY = Hand(jitter=0.0, wobble=0.0, tremble=0.0)
EXACT = 0.95
"""Share of a union that a drawing without any error has in common with the part: a rim is found by
ink that ends where the hand lifts the pen, and the flat sides of a cylinder are finite."""


def through(strokes, camera: Camera = CAMERA) -> Strokes:
    return Strokes([Stroke(s.x, s.y, camera, pressure=s.pressure, t=s.t) for s in strokes])


def ink_of(name: str, seed: int, hand: Hand = STEADY, *, hidden_rims: bool = True) -> Strokes:
    seen = round_view(name, seed)
    assert seen is not None
    return through(strokes_of(seen, hand, seed, hidden_rims=hidden_rims))


def state_of(strokes, **changes) -> PolyhedronState:
    return PolyhedronState(nodes=(Body(id="a", name="a", strokes=strokes, choice=Choice(),
                                       **changes),))  # fmt: skip


def result_of(strokes, **changes) -> Solved:
    state = state_of(strokes, **changes)
    return solved(state.node("a"), state)


# -- ellipses -------------------------------------------------------------------------------------

AXES = some.tuples(some.floats(20.0, 300.0), some.floats(0.15, 1.0), some.floats(0.0, np.pi))


def ellipse(long: float, ratio: float, turn: float, center=(500.0, 400.0)) -> Ellipse:
    axes = np.array(((np.cos(turn), np.sin(turn)), (-np.sin(turn), np.cos(turn))))
    return Ellipse(np.array(center), axes * np.array(((long,), (ratio * long,))))


@given(AXES, some.floats(0.0, 6.0))
def test_points_of_an_ellipse_give_it_back(axes, begin):
    true = ellipse(*axes)
    points = true.at(begin + np.linspace(0.0, TURN, 90))
    found = ellipse_through(points)
    assert found is not None
    assert np.abs(found.center - true.center).max() < 1e-6 * axes[0]
    assert found.lengths == pytest.approx(np.sort(true.lengths)[::-1], rel=1e-6)
    assert np.abs(found.distances(points)).max() < 1e-6 * axes[0]


@given(AXES, some.integers(3, 6), some.floats(0.0, 6.0))
def test_a_polygon_drawn_in_one_stroke_is_no_clear_ellipse(axes, count, begin):
    corners = ellipse(*axes).at(begin + np.arange(count + 1) * TURN / count)
    sides = [a + (b - a) * np.linspace(0, 1, 30)[:, None]
             for a, b in pairwise(corners)]  # fmt: skip
    assert whole_ellipse([np.concatenate(sides)], "clear") is None


@pytest.mark.parametrize("turns", [1.0, 1.5])
def test_an_ellipse_drawn_over_and_in_two_strokes_is_one(turns):
    true = ellipse(120.0, 0.5, 0.4)
    path = true.at(np.linspace(0.0, TURN * turns, 150))
    for paths in ([path], [path[:80], path[78:]], [path[:80][::-1], path[78:]]):
        found = whole_ellipse(paths, "clear")
        assert found is not None
        assert found.lengths == pytest.approx(true.lengths, rel=1e-3)


def test_half_an_ellipse_is_none():
    assert whole_ellipse([ellipse(120.0, 0.5, 0.4).at(np.linspace(0, np.pi, 60))], "all") is None


# -- drawings of flat faces -----------------------------------------------------------------------


@pytest.mark.parametrize("name", sorted(OBJECTS))
def test_a_drawing_of_flat_faces_goes_on_as_it_was_drawn(name):
    seen = view(OBJECTS[name], 72_000)
    if seen is None:
        pytest.skip("seen from no side")
    edges = [(int(a), int(b)) for a, b in OBJECTS[name].edges]
    hidden = np.flatnonzero(seen.hidden > 0.5).tolist()
    for jitter in (0.01, 0.02):
        ink = Strokes(straight_strokes(seen.plane * TO_CANVAS, edges, replace(CLEAN, jitter=jitter),
                                       72_000, hidden))  # fmt: skip
        found = straightened(ink, "clear")
        assert found.reading is None
        assert found.strokes is ink


# -- what becomes of it ---------------------------------------------------------------------------


@pytest.mark.parametrize("seed", [7201, 7202])
@pytest.mark.parametrize("name", sorted(set(PARTS) - {"slotted link", "four rounded edges"}))
def test_a_part_drawn_without_error_comes_out_exactly(name, seed):
    seen = round_view(name, seed)
    assert seen is not None
    found = result_of(ink_of(name, seed))
    assert fault_of(found, seen, EXACT) == ""
    made = found.changed
    assert made is not None
    assert off_planes(made.body) < 1e-9
    brep = brep_with_cylinders(made.body, made.circles)
    assert brep.is_closed


@pytest.mark.parametrize("name", ["cylinder", "hole in a box", "cylinder on a box"])
def test_order_and_direction_of_strokes_mean_nothing(name):
    ink = list(ink_of(name, 7203, replace(CLEAN, jitter=0.005)))
    rng = np.random.default_rng(7204)
    other = [
        Stroke(s.x[::-1], s.y[::-1], s.camera, pressure=s.pressure[::-1])
        if rng.random() < 0.5
        else s
        for s in (ink[k] for k in rng.permutation(len(ink)))
    ]
    first, second = result_of(Strokes(ink)), result_of(Strokes(other))
    assert first.body is not None
    assert second.body is not None
    size = np.ptp(first.body.vertices)
    assert volume_of(second.body) == pytest.approx(volume_of(first.body), rel=0.02)
    assert len(first.body.faces) == len(second.body.faces)
    assert np.abs(first.body.vertices.mean(0) - second.body.vertices.mean(0)).max() < 0.02 * size


def test_a_cylinder_alone_is_drawn_with_four_strokes():
    """Two ellipses, the hidden half of one left out, and two sides."""
    ink = ink_of("cylinder", 7205, hidden_rims=False)
    assert len(ink) == 4
    found = result_of(ink)
    assert found.changed is not None
    walls, cut = walls_of(found.changed.body, found.changed.circles)
    assert (len(walls), cut) == (1, 0)
    assert found.mesh is not None
    check_solid(Solid(found.mesh))


def test_a_cylinder_has_two_answers_that_are_round():
    """The box about it has others, of which the rims would be no circles."""
    found = result_of(ink_of("cylinder", 7205))
    assert len(found.answers) == 2
    assert found.answers[0].confidence > 0.9


def test_ellipses_are_lines_where_that_is_asked():
    ink = ink_of("hole in a box", 7206)
    assert straightened(ink, "none").strokes is ink
    found = result_of(ink, rounds="none")
    assert [each.what for each in found.graph.health].count("curved stroke") >= 1
    assert found.changed is None or not found.changed.circles


def test_bars_that_lie_flat_have_no_rims():
    body = state_of(ink_of("hole in a box", 7206), moves="flat").node("a")
    assert body.evidence == "none"


def test_a_round_stroke_that_is_not_clear_is_told_and_read_at_a_touch():
    """An egg: round, but as far from an ellipse as a polygon is."""
    ink = list(ink_of("hole in a box", 7207, hidden_rims=False))
    rims = read(ink, "clear").rims
    (number,) = (k for rim in rims if rim.is_whole for k in rim.strokes)
    own = ellipse(95.0, 0.6, 0.3, rims[0].ellipse.center)
    angles = np.linspace(0.0, TURN, 120)
    egg = own.center + (own.at(angles) - own.center) * (1.0 + 0.17 * np.cos(3.0 * angles))[:, None]
    ink[number] = Stroke(*egg.T, ink[number].camera, pressure=np.full(120, 0.8))
    ink = [s for k, s in enumerate(ink) if k not in read(list(ink_of("hole in a box", 7207,
           hidden_rims=False)), "clear").strokes or k == number]  # fmt: skip
    body = state_of(Strokes(ink)).node("a")
    graph = graph_of_ink(body.strokes, body.evidence, never)
    finding = next(each for each in graph.health if each.what == "curved stroke")
    after = mended(body, graph, finding)
    assert after.rounds == "all"
    health = graph_of_ink(after.strokes, after.evidence, never).health
    assert not [each for each in health if each.what == "curved stroke"]


def test_a_curve_that_is_not_round_stays_told():
    ink = list(ink_of("hole in a box", 7208))
    turn = np.linspace(0.0, 4.0, 60)
    curl = 300.0 + 90.0 * np.column_stack((np.cos(turn), np.sin(turn))) * turn[:, None]
    ink.append(Stroke(*curl.T, CAMERA, pressure=np.full(60, 0.8)))
    body = state_of(Strokes(ink)).node("a")
    graph = graph_of_ink(body.strokes, body.evidence, never)
    finding: Finding = next(each for each in graph.health if each.what == "curved stroke")
    with pytest.raises(UserError, match="could not be mended"):
        mended(body, graph, finding)


def test_what_was_round_survives_the_document_and_is_in_the_report():
    modeler = PolyhedronModeler()
    state = state_of(ink_of("cylinder on a box", 7209))
    result = modeler.solve(state, Job())
    report = modeler.report(state, result, Job())
    assert report["round"]["cylinders"] == 1
    assert report["round"]["left_out"] == 0
    assert report["closed"]


@pytest.mark.parametrize("seed", range(7210, 7214))
def test_scribbles_are_read_without_an_exception(seed):
    rng = np.random.default_rng(seed)
    ink = []
    for _ in range(int(rng.integers(3, 14))):
        steps = rng.normal(0.0, 1.0, (40, 2)).cumsum(axis=0) * rng.uniform(1.0, 14.0)
        if rng.random() < 0.5:
            turn = np.linspace(0.0, rng.uniform(2.0, 12.0), 40)
            steps = np.column_stack((np.cos(turn), np.sin(turn))) * rng.uniform(0.0, 150.0, 2)
        ink.append(stroke(steps + rng.uniform(0.0, 600.0, 2), float(rng.uniform(0.1, 1.0))))
    for evidence in ("clear", "all"):
        found = straightened(through(ink), evidence)
        for each in found.strokes:
            assert np.isfinite(each.points).all()
        assert set(found.numbers) <= {-1, *range(len(ink))}
    result = result_of(through(ink), rounds="all")
    assert result.body is None or np.isfinite(result.body.vertices).all()


@pytest.mark.parametrize("points", [[(5, 5)], [(5, 5)] * 30, [(0, 0), (1, 1)] * 8])
def test_dots_and_ink_to_and_fro_are_not_round(points):
    assert read([stroke(np.array(points, float))], "all") is None


# -- round ends -----------------------------------------------------------------------------------


def upright(body, at):
    """Return the upright edge at a place of the ground plan."""
    for one, two in edges_of(body.faces).tolist():
        ends = body.vertices[[one, two]]
        if np.abs(ends[:, :2] - at).max() < 1e-9:
            return one, two
    raise AssertionError("no such edge")


def test_a_round_end_has_the_volume_of_half_a_cylinder():
    """A block of 90 × 70 × 50: the end of 70 loses (2 − π/2) r² of its height."""
    body = block()
    made, arc = rounded_end(body, upright(body, (90, 0)), upright(body, (90, 70)))
    assert off_planes(made) < 1e-9
    assert arc.radius == pytest.approx(35.0, abs=1e-9)
    assert arc.sweep == pytest.approx(np.pi)
    walls, cut = walls_of(made, [arc])
    assert (len(walls), cut) == (1, 0)
    flat = 24 * 0.5 * 35.0**2 * np.sin(np.pi / 24)
    assert volume_of(made) == pytest.approx(50.0 * (90.0 * 70.0 - 2.0 * 35.0**2 + flat), rel=1e-9)
    brep = brep_with_cylinders(made, [arc])
    assert brep.is_closed
    assert sum(face.surface.is_plane for face in brep.faces) == 5


def test_both_ends_are_round():
    body = block()
    made, first = rounded_end(body, upright(body, (90, 0)), upright(body, (90, 70)))
    made, second = rounded_end(made, upright(made, (0, 0)), upright(made, (0, 70)))
    walls, cut = walls_of(made, [first, second])
    assert (len(walls), cut) == (2, 0)
    brep = brep_with_cylinders(made, [first, second])
    assert brep.is_closed
    assert sum(face.surface.is_plane for face in brep.faces) == 4


def test_edges_of_no_square_end_are_refused():
    body = block()
    with pytest.raises(UserError, match="do not bound one face"):
        rounded_end(body, upright(body, (90, 0)), upright(body, (0, 70)))
    vertices, faces, _ = prism([(0, 0), (2, 0), (0, 1.2)], 1.5)
    slanted = exact_body(Answer(vertices, faces, 1.0, 0.0, True), noise=0.0)
    with pytest.raises(UserError, match="not square"):
        rounded_end(slanted, upright(slanted, (2, 0)), upright(slanted, (0, 1.2)))


def test_the_polygon_of_a_rim_has_its_area():
    """The oracle of the flat sides: a circle and its polygon enclose the same."""
    found = result_of(ink_of("cylinder", 7215)).changed
    assert found is not None
    (circle,) = found.circles
    corners = polygon_of(circle) - circle.center
    area = 0.5 * np.linalg.norm(np.cross(corners, np.roll(corners, -1, axis=0)).sum(axis=0))
    assert area == pytest.approx(np.pi * circle.radius**2, rel=1e-9)
