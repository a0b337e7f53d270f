"""STEP and IGES of other programs and of ours, read as bodies: against closed forms."""

from __future__ import annotations

import random

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.exchange.export import export
from bozzetto.exchange.import_file import read_mesh_file
from bozzetto.exchange.mesh.manifold_check import enclosed_volume
from bozzetto.geometry import Curve, Shapes
from bozzetto.geometry.shapes import FaceGroup

pytest.importorskip("OCP", reason="the extra “cad” is not installed")
pytestmark = pytest.mark.interop

BOTH = pytest.mark.parametrize("ending", ["step", "igs"])


def kit():
    from OCP import BRepAlgoAPI, BRepBuilderAPI, BRepPrimAPI, gp

    return BRepPrimAPI, BRepAlgoAPI, BRepBuilderAPI, gp


def solids():
    """Shapes of every usual kind of surface, with their volumes."""
    make, cut, _, gp = kit()
    ball = make.BRepPrimAPI_MakeSphere(20.0).Shape()
    bored = cut.BRepAlgoAPI_Cut(
        make.BRepPrimAPI_MakeBox(40.0, 30.0, 20.0).Shape(),
        make.BRepPrimAPI_MakeCylinder(
            gp.gp_Ax2(gp.gp_Pnt(20.0, 15.0, -1.0), gp.gp_Dir(0.0, 0.0, 1.0)), 8.0, 40.0
        ).Shape(),
    ).Shape()
    return {
        "box": (make.BRepPrimAPI_MakeBox(10.0, 20.0, 30.0).Shape(), 6000.0),
        "ball": (ball, 4 / 3 * np.pi * 20.0**3),
        "cone": (make.BRepPrimAPI_MakeCone(10.0, 4.0, 30.0).Shape(), np.pi * 10 * 156),
        "torus": (make.BRepPrimAPI_MakeTorus(30.0, 8.0).Shape(), 2 * np.pi**2 * 30 * 64),
        "bored": (bored, 24000.0 - np.pi * 64 * 20),
    }


def written(shape, path):
    if path.suffix == ".step":
        from OCP.STEPControl import STEPControl_StepModelType, STEPControl_Writer

        writer = STEPControl_Writer()
        writer.Transfer(shape, STEPControl_StepModelType.STEPControl_AsIs)
    else:
        from OCP.IGESControl import IGESControl_Writer

        writer = IGESControl_Writer("MM", 1)
        writer.AddShape(shape)
    writer.Write(str(path))
    return path


@BOTH
@pytest.mark.parametrize("name", ["box", "ball", "cone", "torus", "bored"])
def test_bodies_are_closed_and_of_the_right_size(tmp_path, name, ending):
    shape, volume = solids()[name]
    read = read_mesh_file(written(shape, tmp_path / f"{name}.{ending}"), trusted=True)
    (solid,) = read.shapes.solids
    assert not read.shapes.surfaces
    assert enclosed_volume(solid.mesh) == pytest.approx(volume, rel=0.01)
    assert read.guess is None
    (said,) = read.left_out
    assert "the exact surfaces" in said
    count = sum(len(part.mesh.faces) for part in read.shapes.meshes())
    assert f"{count:,} triangles" in said


