"""Bodies of other objects as bodies of a mechanism: joined, held, pulled, and exchanged."""

from __future__ import annotations

import json
import struct
from dataclasses import replace

import numpy as np
import pytest
from manifold3d import Manifold

from bozzetto.cli.main import main
from bozzetto.document.links import resolved
from bozzetto.document.model import Document
from bozzetto.errors import UserError
from bozzetto.exchange.mesh.manifold_check import check_solid
from bozzetto.geometry import Curve, FaceGroup, Mesh, Placement, Shapes, Solid, Surface
from bozzetto.ink import Stroke
from bozzetto.parameters import idle_parameters, valued_fields
from bozzetto.plugin import Context, Drag, Ink, Job, Tap
from bozzetto.scene import Shaded
from bozzetto.testing import Shell
from bozzetto.view import Camera
from bozzetto_polyhedron.commands.pieces import put_together, take_apart
from bozzetto_polyhedron.model.fittings import Hinge
from bozzetto_polyhedron.model.followed import Followed
from bozzetto_polyhedron.modeler import PolyhedronModeler
from bozzetto_polyhedron.solve.followed_pieces import divided, is_closed
from bozzetto_polyhedron.solve.moving import moving
from bozzetto_polyhedron.tools.draw_lines import DrawLines
from bozzetto_polyhedron.tools.fittings import DrawHinge
from bozzetto_polyhedron.tools.move import Move
from bozzetto_polyhedron.tools.pieces import FreePiece
from tests.plugins.polyhedron.drawn_bodies import VIEW, fitted, strokes_of
from tests.plugins.polyhedron.objects import OBJECTS
from tests.plugins.polyhedron.solid_pieces import mesh_of

MODELER = PolyhedronModeler()
FRAME = 1.0 / 60.0

FRONT = Camera(
    kind="orthographic",
    eye=(0.0, -500.0, 40.0),
    target=(0.0, 0.0, 40.0),
    height=300.0,
    viewport=(900.0, 600.0),
)

BODY = Solid(mesh_of(Manifold.cube((100, 30, 20)).translate((-50, -15, 40))), "body")
LEG = Solid(mesh_of(Manifold.cylinder(45, 6, 6, 24).translate((-30, 0, 0))), "leg")
GIVEN = {"one": Shapes(solids=(BODY,)), "two": Shapes(solids=(LEG,))}


def at(x: float, y: float, z: float) -> np.ndarray:
    return FRONT.project(np.array([[x, y, z]]))[0][0]


def stroke(begin: np.ndarray, end: np.ndarray) -> Stroke:
    places = begin + np.linspace(0.0, 1.0, 20)[:, None] * (end - begin)
    return Stroke(places[:, 0], places[:, 1], FRONT)


def hinged():
    """The leg hinged to the body where both meet, by a stroke across it, seen from the front."""
    state = MODELER.follow(GIVEN)
    begin, end = at(-35.0, 0.0, 44.0), at(-25.0, 0.0, 44.0)
    return DrawHinge().draw(state, Ink((stroke(begin, end),)), Context(sources=GIVEN))


def test_parts_of_other_objects_are_bodies_with_the_mass_of_their_volume():
    state = MODELER.follow(GIVEN)
    assert [part.solid for part in state.of_kind(Followed)] == ["body", "leg"]
    assert MODELER.sources(state) == ("one", "two")
    masses = moving(state, GIVEN).machine.assembly.masses
    assert masses[0] == pytest.approx(1240.0 * 100 * 30 * 20 * 1e-9, rel=1e-5)
    assert moving(state).numbers == {}


def test_the_next_step_leads_from_another_object_to_a_mechanism():
    whole = MODELER.follow({"one": GIVEN["one"]})
    assert DrawLines().next_step(whole).tool == FreePiece.id
    assert DrawLines().next_step(MODELER.follow(GIVEN)).tool == DrawHinge.id
    assert DrawLines().next_step(hinged()).tool == Move.id


