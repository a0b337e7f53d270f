"""Our files in the hands of independent readers.

Every one is optional: trimesh and lib3mf from the extra "interop"; the Khronos validator from
the npm package ``gltf-validator`` in the folder that BOZZETTO_GLTF_VALIDATOR names; pymeshlab
where it is installed; assimp, admesh and prusa-slicer where they are on the PATH.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bozzetto.exchange.export import export
from bozzetto.exchange.import_file import read_mesh
from bozzetto.geometry import FaceGroup, Mesh, Shapes, Solid, Surface
from tests.core.exchange.skinned import skinned

pytestmark = pytest.mark.interop


def torus(at=(0.0, 0.0, 0.0), scale=1.0):
    nu, nv = 60, 30
    u, v = np.meshgrid(
        np.arange(nu) * 2 * np.pi / nu, np.arange(nv) * 2 * np.pi / nv, indexing="ij"
    )
    r = 30 + 8 * np.cos(v)
    vertices = np.stack((r * np.cos(u), r * np.sin(u), 8 * np.sin(v)), -1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(nu), np.arange(nv), indexing="ij")
    a, b = (i * nv + j).ravel(), ((i + 1) % nu * nv + j).ravel()
    c, d = ((i + 1) % nu * nv + (j + 1) % nv).ravel(), (i * nv + (j + 1) % nv).ravel()
    colors = np.stack((128 + 127 * np.cos(u), 128 + 127 * np.sin(v), 40 + 0 * u, 255 + 0 * u), -1)
    colors = colors.reshape(-1, 4).astype(np.uint8) // 64 * 64 | np.uint8([0, 0, 0, 255])
    return Mesh(vertices * scale + at, np.vstack((np.c_[a, b, c], np.c_[a, c, d])), colors=colors)


def volume(mesh):
    corners = mesh.vertices[mesh.faces].astype(float)
    return np.linalg.det(corners).sum() / 6


RING = torus()
SMALL = torus((0, 0, 40), 0.5)
SMALL = Mesh(SMALL.vertices, SMALL.faces)
SHAPES = Shapes(solids=(Solid(RING, "ring <&> ü"), Solid(SMALL, "small", (212, 80, 47))))
SKIN = Surface(Mesh([[0, 0, 0], [9, 0, 0], [0, 9, 0], [9, 9, 1]], [[0, 1, 2], [1, 3, 2]]), "skin")
VOLUME = volume(RING) + volume(SMALL)

LINEAR = np.array(
    [v / 255 / 12.92 if v <= 10 else ((v / 255 + 0.055) / 1.055) ** 2.4 for v in range(256)]
)


def files(tmp_path, endings, shapes=SHAPES):
    for ending in endings:
        export(shapes, tmp_path / f"a.{ending}")
        yield ending, tmp_path / f"a.{ending}"


def test_trimesh_reads_every_format(tmp_path):
    trimesh = pytest.importorskip("trimesh")
    for ending, path in files(tmp_path, ["stl", "glb", "obj", "ply", "3mf"]):
        scene = trimesh.load_scene(path)
        mesh = scene.to_geometry()
        scale = 1000.0 if ending == "glb" else 1.0
        assert mesh.is_watertight, ending
        assert mesh.is_winding_consistent, ending
        assert mesh.volume * scale**3 == pytest.approx(VOLUME, rel=1e-5), ending
        low, high = mesh.bounds * scale
        if ending in ("glb", "obj"):  # back from Y up
            (low, high) = (np.array([b[0], s * b[2], b[1]]) for b, s in ((low, -1), (high, -1)))
            low, high = np.minimum(low, high), np.maximum(low, high)
        both = np.vstack((RING.vertices, SMALL.vertices))
        np.testing.assert_allclose([low, high], [both.min(0), both.max(0)], atol=1e-4)
        if ending in ("glb", "3mf"):
            assert len(scene.geometry) == 2
        if ending == "glb":
            assert set(scene.geometry) == {"ring <&> ü", "small"}


@pytest.mark.parametrize("ending", ["ply", "obj", "glb"])
def test_trimesh_sees_the_colours(tmp_path, ending):
    trimesh = pytest.importorskip("trimesh")
    path = tmp_path / f"a.{ending}"
    export(Shapes(solids=(SHAPES.solids[0],)), path)
    (mesh,) = trimesh.load_scene(path, process=False).geometry.values()
    visual = mesh.visual
    match ending:
        case "glb":
            colors = visual.vertex_attributes["color"]
        case "obj":  # beside its material
            colors = 255.0 * mesh.vertex_attributes["color"]
        case _:
            colors = visual.vertex_colors
    seen = np.asarray(colors)[:, :3].astype(float)
    expected = RING.colors[:, :3].astype(float)
    if ending == "glb":  # linear light in the file
        seen, expected = seen / 65535 * 255, 255 * LINEAR[RING.colors[:, :3]]
    np.testing.assert_allclose(seen, expected, atol=1.0)


@pytest.mark.parametrize("ending", ["stl", "glb", "obj", "ply"])
def test_we_read_what_trimesh_writes(tmp_path, ending):
    trimesh = pytest.importorskip("trimesh")
    mesh = trimesh.creation.box((10, 20, 30))
    mesh.apply_translation((1, 2, 3))
    mesh.export(tmp_path / f"a.{ending}")
    (solid,) = read_mesh(tmp_path / f"a.{ending}").solids
    size = 6000 * (1e9 if ending == "glb" else 1)
    assert volume(solid.mesh) == pytest.approx(size, rel=1e-4)


@pytest.mark.parametrize(
    "shapes",
    [SHAPES, Shapes(solids=(Solid(SMALL, "plain"),)), Shapes(surfaces=(SKIN,)) + SHAPES],
    ids=["colour", "plain", "skin"],
)
def test_lib3mf_accepts_our_3mf_strictly(tmp_path, shapes):
    lib3mf = pytest.importorskip("lib3mf")
    path = tmp_path / "a.3mf"
    export(shapes, path)
    model = lib3mf.get_wrapper().CreateModel()
    reader = model.QueryReader("3mf")
    reader.SetStrictModeActive(True)
    reader.ReadFromFile(str(path))
    assert reader.GetWarningCount() == 0
    objects = model.GetMeshObjects()
    seen = {}
    while objects.MoveNext():
        one = objects.GetCurrentMeshObject()
        seen[one.GetName()] = one
    assert set(seen) == {part.name for part in shapes.meshes()}
    for solid in shapes.solids:
        one = seen[solid.name]
        assert one.IsManifoldAndOriented()
        assert one.GetTriangleCount() == len(solid.mesh.faces)
        vertices = np.array([list(v.Coordinates) for v in one.GetVertices()])
        np.testing.assert_allclose(vertices, solid.mesh.vertices, atol=1e-5)
        if solid.mesh.colors is not None:
            properties = one.GetTriangleProperties(7)
            group = model.GetColorGroupByID(properties.ResourceID)
            for corner, vertex in enumerate(solid.mesh.faces[7]):
                color = group.GetColor(properties.PropertyIDs[corner])
                got = (color.Red, color.Green, color.Blue, color.Alpha)
                assert got == tuple(solid.mesh.colors[vertex])
    items = model.GetBuildItems()
    assert items.Count() == len(seen)


def of_all_finishes(mesh):
    """A solid whose triangles are matt, of gloss, rubber, metal and glass."""
    names = ("matt", "gloss", "rubber", "metal", "glass")
    counts = np.diff(np.linspace(0, len(mesh.faces), len(names) + 1).astype(int)).tolist()
    groups = [
        FaceGroup(name, n, (200, 90, 60), name) for name, n in zip(names, counts, strict=True)
    ]
    return Solid(replace(mesh, colors=None), "finishes", groups=tuple(groups))


VALIDATE = """
const validator = require(process.argv[1]);
const bytes = new Uint8Array(require('fs').readFileSync(process.argv[2]));
validator.validateBytes(bytes).then(report => console.log(JSON.stringify(report)));
"""


@pytest.mark.parametrize(
    "shapes",
    [
        SHAPES,
        Shapes(surfaces=(SKIN,)) + SHAPES,
        Shapes(solids=(skinned(7),)),
        SHAPES + Shapes(solids=(skinned(300, 90.0), skinned(5, roots=(0, 2)))),
        Shapes(solids=(skinned(7, 60.0, texture=True),)),
        Shapes(solids=(of_all_finishes(RING),)),
    ],
    ids=["solids", "skin", "rig", "pose", "texture", "finishes"],
)
def test_the_khronos_validator_finds_nothing(tmp_path, shapes):
    folder = os.environ.get("BOZZETTO_GLTF_VALIDATOR")
    if not folder or not shutil.which("node"):
        pytest.skip("BOZZETTO_GLTF_VALIDATOR names no folder with the npm package, or no node")
    places = (Path(folder), Path(folder) / "node_modules/gltf-validator")
    package = next((p for p in places if (p / "gltf_validator.dart.js").exists()), None)
    if package is None:
        pytest.skip(f"no gltf-validator in {folder}")
    path = tmp_path / "a.glb"
    export(shapes, path)
    done = subprocess.run(
        ["node", "-e", VALIDATE, str(package), str(path)],
        capture_output=True,
        text=True,
        check=True,
    )
    report = json.loads(done.stdout)
    assert report["issues"]["messages"] == []
    assert report["info"]["totalTriangleCount"] == sum(len(p.mesh.faces) for p in shapes.meshes())


def test_trimesh_reads_a_skinned_solid(tmp_path):
    trimesh = pytest.importorskip("trimesh")
    solid = skinned(7, 60.0)
    export(Shapes(solids=(solid,)), tmp_path / "a.glb")
    scene = trimesh.load_scene(tmp_path / "a.glb")
    (mesh,) = scene.geometry.values()
    assert mesh.is_watertight
    assert mesh.volume * 1e9 == pytest.approx(volume(solid.skin.rest), rel=1e-5)
    assert set(solid.skin.rig.names) <= set(scene.graph.nodes)


@pytest.mark.skipif(not shutil.which("prusa-slicer"), reason="prusa-slicer is not here")
@pytest.mark.parametrize("ending", ["stl", "3mf", "obj"])
@pytest.mark.parametrize("solid", ["plain", "finishes"])
def test_prusa_slicer_finds_a_manifold(tmp_path, ending, solid):
    path = tmp_path / f"a.{ending}"
    shown = SHAPES.solids[0] if solid == "plain" else of_all_finishes(RING)
    export(Shapes(solids=(shown,)), path)
    done = subprocess.run(
        ["prusa-slicer", "--info", str(path)], capture_output=True, text=True, check=True
    )
    assert "manifold = yes" in done.stdout
    found = float(re.search(r"volume = ([\d.]+)", done.stdout)[1])
    assert found == pytest.approx(volume(RING), rel=1e-4)


@pytest.mark.skipif(not shutil.which("prusa-slicer"), reason="prusa-slicer is not here")
def test_prusa_slicer_takes_open_shells(tmp_path):
    """It passes over objects of the type "surface", and refuses a file of nothing else."""
    export(Shapes(surfaces=(SKIN,)), tmp_path / "skin.3mf")
    words = ["prusa-slicer", "--export-stl", "-o", str(tmp_path / "b.stl")]
    subprocess.run([*words, str(tmp_path / "skin.3mf")], capture_output=True, check=True)
    (again,) = read_mesh(tmp_path / "b.stl").meshes()
    assert len(again.mesh.faces) == len(SKIN.mesh.faces)
    size = np.ptp(np.asarray(again.mesh.bounds, float), axis=0)
    np.testing.assert_allclose(size, np.ptp(SKIN.mesh.bounds, axis=0), atol=1e-4)


@pytest.mark.skipif(not shutil.which("prusa-slicer"), reason="prusa-slicer is not here")
def test_prusa_slicer_prints_a_solid(tmp_path):
    export(Shapes(solids=(SHAPES.solids[0],)), tmp_path / "a.3mf")
    words = ["prusa-slicer", "--export-gcode", "-o", str(tmp_path / "a.gcode")]
    done = subprocess.run(
        [*words, "--layer-height", "0.3", str(tmp_path / "a.3mf")], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stdout + done.stderr
    layers = (tmp_path / "a.gcode").read_text().count(";LAYER_CHANGE")
    assert layers == pytest.approx(np.ptp(RING.vertices[:, 2]) / 0.3, abs=2)


@pytest.mark.skipif(not shutil.which("assimp"), reason="assimp is not here")
@pytest.mark.parametrize("ending", ["stl", "glb", "obj", "ply", "3mf"])
def test_assimp_reads_all_faces(tmp_path, ending):
    path = tmp_path / f"a.{ending}"
    export(SHAPES, path)
    done = subprocess.run(["assimp", "info", str(path)], capture_output=True, text=True, check=True)
    found = int(re.search(r"Faces:\s+(\d+)", done.stdout)[1])
    assert found == sum(len(p.mesh.faces) for p in SHAPES.meshes())


@pytest.mark.skipif(not shutil.which("admesh"), reason="admesh is not here")
def test_admesh_finds_nothing_to_repair(tmp_path):
    path = tmp_path / "a.stl"
    export(SHAPES, path)
    done = subprocess.run(["admesh", str(path)], capture_output=True, text=True, check=True)
    said = dict(re.findall(r"^([A-Z][a-z ]+?) *: +(\d+)", done.stdout, re.MULTILINE))
    repairs = ("Degenerate facets", "Edges fixed", "Facets removed", "Facets added",
               "Facets reversed", "Backwards edges", "Normals fixed")  # fmt: skip
    assert {said[name] for name in repairs} == {"0"}
    assert said["Number of parts"] == "2"


@pytest.mark.parametrize("ending", ["stl", "obj", "ply", "3mf"])
def test_meshlab_sees_closed_skins(tmp_path, ending):
    pymeshlab = pytest.importorskip("pymeshlab")
    path = tmp_path / f"a.{ending}"
    export(Shapes(solids=(SHAPES.solids[0],)), path)
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(path))
    if ending == "stl":  # which repeats every corner
        meshes.meshing_merge_close_vertices(threshold=pymeshlab.PercentageValue(0))
    topology = meshes.get_topological_measures()
    assert topology["is_mesh_two_manifold"]
    assert topology["boundary_edges"] == 0
    found = meshes.get_geometric_measures()["mesh_volume"]
    assert found == pytest.approx(volume(RING), rel=1e-4)