def assembly(path):
    """Two of one red product at two places, and a blue box with a green face."""
    from OCP.Quantity import Quantity_Color, Quantity_TypeOfColor
    from OCP.STEPCAFControl import STEPCAFControl_Writer
    from OCP.TCollection import TCollection_ExtendedString as Text
    from OCP.TDataStd import TDataStd_Name
    from OCP.TDocStd import TDocStd_Document
    from OCP.TopAbs import TopAbs_ShapeEnum
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopLoc import TopLoc_Location
    from OCP.XCAFDoc import XCAFDoc_ColorType, XCAFDoc_DocumentTool

    make, _, _, gp = kit()
    document = TDocStd_Document(Text("x"))
    tool = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
    paint = XCAFDoc_DocumentTool.ColorTool_s(document.Main())

    def color(what, *values):
        shade = Quantity_Color(*values, Quantity_TypeOfColor.Quantity_TOC_sRGB)
        paint.SetColor(what, shade, XCAFDoc_ColorType.XCAFDoc_ColorSurf)

    wheel = tool.AddShape(make.BRepPrimAPI_MakeCylinder(5.0, 2.0).Shape(), False)
    box = make.BRepPrimAPI_MakeBox(10.0, 10.0, 10.0).Shape()
    case = tool.AddShape(box, False)
    color(wheel, 1.0, 0.0, 0.0)
    color(case, 0.0, 0.0, 1.0)
    color(TopExp_Explorer(box, TopAbs_ShapeEnum.TopAbs_FACE).Current(), 0.0, 1.0, 0.0)
    whole = tool.NewShape()
    for label, x in ((wheel, 0.0), (wheel, 100.0), (case, 50.0)):
        move = gp.gp_Trsf()
        move.SetTranslation(gp.gp_Vec(x, 0.0, 0.0))
        tool.AddComponent(whole, label, TopLoc_Location(move))
    for label, name in ((wheel, "Wheel"), (case, "Case"), (whole, "Cart")):
        TDataStd_Name.Set_s(label, Text(name))
    tool.UpdateAssemblies()
    writer = STEPCAFControl_Writer()
    writer.Transfer(document)
    writer.Write(str(path))
    return path


@pytest.mark.parametrize("trusted", [True, False], ids=["here", "process"])
def test_assemblies_keep_names_places_and_colours(tmp_path, trusted):
    parts = read_mesh_file(assembly(tmp_path / "a.step"), trusted=trusted).shapes.solids
    wheels = [part for part in parts if part.name == "Wheel"]
    (case,) = (part for part in parts if part.name == "Case")
    assert len(parts) == 3
    middles = sorted(float(part.mesh.bounds[:, 0].mean()) for part in wheels)
    assert middles == pytest.approx([0.0, 100.0], abs=0.1)
    assert {part.color for part in wheels} == {(255, 0, 0)}
    assert float(case.mesh.bounds[0][0]) == pytest.approx(50.0)
    assert {(group.color, group.count) for group in case.groups} == {
        ((0, 255, 0), 2),
        ((0, 0, 255), 10),
    }


def looks(path, alpha):
    """Red wheels, one used in green; a blue pane; and in a yellow assembly a box without colour."""
    from OCP.Quantity import Quantity_Color, Quantity_ColorRGBA, Quantity_TypeOfColor
    from OCP.STEPCAFControl import STEPCAFControl_Writer
    from OCP.TCollection import TCollection_ExtendedString as Text
    from OCP.TDataStd import TDataStd_Name
    from OCP.TDocStd import TDocStd_Document
    from OCP.TopLoc import TopLoc_Location
    from OCP.XCAFDoc import XCAFDoc_ColorType, XCAFDoc_DocumentTool

    make, _, _, gp = kit()
    document = TDocStd_Document(Text("x"))
    tool = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
    paint = XCAFDoc_DocumentTool.ColorTool_s(document.Main())

    def color(what, rgb, alpha=1.0):
        shade = Quantity_Color(*rgb, Quantity_TypeOfColor.Quantity_TOC_sRGB)
        seen = Quantity_ColorRGBA(shade, alpha) if alpha < 1.0 else shade
        paint.SetColor(what, seen, XCAFDoc_ColorType.XCAFDoc_ColorSurf)

    def place(x):
        move = gp.gp_Trsf()
        move.SetTranslation(gp.gp_Vec(x, 0.0, 0.0))
        return TopLoc_Location(move)

    wheel = tool.AddShape(make.BRepPrimAPI_MakeCylinder(5.0, 2.0).Shape(), False)
    pane = tool.AddShape(make.BRepPrimAPI_MakeBox(5.0, 2.0, 1.0).Shape(), False)
    plain = tool.AddShape(make.BRepPrimAPI_MakeBox(7.0, 2.0, 1.0).Shape(), False)
    color(wheel, (1.0, 0.0, 0.0))
    color(pane, (0.0, 0.0, 1.0), alpha)
    inner, whole = tool.NewShape(), tool.NewShape()
    tool.AddComponent(inner, plain, place(0.0))
    tool.AddComponent(inner, wheel, place(10.0))
    tool.AddComponent(whole, wheel, place(0.0))
    green = tool.AddComponent(whole, wheel, place(100.0))
    tool.AddComponent(whole, pane, place(50.0))
    yellow = tool.AddComponent(whole, inner, place(200.0))
    color(green, (0.0, 1.0, 0.0))
    color(yellow, (1.0, 1.0, 0.0))
    named = ((wheel, "Wheel"), (pane, "Pane"), (plain, "Plain"), (inner, "Inner"), (whole, "Cart"))
    for label, name in named:
        TDataStd_Name.Set_s(label, Text(name))
    tool.UpdateAssemblies()
    writer = STEPCAFControl_Writer()
    writer.Transfer(document)
    writer.Write(str(path))
    return path


