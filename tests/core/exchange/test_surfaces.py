"""Patchworks in STEP and IGES files, read back by parsers of our own, and in mesh formats.

The tests marked "interop" give them to OpenCASCADE and Gmsh, in processes of their own
(BOZZETTO_CAD_READERS names a Python that has them), and to rhino3dm, the extra "rhino".
"""

from __future__ import annotations

import itertools
import re
from collections import Counter
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from bozzetto.cli.output import write_output
from bozzetto.document.model import Document, Model, OpaqueState
from bozzetto.errors import UserError
from bozzetto.exchange.cad import cad_surfaces as surface_pieces
from bozzetto.exchange.cad.iges import write_shapes as iges
from bozzetto.exchange.cad.step import write_shapes as step
from bozzetto.exchange.export import encode_shapes, export
from bozzetto.exchange.import_file import read_mesh
from bozzetto.geometry import Curve, Mesh, Patchwork, Placement, Shapes, Solid
from bozzetto.geometry.patches import tessellation
from bozzetto.geometry.patches.patch import extent, grid
from bozzetto.plugin.guard.checked_values import Unsound
from bozzetto.plugin.guard.shape_validation import sound_shapes
from bozzetto.plugin.host.listing import Standing
from bozzetto.workbench.placed import shapes_in_world
from tests.core.exchange.curve_kit import NAMES, Iges, Step
from tests.core.exchange.test_curve_interop import ask, messages
from tests.core.geometry.body_kit import body
from tests.core.geometry.patches.test_patchwork import ball

EDGES, SIDES, PATCHES, _ = body(2, 0.3)
CAR = Patchwork.of_edges(EDGES, SIDES, "Car", (200, 30, 20), PATCHES)
LINE = Curve(3, [0] * 4 + [1] * 4, EDGES[7] + [0, 0, 55.5], name="Swage", color=(0, 90, 200))
SHAPES = Shapes(patchworks=(CAR,), curves=(LINE,))


def twice(one):
    """Two of a patchwork, which do not hang together, as one."""
    shift = len(one.edges)
    far = one.placed(Placement(offset=(0.0, 9000.0, 0.0)))
    sides = np.where(far.sides < 0, far.sides - shift, far.sides + shift)
    return Patchwork(
        np.vstack((one.nets, far.nets)),
        np.vstack((one.edges, far.edges)),
        np.vstack((one.sides, sides)),
    )


# -- STEP --------------------------------------------------------------------------------------


class Shells:
    """The shells of a STEP file; every reference is followed."""

    def __init__(self, data):
        self.file = Step(data)
        text = [v for record in self.file.instances.values() for v in record.values()]
        assert set(re.findall(r"#\d+", str(text))) <= set(self.file.instances)
        self.models = [self.model(m) for _, m in self.file.of("SHELL_BASED_SURFACE_MODEL")]
        self.solids = [
            self.model((name, [shell])) for _, (name, shell) in self.file.of("MANIFOLD_SOLID_BREP")
        ]

    def get(self, number, kind):
        return self.file.instances[number][kind]

    def model(self, arguments):
        name, shells = arguments
        found = []
        for shell in shells:
            ((kind, (_, faces)),) = self.file.instances[shell].items()
            found.append((kind, [self.face(f) for f in faces]))
        return name, found

    def point(self, number):
        return self.get(number, "CARTESIAN_POINT")[1]

    def face(self, number):
        name, (bound,), surface, sense = self.get(number, "ADVANCED_FACE")
        assert sense == ".T."
        _, loop, sense = self.get(bound, "FACE_OUTER_BOUND")
        assert sense == ".T."
        run = []
        for oriented in self.get(loop, "EDGE_LOOP")[1]:
            _, start, end, edge, sense = self.get(oriented, "ORIENTED_EDGE")
            assert (start, end) == ("*", "*")
            run.append((edge, sense))
        label, *spline = self.get(surface, "B_SPLINE_SURFACE_WITH_KNOTS")
        assert label == name
        assert spline[:2] == [3, 3]
        assert spline[3:] == [".UNSPECIFIED.", ".F.", ".F.", ".U.", [4, 4], [4, 4], [0.0, 1.0],
                              [0.0, 1.0], ".UNSPECIFIED."]  # fmt: skip
        net = np.array([[self.point(p) for p in row] for row in spline[2]])
        return SimpleNamespace(number=number, name=name, run=run, net=net)

    def edge(self, number, sense):
        """Vertices and control points of an edge in the sense of its loop."""
        _, start, end, curve, same = self.get(number, "EDGE_CURVE")
        assert same == ".T."
        points = self.file.curve(curve).control_points
        for vertex, place in ((start, points[0]), (end, points[-1])):
            assert self.point(self.get(vertex, "VERTEX_POINT")[1]) == place.tolist()
        return (start, end, points) if sense == ".T." else (end, start, points[::-1])