def test_what_has_no_surface_is_refused_and_an_open_one_weighs_like_a_sheet():
    with pytest.raises(UserError, match="no solid"):
        MODELER.follow({"line": Shapes(curves=(Curve(1, [0, 0, 1, 1], [[0, 0, 0], [9, 0, 0]]),))})
    open_box = BODY.mesh.faces[:-2]
    given = {"one": Shapes(surfaces=(Surface(replace(BODY.mesh, faces=open_box), "shell"),))}
    mass = moving(MODELER.follow(given), given).machine.assembly.masses[0]
    assert mass == pytest.approx(1240.0 * 2.0 * 1e-9 * (11200 - mass_less(open_box)), rel=1e-4)


def mass_less(faces: np.ndarray) -> float:
    """Return the area that is missing in the box, mm²."""
    left = BODY.mesh.faces[len(faces) :]
    a, b, c = (np.asarray(BODY.mesh.vertices, float)[left[:, k]] for k in range(3))
    return float(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())


def test_a_hinge_is_drawn_on_them_and_holds_both_together():
    state = hinged()
    (hinge,) = state.of_kind(Hinge)
    first, second = (part.id for part in state.of_kind(Followed))
    assert {hinge.begin.body, hinge.second} == {first, second}
    state = replace(state, gravity=True, ground=True)
    state = Move().tap(state, Tap(*at(49.0, -15.0, 59.0), FRONT), Context(sources=GIVEN))
    start = moving(state, GIVEN)
    for _ in range(60):
        state = Move().step(state, None, FRAME, Context(sources=GIVEN))
    made = moving(state, GIVEN)
    assert made is start
    motion = made.motion(state.moved)
    assert made.stepper.largest_gap(motion) < 1e-5
    assert len(state.node(first).anchors) == 1
    held = state.node(first).anchors[0].spot.point
    number = made.numbers[first]
    vertices = made.machine.shapes[number].vertices
    kept = int(np.argmin(np.linalg.norm(vertices - held, axis=1)))
    assert made.machine.moved(number, motion)[kept] == pytest.approx(vertices[kept], abs=1e-3)


def test_files_and_scene_get_them_where_they_are():
    state = replace(MODELER.follow({"two": GIVEN["two"]}), gravity=True)
    given = {"two": GIVEN["two"]}
    for _ in range(6):
        state = Move().step(state, None, FRAME, Context(sources=given))
    result = MODELER.solve(state, Job(sources=given))
    (solid,) = MODELER.shapes(state, result).solids
    fallen = float(LEG.mesh.vertices[:, 2].min() - solid.mesh.vertices[:, 2].min())
    assert fallen == pytest.approx(0.5 * 9810 * 0.1**2, rel=0.25)
    shown = next(layer for layer in MODELER.scene(state, result).layers if layer.name == "solid")
    assert shown.items[0].mesh.vertices == pytest.approx(solid.mesh.vertices, abs=1e-4)
    assert MODELER.report(state, result, Job())["mechanism"]["pieces"] == 1
    gone = MODELER.solve(state, Job(sources={"two": Shapes(curves=())}))
    assert "no part" in MODELER.cautions(state, gone)[0].message


RED, BLUE = (200, 30, 20), (10, 60, 220)


