"""Bodies of other objects as bodies of a mechanism: joined, held, pulled, and exchanged."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from manifold3d import Manifold

from bozzetto.document.links import resolved
from bozzetto.document.model import Document
from bozzetto.errors import UserError
from bozzetto.geometry import Curve, Placement, Shapes, Solid, Surface
from bozzetto.ink import Stroke
from bozzetto.plugin import Context, Drag, Ink, Job, Tap
from bozzetto.testing import Shell
from bozzetto.view import Camera
from bozzetto_polyhedron.model.fittings import Hinge
from bozzetto_polyhedron.model.followed import Followed
from bozzetto_polyhedron.modeler import PolyhedronModeler
from bozzetto_polyhedron.solve.moving import moving
from bozzetto_polyhedron.tools.fittings import DrawHinge
from bozzetto_polyhedron.tools.move import Move
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
    assert MODELER.report(state, result)["mechanism"]["pieces"] == 1
    gone = MODELER.solve(state, Job(sources={"two": Shapes(curves=())}))
    assert "no part" in MODELER.cautions(state, gone)[0].message


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
