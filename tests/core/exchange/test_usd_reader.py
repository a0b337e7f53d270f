"""USD in: our own files come back as they left, those of USD's own library come in."""

from __future__ import annotations

import subprocess
import zipfile

import numpy as np
import pytest

from bozzetto.errors import FormatError
from bozzetto.exchange.export import export, prepare_export
from bozzetto.exchange.handover import Handover
from bozzetto.exchange.import_file import read_mesh_file
from bozzetto.geometry import Shapes
from tests.core.exchange.test_usd import everything, wagging
from tests.usd_reader import python_of_usd


def kept(part):
    groups = [(g.name, g.count, g.color or part.color, g.finish) for g in part.groups]
    return part.name, part.path, groups


@pytest.mark.parametrize("up", ["y", "z"])
@pytest.mark.parametrize("ending", ["usda", "usdz", "usd"])
def test_our_own_scene_comes_back_as_it_left(tmp_path, ending, up):
    wanted = Handover(up=None if ending == "usdz" else up, unit="cm")
    export(everything(), tmp_path / f"a.{ending}", handover=wanted)
    found = read_mesh_file(tmp_path / f"a.{ending}")
    assert found.left_out == ()
    assert found.guess is None
    before, after = list(everything().meshes()), list(found.shapes.meshes())
    assert len(found.shapes.solids) == len(before)
    for one, two in zip(before, after, strict=True):
        assert kept(two) == kept(one)
        assert two.color == (one.color if not one.groups else None)
        np.testing.assert_array_equal(two.mesh.faces, one.mesh.faces)
        np.testing.assert_allclose(two.mesh.vertices, one.mesh.vertices, atol=2e-5)
        assert (one.texture is None) == (two.texture is None)
        if one.texture is not None:
            np.testing.assert_array_equal(two.texture.pixels, one.texture.pixels)
            np.testing.assert_allclose(two.texture.corners, one.texture.corners, atol=1e-6)
        if one.mesh.colors is not None:
            np.testing.assert_array_equal(two.mesh.colors, one.mesh.colors)


def test_bones_and_motions_come_back(tmp_path):
    worm = wagging()
    export(Shapes(solids=(worm,)), tmp_path / "a.usda")
    (found,) = read_mesh_file(tmp_path / "a.usda").shapes.meshes()
    one, two = worm.skin, found.skin
    assert two.rig.names == one.rig.names
    np.testing.assert_array_equal(two.rig.parents, one.rig.parents)
    np.testing.assert_allclose(two.rig.joints, one.rig.joints, atol=1e-6)
    np.testing.assert_array_equal(two.joints, one.joints)
    np.testing.assert_allclose(two.weights, one.weights, atol=1e-7)
    assert [clip.name for clip in two.clips] == [clip.name for clip in one.clips]
    for mine, its in zip(one.clips, two.clips, strict=True):
        np.testing.assert_allclose(its.seconds, mine.seconds, atol=1e-9)
        same = np.abs((its.turns * mine.turns).sum(axis=2))
        np.testing.assert_allclose(same, 1.0, atol=1e-7)
    np.testing.assert_allclose(found.mesh.vertices, worm.mesh.vertices, atol=1e-4)


def test_what_was_read_is_written_the_same_again(tmp_path):
    export(everything(), tmp_path / "a.usdz")
    once = read_mesh_file(tmp_path / "a.usdz").shapes
    export(once, tmp_path / "b.usdz")
    twice = read_mesh_file(tmp_path / "b.usdz").shapes
    for one, two in zip(once.meshes(), twice.meshes(), strict=True):
        assert kept(one) == kept(two)
        np.testing.assert_allclose(one.mesh.vertices, two.mesh.vertices, rtol=1e-6, atol=1e-5)


HEAD = '#usda 1.0\n(\n defaultPrim = "w"\n metersPerUnit = 0.001\n upAxis = "Z"\n)\n'
SQUARE = """
    int[] faceVertexCounts = [4] # one
    int[] faceVertexIndices = [0, 1, 2, 3]
    point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
"""


def read(tmp_path, body, head=HEAD):
    (tmp_path / "a.usda").write_text(head + body)
    return read_mesh_file(tmp_path / "a.usda")


def test_transforms_are_put_together_in_their_order(tmp_path):
    body = f"""
    def Xform "w" {{
        double3 xformOp:translate:pivot = (1, 0, 0)
        float3 xformOp:rotateXYZ = (0, 0, 90)
        float3 xformOp:scale.timeSamples = {{ 3: (2, 2, 2), 1: (2, 2, 2), }}
        uniform token[] xformOpOrder = ["xformOp:translate:pivot", "xformOp:rotateXYZ",
            "xformOp:scale", "!invert!xformOp:translate:pivot"]
        def Mesh "m" {{{SQUARE}
            matrix4d xformOp:transform = ((1,0,0,0), (0,1,0,0), (0,0,1,0), (0,0,5,1))
            uniform token[] xformOpOrder = ["xformOp:transform"]
        }}
    }}"""
    (part,) = read(tmp_path, body).shapes.meshes()
    expected = [[1, -2, 10], [1, 0, 10], [-1, 0, 10], [-1, -2, 10]]
    np.testing.assert_allclose(part.mesh.vertices, expected, atol=1e-6)


def test_mirrored_and_left_handed_faces_look_outwards(tmp_path):
    mirror = 'float3 xformOp:scale = (-1, 1, 1)\nuniform token[] xformOpOrder = ["xformOp:scale"]\n'
    left = 'uniform token orientation = "leftHanded"\n'
    for own, up in ((mirror, 1.0), (left, -1.0), (mirror + left, -1.0)):
        (part,) = read(tmp_path, f'def Mesh "m" {{{SQUARE}{own}}}').shapes.meshes()
        a, b, c = part.mesh.vertices[part.mesh.faces[0]]
        turned = np.sign(np.cross(b - a, c - a)[2])
        assert turned == (1.0 if own in (mirror,) else up)


