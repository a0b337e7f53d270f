"""Our curves in the hands of independent readers.

OpenCASCADE (``cadquery-ocp-novtk``) and Gmsh, which is under the GPL, run in processes of their
own: BOZZETTO_CAD_READERS names a Python that has them. ezdxf and rhino3dm come with the extras
"dxf" and "rhino".
"""

from __future__ import annotations

import json
import os
import subprocess

import numpy as np
import pytest

from bozzetto.exchange.cad.cad_curves import checked_curves
from bozzetto.exchange.export import export
from bozzetto.geometry import Curve, Shapes
from tests.core.exchange.curve_kit import (
    BROKEN,
    CORNER,
    CURVES,
    NAMES,
    domain,
    points,
    ring,
    values,
)

pytestmark = pytest.mark.interop

USUAL = tuple(curve for curve in CURVES if curve.name not in ("long", "short"))
"""Those whose parameters are written as they are, so that places can be compared by them."""

SMOOTH = (CURVES[0], ring(7, 3), ring(5, 2), CURVES[7])
"""Readers of IGES cut curves at corners of their parameter, and say so; these have none. Corners
that can be seen are cut by us."""


def ask(code, *arguments):
    """What a script in the readers' Python prints: the last line is JSON, the others are said."""
    python = os.environ.get("BOZZETTO_CAD_READERS")
    if not python:
        pytest.skip("BOZZETTO_CAD_READERS names no Python with the readers")
    done = subprocess.run(
        [python, "-c", code, *map(str, arguments)], capture_output=True, text=True, check=True
    )
    *said, last = done.stdout.strip().splitlines()
    return said, json.loads(last)


OPENCASCADE = """
import json, sys
from OCP.BRep import BRep_Tool
from OCP.IFSelect import IFSelect_PrintCount, IFSelect_ReturnStatus
from OCP.IGESControl import IGESControl_Reader
from OCP.STEPControl import STEPControl_Reader
from OCP.TopAbs import TopAbs_EDGE
from OCP.TopExp import TopExp_Explorer
from OCP.TopoDS import TopoDS
path, transfer = sys.argv[1], sys.argv[2] == "transfer"
reader = STEPControl_Reader() if path.endswith("step") else IGESControl_Reader()
assert reader.ReadFile(path) == IFSelect_ReturnStatus.IFSelect_RetDone
reader.PrintCheckLoad(False, IFSelect_PrintCount.IFSelect_ItemsByEntity)
roots = reader.TransferRoots()
if transfer:
    reader.PrintCheckTransfer(False, IFSelect_PrintCount.IFSelect_ItemsByEntity)
edges = TopExp_Explorer(reader.OneShape(), TopAbs_EDGE)
found = []
while edges.More():
    curve = BRep_Tool.Curve_s(TopoDS.Edge(edges.Current()), 0.0, 1.0)
    a, b = curve.FirstParameter(), curve.LastParameter()
    u = [a + (b - a) * k / 40 for k in range(1, 40)]
    places = [curve.Value(v) for v in u]
    found.append([u, [[p.X(), p.Y(), p.Z()] for p in places]])
    edges.Next()
print()
print(json.dumps({"roots": roots, "curves": found}))
"""


def messages(said):
    """What a reader complained about: its colours and its summary are no complaints."""
    return [line for line in said if "Check:" in line or "Fail" in line or "Warning" in line]


def away(found, curves):
    """Largest distance of what was found from our curves at the same parameters, mm."""
    worst = 0.0
    for u, places in found:
        near = [np.abs(values(c, u) - places).max() for c in curves
                if domain(c)[0] <= u[0] and u[-1] <= domain(c)[1]]  # fmt: skip
        worst = max(worst, min(near))
    return worst


@pytest.mark.parametrize("ending", ["step", "iges"])
def test_opencascade_reads_exact_curves_without_a_message(tmp_path, ending):
    path = tmp_path / f"a.{ending}"
    curves = (*USUAL, *checked_curves(Shapes(curves=(BROKEN,))))
    export(Shapes(curves=curves), path)
    said, answer = ask(OPENCASCADE, path, "load")
    assert messages(said) == []
    if ending == "step":
        assert answer["roots"] == 1
        assert len(answer["curves"]) == len(curves)
    else:
        assert answer["roots"] == len(curves) + (CORNER in curves)
    assert away(answer["curves"], curves) <= 1e-9


@pytest.mark.parametrize("ending", ["step", "iges"])
def test_opencascade_transfers_without_a_message(tmp_path, ending):
    path = tmp_path / f"a.{ending}"
    curves = (*SMOOTH, CORNER) if ending == "iges" else CURVES
    export(Shapes(curves=curves), path)
    said, answer = ask(OPENCASCADE, path, "transfer")
    assert messages(said) == []
    assert len(answer["curves"]) == len(curves) + (ending == "iges")


@pytest.mark.parametrize("ending", ["step", "iges"])
def test_opencascade_takes_any_name(tmp_path, ending):
    path = tmp_path / f"a.{ending}"
    curves = tuple(Curve(3, [0] * 4 + [1] * 4, points(4), name=name) for name in NAMES)
    export(Shapes(curves=curves), path)
    said, answer = ask(OPENCASCADE, path, "load")
    assert messages(said) == []
    assert len(answer["curves"]) == len(curves)
    assert away(answer["curves"], curves) <= 1e-9


