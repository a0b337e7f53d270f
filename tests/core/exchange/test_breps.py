"""Breps in STEP, IGES, 3dm and mesh files, read back by parsers of our own and by others.

The tests marked "interop" give them to OpenCASCADE and Gmsh (see `test_surfaces`), and to rhino3dm.
"""

from __future__ import annotations

import io
import re
import zipfile
from dataclasses import replace
from math import pi
from types import SimpleNamespace

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.exchange.cad import cad_surfaces
from bozzetto.exchange.cad.iges import write_shapes as iges
from bozzetto.exchange.cad.step import write_shapes as step
from bozzetto.exchange.export import encode_shapes, export, prepare_export
from bozzetto.exchange.import_file import read_mesh
from bozzetto.exchange.mesh.manifold_check import check_solid
from bozzetto.geometry import (
    Brep,
    BSplineSurface,
    Curve,
    Face,
    FaceGroup,
    Mesh,
    ParameterCurve,
    Placement,
    Shapes,
    Solid,
    Trim,
    brep_mesh,
    cylinder,
    plane_face,
    ruled_surface,
    sewn,
    surface_of_revolution,
)
from bozzetto.geometry.brep import tessellation
from bozzetto.plugin.guard.checked_values import Unsound
from bozzetto.plugin.guard.shape_validation import sound_shapes
from bozzetto.workbench.placed import shapes_in_world
from tests.core.exchange.curve_kit import NAMES, Iges, Step
from tests.core.exchange.test_curve_interop import ask, messages
from tests.core.geometry.brep.exact_shapes import (
    KNOWN,
    UP,
    ZERO,
    bent_net,
    box,
    circle,
    half_circle,
    polyline,
)

RED = (200, 30, 20)
CAN = replace(KNOWN["cylinder"].brep, name="Can", color=RED)
SHEET = Brep.of_surface(bent_net(1), "Sheet", (0, 90, 200))
HOLLOW = sewn([box((9, 9, 9)), cylinder((4, 4, 2), (4, 4, 6), 1.5).turned_over()], "Hollow")
SHAPES = Shapes(breps=(CAN, SHEET))
FAR_APART = 10.0 ** np.linspace(-9, 9, 24).reshape(6, 4)
MOST = 1e-12
"""Departure of numbers that went through text, per unit of the largest."""