@pytest.mark.parametrize("kind", ["color3f[] primvars:displayColor", "color4f[] primvars:Color"])
def test_colours_of_corners_that_agree_are_those_of_vertices(tmp_path, kind):
    """As Blender writes them."""
    last = ", 1" if "4f" in kind else ""
    rows = [f"({red}, 0, 1{last})" for red in (0, 1, 0, 1)]
    for third, told in ((rows[0], ()), (rows[1], ("colours",))):
        values = ", ".join([*rows, rows[0], rows[1], third])
        triangle = SQUARE.replace("[4]", "[4, 3]").replace("2, 3]", "2, 3, 0, 1, 2]")
        said = f'{kind} = [{values}] (interpolation = "faceVarying")'
        found = read(tmp_path, f'def Mesh "m" {{{triangle}{said}}}')
        (part,) = found.shapes.meshes()
        assert all(word in found.left_out[0] for word in told)
        assert len(found.left_out) == len(told)
        if not told:
            assert part.mesh.colors[:, 0].tolist() == [0, 255, 0, 255]


@pytest.mark.parametrize(
    ("extra", "told"),
    [
        ('def Sphere "s" {}', "exact form"),
        ('def TetMesh "s" {}', "no mesh"),
        ('def "s" ( references = @away.usda@ ) {}', "elsewhere"),
        ('def "s" ( references = </nobody> ) {}', "elsewhere"),
        ('def BasisCurves "s" {}', "no faces"),
        ('def "s" (prepend references = @./b.usda@</x> (offset = 1)) {}', "flattened"),
        ('def Mesh "x" { token visibility = "invisible"\n' + SQUARE + "}", "hidden"),
        ('def Mesh "x" { uniform token subdivisionScheme = "loop"\n' + SQUARE + "}", "cages"),
        (
            'def "v" ( variants = { string a = "b" } ) { variantSet "a" = { "b" { } "c" { } } }',
            "not chosen",
        ),
        ('def Camera "c" {}', "camera"),
    ],
)
def test_what_is_left_out_is_told(tmp_path, extra, told):
    found = read(tmp_path, f'def Mesh "m" {{{SQUARE}}}\n{extra}')
    assert any(told in sentence for sentence in found.left_out)
    assert found.shapes.surfaces[0].name == "m"


WRITE = """
import sys
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade, UsdUtils, Vt
stage = Usd.Stage.CreateNew(sys.argv[1])
UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
UsdGeom.SetStageMetersPerUnit(stage, 0.01)
top = UsdGeom.Xform.Define(stage, "/top")
stage.SetDefaultPrim(top.GetPrim())
group = UsdGeom.Xform.Define(stage, "/top/group")
group.AddTranslateOp().Set(Gf.Vec3d(0, 2, 0))
group.AddRotateXYZOp().Set(Gf.Vec3f(10, 20, 30))
mesh = UsdGeom.Mesh.Define(stage, "/top/group/tent")
points = [(0, 0, 0), (4, 0, 0), (4, 0, 6), (0, 0, 6), (2, 3, 3)]
mesh.CreatePointsAttr(points)
mesh.CreateFaceVertexCountsAttr([4, 3, 3, 3, 3])
mesh.CreateFaceVertexIndicesAttr([0, 1, 2, 3, 1, 0, 4, 2, 1, 4, 3, 2, 4, 0, 3, 4])
mesh.CreateSubdivisionSchemeAttr("none")
material = UsdShade.Material.Define(stage, "/top/looks/red")
shader = UsdShade.Shader.Define(stage, "/top/looks/red/preview")
shader.CreateIdAttr("UsdPreviewSurface")
shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).Set(Gf.Vec3f(1, 0, 0))
shader.CreateInput("metallic", Sdf.ValueTypeNames.Float).Set(1.0)
material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
UsdShade.MaterialBindingAPI.Apply(group.GetPrim()).Bind(material)
stage.GetRootLayer().Save()
world = UsdGeom.XformCache().GetLocalToWorldTransform(mesh.GetPrim())
print("answer:", [list(world.Transform(Gf.Vec3d(*p))) for p in points])
"""


@pytest.mark.interop
def test_what_usds_own_library_writes_is_read(tmp_path):
    path = tmp_path / "tent.usda"
    done = subprocess.run(
        [python_of_usd(), "-c", WRITE, str(path)],
        capture_output=True,
        text=True,
        check=True,
        timeout=120,
    )
    found = read_mesh_file(path)
    assert found.left_out == ()
    (part,) = found.shapes.solids
    assert (part.name, part.path) == ("tent", ("group",))
    assert [(g.name, g.color, g.finish) for g in part.groups] == [("red", (255, 0, 0), "metal")]
    rows = np.array(eval(done.stdout.partition("answer:")[2], {}))  # noqa: S307
    expected = 10.0 * np.column_stack([rows[:, 0], -rows[:, 2], rows[:, 1]])
    np.testing.assert_allclose(part.mesh.vertices, expected, atol=1e-4)


def test_a_package_without_a_scene_and_one_cut_short_are_refused(tmp_path):
    data = prepare_export(everything(), "a.usdz").data
    (tmp_path / "a.usdz").write_bytes(data[: len(data) // 2])
    with pytest.raises(FormatError):
        read_mesh_file(tmp_path / "a.usdz")
    with zipfile.ZipFile(tmp_path / "b.usdz", "w") as package:
        package.writestr("a.txt", "a")
    with pytest.raises(FormatError, match="no scene"):
        read_mesh_file(tmp_path / "b.usdz")