def test_bodies_keep_the_colours_and_the_normals_of_what_they_follow():
    body, arm = (
        Manifold.cube((50, 30, 30)).translate((-50, -15, 0)),
        Manifold.cube((60, 10, 10)).translate((-10, -5, 10)),
    )
    mesh = mesh_of(body + arm)
    inside = np.asarray(mesh.vertices)[mesh.faces][:, :, 0].max(axis=1) > 1.0
    order = np.argsort(inside, kind="stable")
    normals = np.tile(np.float32([0.0, 0.6, 0.8]), (len(mesh.vertices), 1))
    mesh = replace(mesh, faces=mesh.faces[order], normals=normals)
    groups = (
        FaceGroup("body", int((~inside).sum()), RED),
        FaceGroup("arm", int(inside.sum()), BLUE),
    )
    sources = {"one": Shapes(solids=(Solid(mesh, "toy", groups=groups),))}
    whole = MODELER.follow(sources)
    apart = take_apart(whole, Context(sources=sources))
    for state in (whole, apart):
        result = MODELER.solve(state, Job(sources=sources))
        solids = MODELER.shapes(state, result).solids
        told = [[group.color for group in solid.groups] or [solid.color] for solid in solids]
        assert told == ([[RED, BLUE]] if state is whole else [[RED], [BLUE]])
        shown = [item for layer in MODELER.scene(state, result).layers for item in layer.items
                 if isinstance(item, Shaded)]  # fmt: skip
        assert {item.color for item in shown} == {RED, BLUE}
        areas = {item.color: len(item.mesh.faces) for item in shown}
        assert areas[RED] >= groups[0].count
        assert areas[BLUE] >= groups[1].count
        for solid in solids:
            check_solid(solid)
            of_cut = np.abs(solid.mesh.normals - np.float32([0.0, 0.6, 0.8])).max(axis=1) > 1e-6
            assert of_cut.sum() == (state is apart)
            np.testing.assert_allclose(np.abs(solid.mesh.normals[of_cut, 0]), 1.0, atol=1e-6)


def test_painted_vertices_keep_their_paint_where_pieces_part():
    paint = np.zeros((len(BODY.mesh.vertices), 4), np.uint8)
    paint[:] = np.where(np.asarray(BODY.mesh.vertices)[:, :1] > 0, (*RED, 255), (*BLUE, 255))
    painted = Solid(replace(BODY.mesh, colors=paint), "body")
    sources = {"one": Shapes(solids=(painted, replace(LEG, color=RED)))}
    state = MODELER.follow(sources)
    result = MODELER.solve(state, Job(sources=sources))
    body, leg = MODELER.shapes(state, result).solids
    np.testing.assert_array_equal(body.mesh.colors, paint)
    assert (leg.color, leg.groups) == (RED, ())
    shown = [item for layer in MODELER.scene(state, result).layers for item in layer.items
             if isinstance(item, Shaded)]  # fmt: skip
    assert [item.color for item in shown if item.mesh.colors is None] == [RED]


def test_pulling_takes_hold_of_a_followed_body():
    given = {"one": GIVEN["one"]}
    state = replace(MODELER.follow(given), damping=5.0)
    start = at(49.0, -15.0, 59.0)
    for frame in range(30):
        path = stroke(start, start + np.array((2.0 * frame + 1.0, 0.0)))
        state = Move().step(state, Drag("", path), FRAME, Context(sources=given))
    moved = state.moved.places[0] - moving(state, given).machine.rest.places[0]
    assert moved[0] > 0.01


@pytest.fixture
def linked(shell: Shell) -> Shell:
    """A drawn box, and a mechanism that follows it."""
    solid = OBJECTS["box"]
    shell.open("bozzetto.polyhedron")
    shell.camera = VIEW
    shell.draw(*strokes_of(fitted(solid), solid.edges, jitter=0.5, seed=9500))
    shell.run("next-answer")
    shell.use("bozzetto.polyhedron")
    return shell


def corners_of(shapes: Shapes) -> np.ndarray:
    """Return both ends of all edges."""
    (brep,) = shapes.breps
    return np.concatenate([edge.control_points for edge in brep.edges])


def test_tools_are_given_what_the_model_was_made_from(linked):
    context = linked.context()
    (source,) = linked.model.sources
    assert list(context.sources) == [source]
    own = linked.workbench.own_shapes(linked.document.model(source), Job())
    assert corners_of(context.sources[source]) == pytest.approx(corners_of(own), abs=0.0)
    assert linked.context().sources[source] is context.sources[source]
    linked.workbench.forget_results()
    assert linked.workbench.given_sources(linked.model) == {}