class Faces:
    """Solids and sheets of a STEP file; every face by its kind, surface and loops."""

    def __init__(self, data):
        self.file = Step(data)
        self.solids = {
            name: self.shell(shell) for _, (name, shell) in self.file.of("MANIFOLD_SOLID_BREP")
        }
        self.hollows = {
            name: (self.shell(shell), [self.oriented(v) for v in voids])
            for _, (name, shell, voids) in self.file.of("BREP_WITH_VOIDS")
        }
        self.sheets = {
            name: [face for shell in shells for face in self.shell(shell)]
            for _, (name, shells) in self.file.of("SHELL_BASED_SURFACE_MODEL")
        }

    def get(self, number, kind):
        return self.file.instances[number][kind]

    def oriented(self, number):
        _, star, shell, sense = self.get(number, "ORIENTED_CLOSED_SHELL")
        assert (star, sense) == ("*", ".T.")
        return self.shell(shell)

    def shell(self, number):
        ((_, (_, faces)),) = self.file.instances[number].items()
        return [self.face(face) for face in faces]

    def vector(self, number, kind):
        return np.array(self.get(number, kind)[1])

    def face(self, number):
        name, bounds, surface, sense = self.get(number, "ADVANCED_FACE")
        assert sense == ".T."
        kinds = [next(iter(self.file.instances[bound])) for bound in bounds]
        assert kinds == ["FACE_OUTER_BOUND"] + ["FACE_BOUND"] * (len(bounds) - 1)
        loops = []
        for bound, kind in zip(bounds, kinds, strict=True):
            _, loop, sense = self.get(bound, kind)
            assert sense == ".T."
            run = [self.get(o, "ORIENTED_EDGE") for o in self.get(loop, "EDGE_LOOP")[1]]
            loops.append([(edge, sense) for _, _, _, edge, sense in run])
        return SimpleNamespace(name=name, surface=self.surface(surface), loops=loops)

    def surface(self, number):
        one = self.file.instances[number]
        if "PLANE" in one:
            _, at, up, right = self.get(one["PLANE"][1], "AXIS2_PLACEMENT_3D")
            return (
                self.vector(at, "CARTESIAN_POINT"),
                self.vector(up, "DIRECTION"),
                self.vector(right, "DIRECTION"),
            )
        spline = one["B_SPLINE_SURFACE_WITH_KNOTS"]
        weights = None
        if "RATIONAL_B_SPLINE_SURFACE" in one:
            spline = [*one["REPRESENTATION_ITEM"], *one["B_SPLINE_SURFACE"], *spline]
            (weights,) = one["RATIONAL_B_SPLINE_SURFACE"]
        _, p, q, rows, _, _, _, _, times_u, times_v, knots_u, knots_v, _ = spline
        net = [[self.vector(point, "CARTESIAN_POINT") for point in row] for row in rows]
        knots = (np.repeat(k, t) for k, t in ((knots_u, times_u), (knots_v, times_v)))
        return BSplineSurface((p, q), *knots, np.array(net), weights)

    def edge(self, number):
        """Places of the ends, and the curve or the line's (place, direction, length)."""
        _, start, end, curve, same = self.get(number, "EDGE_CURVE")
        assert same == ".T."
        ends = [
            self.vector(self.get(v, "VERTEX_POINT")[1], "CARTESIAN_POINT") for v in (start, end)
        ]
        one = self.file.instances[curve]
        if "LINE" not in one:
            return (start, end), ends, self.file.curve(curve)
        _, at, vector = one["LINE"]
        _, along, length = self.get(vector, "VECTOR")
        line = (self.vector(at, "CARTESIAN_POINT"), self.vector(along, "DIRECTION"), length)
        return (start, end), ends, line


def same_surface(one, two):
    assert one.degrees == two.degrees
    for name in ("knots_u", "knots_v", "control_points", "weights"):
        np.testing.assert_array_equal(getattr(one, name), getattr(two, name))


# -- STEP --------------------------------------------------------------------------------------


def test_step_holds_a_closed_brep_as_a_solid_with_its_very_numbers():
    faces = Faces(step(SHAPES)).solids["Can"]
    assert len(faces) == len(CAN.faces)
    for found, face in zip(faces, CAN.faces, strict=True):
        assert found.name == "Can"
        if face.surface.is_plane:
            _, up, right = found.surface
            np.testing.assert_allclose(up, face.surface.normals([0], [0])[0], atol=MOST)
            assert abs(up @ right) < MOST
        else:
            same_surface(found.surface, face.surface)


def test_step_holds_an_open_brep_as_an_open_shell():
    file = Faces(step(SHAPES))
    (face,) = file.sheets["Sheet"]
    same_surface(face.surface, SHEET.faces[0].surface)
    assert len(file.file.of("OPEN_SHELL")) == len(file.file.of("CLOSED_SHELL")) == 1
    kinds = ("ADVANCED_BREP", "MANIFOLD_SURFACE")
    assert all(len(file.file.of(f"{k}_SHAPE_REPRESENTATION")) == 1 for k in kinds)
    assert len(file.file.of("PRODUCT")) == 1


@pytest.mark.parametrize("name", KNOWN)
def test_faces_share_edges_that_start_and_end_in_shared_vertices(name):
    file = Faces(step(Shapes(breps=(KNOWN[name].brep,))))
    (faces,) = file.solids.values()
    uses = {}
    for face in faces:
        for loop in face.loops:
            corners = []
            for edge, sense in loop:
                uses.setdefault(edge, []).append(sense)
                (start, end), ends, curve = file.edge(edge)
                corners.append((start, end) if sense == ".T." else (end, start))
                if isinstance(curve, Curve):
                    np.testing.assert_array_equal(curve.control_points[[0, -1]], ends)
                else:
                    at, along, length = curve
                    np.testing.assert_allclose([at, at + length * along], ends, atol=MOST * 10)
            # Sides follow one another from vertex to vertex, by name.
            assert all(
                a[1] == b[0] for a, b in zip(corners, corners[1:] + corners[:1], strict=True)
            )
    assert {tuple(sorted(senses)) for senses in uses.values()} == {(".F.", ".T.")}
    assert len(uses) == len(KNOWN[name].brep.edges)