def test_step_holds_the_very_patches_in_one_open_shell():
    ((name, ((kind, faces),)),) = Shells(step(SHAPES)).models
    assert (name, kind) == ("Car", "OPEN_SHELL")
    assert [f.name for f in faces] == list(PATCHES)
    np.testing.assert_array_equal([f.net for f in faces], CAR.nets)


def test_faces_in_step_share_their_edges_in_opposite_senses():
    file = Shells(step(SHAPES))
    ((_, ((_, faces),)),) = file.models
    senses = {}
    vertices = set()
    for face in faces:
        run = [file.edge(*one) for one in face.run]
        south, east, north, west = (points for _, _, points in run)
        np.testing.assert_array_equal(south, face.net[:, 0])
        np.testing.assert_array_equal(east, face.net[3])
        np.testing.assert_array_equal(north, face.net[::-1, 3])
        np.testing.assert_array_equal(west, face.net[0, ::-1])
        for (_, end, _), (start, _, _) in itertools.pairwise(run + run[:1]):
            assert end == start
            vertices.add(end)
        for edge, sense in face.run:
            senses.setdefault(edge, []).append(sense)
    assert Counter(tuple(sorted(s)) for s in senses.values())[".F.", ".T."] == 50
    assert Counter(map(len, senses.values())) == {2: 50, 1: 12}
    assert len(vertices) == 35


def test_step_holds_curves_beside_surfaces_in_one_product():
    file = Step(step(SHAPES))
    (found,) = file.curves()
    np.testing.assert_array_equal(found.control_points, LINE.control_points)
    assert found.name == "Swage"
    kinds = {next(iter(file.instances[shape])): product
             for _, (product, shape) in file.of("SHAPE_DEFINITION_REPRESENTATION")}  # fmt: skip
    assert set(kinds) == {
        "MANIFOLD_SURFACE_SHAPE_REPRESENTATION",
        "GEOMETRICALLY_BOUNDED_WIREFRAME_SHAPE_REPRESENTATION",
    }
    assert len(set(kinds.values())) == 1
    ((_, product),) = file.of("PRODUCT")
    assert product[0] == "Car"


def test_faces_and_curves_in_step_have_their_colours():
    file = Shells(step(SHAPES))
    ((_, ((_, faces),)),) = file.models
    tints = {}
    for _, (_, (style,), item) in file.file.of("STYLED_ITEM"):
        (shade,) = file.get(style, "PRESENTATION_STYLE_ASSIGNMENT")[0]
        if "SURFACE_STYLE_USAGE" in file.file.instances[shade]:
            both, side = file.get(shade, "SURFACE_STYLE_USAGE")
            assert both == ".BOTH."
            (fill,) = file.get(side, "SURFACE_SIDE_STYLE")[1]
            (area,) = file.get(fill, "SURFACE_STYLE_FILL_AREA")
            (tint,) = file.get(area, "FILL_AREA_STYLE")[1]
            tint = file.get(tint, "FILL_AREA_STYLE_COLOUR")[1]
        else:
            tint = file.get(shade, "CURVE_STYLE")[3]
        tints[item] = tuple(round(255 * v) for v in file.get(tint, "COLOUR_RGB")[1:])
    assert [tints.pop(f.number) for f in faces] == [CAR.color] * 28
    assert list(tints.values()) == [LINE.color]