def test_sources_are_in_the_frame_of_the_model(linked):
    (source,) = linked.model.sources
    moved = replace(linked.document.model(source), placement=Placement(offset=(7.0, 0.0, 0.0)))
    document = Document((moved, linked.document.model(linked.model.id)))
    model = resolved(document)[linked.model.id]
    before = linked.context().sources[source]
    linked.workbench.solve(model, Job())
    after = linked.workbench.given_sources(model)[source]
    assert corners_of(after) - corners_of(before) == pytest.approx(
        np.tile([7.0, 0.0, 0.0], (24, 1)), abs=1e-9
    )


ARM = Manifold.cylinder(60, 6, 6, 32).rotate((0, 90, 0)).translate((45, 0, 50))
TRUNK = Manifold.cube((100, 30, 20)).translate((-50, -15, 40))


def in_groups(whole: Manifold, *names: str) -> Solid:
    """One solid whose triangles are grouped by the body that they were of."""
    mesh = whole.to_mesh()
    runs = np.diff(np.asarray(mesh.run_index)) // 3
    groups = tuple(FaceGroup(n, int(k)) for n, k in zip(names, runs, strict=True))
    return Solid(mesh_of(whole), "creature", groups=groups)


CREATURE = in_groups(TRUNK.as_original() + ARM.as_original(), "trunk", "arm")
ONE = {"one": Shapes(solids=(CREATURE,))}


def masses_of(state, given) -> dict[str, float]:
    made = moving(state, given)
    return {
        state.node(k).name: float(made.machine.assembly.masses[made.machine.holders[n][0]])
        for k, n in made.numbers.items()
    }


def test_a_touch_frees_a_piece_and_another_one_takes_it_back():
    state = MODELER.follow(ONE)
    whole = masses_of(state, ONE)
    (name,) = whole
    tap = Tap(*at(90.0, -6.0, 50.0), FRONT)
    state = FreePiece().tap(state, tap, Context(sources=ONE))
    masses = masses_of(state, ONE)
    assert [each[:3] for each in masses] == [name[:3], "arm"]
    assert sum(masses.values()) == pytest.approx(whole[name], rel=1e-6)
    assert masses["arm"] == pytest.approx(1240e-9 * 55 * np.pi * 36 * 0.994, rel=2e-3)
    assert all(shape.solid for shape in moving(state, ONE).machine.shapes)
    state = FreePiece().tap(state, tap, Context(sources=ONE))
    assert masses_of(state, ONE) == whole


def test_a_free_arm_swings_on_a_hinge_that_is_drawn_on_it():
    state = MODELER.follow(ONE)
    state = take_apart(state, Context(sources=ONE))
    trunk, arm = (part.id for part in state.of_kind(Followed))
    across = stroke(at(52.0, -6.0, 44.5), at(52.0, -6.0, 55.5))
    state = DrawHinge().draw(state, Ink((across,)), Context(sources=ONE))
    (hinge,) = state.of_kind(Hinge)
    assert {hinge.begin.body, hinge.second} == {trunk, arm}
    state = with_steady_motor(state)
    state = Move().tap(state, Tap(*at(-49.0, -15.0, 59.0), FRONT), Context(sources=ONE))
    for _ in range(60):
        state = Move().step(state, None, FRAME, Context(sources=ONE))
    made = moving(state, ONE)
    motion = made.motion(state.moved)
    assert made.stepper.largest_gap(motion) < 1e-5
    turns = motion.turns[[int(made.machine.holders[made.numbers[k]][0]) for k in (trunk, arm)]]
    angle = np.degrees(np.arccos((np.trace(turns[0].T @ turns[1]) - 1.0) / 2.0))
    assert angle == pytest.approx(90.0, abs=1.0)
    gone = FreePiece().tap(
        replace(state, moved=None), Tap(*at(90.0, -6.0, 50.0), FRONT), Context(sources=ONE)
    )
    assert not gone.of_kind(Hinge)