def test_planes_of_a_box_are_planes_and_its_edges_lines():
    text = step(Shapes(breps=(box(),))).decode()
    assert (text.count("=PLANE("), text.count("=LINE(")) == (6, 12)
    assert "B_SPLINE" not in text


def test_a_hollow_is_in_its_solid():
    file = Faces(step(Shapes(breps=(HOLLOW,))))
    outer, (inner,) = file.hollows["Hollow"]
    assert (len(outer), len(inner), file.solids) == (6, 4, {})


def test_two_solids_and_a_sheet_in_one_brep():
    far = CAN.placed(Placement(offset=(50.0, 0.0, 0.0)))
    file = Faces(step(Shapes(breps=(sewn([CAN, far, SHEET], "All"),))))
    assert len(file.file.of("MANIFOLD_SOLID_BREP")) == 2
    assert len(file.sheets["All"]) == 1


def test_equal_breps_give_equal_files():
    for write in (step, iges):
        assert write(SHAPES) == write(Shapes(breps=(replace(CAN), replace(SHEET))))


@pytest.mark.parametrize("name", NAMES)
def test_odd_names(name):
    one = replace(SHEET, name=name, faces=tuple(replace(f, name=name) for f in SHEET.faces))
    ((said, (face,)),) = Faces(step(Shapes(breps=(one,)))).sheets.items()
    assert face.name == said
    assert not any(ord(letter) < 32 for letter in said)
    iges(Shapes(breps=(one,)))


# -- IGES --------------------------------------------------------------------------------------


def test_iges_trims_what_is_trimmed_and_leaves_whole_surfaces_alone():
    file = Iges(iges(SHAPES))
    kinds = [kind for kind, *_ in file.entities.values()]
    trimmed = sum(not face.is_whole for face in CAN.faces)
    assert trimmed == 2
    assert (kinds.count(144), kinds.count(142)) == (trimmed, trimmed)
    assert kinds.count(128) == len(CAN.faces) + 1
    groups = [values for kind, _, _, values in file.entities.values() if kind == 402]
    assert [int(values[0]) for values in groups] == [len(CAN.faces), 1]


def test_loops_in_iges_run_alike_in_parameters_and_in_space():
    plate = plane_face([[(0, 0, 1), (9, 0, 1), (9, 7, 1), (0, 7, 1)],
                        [(2, 2, 1), (5, 2, 1), (4, 4, 1)]])  # fmt: skip
    file = Iges(iges(Shapes(breps=(plate,))))
    ((_, _, _, trimmed),) = [e for e in file.entities.values() if e[0] == 144]
    assert trimmed[1:3] == ["1", "1"]
    surface = plate.faces[0].surface

    def ends(pointer):
        kind, _, _, values = file.entities[int(pointer)]
        assert kind == 102
        rows = []
        for member in values[1 : 1 + int(values[0])]:
            words = file.entities[int(member)][3]
            numbers = np.array([float(v.replace("D", "E")) for v in words])
            assert numbers[:2].tolist() == [1, 1]
            rows.append(numbers[12:18].reshape(2, 3))
        return np.array(rows)

    for pointer in trimmed[3:5]:
        _, on, flat, space, _ = file.entities[int(pointer)][3][:5]
        assert on == trimmed[0]
        flat, space = ends(flat), ends(space)
        np.testing.assert_allclose(
            surface.value(*flat.reshape(-1, 3)[:, :2].T), space.reshape(-1, 3), atol=MOST * 10
        )
        np.testing.assert_allclose(space[:, 1], np.roll(space[:, 0], -1, axis=0), atol=MOST)