@pytest.mark.parametrize(("alpha", "finish"), [(0.3, "glass"), (0.95, "matt"), (1.0, "matt")])
def test_where_a_part_is_used_it_may_have_another_colour_and_clear_ones_are_glass(
    tmp_path, alpha, finish
):
    parts = read_mesh_file(looks(tmp_path / "a.step", alpha)).shapes.solids
    found = {}
    for part in parts:
        (group,) = part.groups or (FaceGroup(part.name, 0, part.color),)
        at = round(float(part.mesh.bounds[:, 0].mean()))
        found[part.name, at] = (group.color or part.color, group.finish)
    assert found == {
        ("Wheel", 0): ((255, 0, 0), "matt"),
        ("Wheel", 100): ((0, 255, 0), "matt"),
        ("Pane", 52): ((0, 0, 255), finish),
        ("Plain", 204): ((255, 255, 0), "matt"),
        ("Wheel", 210): ((255, 0, 0), "matt"),
    }


def nested(path, unit):
    """A bracket of a plate and two pins, twice on a frame, written in a unit."""
    from OCP.Interface import Interface_Static
    from OCP.Quantity import Quantity_Color, Quantity_TypeOfColor
    from OCP.STEPCAFControl import STEPCAFControl_Writer
    from OCP.TCollection import TCollection_ExtendedString as Text
    from OCP.TDataStd import TDataStd_Name
    from OCP.TDocStd import TDocStd_Document
    from OCP.TopLoc import TopLoc_Location
    from OCP.XCAFDoc import XCAFDoc_ColorType, XCAFDoc_DocumentTool

    make, _, _, gp = kit()
    document = TDocStd_Document(Text("x"))
    tool = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
    paint = XCAFDoc_DocumentTool.ColorTool_s(document.Main())

    def place(x, y, z, degrees):
        turn, move = gp.gp_Trsf(), gp.gp_Trsf()
        axis = gp.gp_Ax1(gp.gp_Pnt(0, 0, 0), gp.gp_Dir(1, 0, 0))
        turn.SetRotation(axis, np.radians(degrees))
        move.SetTranslation(gp.gp_Vec(x, y, z))
        return TopLoc_Location(move * turn)

    plate = tool.AddShape(make.BRepPrimAPI_MakeBox(40.0, 30.0, 4.0).Shape(), False)
    pin = tool.AddShape(make.BRepPrimAPI_MakeBox(2.0, 3.0, 20.0).Shape(), False)
    for label, red, name in ((plate, 0.0, "Plate"), (pin, 1.0, "Pin")):
        shade = Quantity_Color(red, 0.0, 1.0, Quantity_TypeOfColor.Quantity_TOC_sRGB)
        paint.SetColor(label, shade, XCAFDoc_ColorType.XCAFDoc_ColorSurf)
        TDataStd_Name.Set_s(label, Text(name))
    bracket, frame = tool.NewShape(), tool.NewShape()
    tool.AddComponent(bracket, plate, place(0, 0, 0, 0))
    tool.AddComponent(bracket, pin, place(5, 5, 4, 0))
    tool.AddComponent(bracket, pin, place(30, 5, 4, 90))
    tool.AddComponent(frame, bracket, place(0, 0, 0, 0))
    tool.AddComponent(frame, bracket, place(100, 0, 50, 90))
    TDataStd_Name.Set_s(bracket, Text("Bracket"))
    TDataStd_Name.Set_s(frame, Text("Frame"))
    tool.UpdateAssemblies()
    writer = STEPCAFControl_Writer()
    Interface_Static.SetCVal_s("write.step.unit", unit)
    try:
        writer.Transfer(document)
        writer.Write(str(path))
    finally:
        Interface_Static.SetCVal_s("write.step.unit", "MM")
    return path


