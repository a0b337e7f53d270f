"""The modeler end to end: from strokes by a synthetic pen to exact solids."""

from __future__ import annotations

import itertools
import json

import numpy as np
import pytest

from bozzetto.cli.main import main
from bozzetto.errors import UserError
from bozzetto.geometry import brep_mesh
from bozzetto.ink import Stroke, is_one_view, on_canvas
from bozzetto.plugin import Job
from bozzetto.scene import Points
from bozzetto.testing import Pen, Shell
from bozzetto.view import Camera, turn, with_kind
from bozzetto_polyhedron.model.assign_stroke import new_body, parted
from bozzetto_polyhedron.model.state import Body, Measure, PolyhedronState
from bozzetto_polyhedron.modeler import PolyhedronModeler
from bozzetto_polyhedron.tools.draw_lines import DrawLines
from bozzetto_polyhedron.tools.turn_solid import TurnSolid
from tests.plugins.polyhedron.drawn_bodies import VIEW, fitted, strokes_of
from tests.plugins.polyhedron.objects import OBJECTS, Polyhedron, made
from tests.plugins.polyhedron.write_samples import FOLDER, hidden_edges

POLYHEDRON = "bozzetto.polyhedron"
MODELER = PolyhedronModeler()


def drawn(shell: Shell, name: str, *, turned: bool = True, **options: object) -> np.ndarray:
    """Draw a known body in a new model; return its true vertices."""
    solid = OBJECTS[name]
    vertices = fitted(solid)
    shell.open(POLYHEDRON)
    shell.camera = VIEW
    hidden = hidden_edges(solid, vertices, VIEW)
    shell.draw(*strokes_of(vertices, solid.edges, hidden=hidden, **options))
    if turned:
        shell.run("next-answer")
    return vertices


def report(shell: Shell) -> dict:
    return dict(MODELER.report(shell.state, shell.solve(), Job()))


def sizes(shell: Shell) -> np.ndarray:
    """Return the lengths of all edges, sorted, mm."""
    told = report(shell)
    vertices, edges = np.array(told["vertices"]), np.array(told["edges"])
    return np.sort(np.linalg.norm(vertices[edges[:, 0]] - vertices[edges[:, 1]], axis=1))


def true_sizes(solid: Polyhedron) -> np.ndarray:
    vertices = fitted(solid)[solid.edges]
    return np.sort(np.linalg.norm(vertices[:, 0] - vertices[:, 1], axis=1))


@pytest.mark.parametrize("name", ["box", "L", "house", "stairs"])
def test_steady_drawing_gives_the_solid_that_was_drawn(shell, name):
    drawn(shell, name)
    told = report(shell)
    assert told["closed"]
    assert told["health"] == []
    assert len(told["faces"]) == len(OBJECTS[name].faces)
    assert sizes(shell) == pytest.approx(true_sizes(OBJECTS[name]), rel=0.03)


@pytest.mark.parametrize("name", ["box", "house"])
def test_shaky_drawing_has_planes_to_the_last_digits(shell, name):
    drawn(shell, name, jitter=4.0, seed=7001)
    body = shell.solve().bodies["n1"].body
    for rings, normal, offset in zip(body.faces, body.normals, body.offsets, strict=True):
        corners = body.vertices[[corner for ring in rings for corner in ring]]
        assert np.abs(corners @ normal - offset).max() < 1e-9


def test_what_is_handed_over_is_closed(shell):
    drawn(shell, "L", jitter=3.0, seed=7002)
    (brep,) = shell.shapes().breps
    assert brep.is_closed
    mesh = brep_mesh(brep)
    faces = mesh.faces
    directed = {(int(f[k]), int(f[(k + 1) % 3])) for f in faces for k in range(3)}
    assert len(directed) == 3 * len(faces)
    assert {(b, a) for a, b in directed} == directed