# -- meshes, and what is left out --------------------------------------------------------------


@pytest.mark.parametrize("ending", ["stl", "obj", "ply", "glb", "3mf"])
def test_mesh_formats_hold_closed_breps_as_solids(tmp_path, ending, monkeypatch):
    monkeypatch.setattr(tessellation, "TOLERANCE", 2e-3)  # of the size; twenty times the usual
    path = tmp_path / f"a.{ending}"
    made = export(SHAPES, path)
    assert made.as_values()["exact_surfaces"] == ["Can", "Sheet"]
    assert made.left_out == ()
    if ending == "3mf":
        return
    parts = list(read_mesh(path).meshes())
    if ending == "glb":
        assert [(p.name, p.color) for p in parts] == [("Can", RED), ("Sheet", SHEET.color)]
        assert check_solid(Solid(parts[0].mesh)).volume == pytest.approx(90 * pi, rel=2e-2)


def test_3dm_and_flat_formats_name_what_they_leave_out():
    pytest.importorskip("rhino3dm")
    made = prepare_export(SHAPES, "a.3dm")
    assert made.warnings() == (
        "Left out of the 3DM file: the exact form of 2 trimmed faces (such files hold whole "
        "surfaces; these became triangles); save as STEP.",
    )
    assert prepare_export(Shapes(breps=(box(),)), "a.3dm").left_out == ()


def test_svg_names_breps_beside_curves():
    line = polyline([(0, 0, 0), (9, 0, 9)])
    made = prepare_export(Shapes(curves=(line,), breps=(CAN,)), "a.svg")
    (left,) = made.left_out
    assert (left.what, left.names) == ("1 exact surface", ("Can",))
    with pytest.raises(UserError, match=r"Use one of .*\.step"):
        encode_shapes(Shapes(breps=(CAN,)), "a.svg")


@pytest.mark.parametrize("ending", ["step", "stl"])
def test_a_solid_that_is_inside_out_is_refused(ending):
    with pytest.raises(UserError, match="inside out"):
        encode_shapes(Shapes(breps=(CAN.turned_over(),)), f"a.{ending}")


@pytest.mark.parametrize("ending", ["step", "iges"])
@pytest.mark.parametrize(
    ("one", "said"),
    [
        (CAN.placed(Placement(scale=1e9)), "further"),
        (box((1e-7, 1e-7, 1e-7)), "no length"),
        (Brep.of_surface(replace(bent_net(1), weights=FAR_APART)), "too far apart"),
        (Brep.of_surface(BSplineSurface((26, 1), [0] * 27 + [1] * 27, (0, 0, 1, 1),
                                        np.random.default_rng(0).normal(size=(27, 2, 3)))),
         "degree 26"),
    ],
)  # fmt: skip
def test_what_no_reader_could_use_is_refused(ending, one, said):
    with pytest.raises(UserError, match=said):
        encode_shapes(Shapes(breps=(one,)), f"a.{ending}")


def test_more_points_than_can_be_written_are_refused(monkeypatch):
    monkeypatch.setattr(cad_surfaces, "MAX_CONTROL_POINTS", 100)
    with pytest.raises(UserError, match="control points together"):
        step(SHAPES)


# -- between modelers and files ----------------------------------------------------------------


def test_a_brep_is_named_coloured_and_placed_as_its_model():
    model = SimpleNamespace(
        name="Vase", color=(1, 2, 3), placement=Placement(offset=(0.0, 0.0, 10.0))
    )
    shapes = Shapes(breps=(KNOWN["cone"].brep, CAN))
    cone, can = shapes_in_world(shapes, model).breps
    assert (cone.name, cone.color) == ("Vase 1", (1, 2, 3))
    assert (can.name, can.color) == ("Can", RED)
    assert brep_mesh(cone, 0.1).bounds[:, 2].tolist() == [10.0, 19.0]


