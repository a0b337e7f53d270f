"""A face that is touched is left out, and comes back; what is left prints as a sheet."""

from __future__ import annotations

import itertools
import json
from dataclasses import replace

import manifold3d
import numpy as np
import pytest

from bozzetto.cli.main import main
from bozzetto.errors import UserError
from bozzetto.exchange.import_file import read_mesh
from bozzetto.exchange.mesh.manifold_check import check_solid
from bozzetto.geometry import Solid
from bozzetto.plugin import Job
from bozzetto.testing import Pen, Shell
from bozzetto_polyhedron.model.changes import Push
from bozzetto_polyhedron.model.state import Body, Opening
from bozzetto_polyhedron.solid.face_rings import edges_of, tangents
from bozzetto_polyhedron.solid.planar_body import PlanarBody
from bozzetto_polyhedron.solid.sheet import sheet_solid
from bozzetto_polyhedron.solid.unfolding import nets
from bozzetto_polyhedron.solve.open_faces import face_named, name_of
from tests.plugins.polyhedron.shell_bodies import MODELER, body, facing, with_box
from tests.plugins.polyhedron.test_bodies_handed_over import BODIES, as_manifold, made
from tests.plugins.polyhedron.true_bodies import face_areas

SAMPLE = "plugins/bozzetto_polyhedron/samples/house.json"
CLOSED = [name for name, each in BODIES.items() if each.volume is not None]


@pytest.fixture
def box(shell) -> Shell:
    return with_box(shell, seed=9700)


def on_screen(shell: Shell, face: int) -> tuple[float, float]:
    made = body(shell)
    middle = made.vertices[list(made.faces[face][0])].mean(axis=0)
    x, y = shell.camera.project(middle[None])[0][0]
    return float(x), float(y)


def without(body: PlanarBody, *faces: int) -> PlanarBody:
    kept = [k for k in range(len(body.faces)) if k not in faces]
    return replace(
        body,
        faces=tuple(body.faces[k] for k in kept),
        normals=body.normals[kept],
        offsets=body.offsets[kept],
        closed=False,
    )


# -- by the pen ----------------------------------------------------------------------------------


def test_a_touch_leaves_a_face_out_and_another_one_closes_it(box) -> None:
    whole, number = body(box), facing(box)
    place = on_screen(box, number)
    box.tap(*place, tool="open")
    left = body(box)
    assert left.faces == tuple(f for k, f in enumerate(whole.faces) if k != number)
    assert np.array_equal(left.vertices, whole.vertices)
    assert not left.closed
    box.tap(*place, tool="open")
    assert body(box).closed
    assert body(box).faces == whole.faces
    assert not box.state.of_kind(Opening)
    box.undo()
    assert not body(box).closed
    box.undo()
    assert body(box).closed


def test_what_is_open_stays_open_in_a_file(box) -> None:
    box.tap(*on_screen(box, facing(box)), tool="open")
    before = body(box)
    box.save()
    assert not box.reopen()
    assert body(box).faces == before.faces
    assert np.array_equal(body(box).vertices, before.vertices)


def test_a_face_stays_open_when_sizes_change_and_closes_when_its_opening_is_hidden(
    box,
) -> None:
    number = facing(box)
    normal = body(box).normals[number]
    box.tap(*on_screen(box, number), tool="open")
    (opening,) = box.state.of_kind(Opening)
    ends = body(box).vertices[edges_of(body(box).faces)[0]].mean(axis=0)
    x, y = box.camera.project(ends[None])[0][0]
    box.tap(float(x), float(y), tool="dimension")
    box.set(length=260.0)
    left = body(box)
    assert len(left.faces) == 5
    assert (left.normals @ normal < 0.5).all()
    box.put(box.state.with_node(replace(opening, visible=False)))
    assert body(box).closed


def test_what_is_drawn_on_other_faces_goes_on_and_an_open_face_is_not_drawn_on(box) -> None:
    whole, number = body(box), facing(box)
    place = on_screen(box, number)
    middle = whole.vertices[list(whole.faces[number][0])].mean(axis=0)
    ring = middle + 10.0 * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1)]) @ tangents(
        whole.normals[number]
    )
    stroke = Pen(box.camera).along(box.camera.project(ring)[0])
    box.tap(*place, tool="open")
    with pytest.raises(UserError, match="open"):
        box.draw(stroke, tool="loop")
    box.tap(*place, tool="open")
    box.draw(stroke, tool="loop")
    (push,) = box.state.of_kind(Push)
    sight = whole.normals @ box.camera.axes[2]
    other = int(np.argsort(sight)[1])
    beside = whole.vertices[list(whole.faces[other][0])].mean(axis=0)
    x, y = box.camera.project(beside[None])[0][0]
    box.tap(float(x), float(y), tool="open")
    assert not body(box).closed
    assert len(body(box).faces) == 6 + 5 - 1
    assert push.id in {each.id for each in box.state.of_kind(Push)}


def test_the_last_face_stays_and_a_touch_beside_is_told(box) -> None:
    state = box.state
    (drawing,) = state.of_kind(Body)
    whole = body(box)
    number = facing(box)
    for face in range(len(whole.faces)):
        if face != number:
            place, normal = name_of(whole, face)
            state = state.with_node(
                Opening(id=state.unused_id(), body=drawing.id, place=place, normal=normal)
            )
    place = on_screen(box, number)
    box.put(state)
    assert len(body(box).faces) == 1
    with pytest.raises(UserError, match="Close one"):
        box.tap(*place, tool="open")
    assert box.state is not None
    assert len(body(box).faces) == 1
    with pytest.raises(UserError, match="no face here"):
        box.tap(3.0, 3.0, tool="open")