def test_a_closed_skin_is_a_solid_and_two_parts_are_two_shells():
    ((_, shells),) = Shells(step(Shapes(patchworks=(ball(),)))).solids
    assert [(kind, len(faces)) for kind, faces in shells] == [("CLOSED_SHELL", 6)]
    ((_, shells),) = Shells(step(Shapes(patchworks=(twice(CAR),)))).models
    assert [(kind, len(faces)) for kind, faces in shells] == [("OPEN_SHELL", 28)] * 2


def test_several_patchworks_are_several_models():
    file = Shells(step(Shapes(patchworks=(CAR, ball()))))
    assert [name for name, _ in file.models] == ["Car"]
    assert [name for name, _ in file.solids] == ["Ball"]
    for kind in ("ADVANCED_BREP", "MANIFOLD_SURFACE"):
        ((_, (title, items, _)),) = file.file.of(f"{kind}_SHAPE_REPRESENTATION")
        assert (title, len(items)) == ("Surfaces", 2)


# -- IGES --------------------------------------------------------------------------------------


class Nets(Iges):
    """The patches of an IGES file and their groups."""

    def label(self, values):
        associated, properties, pointer = map(int, values[-3:])
        assert (associated, properties) == (0, 1)
        kind, form, _, (count, name) = self.entities[pointer]
        assert (kind, form, int(count)) == (406, 15, 1)
        return name

    def patches(self):
        found = {}
        for number, (kind, form, color, values) in self.entities.items():
            if kind == 128:
                assert form == 0
                assert values[:9] == ["3", "3", "3", "3", "0", "0", "1", "0", "0"]
                numbers = np.array([float(v.replace("D", "E")) for v in values[9:-3]])
                knots, weights, places, ends = np.split(numbers, [16, 32, 80])
                assert knots.tolist() == ([0] * 4 + [1] * 4) * 2
                assert (weights == 1).all()
                assert ends.tolist() == [0, 1, 0, 1]
                shades = self.entities[-color][3] if color else None
                tint = shades and tuple(
                    round(2.55 * float(v.replace("D", "E"))) for v in shades[:3]
                )
                net = places.reshape(4, 4, 3).transpose(1, 0, 2)
                found[number] = (self.label(values), net, tint)
        return found

    def groups(self):
        return [(self.label(values), [int(v) for v in values[1:-3]], form, int(values[0]))
                for kind, form, _, values in self.entities.values() if kind == 402]  # fmt: skip


def test_iges_holds_the_very_patches_in_a_group():
    file = Nets(iges(SHAPES))
    patches = file.patches()
    assert [name for name, _, _ in patches.values()] == list(PATCHES)
    np.testing.assert_array_equal([net for _, net, _ in patches.values()], CAR.nets)
    assert {tint for _, _, tint in patches.values()} == {CAR.color}
    assert file.groups() == [("Car", list(patches), 7, 28)]
    (curve,) = file.curves()
    np.testing.assert_array_equal(curve.control_points, LINE.control_points)
    assert (curve.name, curve.color) == ("Swage", LINE.color)
    assert file.settings[13:15] == ["2", "MM"]
    assert float(file.settings[19].replace("D", "E")) == np.abs(CAR.nets).max()


# -- both --------------------------------------------------------------------------------------


@pytest.mark.parametrize("write", [step, iges])
def test_equal_skins_give_equal_files(write):
    assert write(SHAPES) == write(Shapes(patchworks=(replace(CAR),), curves=(LINE,)))