def tampered(part, attribute, value):
    """A part with a value that its maker let through."""
    one = replace(part)
    object.__setattr__(one, attribute, value)
    return one


@pytest.mark.parametrize(
    "one",
    [
        tampered(CAN, "name", 3),
        tampered(CAN, "edges", list(CAN.edges)),
        tampered(CAN, "faces", ("a face",)),
        tampered(CAN, "faces", (tampered(CAN.faces[0], "name", None),)),
        tampered(SHEET, "faces", (
            tampered(SHEET.faces[0], "surface",
                     tampered(bent_net(1), "control_points", np.full((2, 2, 3), np.nan))),)),
        tampered(CAN, "edges", (tampered(CAN.edges[0], "control_points", np.array([np.inf])),)),
        Mesh(np.zeros((0, 3)), np.zeros((0, 3))),
    ],
)  # fmt: skip
def test_the_guard_refuses_unsound_breps(one):
    with pytest.raises(Unsound):
        sound_shapes(Shapes(breps=(one,)))
    assert sound_shapes(SHAPES) is SHAPES


# -- independent readers -----------------------------------------------------------------------

OPENCASCADE = """
import json, sys
from OCP.BRep import BRep_Tool
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepGProp import BRepGProp
from OCP.GProp import GProp_GProps
from OCP.IFSelect import IFSelect_PrintCount, IFSelect_ReturnStatus
from OCP.IGESControl import IGESControl_Reader
from OCP.STEPControl import STEPControl_Reader
from OCP.TopAbs import TopAbs_EDGE, TopAbs_FACE, TopAbs_SHELL, TopAbs_SOLID
from OCP.TopExp import TopExp_Explorer
from OCP.TopoDS import TopoDS
path = sys.argv[1]
reader = STEPControl_Reader() if path.endswith("step") else IGESControl_Reader()
assert reader.ReadFile(path) == IFSelect_ReturnStatus.IFSelect_RetDone
reader.PrintCheckLoad(False, IFSelect_PrintCount.IFSelect_ItemsByEntity)
reader.TransferRoots()
reader.PrintCheckTransfer(False, IFSelect_PrintCount.IFSelect_ItemsByEntity)
shape = reader.OneShape()

def each(kind):
    found, explorer = [], TopExp_Explorer(shape, kind)
    while explorer.More():
        found.append(explorer.Current())
        explorer.Next()
    return found

inside, outside = GProp_GProps(), GProp_GProps()
BRepGProp.VolumeProperties_s(shape, inside, 1e-9)
BRepGProp.SurfaceProperties_s(shape, outside, 1e-9)
wide = max(BRep_Tool.Tolerance_s(TopoDS.Edge(edge)) for edge in each(TopAbs_EDGE))
print()
print(json.dumps({
    "valid": BRepCheck_Analyzer(shape).IsValid(), "solids": len(each(TopAbs_SOLID)),
    "shells": len(each(TopAbs_SHELL)), "faces": len(each(TopAbs_FACE)),
    "volume": inside.Mass(), "area": outside.Mass(), "tolerance": wide,
}))
"""

PLACE = Placement((0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0), 2.0, (11.0, -4.0, 300.0))


def prism():
    """A plate with a round hole, between two plane faces."""
    square = [(0, 0, 0), (20, 0, 0), (20, 20, 0), (0, 20, 0)]
    ring = circle(3.0).placed(Placement((1, 0, 0, 0, 0, 1, 0, 1, 0), 1.0, (10, 10, 0)))
    lift = Placement(offset=(0.0, 0.0, 5.0))
    sides = [polyline((a, b)) for a, b in zip(square, square[1:] + square[:1], strict=True)]
    halves = [
        ring.with_knots(k) for k in ([0] * 3 + [1] * 2 + [2] * 3, [2] * 3 + [3] * 2 + [4] * 3)
    ]
    walls = [ruled_surface(side, side.placed(lift)) for side in sides]
    walls += [ruled_surface(half, half.placed(lift)).turned_over() for half in halves]
    # The floor's edges are those of the walls, so that they are sewn.
    floor = plane_face([sides, [w.edges[0] for w in walls[4:]]], normal=(0, 0, -1))
    roof = plane_face(
        [[s.placed(lift) for s in sides], [w.edges[0].placed(lift) for w in walls[4:]]], normal=UP
    )
    return sewn([*walls, floor, roof], "Prism")