def test_order_and_direction_of_strokes_do_not_matter(shell):
    drawn(shell, "house", jitter=2.0, seed=7003)
    before = sizes(shell)
    solid, vertices = OBJECTS["house"], fitted(OBJECTS["house"])
    strokes = strokes_of(
        vertices, solid.edges, jitter=2.0, seed=7003, hidden=hidden_edges(solid, vertices, VIEW)
    )
    shell.open(POLYHEDRON)
    shuffled = [strokes[k] for k in np.random.default_rng(5).permutation(len(strokes))]
    for stroke in shuffled[:4]:
        shell.draw(stroke)
    shell.draw(*shuffled[4:])
    assert len(shell.state.of_kind(Body)) == 1
    shell.run("next-answer")
    assert sizes(shell) == pytest.approx(before, rel=1e-6)


def test_lines_are_shown_while_one_draws_and_the_solid_after_a_touch(shell):
    vertices = drawn(shell, "box", turned=False)
    assert {"ink", "lines"} <= {layer.name for layer in shell.scene().layers}
    assert shell.state.nodes[0].choice is None
    x, y = VIEW.project(vertices)[0][0]
    shell.tap(x + 6.0, y - 5.0, tool="turn")
    assert shell.state.nodes[0].choice is not None
    names = {layer.name for layer in shell.scene().layers}
    assert "solid" in names
    assert "lines" not in names


def test_a_touch_beside_all_corners_is_refused(shell):
    drawn(shell, "box", turned=False)
    with pytest.raises(UserError, match="no corner here"):
        shell.tap(20.0, 20.0, tool="turn")


def test_next_answer_goes_round_and_is_kept_with_its_shape(shell):
    drawn(shell, "house", jitter=3.0, seed=7004)
    count = len(report(shell)["answers"])
    assert count > 1
    first = report(shell)["vertices"]
    seen = []
    for _ in range(count):
        shell.run("next-answer")
        seen.append(report(shell)["answer"])
    assert sorted(seen) == list(range(1, count + 1))
    assert report(shell)["vertices"] == first


def test_near_and_far_are_exchanged_and_back(shell):
    solid, vertices = OBJECTS["box"], fitted(OBJECTS["box"])
    shell.open(POLYHEDRON)
    shell.camera = VIEW
    shell.draw(*strokes_of(vertices, solid.edges, jitter=1.0, seed=7005))
    shell.run("next-answer")
    before = np.array(report(shell)["vertices"]) @ VIEW.axes[2]
    shell.run("mirrored-answer")
    after = np.array(report(shell)["vertices"]) @ VIEW.axes[2]
    assert np.corrcoef(before, after)[0, 1] < -0.9
    shell.run("mirrored-answer")
    assert np.array(report(shell)["vertices"]) @ VIEW.axes[2] == pytest.approx(before)


def test_answer_is_set_like_any_parameter(shell):
    drawn(shell, "house", jitter=3.0, seed=7006)
    shell.set(answer=2)
    assert report(shell)["answer"] == 2


def test_undo_and_redo_and_a_file_keep_the_solid(shell):
    drawn(shell, "house", jitter=3.0, seed=7007)
    before = report(shell)
    shell.run("right-angles")
    assert report(shell)["vertices"] != before["vertices"]
    shell.undo()
    assert report(shell) == before
    shell.redo()
    shell.undo()
    shell.save()
    shell.reopen()
    assert report(shell) == before


def test_two_bodies_side_by_side(shell):
    shell.open(POLYHEDRON)
    shell.camera = VIEW
    box = OBJECTS["box"]
    for at in ((-55.0, 0.0, 40.0), (60.0, 0.0, 40.0)):
        shell.draw(*strokes_of(fitted(box, 50.0, at), box.edges, jitter=1.0))
        shell.run("next-answer")
    assert len(shell.state.of_kind(Body)) == 2
    assert [entry["closed"] for entry in report(shell)["bodies"]] == [True, True]
    assert len(shell.shapes().breps) == 2