def turned(low, high, place, degrees):
    """Corners of a box that is turned about x by quarters and then moved."""
    c, s = round(np.cos(np.radians(degrees))), round(np.sin(np.radians(degrees)))
    both = np.array([low, high]) @ np.array([[1, 0, 0], [0, c, -s], [0, s, c]]).T + place
    return both.min(axis=0), both.max(axis=0)


@pytest.mark.parametrize("unit", ["MM", "INCH", "M"])
def test_assemblies_in_assemblies_stand_where_they_belong_in_any_unit(tmp_path, unit):
    path = nested(tmp_path / "a.step", unit)
    assert ("INCH" in path.read_text().upper()) == (unit == "INCH")
    parts = read_mesh_file(path).shapes.solids
    own = {
        "Plate": [turned((0, 0, 0), (40, 30, 4), (0, 0, 0), 0)],
        "Pin": [
            turned((0, 0, 0), (2, 3, 20), (5, 5, 4), 0),
            turned((0, 0, 0), (2, 3, 20), (30, 5, 4), 90),
        ],
    }
    assert len(parts) == 6
    for name, boxes in own.items():
        found = [part for part in parts if part.name == name]
        wanted = boxes + [turned(*box, (100, 0, 50), 90) for box in boxes]
        seen = sorted(tuple(np.round(part.mesh.bounds, 3).ravel().tolist()) for part in found)
        np.testing.assert_allclose(seen, sorted(tuple(np.ravel(box)) for box in wanted), atol=2e-3)
        assert {part.color for part in found} == {(255 if name == "Pin" else 0, 0, 255)}
        count = len(found) // 2
        paths = [("Frame", "Bracket")] * count + [("Frame", "Bracket 2")] * count
        assert sorted(part.path for part in found) == paths


def occurrences(path):
    """Two of a subassembly with names; a box that is mirrored, and one that is twice as large."""
    from OCP.STEPCAFControl import STEPCAFControl_Writer
    from OCP.TCollection import TCollection_ExtendedString as Text
    from OCP.TDataStd import TDataStd_Name
    from OCP.TDocStd import TDocStd_Document
    from OCP.TopLoc import TopLoc_Location
    from OCP.XCAFDoc import XCAFDoc_DocumentTool

    make, _, _, gp = kit()
    document = TDocStd_Document(Text("x"))
    tool = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())

    def place(x, change=None):
        move = gp.gp_Trsf()
        move.SetTranslation(gp.gp_Vec(x, 0.0, 0.0))
        return TopLoc_Location(move if change is None else move * change)

    mirror, larger = gp.gp_Trsf(), gp.gp_Trsf()
    mirror.SetMirror(gp.gp_Ax2(gp.gp_Pnt(0, 0, 0), gp.gp_Dir(1, 0, 0)))
    larger.SetScale(gp.gp_Pnt(0, 0, 0), 2.0)
    box = tool.AddShape(make.BRepPrimAPI_MakeBox(1.0, 2.0, 3.0).Shape(), False)
    pin = tool.AddShape(make.BRepPrimAPI_MakeBox(1.0, 1.0, 9.0).Shape(), False)
    inner, whole = tool.NewShape(), tool.NewShape()
    named = [(box, "Box"), (pin, "Pin"), (inner, "Inner"), (whole, "Whole")]
    named.append((tool.AddComponent(inner, box, place(0.0)), "first"))
    named.append((tool.AddComponent(inner, pin, place(5.0)), "NAUO7"))
    named.append((tool.AddComponent(inner, box, place(10.0)), "the same"))
    named.append((tool.AddComponent(inner, pin, place(15.0)), "the same"))
    tool.AddComponent(whole, inner, place(0.0))
    tool.AddComponent(whole, inner, place(100.0))
    named.append((tool.AddComponent(whole, box, place(-10.0, mirror)), "flipped"))
    named.append((tool.AddComponent(whole, box, place(-30.0, larger)), "large"))
    for label, name in named:
        TDataStd_Name.Set_s(label, Text(name))
    tool.UpdateAssemblies()
    writer = STEPCAFControl_Writer()
    writer.Transfer(document)
    writer.Write(str(path))
    return path