SOLIDS = {
    **KNOWN,
    "hollow": SimpleNamespace(brep=HOLLOW, volume=729 - 9 * pi, area=6 * 81 + pi * 3 * 5.5),
    "placed": SimpleNamespace(
        brep=KNOWN["torus"].brep.placed(PLACE),
        volume=8 * KNOWN["torus"].volume,
        area=4 * KNOWN["torus"].area,
    ),
    "mirrored": SimpleNamespace(
        brep=KNOWN["cone"].brep.placed(Placement((1, 0, 0, 0, 1, 0, 0, 0, -1), 1.0, (0, 0, 7))),
        volume=KNOWN["cone"].volume,
        area=KNOWN["cone"].area,
    ),
    "prism": SimpleNamespace(
        brep=prism(), volume=5 * (400 - 9 * pi), area=2 * (400 - 9 * pi) + 5 * (80 + 6 * pi)
    ),
}


def test_a_prism_of_ruled_walls_and_plane_faces_closes():
    made = SOLIDS["prism"].brep
    assert made.is_closed
    assert len(made.edges) == 12 + 6


@pytest.mark.interop
@pytest.mark.parametrize("name", SOLIDS)
@pytest.mark.parametrize("ending", ["step", "iges"])
def test_opencascade_sees_valid_solids_of_the_exact_volume(tmp_path, name, ending):
    known = SOLIDS[name]
    path = tmp_path / f"a.{ending}"
    export(Shapes(breps=(known.brep,)), path)
    said, answer = ask(OPENCASCADE, path)
    twice_in_profile = ("C0-continuous", "With C0 continuity")  # half circles of two arcs
    if ending == "step" or name not in ("sphere", "torus", "placed", "prism"):
        assert messages(said) == []
    else:
        assert all(
            any(word in line for word in (*twice_in_profile, "Entity")) for line in messages(said)
        )
    assert answer["valid"]
    assert answer["faces"] == len(known.brep.faces)
    assert answer["solids"] == (ending == "step")
    assert answer["volume"] == pytest.approx(known.volume, rel=1e-9)
    assert answer["area"] == pytest.approx(known.area, rel=1e-9)
    assert answer["tolerance"] <= 1e-6


GMSH = """
import json, sys
import gmsh
gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
gmsh.logger.start()
gmsh.model.occ.importShapes(sys.argv[1])
gmsh.model.occ.synchronize()
gmsh.model.mesh.generate(3)
said = [line for line in gmsh.logger.get() if not line.startswith(("Info", "Progress"))]
volumes = [gmsh.model.occ.getMass(3, tag) for _, tag in gmsh.model.getEntities(3)]
kinds, numbers, _ = gmsh.model.mesh.getElements(3)
count = sum(len(n) for n in numbers)
surfaces = [gmsh.model.getType(2, tag) for _, tag in gmsh.model.getEntities(2)]
gmsh.finalize()
print(json.dumps({"said": said, "volumes": volumes, "tetrahedra": count, "surfaces": surfaces}))
"""


@pytest.mark.interop
@pytest.mark.parametrize("name", SOLIDS)
def test_gmsh_fills_solids_with_tetrahedra(tmp_path, name):
    path = tmp_path / "a.step"
    export(Shapes(breps=(SOLIDS[name].brep,)), path)
    _, answer = ask(GMSH, path)
    assert answer["said"] == []
    # Gmsh integrates with few places a span; the test of OpenCASCADE holds the exact volume.
    assert answer["volumes"] == pytest.approx([SOLIDS[name].volume], rel=2e-3)
    assert answer["tetrahedra"] > 10
    planes = sum(face.surface.is_plane for face in SOLIDS[name].brep.faces)
    assert answer["surfaces"].count("Plane") == planes