def test_the_eraser_takes_openings_with_their_body(box) -> None:
    box.tap(*on_screen(box, facing(box)), tool="open")
    drawing = box.state.of_kind(Body)[0]
    box.camera = drawing.strokes[0].camera
    for stroke in drawing.strokes:
        box.draw(stroke, tool="erase")
    assert box.state.nodes == ()


def test_an_opening_whose_face_is_gone_is_told(box) -> None:
    (drawing,) = box.state.of_kind(Body)
    gone = Opening(id="n9", name="Open face", body=drawing.id, place=(4.0, 4.0, 4.0))
    box.put(box.state.with_node(gone))
    assert body(box).closed
    result = MODELER.solve(box.state, Job())
    assert any("is gone" in each.message for each in MODELER.cautions(box.state, result))


def test_an_open_solid_says_what_makes_it_print(box) -> None:
    box.tap(*on_screen(box, facing(box)), tool="open")
    result = MODELER.solve(box.state, Job())
    assert any("thickness" in each.message for each in MODELER.cautions(box.state, result))
    drawing = box.state.of_kind(Body)[0]
    box.put(box.state.with_node(replace(drawing, wall=2.0)))
    result = MODELER.solve(box.state, Job())
    assert not any("thickness" in each.message for each in MODELER.cautions(box.state, result))
    (solid,) = box.shapes().solids
    check_solid(solid)


# -- names of faces ------------------------------------------------------------------------------


@pytest.mark.parametrize("name", CLOSED)
@pytest.mark.parametrize("stretched", [(1.0, 1.0, 1.0), (2.5, 0.7, 1.3)])
def test_every_face_is_found_by_its_name_whatever_the_sizes(name, stretched) -> None:
    whole = made(name)
    changed = stretched_body(whole, np.array(stretched))
    for face in range(len(whole.faces)):
        place, normal = name_of(whole, face)
        assert face_named(changed, Opening(place=place, normal=normal)) == face


def stretched_body(body: PlanarBody, factors: np.ndarray) -> PlanarBody:
    normals = body.normals / factors
    lengths = np.linalg.norm(normals, axis=1)
    return replace(
        body,
        vertices=body.vertices * factors,
        normals=normals / lengths[:, None],
        offsets=body.offsets / lengths,
    )


# -- sheets --------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", CLOSED)
def test_without_any_one_or_two_faces_it_prints(name) -> None:
    whole = made(name)
    numbers = range(len(whole.faces))
    for faces in (*itertools.combinations(numbers, 1), *itertools.combinations(numbers, 2)):
        left = without(whole, *faces)
        solid = sheet_solid(left, 2.0)
        check_solid(Solid(solid.mesh))
        found = as_manifold(solid.mesh)
        assert found.status() == manifold3d.Error.NoError
        plates = 2.0 * float(face_areas(left).sum())
        assert 0.7 * plates < found.volume() < 1.3 * plates


@pytest.mark.parametrize("name", ["box", "L", "U", "hole"])
@pytest.mark.parametrize("thickness", [0.5, 3.0])
def test_the_rim_of_a_prism_ends_where_it_was_drawn(name, thickness) -> None:
    whole = made(name, share=0.0)
    lid = 1  # of `true_bodies.prism`
    base = without(whole, lid).normals[0]
    height = float(whole.offsets[lid] + whole.offsets[0])
    sheet = as_manifold(sheet_solid(without(whole, lid), thickness).mesh)
    along = np.array(sheet.to_mesh().vert_properties)[:, :3] @ -base
    assert along.max() == pytest.approx(whole.offsets[lid], abs=1e-3)
    assert along.min() == pytest.approx(-whole.offsets[0] - 0.5 * thickness, abs=1e-3)
    rings = [whole.vertices[list(ring)] @ tangents(base).T for ring in whole.faces[0]]
    outline = manifold3d.CrossSection(rings, manifold3d.FillRule.EvenOdd)
    outer, inner = (
        outline.offset(side * thickness / 2, manifold3d.JoinType.Miter, 2.0).area()
        for side in (1, -1)
    )
    volume = outer * (height + thickness / 2) - inner * (height - thickness / 2)
    assert sheet.volume() == pytest.approx(volume, rel=1e-5)


def test_the_net_of_an_open_box_has_five_faces() -> None:
    left = without(made("box"), 1)
    (net,) = nets(left, 0.0)
    assert sorted(net.faces) == list(range(5))


# -- from the command line -----------------------------------------------------------------------


def test_the_top_is_opened_from_the_command_line(tmp_path) -> None:
    target, report = tmp_path / "house.stl", tmp_path / "report.json"
    build = ["build", "polyhedron", SAMPLE, "-o", str(target), "--report", str(report)]
    assert main([*build, "--set", "lid=open", "--set", "wall=2"]) == 0
    read = json.loads(report.read_text())
    assert not read["closed"]
    assert len(read["faces"]) == 7 - 1
    (solid,) = read_mesh(target).solids
    check_solid(solid)