@pytest.mark.parametrize("write", [step, iges])
def test_numbers_of_every_size_keep_all_digits(write):
    rng = np.random.default_rng(3)
    edges = EDGES * 10.0 ** rng.integers(-9, 6) + 1 / 3
    one = Patchwork.of_edges(edges, SIDES)
    data = write(Shapes(patchworks=(one,)))
    if write is step:
        ((_, ((_, faces),)),) = Shells(data).models
        found = [f.net for f in faces]
    else:
        found = [net for _, net, _ in Nets(data).patches().values()]
    np.testing.assert_array_equal(found, one.nets)


@pytest.mark.parametrize("name", NAMES)
def test_odd_names(name):
    one = replace(CAR, name=name, patch_names=(name,) * 28)
    ((model, ((_, faces),)),) = Shells(step(Shapes(patchworks=(one,)))).models
    said = re.sub("[\x00-\x1f\x7f-\x9f\ud800-\udfff]", " ", name).strip()
    assert {model, *(f.name for f in faces)} == {said}
    file = Nets(iges(Shapes(patchworks=(one,))))
    for label, _, _ in file.patches().values():
        assert label.isascii()


def test_patches_without_names_have_that_of_the_whole():
    one = Shapes(patchworks=(replace(CAR, patch_names=()),))
    ((_, ((_, faces),)),) = Shells(step(one)).models
    assert {f.name for f in faces} == {"Car"}
    assert {name for name, _, _ in Nets(iges(one)).patches().values()} == {"Car"}


# -- refused -----------------------------------------------------------------------------------


def poisoned(attribute, value):
    """A patchwork with a number that its maker let through."""
    one = replace(CAR)
    array = np.array(getattr(one, attribute))
    array.flat[5] = value
    object.__setattr__(one, attribute, array)
    return one


def pinched():
    """One of a square's edges is a point."""
    corners = np.array([[0, 0, 0], [9, 0, 0], [9, 9, 0], [9, 9, 0], [0, 0, 0]], float)
    edges = [np.linspace(a, b, 4) for a, b in itertools.pairwise(corners)]
    return Patchwork.of_edges(edges, [[0, 1, 2, 3]], "Wedge")


@pytest.mark.parametrize("ending", ["step", "iges"])
@pytest.mark.parametrize(
    ("one", "said"),
    [
        (poisoned("nets", np.nan), "“Car” holds a number that is not finite"),
        (poisoned("edges", np.inf), "not finite"),
        (CAR.placed(Placement(scale=1e6)), "further"),
        (pinched(), "“Wedge” has no length"),
    ],
)
def test_what_no_reader_could_use_is_refused(tmp_path, ending, one, said):
    with pytest.raises(UserError, match=said):
        export(Shapes(patchworks=(one,)), tmp_path / f"a.{ending}")
    assert not list(tmp_path.iterdir())


def test_more_points_than_can_be_written_are_refused(monkeypatch):
    monkeypatch.setattr(surface_pieces, "MAX_CONTROL_POINTS", 600)
    with pytest.raises(UserError, match="696 control points"):
        step(SHAPES)


@pytest.mark.parametrize("ending", ["dxf", "svg"])
def test_flat_formats_say_where_surfaces_go(ending):
    with pytest.raises(UserError, match=r"curves.*and there are none\. Use one of") as caught:
        encode_shapes(Shapes(patchworks=(CAR,)), f"a.{ending}")
    for known in (".stl", ".glb", ".step", ".iges", ".3dm"):
        assert caught.value.message.count(known) == 1
    assert "a drawing of its outlines" in caught.value.message


