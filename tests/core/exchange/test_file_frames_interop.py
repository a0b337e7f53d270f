"""What other programs measure of our files, in every unit, with every axis up, at two scales.

Formats that say their unit or axis are read as they are; of the others a program is told both, as a
person tells it in the dialog.
"""

from __future__ import annotations

import itertools
import json
import re
import shutil
import subprocess

import numpy as np
import pytest

from bozzetto.exchange.export import export
from bozzetto.exchange.formats import FORMATS
from bozzetto.exchange.handover import Handover
from bozzetto.geometry import Shapes
from tests.blender import asked
from tests.core.exchange.test_curve_interop import ask
from tests.core.exchange.test_file_frames import HIGH, LOW, MM, UPS, things
from tests.core.geometry.brep.exact_shapes import box
from tests.usd_reader import asked_usd

pytestmark = pytest.mark.interop

CHOICES = list(itertools.product(MM, UPS, (1.0, 3.0)))
"""Units, axes and scales."""

TURN = {"y": np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]]), "z": np.eye(3)}
"""From axes of which the second or the third points up to ours."""


def files(folder, ending, shapes=None):
    """Write all of them: each path, with its unit in mm and the axis that a reader has to know."""
    (usual,) = (one for one in FORMATS if one.writes and f".{ending}" in one.endings)
    for number, (unit, up, scale) in enumerate(CHOICES):
        path = folder / f"{ending}{number}.{ending}"
        wanted = Handover(unit=unit, up=up, scale=scale)
        export(things() if shapes is None else shapes, path, handover=wanted)
        kept = usual.frame
        if "unit" not in usual.choices:
            unit = None
        if "up" not in usual.choices:
            up = None
        yield path, MM[unit or kept.unit], up or kept.up, scale


def agree(low, high, scale, of=(LOW, HIGH)):
    """Whether a box, mm, is that of the things."""
    both = np.sort([low, high], axis=0)
    np.testing.assert_allclose(both, scale * np.array(of), rtol=1e-5, atol=5e-5 * scale)


BLENDER = """
answer = []
for path, up in json.load(open(sys.argv[1])):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    ending = path.rpartition(".")[2]
    axes = {"forward_axis": "NEGATIVE_Z" if up == "y" else "Y", "up_axis": up.upper()}
    if ending == "glb":
        bpy.ops.import_scene.gltf(filepath=path)
    elif ending.startswith("usd"):
        bpy.ops.wm.usd_import(filepath=path)
    else:
        getattr(bpy.ops.wm, ending + "_import")(filepath=path, **axes)
    bpy.context.view_layer.update()
    places = [
        one.matrix_world @ v.co for one in bpy.data.objects if one.type == "MESH"
        for v in one.data.vertices
    ]
    answer.append([[kind(p[k] for p in places) for k in range(3)] for kind in (min, max)])
"""


@pytest.mark.parametrize("ending", ["stl", "obj", "ply", "glb", "usda", "usdz"])
def test_blender_measures_what_was_asked_for(tmp_path, ending):
    rows = list(files(tmp_path, ending))
    wanted = tmp_path / "wanted.json"
    wanted.write_text(json.dumps([[str(path), up] for path, _, up, _ in rows]))
    for (low, high), (path, unit, _, scale) in zip(asked(BLENDER, wanted), rows, strict=True):
        size = 1000.0 if ending.startswith("usd") else unit  # Blender knows what USD says
        try:
            agree(size * np.array(low), size * np.array(high), scale)
        except AssertionError as wrong:
            raise AssertionError(path.name) from wrong


@pytest.mark.parametrize("ending", ["stl", "obj", "ply", "glb", "3mf"])
def test_trimesh_measures_what_was_asked_for(tmp_path, ending):
    trimesh = pytest.importorskip("trimesh")
    for path, unit, up, scale in files(tmp_path, ending):
        scene = trimesh.load_scene(path)
        said = {"millimeters": 1.0, "millimeter": 1.0, "centimeter": 10.0, "meter": 1000.0,
                "meters": 1000.0, "inch": 25.4, None: None}[scene.units]  # fmt: skip
        assert said in (None, unit)
        agree(*(unit * scene.bounds @ TURN[up].T), scale)


USD = """
answer = []
for path in json.load(open(sys.argv[2])):
    stage = Usd.Stage.Open(path)
    box = UsdGeom.BBoxCache(0, ["default"]).ComputeWorldBound(stage.GetPseudoRoot())
    found = box.ComputeAlignedRange()
    answer.append([
        list(found.GetMin()), list(found.GetMax()), UsdGeom.GetStageMetersPerUnit(stage),
        UsdGeom.GetStageUpAxis(stage),
    ])
"""


