"""Bodies as files and paper: planes in STEP, closed meshes, sheets, nets and hidden lines."""

from __future__ import annotations

import itertools
import re

import manifold3d
import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.exchange.export import encode_shapes
from bozzetto.geometry import Placement, Shapes, Solid
from bozzetto.view import Camera
from bozzetto_polyhedron.drawing_on.circles import Circle, polygon_of
from bozzetto_polyhedron.drawing_on.cylinders import brep_with_cylinders
from bozzetto_polyhedron.drawing_on.push import pushed
from bozzetto_polyhedron.solid.exact import exact_body
from bozzetto_polyhedron.solid.face_rings import edges_of
from bozzetto_polyhedron.solid.hand_over import brep_of, mesh_of, solid_of
from bozzetto_polyhedron.solid.sheet import sheet_solid
from bozzetto_polyhedron.solid.triangulation import genus_of, triangles_of, volume_of
from bozzetto_polyhedron.solid.unfolding import face_curves, laid_faces, net_curves, nets
from bozzetto_polyhedron.solid.visibility import visible_pieces
from bozzetto_polyhedron.solve.pipeline import placed_body
from bozzetto_polyhedron.solve.standing import foot_of, upright
from tests.core.exchange.test_curve_interop import ask
from tests.plugins.polyhedron.drawn_bodies import VIEW
from tests.plugins.polyhedron.true_bodies import all_bodies, drawn, face_areas, polygon_area

BODIES = {body.name: body for body in all_bodies()}


def made(name, seed=4001, share=0.01):
    answer, noise, _ = drawn(BODIES[name], share, np.random.default_rng(seed))
    return exact_body(answer, noise=noise)


def as_manifold(mesh):
    return manifold3d.Manifold(
        manifold3d.Mesh(np.array(mesh.vertices), np.array(mesh.faces).astype(np.uint32))
    )


# -- exact faces ---------------------------------------------------------------------------------

PLANES = """
import json, sys
from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepGProp import BRepGProp
from OCP.GProp import GProp_GProps
from OCP.GeomAbs import GeomAbs_Plane
from OCP.STEPControl import STEPControl_Reader
from OCP.TopAbs import TopAbs_FACE, TopAbs_REVERSED
from OCP.TopExp import TopExp_Explorer
from OCP.TopoDS import TopoDS
reader = STEPControl_Reader()
reader.ReadFile(sys.argv[1])
reader.TransferRoots()
shape = reader.OneShape()
found = []
faces = TopExp_Explorer(shape, TopAbs_FACE)
while faces.More():
    face = TopoDS.Face(faces.Current()) if hasattr(TopoDS, "Face") else TopoDS.Face_s(faces.Current())
    surface = BRepAdaptor_Surface(face)
    assert surface.GetType() == GeomAbs_Plane
    plane = surface.Plane()
    way = -1.0 if face.Orientation() == TopAbs_REVERSED else 1.0
    axis, place = plane.Axis().Direction(), plane.Location()
    normal = [way * axis.X(), way * axis.Y(), way * axis.Z()]
    offset = normal[0] * place.X() + normal[1] * place.Y() + normal[2] * place.Z()
    found.append([*normal, offset])
    faces.Next()
measured = GProp_GProps()
volume = BRepGProp.VolumeProperties if hasattr(BRepGProp, "VolumeProperties") else BRepGProp.VolumeProperties_s
volume(shape, measured)
print(json.dumps({"planes": found, "volume": measured.Mass(), "valid": BRepCheck_Analyzer(shape).IsValid()}))
"""  # noqa: E501


@pytest.mark.interop
@pytest.mark.parametrize("name", BODIES)
def test_opencascade_reads_the_same_planes(name, tmp_path):
    body = made(name)
    path = tmp_path / "body.step"
    path.write_bytes(encode_shapes(Shapes(breps=(brep_of(body),)), path))
    _, read = ask(PLANES, path)
    wanted = np.c_[body.normals, body.offsets]
    found = np.array(read["planes"])
    assert len(found) == len(wanted)
    for plane in wanted:
        assert np.abs(found - plane).max(axis=1).min() < 1e-9
    assert read["valid"]
    if body.closed:
        assert read["volume"] == pytest.approx(volume_of(body), rel=1e-9)