@pytest.mark.parametrize("drive", ["no", "steady", "swing"])
def test_numbers_of_another_motor_change_nothing(drive):
    def turns(**values):
        (hinge,) = hinged().of_kind(Hinge)
        hinge = replace(hinge, drive=drive, **values)
        state = replace(hinged().with_node(hinge), gravity=True)
        for _ in range(6):
            state = Move().step(state, None, FRAME, Context(sources=GIVEN))
        return moving(state, GIVEN).motion(state.moved).turns.tobytes()

    idle = idle_parameters(valued_fields(Hinge(drive=drive)))
    for name, value in {"speed": 200.0, "angle": 75.0, "period": 0.7}.items():
        assert (turns() == turns(**{name: value})) == (name in idle)


def test_an_axis_that_sticks_out_of_a_limb_runs_through_its_middle():
    state = take_apart(MODELER.follow(ONE), Context(sources=ONE))
    trunk, arm = (part.id for part in state.of_kind(Followed))
    across = stroke(at(52.0, 0.0, 20.0), at(52.0, 0.0, 80.0))
    state = DrawHinge().draw(state, Ink((across,)), Context(sources=ONE))
    (hinge,) = state.of_kind(Hinge)
    assert {hinge.begin.body, hinge.second} == {trunk, arm}
    ends = np.array([hinge.begin.point, hinge.end.point])
    assert ends.mean(axis=0)[[0, 2]] == pytest.approx([52.0, 50.0], abs=1.0)
    assert np.abs(ends[:, 1]).max() < 0.75 * 6.0  # 6 is how far its front is from its middle
    assert np.ptp(ends[:, 2]) > 6.0
    beside = Ink((stroke(at(120.0, 0.0, 20.0), at(120.0, 0.0, 80.0)),))
    with pytest.raises(UserError):
        DrawHinge().draw(state, beside, Context(sources=ONE))


def test_pieces_come_apart_and_together_by_commands():
    state = take_apart(MODELER.follow(ONE), Context(sources=ONE))
    assert [part.piece for part in state.of_kind(Followed)] == ["", "arm"]
    assert take_apart(state, Context(sources=ONE)).of_kind(Followed) == state.of_kind(Followed)
    state = put_together(state, Context(sources=ONE))
    assert [part.piece for part in state.of_kind(Followed)] == [""]
    with pytest.raises(UserError, match="is together"):
        put_together(state, Context(sources=ONE))
    with pytest.raises(UserError, match="is one piece"):
        take_apart(MODELER.follow({"two": GIVEN["two"]}), Context(sources={"two": GIVEN["two"]}))


def test_what_hangs_apart_is_a_piece_without_groups_and_panels_of_a_skin_are_sheets():
    both = TRUNK + Manifold.cube((10, 10, 10)).translate((80, 0, 0))
    given = {"one": Shapes(solids=(Solid(mesh_of(both), "blocks"),))}
    state = take_apart(MODELER.follow(given), Context(sources=given))
    assert sorted(masses_of(state, given).values()) == pytest.approx(
        [1240e-9 * 1000, 1240e-9 * 60000], rel=1e-5
    )
    skin = Surface(
        Mesh(9.0 * np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]), [[0, 1, 2], [0, 2, 3]]),
        "car",
        groups=(FaceGroup("door", 1), FaceGroup("roof", 1)),
    )  # fmt: skip
    given = {"one": Shapes(surfaces=(skin,))}
    state = take_apart(MODELER.follow(given), Context(sources=given))
    assert list(masses_of(state, given).values()) == pytest.approx(
        [1240e-9 * 2.0 * 40.5] * 2, rel=1e-3
    )