def test_meshes_are_no_exact_surfaces():
    tetra = Mesh(np.vstack((np.zeros(3), np.eye(3))), [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    with pytest.raises(UserError, match="holds exact surfaces or curves, and there are none"):
        encode_shapes(Shapes(solids=(Solid(tetra),)), "a.step")


# -- meshes ------------------------------------------------------------------------------------


@pytest.mark.parametrize("ending", ["stl", "obj", "ply", "glb"])
def test_mesh_formats_hold_triangles_that_close_along_every_edge(tmp_path, ending, monkeypatch):
    monkeypatch.setattr(tessellation, "TOLERANCE", 1e-3)  # of the size; ten times the usual
    path = tmp_path / f"a.{ending}"
    export(SHAPES, path)
    (part,) = read_mesh(path).meshes()
    vertices, which = np.unique(part.mesh.vertices, axis=0, return_inverse=True)
    faces = which[part.mesh.faces].astype(np.int64)
    runs = np.stack((faces, np.roll(faces, -1, axis=1)), axis=-1).reshape(-1, 2)
    there, back = (np.sort(r[:, 0] * len(vertices) + r[:, 1]) for r in (runs, runs[:, ::-1]))
    assert (np.diff(there) > 0).all()  # no edge twice in one sense
    free = np.setdiff1d(there, back)
    starts, ends = np.divmod(free, len(vertices))
    assert np.array_equal(np.sort(starts), np.sort(ends))
    assert (vertices[starts, 2] < 400).all()  # only the rim below is open
    np.testing.assert_allclose(part.mesh.bounds, extent(CAR.nets), atol=6.0)
    if ending == "glb":
        assert part.name == "Car"
        assert {group.color for group in part.groups} == {CAR.color}
        assert [group.name for group in part.groups] == list(CAR.patch_names)


def test_the_command_line_hands_a_skin_over(tmp_path):
    document = Document((Model("m1", "Car", "author.car", OpaqueState(1, b"{}")),))
    bench = SimpleNamespace(
        shapes=lambda models, job: SHAPES if len(models) else Shapes(),
        registry=SimpleNamespace(standing=lambda modeler: Standing("ready", "author.car")),
        is_usable=lambda model: True,
        cautions=lambda model, job: (),
    )
    write_output(bench, document, tmp_path / "out" / "car.STP")
    assert (tmp_path / "out" / "car.STP").read_bytes() == step(SHAPES)
    with pytest.raises(UserError, match=r"“\.3ds” cannot be used here.*\.step"):
        write_output(bench, document, tmp_path / "car.3ds")


def test_3mf_takes_them_too():
    assert len(encode_shapes(Shapes(patchworks=(CAR,)), "a.3mf")) > 10_000


# -- between modelers and files ----------------------------------------------------------------


def test_a_skin_is_named_coloured_and_placed_as_its_model():
    one = Shapes(patchworks=(replace(CAR, name="skin", color=None),))
    placement = Placement(offset=(0.0, 0.0, 10.0))
    model = SimpleNamespace(name="Coupé", color=(1, 2, 3), placement=placement)
    (found,) = shapes_in_world(one, model).patchworks
    assert (found.name, found.color, found.patch_names) == ("Coupé", (1, 2, 3), PATCHES)
    np.testing.assert_allclose(found.nets - CAR.nets, np.tile([0, 0, 10.0], (28, 4, 4, 1)))


@pytest.mark.parametrize(
    "one",
    [poisoned("nets", np.nan), poisoned("edges", -np.inf), replace(CAR, name=3),
     replace(CAR, patch_names=(1,) * 28), "a car"],
)  # fmt: skip
def test_the_guard_refuses_unsound_skins(one):
    with pytest.raises(Unsound):
        sound_shapes(Shapes(patchworks=(one,)))
    assert sound_shapes(SHAPES) is SHAPES


# -- independent readers -----------------------------------------------------------------------

OPENCASCADE = """
import json, sys
from OCP.BRep import BRep_Tool
from OCP.BRepBuilderAPI import BRepBuilderAPI_Sewing
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.IFSelect import IFSelect_PrintCount, IFSelect_ReturnStatus
from OCP.IGESControl import IGESControl_Reader
from OCP.STEPControl import STEPControl_Reader
from OCP.TopAbs import TopAbs_EDGE, TopAbs_FACE, TopAbs_SHELL
from OCP.TopExp import TopExp_Explorer
from OCP.TopoDS import TopoDS
path = sys.argv[1]
reader = STEPControl_Reader() if path.endswith("step") else IGESControl_Reader()
assert reader.ReadFile(path) == IFSelect_ReturnStatus.IFSelect_RetDone
reader.PrintCheckLoad(False, IFSelect_PrintCount.IFSelect_ItemsByEntity)
roots = reader.TransferRoots()
reader.PrintCheckTransfer(False, IFSelect_PrintCount.IFSelect_ItemsByEntity)
shape = reader.OneShape()

def each(kind):
    explorer = TopExp_Explorer(shape, kind)
    while explorer.More():
        yield explorer.Current()
        explorer.Next()

at = [k / 6 for k in range(7)]
faces = []
for found in each(TopAbs_FACE):
    surface = BRep_Tool.Surface_s(TopoDS.Face(found))
    places = [surface.Value(u, v) for u in at for v in at]
    faces.append([[p.X(), p.Y(), p.Z()] for p in places])
edges = []
for found in each(TopAbs_EDGE):
    curve = BRep_Tool.Curve_s(TopoDS.Edge(found), 0.0, 1.0)
    places = [curve.Value(u) for u in at]
    edges.append([[p.X(), p.Y(), p.Z()] for p in places])
sewing = BRepBuilderAPI_Sewing(1e-6)
sewing.Add(shape)
sewing.Perform()
print()
print(json.dumps({
    "roots": roots, "shells": len(list(each(TopAbs_SHELL))), "faces": faces, "edges": edges,
    "valid": BRepCheck_Analyzer(shape).IsValid(), "free": sewing.NbFreeEdges(),
}))
"""


@pytest.mark.interop
@pytest.mark.parametrize("ending", ["step", "iges"])
@pytest.mark.parametrize("shapes", [SHAPES, Shapes(patchworks=(CAR,))])
def test_opencascade_reads_the_very_skin_without_a_message(tmp_path, ending, shapes):
    path = tmp_path / f"a.{ending}"
    export(shapes, path)
    said, answer = ask(OPENCASCADE, path)
    assert messages(said) == []
    assert answer["valid"]
    assert answer["free"] == 12
    assert answer["shells"] == (ending == "step")
    at = np.linspace(0, 1, 7)
    expected = grid(CAR.nets, at, at).reshape(28, 49, 3)
    assert np.abs(np.array(answer["faces"]) - expected).max() <= 1e-9
    lines = np.einsum("nk,mkx->mnx", bernstein_by_powers(at), CAR.edges)
    styled = np.reshape([c.control_points for c in shapes.curves], (-1, 4, 3))
    wires = np.einsum("nk,mkx->mnx", bernstein_by_powers(at), styled)
    known = np.concatenate((lines, lines[:, ::-1], wires))
    assert len(answer["edges"]) == 112 + len(shapes.curves)
    for found in np.array(answer["edges"]):
        assert np.abs(known - found).max(axis=(1, 2)).min() <= 1e-9
    for wire in wires:
        assert np.abs(np.array(answer["edges"]) - wire).max(axis=(1, 2)).min() <= 1e-9


def bernstein_by_powers(t):
    """Cubic Bernstein polynomials out of their powers."""
    powers = np.array([[1, -3, 3, -1], [0, 3, -6, 3], [0, 0, 3, -3], [0, 0, 0, 1]])
    return np.vander(t, 4, increasing=True) @ powers.T


@pytest.mark.interop
def test_opencascade_takes_any_name_of_a_skin(tmp_path):
    names = tuple(itertools.islice(itertools.cycle(NAMES), 28))
    path = tmp_path / "a.step"
    export(Shapes(patchworks=(replace(CAR, name=NAMES[0], patch_names=names),)), path)
    said, answer = ask(OPENCASCADE, path)
    assert messages(said) == []
    assert (len(answer["faces"]), answer["free"]) == (28, 12)


@pytest.mark.interop
def test_opencascade_sees_a_closed_shell_and_two_open_ones(tmp_path):
    for one, free, shells in ((ball(), 0, 1), (twice(CAR), 24, 2)):
        path = tmp_path / "a.step"
        export(Shapes(patchworks=(one,)), path)
        said, answer = ask(OPENCASCADE, path)
        assert messages(said) == []
        assert (answer["free"], answer["shells"], answer["valid"]) == (free, shells, True)


GMSH = """
import json, sys
import gmsh
gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
gmsh.logger.start()
gmsh.model.occ.importShapes(sys.argv[1], highestDimOnly=False)
gmsh.model.occ.synchronize()
at = [k / 6 for k in range(7)]
both = [x for u in at for v in at for x in (u, v)]
faces = []
for _, tag in gmsh.model.getEntities(2):
    flat = [float(v) for v in gmsh.model.getValue(2, tag, both)]
    places = [flat[k : k + 3] for k in range(0, len(flat), 3)]
    faces.append([places, gmsh.model.getColor(2, tag)[:3]])
sides = [len(gmsh.model.getAdjacencies(1, tag)[0]) for _, tag in gmsh.model.getEntities(1)]
said = [line for line in gmsh.logger.get() if not line.startswith("Info")]
count = [len(gmsh.model.getEntities(d)) for d in range(3)]
gmsh.finalize()
print(json.dumps({"said": said, "faces": faces, "sides": sides, "count": count}))
"""


@pytest.mark.interop
@pytest.mark.parametrize("ending", ["step", "iges"])
def test_gmsh_reads_the_very_skin(tmp_path, ending):
    path = tmp_path / f"a.{ending}"
    export(SHAPES, path)
    _, answer = ask(GMSH, path)
    assert answer["said"] == []
    at = np.linspace(0, 1, 7)
    expected = grid(CAR.nets, at, at).reshape(28, 49, 3)
    assert np.abs(np.array([f for f, _ in answer["faces"]]) - expected).max() <= 1e-9
    assert {tuple(color) for _, color in answer["faces"]} == {CAR.color}
    if ending == "step":
        assert answer["count"] == [35 + 2, 62 + 1, 28]
        assert Counter(answer["sides"]) == {2: 50, 1: 12, 0: 1}
    else:
        assert answer["count"][2] == 28


@pytest.mark.interop
def test_rhino3dm_reads_the_very_numbers(tmp_path):
    rhino = pytest.importorskip("rhino3dm")
    path = tmp_path / "a.3dm"
    export(Shapes(patchworks=(CAR, replace(ball(), name="[ball")), curves=(LINE,)), path)
    model = rhino.File3dm.Read(str(path))
    assert model.Settings.ModelUnitSystem == rhino.UnitSystem.Millimeters
    assert [group.Name for group in model.Groups] == ["Car", "_[ball"]
    nets = np.vstack((CAR.nets, ball().nets))
    assert len(model.Objects) == len(nets) + 1
    for number, (one, net) in enumerate(zip(list(model.Objects)[:-1], nets, strict=True)):
        shape, look = one.Geometry, one.Attributes
        assert shape.IsValid
        surface = shape.ToNurbsSurface()
        assert list(surface.KnotsU) == list(surface.KnotsV) == [0, 0, 0, 1, 1, 1]
        points = [[surface.Points[i, j] for j in range(4)] for i in range(4)]
        found = np.array([[(p.X, p.Y, p.Z, p.W) for p in row] for row in points])
        np.testing.assert_array_equal(found[..., :3], net)
        assert (found[..., 3] == 1).all()
        assert look.GroupCount == 1
        assert look.GetGroupList()[0] == (number >= 28)
        assert look.Name == (PATCHES[number] if number < 28 else "_[ball")
        if number < 28:
            assert look.ObjectColor[:3] == CAR.color
    assert model.Objects[len(nets)].Attributes.Name == "Swage"