@pytest.mark.interop
@pytest.mark.parametrize("depth", [-10.0, 12.0, -np.inf])
def test_opencascade_reads_round_holes_and_bosses(depth, tmp_path):
    body = made("box", 4002, 0.0)
    middle = body.vertices[list(body.faces[1][0])].mean(axis=0)
    circle = Circle(middle, body.normals[1], 12.0, 1, 0.0)
    made_round = brep_with_cylinders(pushed(body, 1, polygon_of(circle), depth), [circle])
    path = tmp_path / "round.step"
    path.write_bytes(encode_shapes(Shapes(breps=(made_round,)), path))
    _, read = ask(
        PLANES.replace("assert surface.GetType()", "if surface.GetType()").replace(
            "== GeomAbs_Plane\n", "!= GeomAbs_Plane:\n        faces.Next()\n        continue\n"
        ),
        path,
    )
    change = np.pi * 12.0**2 * max(depth, -90.0)
    assert read["valid"]
    assert len(read["planes"]) == 6 + np.isfinite(depth)
    assert read["volume"] == pytest.approx(volume_of(body) + change, rel=1e-6)


@pytest.mark.parametrize("name", BODIES)
def test_exact_faces_share_all_edges(name):
    body = made(name)
    brep = brep_of(body, "part", (200, 30, 20))
    assert brep.is_closed == body.closed
    assert len(brep.faces) == len(body.faces)
    assert len(brep.edges) == len(edges_of(body.faces))
    assert all(face.surface.is_plane for face in brep.faces)
    assert brep.largest_gap() < 1e-10


@pytest.mark.parametrize("name", ["box", "house", "hole", "notched"])
def test_axis_planes_of_a_body_put_on_the_ground_are_written_as_zeros_and_ones(name, tmp_path):
    body = made(name)
    number = foot_of(body)
    assert number is not None
    standing = placed_body(body, Placement(upright(body, number, VIEW.axes[2])))
    path = tmp_path / "body.step"
    text = encode_shapes(Shapes(breps=(brep_of(standing),)), path).decode()
    directions = re.findall(r"DIRECTION\('[^']*',\(([^)]*)\)\)", text)
    numbers = np.array([[float(v) for v in d.split(",")] for d in directions])
    ones = np.abs(numbers).max(axis=1) > 1 - 1e-9
    assert ones.sum() >= 3
    assert set(np.abs(numbers[ones]).ravel().tolist()) == {0.0, 1.0}


@pytest.mark.parametrize("name", BODIES)
def test_meshes_are_closed_and_measure_the_same(name):
    body = made(name)
    part = solid_of(body)
    assert isinstance(part, Solid) == body.closed
    if body.closed:
        found = as_manifold(part.mesh)
        assert found.status() == manifold3d.Error.NoError
        assert found.genus() == genus_of(body) == BODIES[name].genus
        assert found.volume() == pytest.approx(volume_of(body), rel=1e-5)
    triangles, owner = triangles_of(body)
    corners = body.vertices[triangles]
    vectors = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert (np.einsum("tk,tk->t", vectors, body.normals[owner]) > 0).all()
    areas = np.bincount(owner, np.linalg.norm(vectors, axis=1))
    assert np.allclose(areas, face_areas(body), rtol=1e-12)
    assert mesh_of(body).faces.shape == triangles.shape


# -- sheets --------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", BODIES)
@pytest.mark.parametrize("thickness", [0.8, 4.0])
def test_sheets_are_watertight_and_thick(name, thickness):
    body = made(name)
    sheet = sheet_solid(body, thickness)
    found = as_manifold(sheet.mesh)
    assert found.status() == manifold3d.Error.NoError
    plates = float(face_areas(body).sum()) * thickness
    rim = float(sum(np.linalg.norm(body.vertices[a] - body.vertices[b]) for a, b in
                    edges_of(body.faces))) * thickness**2  # fmt: skip
    assert abs(found.volume() - plates) < 2 * rim + 40 * thickness**3
    if body.closed:  # an inside and an outside, of the genus of the body each
        assert found.genus() == 2 * BODIES[name].genus - 1


