"""STEP and IGES of other programs and of ours, read as bodies: against closed forms."""

from __future__ import annotations

import random

import numpy as np
import pytest

from bozzetto.errors import FormatError, UserError
from bozzetto.exchange.export import export
from bozzetto.exchange.import_file import read_mesh_file
from bozzetto.exchange.mesh.manifold_check import enclosed_volume
from bozzetto.geometry import Curve, Shapes

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
        assert {part.path for part in found} == {("Frame", "Bracket")}


def test_loose_curves_are_told(tmp_path):
    _, _, build, gp = kit()
    from OCP.BRep import BRep_Builder
    from OCP.TopoDS import TopoDS_Compound

    both, builder = TopoDS_Compound(), BRep_Builder()
    builder.MakeCompound(both)
    builder.Add(both, solids()["box"][0])
    edge = build.BRepBuilderAPI_MakeEdge(gp.gp_Pnt(0, 0, 0), gp.gp_Pnt(90, 0, 0)).Edge()
    builder.Add(both, edge)
    read = read_mesh_file(written(both, tmp_path / "a.step"), trusted=True)
    assert len(read.shapes.solids) == 1
    assert "Left out: a curve" in read.left_out[0]


@pytest.mark.parametrize("entry", ["SOLID", "COMPOUND", "=>[0:1:1:3]"])
def test_what_the_library_calls_a_shape_is_no_name(tmp_path, entry):
    """A product of a body and curves beside it, as older programs write them."""
    text = nested(tmp_path / "a.step", "MM").read_text()
    (tmp_path / "b.step").write_text(text.replace("'Pin'", f"'{entry}'"))
    named = [part.name for part in read_mesh_file(tmp_path / "a.step", trusted=True).shapes.solids]
    found = [part.name for part in read_mesh_file(tmp_path / "b.step", trusted=True).shapes.solids]
    assert "Pin" in named
    assert found == ["Bracket" if name == "Pin" else name for name in named]


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
    assert said in outcome(tmp_path / "only.step")
    assert "other files" not in outcome(tmp_path / "none.step")
    read = read_mesh_file(tmp_path / "also.step", trusted=True)
    assert len(read.shapes.solids) == 1
    assert any(said in words for words in read.left_out)


def test_curves_alone_are_refused(tmp_path):
    places = np.array([[0, 0, 0], [30, 0, 0], [30, 20, 0], [0, 20, 0]], float)
    curve = Curve(3, np.array([0, 0, 0, 0, 1, 1, 1, 1.0]), places)
    export(Shapes(curves=(curve,)), tmp_path / "a.step")
    with pytest.raises(FormatError, match="no faces"):
        read_mesh_file(tmp_path / "a.step", trusted=True)


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