def test_parts_are_called_as_where_they_are_used_and_mirrored_ones_look_outwards(tmp_path):
    found = read_mesh_file(occurrences(tmp_path / "a.step")).shapes
    assert not found.surfaces
    rows = {
        (part.path, part.name, round(float(part.mesh.bounds[0][0]), 3)): enclosed_volume(part.mesh)
        for part in found.solids
    }
    wanted = {(("Whole",), "flipped", -11.0): 6.0, (("Whole",), "large", -30.0): 48.0}
    for path, x in ((("Whole", "Inner"), 0.0), (("Whole", "Inner 2"), 100.0)):
        wanted |= {(path, "first", x): 6.0, (path, "Pin", x + 5.0): 9.0}
        wanted |= {(path, "Box", x + 10.0): 6.0, (path, "Pin", x + 15.0): 9.0}
    assert rows == pytest.approx(wanted)


def iges(entities):
    """Text of a file: of each entity the type, parameters, number of its matrix, and status."""
    directory, parameters = [], []
    for number, (kind, values, matrix, status) in enumerate(entities):
        place, body = 2 * number + 1, f"{kind},{values};"
        rows = [body[k : k + 64] for k in range(0, len(body), 64)]
        change = 2 * matrix + 1 if matrix is not None else 0
        fields = (kind, len(parameters) + 1, 0, 0, 0, 0, change, 0)
        directory.append("".join(f"{one:8d}" for one in fields) + status)
        directory.append(f"{kind:8d}{0:8d}{0:8d}{len(rows):8d}{0:8d}{'':24}{0:8d}")
        parameters += [(row, place) for row in rows]
    head = (
        "1H,,1H;,1Ha,1Ha,1Ha,1Ha,32,38,6,308,15,1Ha,1.,2,2HMM,1,0.01,15H20260101.000000,1E-06,"
        "1000.,1Ha,1Ha,11,0,15H20260101.000000;"
    )
    rows = [head[k : k + 72] for k in range(0, len(head), 72)]
    lines = [f"{'a':72}S{1:7d}", *(f"{row:72}G{k:7d}" for k, row in enumerate(rows, 1))]
    lines += [f"{row:72}D{k:7d}" for k, row in enumerate(directory, 1)]
    lines += [f"{row:64}{at:8d}P{k:7d}" for k, (row, at) in enumerate(parameters, 1)]
    counts = f"S{1:7d}G{len(rows):7d}D{len(directory):7d}P{len(parameters):7d}"
    return "\n".join([*lines, f"{counts:72}T{1:7d}", ""])