@pytest.mark.parametrize("thickness", [0.0, -1.0, float("nan"), 1e6])
def test_sheets_without_a_thickness_are_told(thickness):
    with pytest.raises(UserError):
        sheet_solid(made("open box"), thickness)


# -- faces laid flat -----------------------------------------------------------------------------


@pytest.mark.parametrize("name", BODIES)
def test_nets_have_the_area_of_the_faces_and_nothing_overlaps(name):
    body = made(name)
    unfolded = nets(body, 6.0)
    assert sorted(face for net in unfolded for face in net.faces) == list(range(len(body.faces)))
    areas = face_areas(body)
    for net in unfolded:
        sections = [
            manifold3d.CrossSection(list(rings), manifold3d.FillRule.EvenOdd) for rings in net.rings
        ]
        sections += [
            manifold3d.CrossSection([tab], manifold3d.FillRule.EvenOdd) for tab in net.tabs
        ]
        for one, two in itertools.combinations(sections, 2):
            assert (one ^ two).area() < 1e-5 * min(one.area(), two.area())
        for face, rings in zip(net.faces, net.rings, strict=True):
            assert sum(map(polygon_area, rings)) == pytest.approx(areas[face], rel=1e-12)


@pytest.mark.parametrize("name", BODIES)
def test_every_edge_of_a_net_is_folded_once_or_cut_twice(name):
    body = made(name)
    unfolded = nets(body)
    edges, uses = edges_of(body.faces), sum(len(net.cuts) + 2 * len(net.folds) for net in unfolded)
    sides = sum(len(ring) for face in body.faces for ring in face)
    assert uses == sides
    if body.closed:
        assert sides == 2 * len(edges)
    assert sum(len(net.folds) for net in unfolded) == len(body.faces) - len(unfolded)


@pytest.mark.parametrize("name", ["box", "L", "stairs", "frustum4", "pyramid5", "hexagon"])
def test_simple_solids_unfold_in_one_piece_with_a_tab_for_every_cut(name):
    body = made(name)
    (net,) = nets(body, 5.0)
    assert len(net.tabs) == len(net.cuts) // 2
    concave = {"L": 1, "stairs": 2}
    folded_inward = int(net.valleys.sum())
    assert folded_inward <= concave.get(name, 0)


def test_faces_lie_side_by_side_at_true_size():
    body = made("hole")
    flat = laid_faces(body)
    spans = [(np.concatenate(r)[:, 0].min(), np.concatenate(r)[:, 0].max()) for r in flat]
    assert all(a[1] < b[0] for a, b in itertools.pairwise(spans))
    areas = [sum(map(polygon_area, rings)) for rings in flat]
    assert np.allclose(areas, face_areas(body), rtol=1e-12)


def test_curves_of_nets_and_faces_are_written_at_true_size(tmp_path):
    body = made("box")
    path = tmp_path / "net.svg"
    curves = face_curves(body, "front")
    text = encode_shapes(Shapes(curves=curves), path).decode()
    assert re.search(r'width="[0-9.]+mm"', text)
    cuts = net_curves(nets(body, 5.0))
    assert all(np.abs(curve.control_points[:, 2]).max() == 0.0 for curve in cuts)
    lengths = {round(float(np.linalg.norm(np.ptp(c.control_points, axis=0))), 6)
               for c in cuts if c.name.endswith("cuts")}  # fmt: skip
    edges = edges_of(body.faces)
    true = np.linalg.norm(body.vertices[edges[:, 0]] - body.vertices[edges[:, 1]], axis=1)
    assert all(np.abs(true - length).min() < 1e-5 for length in lengths)


# -- hidden lines --------------------------------------------------------------------------------