@pytest.mark.parametrize("first", [0, 1])
def test_two_bodies_drawn_beside_one_another_before_either_is_turned(shell, first):
    shell.open(POLYHEDRON)
    shell.camera = VIEW
    box = OBJECTS["box"]
    places = ((-55.0, 0.0, 40.0), (60.0, 0.0, 40.0))
    for at in places:
        shell.draw(*strokes_of(fitted(box, 50.0, at), box.edges, jitter=1.0))
    drawn = shell.state
    assert len(drawn.of_kind(Body)) == 1
    for at in (places[first], places[1 - first]):
        (corner,) = VIEW.project(fitted(box, 50.0, at)[:1])[0]
        shell.tap(*corner, tool="turn")
        assert len(shell.state.of_kind(Body)) == 2
    assert [entry["closed"] for entry in report(shell)["bodies"]] == [True, True]
    sizes = [len(body.strokes) for body in shell.state.of_kind(Body)]
    assert sizes == [len(box.edges)] * 2
    assert len(shell.shapes().breps) == 2
    shell.undo()
    shell.undo()
    assert shell.state == drawn


@pytest.mark.parametrize("seed", range(90_600, 90_612))
def test_a_drawing_with_loops_stays_one_when_it_is_turned(seed: int) -> None:
    solid = made(seed, ("looped",))
    strokes = strokes_of(fitted(solid), solid.edges, jitter=1.0, seed=seed)
    state = new_body(PolyhedronState(), strokes)
    after, body = parted(state, state.of_kind(Body)[0], np.zeros(2))
    assert after is state
    assert len(body.strokes) == len(strokes)


def far_apart(strokes: list[Stroke]) -> list[Stroke]:
    """Return strokes so that each one is drawn as far from all before it as can be."""
    middles = np.array([stroke.points.mean(0) for stroke in strokes])
    order = [int(middles[:, 0].argmin())]
    while len(order) < len(strokes):
        apart = np.linalg.norm(middles[:, None] - middles[order], axis=2).min(1)
        order.append(int(apart.argmax()))
    return [strokes[k] for k in order]


def test_lines_that_begin_far_from_one_another_become_one_drawing(shell):
    box = OBJECTS["box"]
    vertices = fitted(box, 130.0) * (1.7, 1.0, 1.0)
    strokes = far_apart(list(strokes_of(vertices, box.edges)))
    shell.open(POLYHEDRON)
    shell.camera = VIEW
    shell.draw(*strokes[:2])
    assert len(shell.state.of_kind(Body)) == 2
    shell.draw(*strokes[2:])
    assert [len(body.strokes) for body in shell.state.of_kind(Body)] == [12]
    assert report(shell)["closed"]
    shell.undo()
    assert [len(body.strokes) for body in shell.state.of_kind(Body)] == [1, 1]


def test_a_solid_beside_another_drawing_stays_when_a_line_ends_at_it(shell):
    drawn(shell, "box")
    ends = VIEW.project(fitted(OBJECTS["box"]))[0]
    left = ends[ends[:, 0].argmin()]
    low = left - np.array((380.0, 0.0))
    shell.draw(Stroke(*np.linspace(low, low + np.array((0.0, 60.0)), 9).T, VIEW))
    count = len(shell.state.of_kind(Body))
    shell.draw(Stroke(*np.linspace(low, left, 9).T, VIEW))
    assert len(shell.state.of_kind(Body)) == count


def test_missing_edge_is_said_and_drawing_it_closes_the_solid(shell):
    solid, vertices = OBJECTS["box"], fitted(OBJECTS["box"])
    strokes = strokes_of(vertices, solid.edges)
    shell.open(POLYHEDRON)
    shell.camera = VIEW
    shell.draw(*strokes[:-1])
    places = VIEW.project(vertices)[0][solid.edges[-1]]
    told = [entry["place"] for entry in report(shell)["health"]]
    assert len(told) == 2
    for place in places:
        assert np.linalg.norm(np.array(told) - place, axis=1).min() < 8.0
    step = DrawLines().next_step(shell.state)
    assert step.place is not None
    shell.draw(strokes[-1])
    assert report(shell)["health"] == []
    assert report(shell)["closed"]