def test_iges_subfigures_stand_where_they_are_used(tmp_path):
    """Subfigures in subfigures (308, 408), scaled, and changed by a matrix (124)."""
    square = "1,1,1,1,0,0,1,0,0,0.,0.,1.,1.,0.,0.,1.,1.,1.,1.,1.,1.,"
    square += "0.,0.,0.,4.,0.,0.,0.,2.,0.,4.,2.,0.,0.,1.,0.,1."
    used, inner, shown = "00010000", "00000201", "00000000"
    rows = [
        (128, square, None, used),
        (308, "0,5HWheel,1,1", None, inner),
        (408, "3,100.,0.,0.,1.", None, used),
        (408, "3,0.,100.,5.,3.", None, used),
        (308, "1,4HAxle,2,5,7", None, inner),
        (408, "9,0.,0.,500.,1.", None, shown),
        (124, "0.,-1.,0.,10.,1.,0.,0.,20.,0.,0.,1.,30.", None, "00000100"),
        (408, "3,0.,0.,0.,1.", 6, shown),
        (128, square, 6, shown),
    ]
    (tmp_path / "a.igs").write_text(iges(rows))
    found = read_mesh_file(tmp_path / "a.igs").shapes.surfaces
    boxes = sorted(np.round(part.mesh.bounds, 6).ravel().tolist() for part in found)
    turned_box = [8.0, 20.0, 30.0, 10.0, 24.0, 30.0]
    assert boxes == pytest.approx(np.array([
        [0.0, 100.0, 505.0, 12.0, 106.0, 505.0], turned_box, turned_box,
        [100.0, 0.0, 500.0, 104.0, 2.0, 500.0],
    ]))  # fmt: skip
    assert sorted(part.path for part in found) == [(), (), ("Axle",), ("Axle",)]
    assert "Wheel" in {part.name for part in found}


@BOTH
def test_loose_curves_come_with_the_bodies(tmp_path, ending):
    _, _, build, gp = kit()
    from OCP.BRep import BRep_Builder
    from OCP.TopoDS import TopoDS_Compound

    both, builder = TopoDS_Compound(), BRep_Builder()
    builder.MakeCompound(both)
    builder.Add(both, solids()["box"][0])
    edge = build.BRepBuilderAPI_MakeEdge(gp.gp_Pnt(0, 0, 0), gp.gp_Pnt(90, 0, 0)).Edge()
    builder.Add(both, edge)
    read = read_mesh_file(written(both, tmp_path / f"a.{ending}"))
    assert len(read.shapes.solids) == 1
    (curve,) = read.shapes.curves
    assert curve.value(curve.range) == pytest.approx(np.array([[0, 0, 0], [90, 0, 0]]))
    assert not any("curve" in said for said in read.left_out)


def conic_edges():
    """Arcs and whole ellipses in space, each with its places by Open CASCADE."""
    _, _, build, gp = kit()
    from OCP.Geom import Geom_Circle, Geom_Ellipse

    frame = gp.gp_Ax2(gp.gp_Pnt(3, -4, 5), gp.gp_Dir(1, 2, 3), gp.gp_Dir(3, 0, -1))
    circle, ellipse = Geom_Circle(frame, 12.5), Geom_Ellipse(frame, 20.0, 6.0)
    ends = [(circle, 0.4, 5.1), (circle, 0.0, 2 * np.pi), (ellipse, 5.0, 7.5),
            (ellipse, 0.0, 2 * np.pi)]  # fmt: skip
    for curve, begin, end in ends:
        edge = build.BRepBuilderAPI_MakeEdge(curve, begin, end).Edge()
        at = np.linspace(begin, end, 60)
        points = [curve.Value(float(t)) for t in at]
        yield edge, np.array([(p.X(), p.Y(), p.Z()) for p in points])


@BOTH
def test_curves_of_another_kernel_lie_where_it_has_them(tmp_path, ending):
    for number, (edge, places) in enumerate(conic_edges()):
        read = read_mesh_file(written(edge, tmp_path / f"{number}.{ending}"))
        (curve,) = read.shapes.curves
        assert not tuple(read.shapes.meshes())
        begin, end = curve.range
        dense = curve.value(np.linspace(begin, end, 20_001))
        size = float(np.linalg.norm(np.ptp(places, axis=0)))
        off = [np.linalg.norm(dense - place, axis=1).min() for place in places]
        assert max(off) <= 3e-4 * size, number  # half a step between the places
        ends = np.sort(np.linalg.norm(dense[[0, -1], None] - places[[0, -1]], axis=2).min(axis=1))
        assert ends[-1] <= 1e-9 * size, number