def hidden_by_triangles(body, camera, points):
    """The same by another way: every triangle of every face against the line of sight."""
    triangles, _ = triangles_of(body)
    answers = []
    for point in points:
        eye = (
            np.array(camera.eye)
            if camera.kind == "perspective"
            else point - 1000.0 * camera.axes[2]
        )
        sight = point - eye
        a, b, c = (body.vertices[triangles[:, k]] for k in range(3))
        matrix = np.stack((b - a, c - a, np.broadcast_to(-sight, a.shape)), axis=2)
        sound = np.abs(np.linalg.det(matrix)) > 1e-7
        u, v, s = np.linalg.solve(matrix[sound], (eye - a[sound])[..., None])[..., 0].T
        within = (u > 1e-9) & (v > 1e-9) & (u + v < 1 - 1e-9)
        answers.append(bool((within & (s > 0) & (s < 1 - 1e-7)).any()))
    return np.array(answers)


@pytest.mark.parametrize("kind", ["orthographic", "perspective"])
@pytest.mark.parametrize("name", BODIES)
def test_hidden_lines_agree_with_rays_against_triangles(name, kind):
    rng = np.random.default_rng(4010)
    body = made(name)
    for _ in range(2):
        eye = rng.normal(size=3)
        camera = Camera(kind, eye=tuple(260.0 * eye / np.linalg.norm(eye)), height=200.0)
        pieces = visible_pieces(body, camera)
        share = rng.uniform(0.02, 0.98, len(pieces.ends))[:, None]
        points = pieces.ends[:, 0] + share * (pieces.ends[:, 1] - pieces.ends[:, 0])
        assert (hidden_by_triangles(body, camera, points) == pieces.hidden).all()


@pytest.mark.parametrize("name", BODIES)
def test_pieces_cover_every_edge_without_gaps(name):
    body = made(name)
    pieces = visible_pieces(body, Camera(eye=(200.0, -300.0, 150.0)))
    for number, (one, two) in enumerate(pieces.edges):
        ends = pieces.ends[pieces.edge == number]
        assert np.abs(ends[0, 0] - body.vertices[one]).max() < 1e-12
        assert np.abs(ends[-1, 1] - body.vertices[two]).max() < 1e-10
        assert np.abs(ends[1:, 0] - ends[:-1, 1]).max(initial=0.0) < 1e-10


def test_what_is_seen_moves_with_body_and_camera():
    body, camera = made("stairs"), Camera(eye=(200.0, -300.0, 150.0))
    turn, _ = np.linalg.qr(np.random.default_rng(4011).normal(size=(3, 3)))
    turn *= np.sign(np.linalg.det(turn))
    placement = Placement(tuple(turn.ravel()), 1.0, (30.0, -700.0, 20.0))
    from dataclasses import replace

    normals = body.normals @ turn.T
    elsewhere = replace(
        body,
        vertices=placement.points(body.vertices),
        normals=normals,
        offsets=body.offsets + normals @ np.array(placement.offset),
    )
    one = visible_pieces(body, camera)
    two = visible_pieces(elsewhere, camera.moved(placement))
    assert (one.hidden == two.hidden).all()
    assert np.abs(placement.points(one.ends.reshape(-1, 3)) - two.ends.reshape(-1, 3)).max() < 1e-8


def test_an_eye_inside_the_body_sees_what_is_before_it():
    pieces = visible_pieces(made("box"), Camera(eye=(0.0, 0.0, 0.0), target=(10.0, 20.0, 5.0)))
    assert np.isfinite(pieces.ends).all()
    assert not pieces.hidden.any()


def test_the_floor_of_a_pocket_is_hidden_from_below():
    body = made("box", 4012, 0.0)
    corners = body.vertices[list(body.faces[1][0])]
    loop = corners.mean(axis=0) + 0.5 * (corners - corners.mean(axis=0))
    pocket = pushed(body, 1, loop, -20.0)
    below = Camera(
        "orthographic", eye=tuple(-300.0 * body.normals[1] + (5.0, 3.0, 2.0)), height=200.0
    )
    pieces = visible_pieces(pocket, below)
    apart = np.linalg.norm(pocket.vertices[:, None] - body.vertices[None], axis=-1).min(axis=1)
    inner = (apart[pieces.edges[pieces.edge]] > 1.0).all(axis=1)
    assert inner.any()
    assert pieces.hidden[inner].all()