GMSH = """
import json, sys
import gmsh
gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
gmsh.logger.start()
gmsh.model.occ.importShapes(sys.argv[1], highestDimOnly=False)
gmsh.model.occ.synchronize()
said = [line for line in gmsh.logger.get() if not line.startswith("Info")]
found = []
for _, tag in gmsh.model.getEntities(1):
    (a,), (b,) = gmsh.model.getParametrizationBounds(1, tag)
    u = [a + (b - a) * k / 40 for k in range(1, 40)]
    flat = [float(v) for v in gmsh.model.getValue(1, tag, u)]
    places = [flat[k : k + 3] for k in range(0, len(flat), 3)]
    name = gmsh.model.getEntityName(1, tag).rpartition("/")[2]
    found.append([u, places, name, gmsh.model.getColor(1, tag)[:3]])
gmsh.finalize()
print(json.dumps({"said": said, "curves": found}))
"""


@pytest.mark.parametrize("ending", ["step", "iges"])
def test_gmsh_reads_exact_curves(tmp_path, ending):
    path = tmp_path / f"a.{ending}"
    export(Shapes(curves=USUAL), path)
    _, answer = ask(GMSH, path)
    assert answer["said"] == []
    if ending == "step":
        assert len(answer["curves"]) == len(USUAL)
    assert away([found[:2] for found in answer["curves"]], USUAL) <= 1e-9


def test_gmsh_sees_names_and_colours_in_iges(tmp_path):
    path = tmp_path / "a.iges"
    curves = (CURVES[0], Curve(1, [0, 0, 1, 1], points(2), name="b", color=(1, 200, 30)))
    export(Shapes(curves=curves), path)
    _, answer = ask(GMSH, path)
    seen = {name: tuple(color) for _, _, name, color in answer["curves"]}
    assert seen["roof"] == (212, 80, 47)
    assert seen["b"] == (1, 200, 30)


def test_ezdxf_finds_nothing_wrong_and_the_very_numbers(tmp_path):
    ezdxf = pytest.importorskip("ezdxf")
    path = tmp_path / "a.dxf"
    named = [Curve(1, [0, 0, 1, 1], points(2), name=name) for name in (*NAMES, "*ROOF|", "roof")]
    pieces = checked_curves(Shapes(curves=(*CURVES, BROKEN, *named)))
    export(Shapes(curves=(*CURVES, BROKEN, *named)), path)
    drawing = ezdxf.readfile(path)
    audit = drawing.audit()
    assert (audit.errors, audit.fixes) == ([], [])
    assert drawing.units == ezdxf.units.MM
    splines = list(drawing.modelspace())
    assert [s.dxftype() for s in splines] == ["SPLINE"] * len(pieces)
    for spline, curve in zip(splines, pieces, strict=True):
        assert spline.dxf.degree == curve.degree
        assert spline.closed == curve.closed
        np.testing.assert_array_equal(spline.control_points, curve.control_points)
        np.testing.assert_array_equal(spline.knots, curve.knots)
        weights = [] if curve.weights is None else curve.weights
        np.testing.assert_array_equal(spline.weights, weights)
        assert (None if spline.rgb is None else tuple(spline.rgb)) == curve.color
        assert spline.dxf.layer in drawing.layers
    by_name = {curve.name: s.dxf.layer for s, curve in zip(splines, pieces, strict=True)}
    assert by_name["roof"] == "roof"
    assert by_name["circle"] == "circle"


def test_rhino3dm_reads_the_very_numbers(tmp_path):
    rhino = pytest.importorskip("rhino3dm")
    path = tmp_path / "a.3dm"
    named = [Curve(1, [0, 0, 1, 1], points(2), name=name) for name in NAMES]
    pieces = checked_curves(Shapes(curves=(*CURVES, BROKEN, *named)))
    export(Shapes(curves=(*CURVES, BROKEN, *named)), path)
    model = rhino.File3dm.Read(str(path))
    assert model.Settings.ModelUnitSystem == rhino.UnitSystem.Millimeters
    assert len(model.Objects) == len(pieces)
    for one, curve in zip(model.Objects, pieces, strict=True):
        shape, look = one.Geometry, one.Attributes
        assert shape.IsValid
        assert shape.Degree == curve.degree
        assert look.Name in (curve.name, f"_{curve.name}")  # openNURBS drops a leading bracket
        assert shape.IsClosed == bool(
            np.abs(curve.control_points[0] - curve.control_points[-1]).max() < 1e-9
        )
        if curve.color is not None:
            assert look.ColorSource == rhino.ObjectColorSource.ColorFromObject
            assert look.ObjectColor[:3] == curve.color
        np.testing.assert_array_equal(list(shape.Knots), curve.knots[1:-1])
        lifted = np.array([(p.X, p.Y, p.Z, p.W) for p in shape.Points])
        weights = np.ones(len(lifted)) if curve.weights is None else curve.weights
        np.testing.assert_array_equal(lifted[:, 3], weights)
        np.testing.assert_array_equal(lifted[:, :3], curve.control_points * weights[:, None])
        u = np.linspace(*domain(curve), 20)[1:-1]
        seen = [(p.X, p.Y, p.Z) for p in map(shape.PointAt, u)]
        np.testing.assert_allclose(seen, values(curve, u), atol=1e-9)