def test_eraser_takes_a_stroke_before_and_after_the_turn(shell):
    vertices = drawn(shell, "box", turned=False)
    ends = VIEW.project(vertices)[0][OBJECTS["box"].edges[0]]
    rubber = Pen(VIEW, tool="eraser")
    shell.draw(rubber.along(ends))
    assert len(shell.state.nodes[0].strokes) == 11
    shell.undo()
    shell.run("next-answer")
    shell.camera = turn(VIEW, 40.0, 10.0)
    edge = report(shell)["edges"][3]
    seen = shell.camera.project(report(shell)["vertices"])[0][edge]
    shell.draw(Pen(shell.camera, tool="eraser").along(seen))
    assert len(shell.state.nodes[0].strokes) < 12


@pytest.mark.parametrize("turned", [False, True])
def test_eraser_takes_the_line_that_it_crosses_and_no_other(shell, turned):
    vertices = drawn(shell, "box", turned=turned)
    before = shell.state.of_kind(Body)[0].strokes
    places = VIEW.project(vertices)[0][OBJECTS["box"].edges]
    middles = places.mean(1)
    spans = places[:, 1] - places[:, 0]
    lengths = np.linalg.norm(spans, axis=1)
    across = np.column_stack((-spans[:, 1], spans[:, 0])) / lengths[:, None]
    others = np.linalg.norm(middles[:, None] - middles, axis=2) + 1e9 * np.eye(len(middles))
    chosen = int(others.min(1).argmax())
    ends = middles[chosen] + np.outer((-12.0, 12.0), across[chosen])
    shell.draw(Pen(VIEW, tool="eraser").along(ends))
    left = shell.state.of_kind(Body)[0].strokes
    gone = [k for k, stroke in enumerate(before) if stroke not in tuple(left)]
    assert gone == [chosen]
    with pytest.raises(UserError, match="no line under"):
        shell.draw(Pen(VIEW, tool="eraser").along([(5.0, 5.0), (25.0, 5.0)]))


def test_typed_dimension_is_kept_to_the_last_digits(shell):
    vertices = drawn(shell, "box", jitter=3.0, seed=7008)
    ends = VIEW.project(vertices)[0][OBJECTS["box"].edges[0]]
    shell.tap(*(0.4 * ends[0] + 0.6 * ends[1]), tool="dimension")
    (measure,) = shell.state.of_kind(Measure)
    assert measure.length == pytest.approx(true_sizes(OBJECTS["box"])[0], rel=2.0)
    shell.set(length=77.125)
    lengths = sizes(shell)
    assert (np.abs(lengths - 77.125) < 77.125e-12).sum() == 4
    before = len(shell.state.nodes)
    shell.tap(*ends.mean(axis=0), tool="dimension")
    assert len(shell.state.nodes) == before


def test_body_stands_on_the_ground_with_exact_planes(shell):
    drawn(shell, "house", jitter=2.0, seed=7009)
    shell.run("ground")
    vertices = np.array(report(shell)["vertices"])
    assert vertices[:, 2].min() == 0.0
    normals = shell.solve().bodies["n1"].body.normals
    (foot,) = np.flatnonzero(normals[:, 2] == -1.0)
    on_it = report(shell)["faces"][foot][0]
    assert sorted(on_it) == np.flatnonzero(vertices[:, 2] == 0.0).tolist()
    assert (np.abs(normals) == 1.0).any(axis=1).sum() >= 3


def test_a_stroke_after_standing_up_still_finds_its_drawing(shell):
    drawn(shell, "box")
    shell.run("ground")
    body = shell.state.nodes[0]
    shell.camera = body.strokes[0].camera.moved(body.placement)
    shell.draw(Pen(shell.camera).along(body.strokes[0].points))
    assert len(shell.state.of_kind(Body)) == 1
    assert len(shell.state.nodes[0].strokes) == 13