@pytest.mark.parametrize(
    "entry", ["SOLID", "COMPOUND", "=>[0:1:1:3]", "Open CASCADE STEP translator 7.6 1.2"]
)
def test_what_the_library_calls_a_shape_is_no_name(tmp_path, entry):
    """A product of a body and curves beside it, as older programs write them."""
    text = nested(tmp_path / "a.step", "MM").read_text()
    (tmp_path / "b.step").write_text(text.replace("'Pin'", f"'{entry}'"))
    named = read_mesh_file(tmp_path / "a.step", trusted=True).shapes.solids
    found = read_mesh_file(tmp_path / "b.step", trusted=True).shapes.solids
    assert "Pin" in {part.name for part in named}
    assert [part.name for part in found] == [
        part.path[-1] if part.name == "Pin" else part.name for part in named
    ]


def test_parts_that_lie_in_other_files_are_named(tmp_path):
    """An assembly of CATIA or Creo with external references has products, and no faces."""
    places = np.array([[0, 0, 0], [30, 0, 0], [30, 20, 0], [0, 20, 0]], float)
    curve = Curve(3, np.array([0, 0, 0, 0, 1, 1, 1, 1.0]), places)
    export(Shapes(curves=(curve,)), tmp_path / "only.step")
    export(Shapes(curves=(curve,)), tmp_path / "none.step")
    written(solids()["box"][0], tmp_path / "also.step")
    names = "".join(
        f"#{90000 + n}=DOCUMENT_FILE('{name}','','',$,'',$) ;\n"
        for n, name in enumerate(("LEG.stp", "seat.STEP", "LEG.stp", "manual.pdf"))
    ).encode()
    for name in ("only", "also"):
        data = (tmp_path / f"{name}.step").read_bytes()
        before, _, after = data.rpartition(b"ENDSEC;")
        (tmp_path / f"{name}.step").write_bytes(before + names + b"ENDSEC;" + after)
    said = "in other files (LEG.stp, seat.STEP). Open those"
    read = read_mesh_file(tmp_path / "only.step", trusted=True)
    assert len(read.shapes.curves) == 1
    assert any(said in words for words in read.left_out)
    assert "other files" not in outcome(tmp_path / "none.step")
    read = read_mesh_file(tmp_path / "also.step", trusted=True)
    assert len(read.shapes.solids) == 1
    assert any(said in words for words in read.left_out)


def test_curves_alone_need_no_library(tmp_path):
    places = np.array([[0, 0, 0], [30, 0, 0], [30, 20, 0], [0, 20, 0]], float)
    curve = Curve(3, np.array([0, 0, 0, 0, 1, 1, 1, 1.0]), places)
    export(Shapes(curves=(curve,)), tmp_path / "a.step")
    read = read_mesh_file(tmp_path / "a.step")
    (found,) = read.shapes.curves
    assert (found.control_points == places).all()
    assert read.left_out == ()


def outcome(path):
    """Return what is said of a file; nothing where it is read."""
    try:
        read_mesh_file(path)
    except UserError as said:
        return said.message
    return ""


def test_damaged_files_end_in_a_sentence(tmp_path):
    good = written(solids()["bored"][0], tmp_path / "good.step").read_bytes()
    rng, said = random.Random(3), []
    for number in range(12):
        bad = bytearray(good)
        for _ in range(rng.randint(1, 30)):
            at = rng.randrange(200, len(bad))
            bad[at : at + rng.choice((1, 2, 30))] = rng.randbytes(rng.choice((0, 1, 2, 30)))
        (tmp_path / f"{number}.step").write_bytes(bytes(bad))
        said.append(outcome(tmp_path / f"{number}.step"))
    assert outcome(tmp_path / "good.step") == ""
    (tmp_path / "cut.step").write_bytes(good[:400])
    (tmp_path / "hello.step").write_bytes(b"hello")
    assert outcome(tmp_path / "cut.step")
    assert "neither a STEP" in outcome(tmp_path / "hello.step")
