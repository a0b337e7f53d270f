"""The tool that moves: bodies as links, plates or one piece, pulled by the pen."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bozzetto.cli.main import main
from bozzetto.document.model import Document, Model
from bozzetto.document.storage.bozz_file import read_document, write_document
from bozzetto.errors import UserError
from bozzetto.geometry import Placement, brep_mesh
from bozzetto.ink import Drawing, Stroke, Strokes
from bozzetto.plugin import Context, Drag, Ink, Job, Tap
from bozzetto.plugin.host.registry import Registry
from bozzetto.testing import Pen
from bozzetto_polyhedron.commands.motion import at_rest
from bozzetto_polyhedron.mechanism.analysis import mobility_of
from bozzetto_polyhedron.model.fittings import Fitting, Trace
from bozzetto_polyhedron.model.state import PolyhedronState
from bozzetto_polyhedron.modeler import PolyhedronModeler
from bozzetto_polyhedron.solve.moving import moving
from bozzetto_polyhedron.tools.draw_lines import DrawLines
from bozzetto_polyhedron.tools.fittings import DrawHinge
from bozzetto_polyhedron.tools.move import Move
from tests.plugins.polyhedron.drawn_bodies import VIEW, fitted, strokes_of
from tests.plugins.polyhedron.objects import OBJECTS
from tests.plugins.polyhedron.write_samples import FOLDER

MODELER, TOOL = PolyhedronModeler(), Move()
FRAME = 1.0 / 60.0


def box(moves: str, **options: object) -> PolyhedronState:
    solid = OBJECTS["box"]
    strokes = strokes_of(fitted(solid), solid.edges, jitter=1.0, seed=9100)
    state = MODELER.read_drawing(Drawing(Strokes(strokes), VIEW), Context(), Job())
    return replace(state.with_node(replace(state.nodes[0], moves=moves)), **options)


def corners(state: PolyhedronState) -> np.ndarray:
    """Return the corners where they are now, mm."""
    made = moving(state)
    return made.machine.moved(0, made.motion(state.moved))


def pixels(state: PolyhedronState) -> np.ndarray:
    return VIEW.project(corners(state))[0]


def anchored(state: PolyhedronState, *numbers: int) -> PolyhedronState:
    for number in numbers:
        x, y = pixels(state)[number]
        state = TOOL.tap(state, Tap(float(x) + 3.0, float(y) - 2.0, VIEW), Context())
    return state


def pulled(state: PolyhedronState, number: int, way: np.ndarray, seconds: float) -> PolyhedronState:
    start = pixels(state)[number]
    count = int(seconds / FRAME)
    path = start + np.linspace(0.0, 1.0, count + 1)[:, None] * way
    for frame in range(count):
        held = Drag("", Stroke(*path[: frame + 2].T, VIEW))
        state = TOOL.step(state, held, FRAME, Context())
    return state


def lengths(state: PolyhedronState) -> np.ndarray:
    made = moving(state)
    ends = corners(state)[made.machine.shapes[0].edges]
    return np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1)


def test_bars_keep_their_lengths_and_held_corners_their_places():
    state = anchored(box("links"), 0, 1)
    before, rest = lengths(state), corners(state)
    end = pulled(state, 7, np.array([90.0, -40.0]), 0.5)
    assert np.abs(lengths(end) / before - 1.0).max() < 1e-4
    assert corners(end)[[0, 1]] == pytest.approx(rest[[0, 1]], abs=1e-9)
    assert np.linalg.norm(corners(end)[7] - rest[7]) > 5.0


def handed(state: PolyhedronState) -> list[np.ndarray]:
    """Return the corners of every part that files get."""
    parts = MODELER.shapes(state, MODELER.solve(state, Job())).breps
    return [np.array([edge.control_points[k] for edge in p.edges for k in (0, -1)]) for p in parts]


@pytest.mark.parametrize("moves", ["whole", "plates"])
def test_files_get_what_was_moved_where_it_stands(moves):
    state = pulled(anchored(box(moves), 0), 7, np.array([90.0, -40.0]), 0.4)
    rest, now = handed(replace(state, moved=None)), handed(state)
    assert len(rest) == 1
    assert len(now) == (1 if moves == "whole" else 6)
    places = corners(state)
    for points in now:
        away = np.linalg.norm(points[:, None] - places[None], axis=2).min(axis=1)
        assert away.max() < 0.01
    away = np.linalg.norm(rest[0][:, None] - places[None], axis=2).min(axis=1)
    assert away.max() > 1.0


def test_what_is_pulled_comes_to_the_pen():
    state = box("whole", damping=5.0)
    way = np.array([120.0, 30.0])
    start = pixels(state)[3]
    end = pulled(state, 3, way, 0.7)
    assert np.linalg.norm(pixels(end)[3] - start - way) < 12.0
    assert lengths(end) == pytest.approx(lengths(state), rel=1e-9)


def test_a_box_of_hinged_plates_is_rigid_and_open_ones_swing():
    closed = mobility_of(*rigged(box("plates")))
    assert closed.degrees == 6
    assert closed.redundant > 0


def rigged(state: PolyhedronState):
    machine = moving(state).machine
    return machine.assembly, machine.rest


def test_links_of_a_box_can_shear_and_a_fixed_corner_takes_freedoms():
    free = mobility_of(*rigged(box("links"))).degrees
    assert free == 3 * 8 - 12
    assert mobility_of(*rigged(anchored(box("links"), 2))).degrees == free - 3


def test_it_falls_when_it_plays_with_gravity_and_rests_without():
    state = TOOL.step(box("whole"), None, FRAME, Context())
    assert corners(state) == pytest.approx(corners(box("whole")), abs=1e-12)
    falling = box("whole", gravity=True, damping=0.0)
    high = corners(falling)[:, 2]
    for _ in range(6):
        falling = TOOL.step(falling, None, 0.05, Context())
    fallen = 0.5 * 9810.0 * 0.3**2
    assert high - corners(falling)[:, 2] == pytest.approx(np.full(8, fallen), rel=1e-6)


def test_a_held_corner_is_let_go_by_a_second_touch():
    state = anchored(box("links"), 4)
    assert len(state.nodes[0].anchors) == 1
    assert anchored(state, 4).nodes[0].anchors == ()


@pytest.mark.parametrize("moves", ["whole", "links", "plates", "flat"])
def test_a_corner_is_held_where_it_is_and_nothing_goes_back_to_rest(moves):
    state = pulled(anchored(box(moves), 0), 7, np.array([60.0, -40.0]), 0.4)
    before, rest = corners(state), corners(replace(state, moved=None))
    held = anchored(state, 7)
    assert corners(held) == pytest.approx(before, abs=1e-12)
    assert np.linalg.norm(before[7] - rest[7]) > 1.0
    for _ in range(20):
        held = TOOL.step(held, None, FRAME, Context())
    assert corners(held)[[0, 7]] == pytest.approx(before[[0, 7]], abs=1e-3)
    again = at_rest(held, Context())
    assert corners(again) == pytest.approx(rest, abs=1e-12)
    moved = pulled(again, 3, np.array([40.0, 10.0]), 0.2)
    assert corners(moved)[7] == pytest.approx(rest[7], abs=1e-3)


def test_what_is_held_elsewhere_is_kept_by_a_document(tmp_path):
    state = anchored(pulled(anchored(box("whole"), 0), 7, np.array([60.0, -40.0]), 0.2), 7)
    path = tmp_path / "held.bozz"
    model = Model("m1", "Held", MODELER.id, state, state_version=MODELER.state_version)
    write_document(Document((model,)), path)
    again = read_document(path, Registry())[0].model("m1").state
    assert corners(again) == pytest.approx(corners(state), abs=0.0)
    assert again.nodes[0].anchors == state.nodes[0].anchors


def test_held_corners_of_the_first_version_are_found_by_their_place():
    body = box("links").nodes[0]
    stored = {"nodes": [{"$type": "Body", "id": body.id, "anchors": [[3.0, 4.0]]}, {"id": "n2"}]}
    node, other = MODELER.upgrade(stored, 1)["nodes"]
    assert node["anchors"] == [{"spot": {"body": body.id, "corner": [3.0, 4.0]}}]
    assert other == {"id": "n2"}
    assert MODELER.upgrade(stored, 2) is stored


def test_pulling_at_nothing_or_at_a_held_corner_is_refused():
    state = anchored(box("links"), 0)
    with pytest.raises(UserError, match="is held"):
        pulled(state, 0, np.array([50.0, 0.0]), 0.1)
    with pytest.raises(UserError, match="no corner here"):
        TOOL.step(state, Drag("", Pen(VIEW).along([(5, 5), (9, 9)])), FRAME, Context())
    with pytest.raises(UserError, match="nothing to move"):
        TOOL.step(PolyhedronState(), None, FRAME, Context())


def test_steps_are_the_same_again_and_are_kept_in_a_file(shell):
    state = anchored(box("links"), 0)
    ends = [pulled(state, 6, np.array([60.0, 0.0]), 0.2) for _ in range(2)]
    assert (corners(ends[0]) == corners(ends[1])).all()
    scene = MODELER.scene(ends[0], MODELER.solve(ends[0], Job(quality="preview")))
    assert {"solid", "anchors"} <= {layer.name for layer in scene.layers}


def test_all_of_it_can_be_put_back(shell):
    solid = OBJECTS["box"]
    shell.open("bozzetto.polyhedron")
    shell.camera = VIEW
    shell.draw(*strokes_of(fitted(solid), solid.edges, jitter=1.0, seed=9100))
    shell.run("next-answer")
    rest = corners(shell.state)
    shell.set(moves="links")
    moved = pulled(shell.state, 2, np.array([40.0, 40.0]), 0.2)
    assert np.abs(corners(moved) - rest).max() > 1.0
    (command,) = (c for c in MODELER.commands() if c.id == "rest")
    assert command.enabled(moved)
    assert corners(command.run(moved, Context())) == pytest.approx(rest)


def test_freedoms_and_gaps_are_reported():
    state = pulled(anchored(box("links"), 0, 1), 7, np.array([30.0, 0.0]), 0.1)
    told = MODELER.report(state, MODELER.solve(state, Job()), Job())["mechanism"]
    assert told["pieces"] == 8
    assert told["freedoms"] == 3 * 6 - 11
    assert told["joint_gap_mm"] < 1e-2


def held_at(state: PolyhedronState, number: int, pressure: list[float], **keys: bool) -> Drag:
    start = np.tile(pixels(state)[number], (len(pressure), 1))
    return Drag("", Stroke(*start.T, VIEW, pressure=np.array(pressure)), **keys)


def depth(state: PolyhedronState, number: int) -> float:
    """Return how far a corner is from the eye, mm."""
    return float(corners(state)[number] @ np.asarray(VIEW.axes[2]))


def test_pressing_pulls_away_from_the_eye_and_so_does_shift():
    state = box("whole", damping=5.0)
    before = depth(state, 3)
    ends = {}
    for way, pressure, keys in (
        ("even", [0.5] * 30, {}),
        ("firm", [0.4] * 6 + [0.9] * 24, {}),
        ("soft", [0.9] * 6 + [0.4] * 24, {}),
        ("shift", [0.5] * 30, {"shift": True}),
        ("ctrl", [0.5] * 30, {"ctrl": True}),
    ):
        moved = state
        for _ in range(30):
            moved = TOOL.step(moved, held_at(state, 3, pressure, **keys), FRAME, Context())
        ends[way] = depth(moved, 3) - before
    assert abs(ends["even"]) < 1e-6
    assert min(ends["firm"], ends["shift"]) > 5.0
    assert max(ends["soft"], ends["ctrl"]) < -5.0


def hinged(state: PolyhedronState, one: int, other: int, **how: object) -> PolyhedronState:
    """Return a state with a hinge drawn from one corner to another."""
    ends = pixels(state)[[one, other]]
    path = np.linspace(ends[0] + 2.0, ends[1] - 2.0, 30)
    state = DrawHinge().draw(state, Ink((Stroke(*path.T, VIEW),)), Context())
    return state.with_node(replace(state.node(state.selected), **how))


def test_a_box_turns_about_an_edge_like_a_door():
    state = box("whole", damping=0.0)
    edges = moving(state).machine.shapes[0].edges
    one, other = (int(k) for k in edges[0])
    free = hinged(state, one, other)
    assert mobility_of(*rigged(free)).degrees == 1
    driven = hinged(state, one, other, drive="steady", speed=90.0)
    assert mobility_of(*rigged(driven)).degrees == 0
    rest = corners(driven)
    for _ in range(60):
        driven = TOOL.step(driven, None, FRAME, Context())
    now = corners(driven)
    assert now[[one, other]] == pytest.approx(rest[[one, other]], abs=1e-3)
    axis = (rest[other] - rest[one]) / np.linalg.norm(rest[other] - rest[one])
    turn = Rotation.from_rotvec(np.radians(90.0) * axis)
    assert now - rest[one] == pytest.approx(turn.apply(rest - rest[one]), abs=1e-2)


def test_what_is_handed_over_is_where_it_was_moved_to():
    state = box("whole", gravity=True, damping=0.0)
    state = TOOL.step(state, None, 0.05, Context())
    (brep,) = MODELER.shapes(state, MODELER.solve(state, Job())).breps
    vertices = brep_mesh(brep).vertices
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    assert low == pytest.approx(corners(state).min(axis=0), abs=1e-4)
    assert high == pytest.approx(corners(state).max(axis=0), abs=1e-4)
    plates = replace(state, moved=None)
    plates = plates.with_node(replace(plates.nodes[0], moves="plates"))
    plates = TOOL.step(plates, None, 0.05, Context())
    assert len(MODELER.shapes(plates, MODELER.solve(plates, Job())).breps) == 6


def test_a_drawn_box_weighs_what_its_volume_does_and_lands_on_the_ground():
    state = box("whole", gravity=True, ground=True, damping=0.5)
    placed = replace(state.nodes[0], placement=Placement(offset=(0.0, 0.0, 60.0)), density=700.0)
    state = state.with_node(placed)
    size = np.sort(
        np.linalg.norm(
            np.diff(corners(state)[moving(state).machine.shapes[0].edges], axis=1), axis=2
        )[:, 0]
    )
    mass = moving(state).machine.assembly.masses.sum()
    assert mass == pytest.approx(700.0 * size[0] * size[5] * size[11] * 1e-9, rel=1e-6)
    for _ in range(90):
        state = TOOL.step(state, None, FRAME, Context())
    assert np.sort(corners(state)[:, 2])[:4] == pytest.approx(np.zeros(4), abs=1e-3)
    assert np.abs(state.moved.velocities).max() < 1e-4


@pytest.mark.parametrize("name", ["four-bar", "walker", "scissor-lift"])
def test_bars_that_move_are_no_solid_to_be_mended(tmp_path, name):
    """The foot of a walker is a corner of two lines, and right."""
    path = tmp_path / "bars.bozz"
    assert main(["build", "polyhedron", str(FOLDER / f"{name}.json"), "-o", str(path)]) == 0
    state = read_document(path, Registry())[0].models[0].state
    names = {layer.name for layer in MODELER.scene(state, MODELER.solve(state, Job())).layers}
    assert {"lines", "fittings"} <= names
    assert "findings" not in names
    assert DrawLines().next_step(replace(state, selected="")).tool == Move.id
    alone = replace(
        state, nodes=tuple(n for n in state.nodes if not isinstance(n, Fitting | Trace))
    )
    bare = replace(alone, nodes=tuple(replace(body, anchors=()) for body in alone.nodes))
    for moves, told in (("flat", False), ("whole", True)):
        drawn = replace(bare, nodes=tuple(replace(body, moves=moves) for body in bare.nodes))
        result = MODELER.solve(drawn, Job())
        names = {layer.name for layer in MODELER.scene(drawn, result).layers}
        assert ("findings" in names) is told
        for entry in MODELER.report(drawn, result, Job())["bodies"]:
            assert {"closed" in entry, "answers" in entry} == {told}