@pytest.mark.parametrize("ending", ["usda", "usdz"])
def test_usds_own_library_measures_what_was_asked_for(tmp_path, ending):
    rows = list(files(tmp_path, ending))
    wanted = tmp_path / "wanted.json"
    wanted.write_text(json.dumps([str(path) for path, *_ in rows]))
    found = asked_usd(USD, rows[0][0], wanted)
    for (low, high, metres, axis), (_, unit, up, scale) in zip(found, rows, strict=True):
        assert 1000.0 * metres == pytest.approx(unit)
        assert axis == up.upper()
        agree(*(1000.0 * metres * np.array([low, high]) @ TURN[axis.lower()].T), scale)


OPENCASCADE = """
import json, sys
from OCP.Bnd import Bnd_Box
from OCP.BRepBndLib import BRepBndLib
from OCP.IGESControl import IGESControl_Reader
from OCP.STEPControl import STEPControl_Reader
answer = []
for path in sys.argv[1:]:
    reader = STEPControl_Reader() if path.endswith("step") else IGESControl_Reader()
    reader.ReadFile(path)
    reader.TransferRoots()
    around = Bnd_Box()
    BRepBndLib.AddOptimal_s(reader.OneShape(), around, False, False)
    low, high = around.CornerMin(), around.CornerMax()
    answer.append([low.X(), low.Y(), low.Z(), high.X(), high.Y(), high.Z()])
print()
print(json.dumps(answer))
"""

GMSH = """
import json, sys
import gmsh
gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
answer = []
for path in sys.argv[1:]:
    gmsh.clear()
    gmsh.model.occ.importShapes(path)
    gmsh.model.occ.synchronize()
    answer.append(gmsh.model.getBoundingBox(-1, -1))
gmsh.finalize()
print(json.dumps(answer))
"""


@pytest.mark.parametrize("ending", ["step", "iges"])
@pytest.mark.parametrize("reader", [OPENCASCADE, GMSH], ids=["opencascade", "gmsh"])
def test_cad_programs_measure_what_was_asked_for(tmp_path, ending, reader):
    rows = list(files(tmp_path, ending, Shapes(breps=(box((10.0, 20.0, 30.0)),))))
    _, found = ask(reader, *(path for path, *_ in rows))
    for sides, (_, _, _, scale) in zip(found, rows, strict=True):
        there = np.reshape(sides, (2, 3))
        np.testing.assert_allclose(there, scale * np.array([[0, 0, 0], [10, 20, 30]]), atol=1e-4)


@pytest.mark.parametrize("ending", ["stl", "obj", "3mf"])
def test_a_slicer_measures_what_was_asked_for(tmp_path, ending):
    slicer = shutil.which("prusa-slicer")
    if slicer is None:
        pytest.skip("prusa-slicer is not there")
    for path, unit, up, scale in files(tmp_path, ending):
        if ending != "3mf" and unit in (1000.0, 25.4):
            continue  # it takes numbers so small for metres or inches, and asks in its window
        done = subprocess.run([slicer, "--info", path], capture_output=True, text=True, check=True)
        found = {a: float(v) for a, v in re.findall(r"size_(\w) = ([\d.]+)", done.stdout)}
        size = scale * np.array([10.0, 30.0, 20.0] if up == "y" else [10.0, 20.0, 30.0])
        size = size if ending == "3mf" else size / unit  # it takes all numbers for millimetres
        np.testing.assert_allclose([found[a] for a in "xyz"], size, rtol=1e-5, err_msg=path.name)


def test_ezdxf_and_rhino3dm_know_the_unit(tmp_path):
    ezdxf, rhino = pytest.importorskip("ezdxf"), pytest.importorskip("rhino3dm")
    from ezdxf.bbox import extents

    numbers = {1.0: 4, 10.0: 5, 1000.0: 6, 25.4: 1}
    for path, unit, _, scale in files(tmp_path, "dxf"):
        drawing = ezdxf.readfile(path)
        assert drawing.units == numbers[unit]
        found = extents(drawing.modelspace())
        agree(unit * np.array(found.extmin), unit * np.array(found.extmax), scale)
    system = rhino.UnitSystem
    names = {
        1.0: system.Millimeters, 10.0: system.Centimeters,
        1000.0: system.Meters, 25.4: system.Inches,
    }  # fmt: skip
    for path, unit, _, scale in files(tmp_path, "3dm"):
        model = rhino.File3dm.Read(str(path))
        assert model.Settings.ModelUnitSystem == names[unit]
        (one,) = model.Objects
        around = one.Geometry.GetBoundingBox()
        corners = np.array([[c.X, c.Y, c.Z] for c in (around.Min, around.Max)])
        agree(*(unit * corners), scale)