@pytest.mark.interop
def test_opencascade_sees_sheets_and_a_partial_turn(tmp_path):
    part = surface_of_revolution(half_circle(5.0), ZERO, UP, 2.0)
    for one, area in ((part, 2 * 2 * 25), (SHEET, None)):
        path = tmp_path / "a.step"
        export(Shapes(breps=(one,)), path)
        said, answer = ask(OPENCASCADE, path)
        assert messages(said) == []
        assert (answer["valid"], answer["solids"], answer["shells"]) == (True, 0, 1)
        if area:
            assert answer["area"] == pytest.approx(area, rel=1e-9)


@pytest.mark.interop
def test_rhino3dm_reads_the_very_surfaces_and_triangles_for_trimmed_ones(tmp_path):
    rhino = pytest.importorskip("rhino3dm")
    path = tmp_path / "a.3dm"
    export(SHAPES, path)
    model = rhino.File3dm.Read(str(path))
    assert [group.Name for group in model.Groups] == ["Can", "Sheet"]
    faces = [*CAN.faces, *SHEET.faces]
    assert len(model.Objects) == len(faces)
    for one, face in zip(model.Objects, faces, strict=True):
        shape = one.Geometry
        assert shape.IsValid
        if not face.is_whole:
            assert shape.ObjectType == rhino.ObjectType.Mesh
            continue
        found = shape.ToNurbsSurface()
        m, n = face.surface.control_points.shape[:2]
        points = [[found.Points[i, j] for j in range(n)] for i in range(m)]
        lifted = np.array([[(p.X, p.Y, p.Z, p.W) for p in row] for row in points])
        np.testing.assert_allclose(lifted[..., 3], face.surface.weights, rtol=1e-15)
        assert list(found.KnotsU) == face.surface.knots_u[1:-1].tolist()


def test_an_author_puts_a_face_together():
    """As the guide for authors says: a surface, loops of trims, edges that agree with them."""
    surface = bent_net(2)
    (u0, u1), (v0, v1) = surface.ranges
    whole = Brep.of_surface(surface)
    corners = [(u0, v0), (u1, v0), (u1, v1), (u0, v1)]
    trims = []
    for number, ends in enumerate(zip(corners, corners[1:] + corners[:1], strict=True)):
        forward = number < 2
        path = ParameterCurve.line(*(ends if forward else ends[::-1]), surface.ranges[number % 2])
        trims.append(Trim(number, forward, path))
    made = Brep(whole.edges, (Face(surface, (tuple(trims),)),))
    assert step(Shapes(breps=(made,))) == step(Shapes(breps=(whole,)))


# -- faces with names and colours of their own -----------------------------------------------------

SHADES = tuple((40 * k, 255 - 40 * k, 7 * k) for k in range(6))


def painted_box(closed=True):
    whole = box(name="Box")
    faces = tuple(
        replace(face, name=f"side {k}", color=shade if k else None)
        for k, (face, shade) in enumerate(zip(whole.faces, SHADES, strict=True))
    )
    made = replace(whole, faces=faces, color=RED)
    return made if closed else sewn([Brep(*_one_face(made, k)) for k in range(5)], "Open", RED)


def _one_face(brep, k):
    face = brep.faces[k]
    used = sorted({trim.edge for trim in face.trims})
    loops = tuple(
        tuple(replace(trim, edge=used.index(trim.edge)) for trim in loop) for loop in face.loops
    )
    return tuple(brep.edges[e] for e in used), (replace(face, loops=loops),)


def shade_of(k):
    return SHADES[k] if k else RED


@pytest.mark.parametrize("closed", [True, False])
def test_obj_has_a_group_for_every_face_over_shared_vertices(closed):
    text = encode_shapes(Shapes(breps=(painted_box(closed),)), "a.obj").decode()
    count = 6 if closed else 5
    assert [line for line in text.splitlines() if line.startswith("g ")] == [
        f"g side_{k}" for k in range(count)
    ]
    assert sum(line.startswith("v ") for line in text.splitlines()) == 8
    for piece in text.split("g side_")[1:]:
        lines = [line for line in piece.splitlines()[1:] if line.startswith("f ")]
        corners = {int(word.partition("/")[0]) for line in lines for word in line.split()[1:]}
        assert len(corners) == 4