def test_sheet_has_the_walls_of_the_solid(shell):
    drawn(shell, "box")
    shell.set(wall=2.0)
    (solid,) = shell.shapes().solids
    corners = solid.mesh.vertices[solid.mesh.faces].astype(float)
    volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6
    box = true_sizes(OBJECTS["box"])[[0, 4, 8]]
    walls = np.prod(box + 2.0) - np.prod(box - 2.0)
    assert volume == pytest.approx(walls, rel=0.01)


def test_same_ink_gives_the_same_answers_again(shell):
    drawn(shell, "house", jitter=3.0, seed=7010)
    first = report(shell)
    other = MODELER.solve(shell.state, Job())
    assert dict(MODELER.report(shell.state, other, Job())) == first


def test_ink_of_a_resized_window_belongs_to_the_same_drawing(shell):
    solid, vertices = OBJECTS["box"], fitted(OBJECTS["box"])
    shell.open(POLYHEDRON)
    shell.camera = VIEW
    for number, edge in enumerate(solid.edges):
        camera = VIEW if number % 2 else VIEW.with_viewport(800.0, 700.0)
        shell.camera = camera
        shell.draw(strokes_of(vertices, edge[None], camera=camera)[0])
    assert len(shell.state.of_kind(Body)) == 1
    assert report(shell)["closed"]


@pytest.mark.parametrize(
    ("name", "faces", "genus"),
    [("house", 7, 0), ("bracket", 16, 2), ("stairs", 10, 0), ("chair", 12, 0), ("tower", 12, 0)],
)
def test_samples_are_built_headless_into_solids(tmp_path, name, faces, genus):
    told_at, shape_at = tmp_path / "told.json", tmp_path / "shape.stl"
    sample = FOLDER / f"{name}.json"
    asked = ["build", "polyhedron", str(sample), "-o", str(shape_at), "--report", str(told_at)]
    assert main([*asked, "--set", "answer=1"]) == 0
    told = json.loads(told_at.read_text(encoding="utf-8"))
    assert told["closed"]
    assert told["genus"] == genus
    assert len(told["faces"]) == faces
    assert told["health"] == []
    assert told["confidence"] > 0.5
    assert len(told["places"]) == len(told["answers"][0]["vertices"])
    assert told["residual_px"] < told["noise_px"]
    assert shape_at.stat().st_size > 84


@pytest.mark.parametrize("seed", range(4000, 4012))
def test_scribbles_are_solved_or_refused_in_plain_words(shell, seed):
    check_scribble(shell, seed)


@pytest.mark.slow
@pytest.mark.parametrize("block", range(3))
def test_many_scribbles_are_solved_or_refused(shell, block):
    for seed in range(10_000 + 50 * block, 10_050 + 50 * block):
        check_scribble(shell, seed)


def check_scribble(shell: Shell, seed: int) -> None:
    shell.open(POLYHEDRON)
    shell.camera = VIEW if seed % 2 else Camera()
    try:
        shell.draw(*scribble(seed, shell.camera))
        shell.run("next-answer")
    except UserError:
        pass
    told = report(shell)
    json.dumps(told, allow_nan=False)
    shell.scene()
    shell.shapes()


def scribble(seed: int, camera: Camera) -> list[Stroke]:
    """Return ticks, open chains, loops and single lines."""
    rng = np.random.default_rng((23, seed))
    strokes = []
    for _ in range(rng.integers(1, 14)):
        kind = rng.integers(4)
        at = rng.uniform((100, 100), (1100, 800))
        if kind == 0:
            path = at + rng.normal(scale=rng.uniform(3, 250), size=(2, 2))
        elif kind == 1:
            path = at + np.cumsum(rng.normal(scale=40, size=(rng.integers(2, 9), 2)), axis=0)
        elif kind == 2:
            angle = np.linspace(0, rng.uniform(1, 9), 40)
            path = at + rng.uniform(5, 200) * np.stack((np.cos(angle), np.sin(angle)), axis=1)
        else:
            path = at + np.outer(np.linspace(0, 1, 5), rng.normal(scale=300, size=2)).round(-2)
        strokes.append(Pen(camera, tremor=rng.uniform(0, 3), seed=seed).along(path))
    return strokes