@pytest.mark.parametrize("seed", range(20))
def test_pieces_of_any_division_weigh_what_the_whole_weighs(seed):
    """Whatever triangles are grouped: caps of both sides are the same."""
    random = np.random.default_rng(seed)
    ball = Manifold.sphere(20, 24)
    middles = np.asarray(mesh_of(ball).vertices)[mesh_of(ball).faces].mean(axis=1)
    side = (middles @ random.normal(size=3) > random.uniform(-8, 8)).astype(int)
    faces = mesh_of(ball).faces[np.argsort(side, kind="stable")]
    counts = np.bincount(side, minlength=2)
    solid = Solid(
        replace(mesh_of(ball), faces=faces), "ball",
        groups=(FaceGroup("a", int(counts[0])), FaceGroup("b", int(counts[1]))),
    )  # fmt: skip
    whole = divided([solid], "ball")
    pieces = [whole.taken((k,)).mesh for k in range(len(whole.names))]
    volumes = [abs(solid_volume(piece)) for piece in pieces]
    assert all(is_closed(piece) for piece in pieces)
    assert sum(volumes) == pytest.approx(solid_volume(whole.mesh), rel=1e-6)


def solid_volume(mesh: Mesh) -> float:
    a, b, c = (np.asarray(mesh.vertices, float)[mesh.faces[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


def ellipse(x: float, z: float, width: float, height: float) -> Stroke:
    turn = np.linspace(0.0, 2.0 * np.pi, 120)
    ring = np.column_stack((x + width * np.cos(turn), 0.0 * turn, z + height * np.sin(turn)))
    places = FRONT.project(ring)[0]
    return Stroke(places[:, 0], places[:, 1], FRONT)


@pytest.fixture
def puppet(shell: Shell) -> Shell:
    """A silhouette of a trunk and an arm that melts into it, and a mechanism that follows it."""
    shell.open("bozzetto.silhouette")
    shell.camera = FRONT
    shell.draw(ellipse(0.0, 40.0, 30.0, 45.0))
    shell.draw(ellipse(55.0, 50.0, 40.0, 9.0))
    shell.set(operation="merge", blend=0.3)
    shell.use("bozzetto.polyhedron")
    shell.run("take-apart")
    return shell


def test_parts_of_a_silhouette_are_bodies_that_hinges_hold_and_films_show(puppet, tmp_path):
    source = puppet.context().sources[puppet.model.sources[0]]
    (solid,) = source.solids
    assert [group.name for group in solid.groups] == ["Part 1", "Part 2"]
    masses = masses_of(puppet.state, puppet.context().sources)
    whole = 1240e-9 * solid_volume(solid.mesh)
    assert sum(masses.values()) == pytest.approx(whole, rel=1e-3)
    assert 0.02 < min(masses.values()) / whole < 0.2
    axis = stroke(at(30.0, 0.0, 44.0), at(30.0, 0.0, 56.0))
    puppet.draw(axis, tool="hinge")
    (hinge,) = puppet.state.of_kind(Hinge)
    assert {hinge.begin.body, hinge.second} == {p.id for p in puppet.state.of_kind(Followed)}
    puppet.tap(*at(-10.0, 0.0, 60.0), tool="move")
    puppet.put(with_steady_motor(puppet.state))
    puppet.reopen()
    film = tmp_path / "film.glb"
    words = ["simulate", str(puppet.save()), "-o", str(film), "--seconds", "0.5", "--rate", "10"]
    assert main(words) == 0
    data = film.read_bytes()
    said = json.loads(data[20 : 20 + struct.unpack("<I", data[12:16])[0]])
    moving_nodes = {each["target"]["node"] for each in said["animations"][0]["channels"]}
    assert "Part 2" in [said["nodes"][k]["name"] for k in moving_nodes]


def with_steady_motor(state):
    nodes = tuple(
        replace(node, drive="steady", speed=90.0) if isinstance(node, Hinge) else node
        for node in state.nodes
    )
    return replace(state, nodes=nodes)