def test_glb_has_a_material_for_every_face():
    trimesh = pytest.importorskip("trimesh")
    data = encode_shapes(Shapes(breps=(painted_box(),)), "a.glb")
    scene = trimesh.load_scene(file_obj=trimesh.util.wrap_as_stream(data), file_type="glb")
    linear = {}
    for mesh in scene.geometry.values():
        material = mesh.visual.material
        assert len(mesh.faces) == 2
        linear[material.name] = np.asarray(material.baseColorFactor, float)[:3] / 255
    wanted = {f"side {k}": np.asarray(shade_of(k)) / 255 for k in range(6)}
    assert linear.keys() == wanted.keys()
    for name, shade in wanted.items():
        np.testing.assert_allclose(linear[name], shade**2.2, atol=0.03)


def test_3mf_has_the_colour_of_its_face_on_every_triangle():
    data = encode_shapes(Shapes(breps=(painted_box(),)), "a.3mf")
    with zipfile.ZipFile(io.BytesIO(data)) as package:
        model = package.read("3D/3dmodel.model").decode()
    palette = re.findall(r'<m:color color="#(......)FF"/>', model)
    used = re.findall(r'<triangle [^>]*p1="(\d+)" p2="(\d+)" p3="(\d+)"', model)
    shades = [palette[int(a)] for a, b, c in used if a == b == c]
    wanted = ["{:02X}{:02X}{:02X}".format(*shade_of(k)) for k in range(6) for _ in range(2)]
    assert sorted(shades) == sorted(wanted)


def test_step_and_iges_name_and_paint_every_face():
    shapes = Shapes(breps=(painted_box(),))
    file = Step(step(shapes))
    painted = {face[0]: file.color(number) for number, face in file.of("ADVANCED_FACE")}
    assert painted == {f"side {k}": shade_of(k) for k in range(6)}
    text = iges(shapes).decode()
    assert all(f"side {k}" in text for k in range(6))


def test_faces_keep_names_and_colours_where_they_are_moved_mirrored_and_sewn():
    mirror = Placement((1, 0, 0, 0, -1, 0, 0, 0, 1), 2.0, (1.0, 2.0, 3.0))
    for made in (painted_box().placed(mirror), painted_box(False), sewn([painted_box()])):
        told = {(face.name, face.color or RED) for face in made.faces}
        assert told <= {(f"side {k}", shade_of(k)) for k in range(6)}
        assert len(told) >= 5


def test_groups_hold_all_triangles_and_colours_are_three_bytes():
    mesh = brep_mesh(box())
    with pytest.raises(ValueError, match="all triangles"):
        Solid(mesh, groups=(FaceGroup("a", 3),))
    for color in ((1, 2), (1, 2, 300), "red", (0.5, 0.5, 0.5)):
        part = Solid(mesh, groups=(FaceGroup("a", len(mesh.faces), color),))
        with pytest.raises(Unsound, match="colour"):
            sound_shapes(Shapes(solids=(part,)))


def test_the_exact_form_of_a_part_goes_by_the_name_and_colour_of_the_part():
    part = Solid(brep_mesh(box()), "Lid", RED, exact=box(name="anything"))
    file = Step(step_of(part))
    assert {face[0] for _, face in file.of("ADVANCED_FACE")} == {"Lid"}
    assert {file.color(number) for number, _ in file.of("ADVANCED_FACE")} == {RED}


def step_of(part):
    return encode_shapes(Shapes(solids=(part,)), "a.step")


def test_an_exact_form_that_is_none_is_refused():
    with pytest.raises(Unsound, match="exact form"):
        sound_shapes(Shapes(solids=(Solid(brep_mesh(box()), exact="a box"),)))