@pytest.mark.parametrize(
    "order", [("perspective", "orthographic"), ("orthographic", "perspective")]
)
def test_perspective_switched_while_drawing_leaves_one_drawing(shell, order):
    """The view goes over to parallel on a new sheet, perhaps a few strokes late."""
    solid = OBJECTS["L"]
    vertices = fitted(solid)
    strokes = strokes_of(vertices, solid.edges, hidden=hidden_edges(solid, vertices, VIEW))
    shell.open(POLYHEDRON)
    for kind, part in zip(order, (strokes[:7], strokes[7:]), strict=True):
        shell.camera = with_kind(VIEW, kind)
        shell.draw(*(on_canvas(stroke, shell.camera) for stroke in part))
    (body,) = shell.state.of_kind(Body)
    assert len(body.strokes) == len(strokes)
    assert all(is_one_view(s.camera, with_kind(VIEW, order[1]), 1e-7) for s in body.strokes)
    shell.run("next-answer")
    if order[1] == VIEW.kind:
        assert sizes(shell) == pytest.approx(true_sizes(solid), rel=0.03)


def test_a_new_sheet_is_looked_at_without_perspective_until_a_solid_is_turned(shell):
    seen = with_kind(VIEW, "perspective")
    shell.open(POLYHEDRON)
    advice = MODELER.view_advice(shell.state, seen, Job())
    assert advice.follow
    assert advice.better == with_kind(seen, "orthographic")
    assert MODELER.view_advice(shell.state, advice.better, Job()) is None
    drawn(shell, "box")
    assert MODELER.view_advice(shell.state, seen, Job()) is None


def test_after_the_touch_it_is_told_what_came_of_it(shell):
    """A ring of four lines has answers, but none of them is a solid: corners have too few lines."""
    ring = [(300, 500), (400, 200), (650, 270), (720, 500), (300, 500)]
    shell.open(POLYHEDRON)
    shell.camera = VIEW
    shell.draw(*(Pen(VIEW).along(pair) for pair in itertools.pairwise(ring)))
    shell.run("next-answer")
    step = TurnSolid().next_step(shell.state)
    assert "two lines" in step.sentence
    assert step.place is not None
    drawn(shell, "box")
    assert "Turn the view to see it" in TurnSolid().next_step(shell.state).sentence


def test_marks_of_a_folded_sheet_stay_on_it_when_the_view_turns(shell):
    """Three faces of a house without its hidden edges: its corners of two lines are told of."""
    solid = OBJECTS["house"]
    vertices = fitted(solid)
    shell.open(POLYHEDRON)
    shell.camera = VIEW
    seen = np.delete(solid.edges, hidden_edges(solid, vertices, VIEW), axis=0)
    shell.draw(*strokes_of(vertices, seen))
    shell.run("next-answer")
    (found,) = shell.solve().bodies.values()
    assert found.graph.health
    (layer,) = (one for one in shell.scene().layers if one.name == "findings")
    (marks,) = (item for item in layer.items if isinstance(item, Points))
    corners = found.answer.vertices
    (body,) = shell.state.of_kind(Body)
    there = body.placement.points(corners)
    size = np.ptp(there, axis=0).max()
    gaps = np.linalg.norm(np.asarray(marks.points)[:, None] - there, axis=2).min(axis=1)
    assert gaps.max() < 0.02 * size
    for tool in (TurnSolid(), DrawLines()):
        place = tool.next_step(shell.state).place
        assert place is not None
        assert np.linalg.norm(there - place, axis=1).min() < 0.02 * size
