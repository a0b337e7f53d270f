"""USD: what stands in the files, and what USD's own library and Blender make of them."""

from __future__ import annotations

import io
import re
import zipfile
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image
from scipy.spatial.transform import Rotation

from bozzetto.exchange.color import srgb_to_linear
from bozzetto.exchange.export import export, prepare_export
from bozzetto.exchange.handover import Handover
from bozzetto.exchange.usd.prims import Names, quoted
from bozzetto.exchange.usd.usdz import write_motion
from bozzetto.geometry import Clip, FaceGroup, Mesh, Placement, Shapes, Solid, Texture
from tests.blender import asked
from tests.core.exchange.skinned import skinned
from tests.core.exchange.test_blender import BOX
from tests.usd_reader import asked_usd

CHECK = """
registry = UsdValidation.ValidationRegistry()
context = UsdValidation.ValidationContext(registry.GetOrLoadAllValidators())
answer = [f"{e.GetName()}: {e.GetMessage()}" for e in context.Validate(stage)]
"""

TREE = """
answer = {
    str(prim.GetPath()): [str(prim.GetTypeName()), prim.GetDisplayName()]
    for prim in stage.Traverse()
}
"""

MESHES = """
answer = {}
for prim in stage.Traverse():
    if not prim.IsA(UsdGeom.Mesh):
        continue
    mesh, api = UsdGeom.Mesh(prim), UsdGeom.PrimvarsAPI(prim)
    colors, places = api.GetPrimvar("displayColor"), api.GetPrimvar("st")
    answer[prim.GetName()] = {
        "points": rows(mesh.GetPointsAttr().Get()),
        "faces": list(mesh.GetFaceVertexIndicesAttr().Get()),
        "extent": rows(mesh.GetExtentAttr().Get()),
        "normals": rows(mesh.GetNormalsAttr().Get()),
        "normals of": mesh.GetNormalsInterpolation(),
        "st": rows(places.ComputeFlattened()) if places.HasValue() else None,
        "colors": rows(colors.ComputeFlattened()) if colors.HasValue() else None,
        "twofold": mesh.GetDoubleSidedAttr().Get(),
        "subsets": {
            subset.GetPrim().GetName(): [
                list(subset.GetIndicesAttr().Get()),
                str(UsdShade.MaterialBindingAPI(subset).ComputeBoundMaterial()[0].GetPath()),
            ]
            for subset in UsdShade.MaterialBindingAPI(prim).GetMaterialBindSubsets()
        },
    }
"""

LOOKS = """
answer = {}
for prim in stage.Traverse():
    if prim.IsA(UsdShade.Material):
        shader = UsdShade.Material(prim).ComputeSurfaceSource()[0]
        values = {}
        for one in shader.GetInputs():
            source = one.GetConnectedSources()[0]
            value = one.Get()
            if source:
                values[one.GetBaseName()] = UsdShade.Shader(source[0].source).GetIdAttr().Get()
            else:
                values[one.GetBaseName()] = list(value) if hasattr(value, "__len__") else value
        answer[prim.GetName()] = values
"""

SKINNED = """
# The library's own skinning of every mesh, in the axes of the scene, at some times.
answer = []
for time in json.loads(sys.argv[2]):
    cache, found = UsdSkel.Cache(), {}
    for prim in stage.Traverse():
        if not prim.IsA(UsdSkel.Root):
            continue
        root = UsdSkel.Root(prim)
        cache.Populate(root, Usd.PrimDefaultPredicate)
        for binding in cache.ComputeSkelBindings(root, Usd.PrimDefaultPredicate):
            skeleton = cache.GetSkelQuery(binding.GetSkeleton())
            moves = skeleton.ComputeSkinningTransforms(time)
            for target in binding.GetSkinningTargets():
                mesh = UsdGeom.Mesh(target.GetPrim())
                points = Vt.Vec3fArray(mesh.GetPointsAttr().Get())
                assert target.ComputeSkinnedPoints(moves, points, time)
                found[target.GetPrim().GetName()] = rows(points)
    answer.append(found)
"""

RIGID = """
answer = []
for time in json.loads(sys.argv[2]):
    cache = UsdGeom.XformCache(time)
    answer.append({
        prim.GetName(): rows(
            cache.GetLocalToWorldTransform(prim).Transform(Gf.Vec3d(point))
            for point in UsdGeom.Mesh(prim).GetPointsAttr().Get()
        )
        for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh)
    })
"""

Y_UP = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])


def wagging(texture=False, **options):
    """A worm with two motions, one of which moves a joint away as well."""
    worm = skinned(turned=True, texture=texture, **options)
    joints = len(worm.skin.rig.joints)
    turns = np.tile([0.0, 0, 0, 1], (4, joints, 1))
    for k in range(4):
        turns[k, 3] = Rotation.from_euler("zx", [115.0 * k, 20 * k], degrees=True).as_quat()
        turns[k, 5] = Rotation.from_euler("y", -25.0 * k, degrees=True).as_quat()
    shifts = np.zeros((4, joints, 3))
    shifts[2:, 0, 2] = 5.0
    clips = (
        Clip("wag", [0.0, 0.4, 0.9, 1.3], turns, shifts),
        Clip("né 2", [0.0, 1.0], turns[:2]),
    )
    return replace(worm, skin=replace(worm.skin, clips=clips))


def posed_at(worm, clip, k):
    """Our own skinning at one of the keys of a clip, mm."""
    rig = replace(
        worm.skin.rig,
        turns=clip.turns[k],
        shifts=None if clip.shifts is None else clip.shifts[k],
    )
    rest = worm.skin.rest or worm.mesh
    return replace(worm.skin, rig=rig).posed(rest).vertices.astype(float)


def everything():
    painted = np.array([[255, 0, 0, 255]] * 4 + [[0, 0, 255, 255]] * 4, np.uint8)
    groups = (FaceGroup("lid", 4, color=(10, 200, 30)), FaceGroup("pane", 8, finish="glass"))
    metal = (FaceGroup("inner", 12, finish="metal"),)
    pixels = np.zeros((4, 4, 4), np.uint8)
    pixels[:2], pixels[2:] = (255, 0, 0, 255), (0, 0, 255, 255)
    corners = np.random.default_rng(3).random((len(BOX.faces), 3, 2)).astype(np.float32)
    return Shapes(
        solids=(
            wagging(),
            Solid(BOX, 'Bö "x" a.b', (200, 50, 25), groups=groups, path=("outer 1",)),
            Solid(BOX, "inner", groups=metal, path=("outer 1", 'Bö "x" a.b')),
            Solid(replace(BOX, colors=painted), "painted", path=("outer 1",)),
            Solid(BOX, "画", path=("1st",), texture=Texture(pixels, corners)),
        )
    )


@pytest.fixture(params=["usda", "usd", "usdz"])
def whole(request, tmp_path):
    path = tmp_path / f"all of it.{request.param}"
    export(everything(), path)
    return path


def test_identifiers_are_plain_and_all_different():
    names = Names()
    given = ("Körper", "Korper", "arm.L", "2nd", "", "画", "a b", "a.b")
    made = [names.new(name) for name in given]
    assert made == ["Korper", "Korper_2", "arm_L", "_2nd", "part", "part_2", "a_b", "a_b_2"]
    assert all(re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", name) for name in made)


def test_text_cannot_leave_its_quotes():
    assert quoted('a"b\\c\nd\0') == '"a\\"b\\\\c d "'


def test_package_is_stored_aligned_and_the_same_again(tmp_path):
    first, second = (prepare_export(everything(), tmp_path / "a.usdz").data for _ in range(2))
    assert first == second
    package = zipfile.ZipFile(io.BytesIO(first))
    assert [entry.filename for entry in package.infolist()] == ["model.usda", "textures/1.png"]
    for entry in package.infolist():
        assert entry.compress_type == zipfile.ZIP_STORED
        content = package.read(entry)
        begin = first.index(content)
        assert begin % 64 == 0
    assert package.testzip() is None
    with Image.open(io.BytesIO(package.read("textures/1.png"))) as picture:
        assert picture.getpixel((0, 0))[:3] == (255, 0, 0)
        assert picture.getpixel((0, 3))[:3] == (0, 0, 255)


def test_pictures_lie_beside_the_text(tmp_path):
    made = export(everything(), tmp_path / "a@b.usda")
    assert [name for name, _ in made.beside] == ["a_b-1.png"]
    assert (tmp_path / "a_b-1.png").read_bytes().startswith(b"\x89PNG")
    assert "@./a_b-1.png@" in (tmp_path / "a@b.usda").read_text()


def test_what_the_files_do_not_hold_is_said(tmp_path):
    wanted = Handover(up="z", levels=True, unit="cm")
    notes = prepare_export(everything(), tmp_path / "a.usdz", handover=wanted).notes
    assert notes == (
        "USDZ files always have Y up.",
        "USDZ files hold one level of detail: the finest. GLB holds all.",
        "USDZ files play one motion: the first. The others lie beside it.",
    )
    one = skinned()
    assert prepare_export(Shapes(solids=(one,)), tmp_path / "a.usda").warnings() == ()


@pytest.mark.interop
def test_usd_finds_no_fault(whole):
    assert asked_usd(CHECK, whole) == []


@pytest.mark.interop
def test_parts_are_where_they_belong_by_name(whole):
    tree = asked_usd(TREE, whole)
    assert tree["/Model/worm_rig"] == ["SkelRoot", "worm rig"]
    assert tree["/Model/worm_rig/worm"] == ["Mesh", ""]
    assert tree["/Model/worm_rig/ne_2"] == ["SkelAnimation", "né 2"]
    assert tree["/Model/outer_1"] == ["Xform", "outer 1"]
    box = "/Model/outer_1/Bo_x_a_b"
    assert tree[box] == ["Xform", 'Bö "x" a.b']  # a mesh may hold no mesh
    assert tree[f"{box}/Bo_x_a_b"] == ["Mesh", 'Bö "x" a.b']
    assert tree[f"{box}/inner"] == ["Mesh", ""]
    assert tree["/Model/_1st/part"] == ["Mesh", "画"]


@pytest.mark.interop
def test_meshes_have_all_that_ours_have(whole):
    meshes = asked_usd(MESHES, whole)
    corners = BOX.vertices[BOX.faces].astype(float)
    flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    flat = flat / np.linalg.norm(flat, axis=1, keepdims=True) @ Y_UP.T
    shapes = {"Bo_x_a_b": 1, "inner": 2, "painted": 3, "part": 4}
    for name in shapes:
        mesh = meshes[name]
        there = BOX.vertices @ Y_UP.T / 1000.0
        np.testing.assert_allclose(mesh["points"], there, atol=1e-9)
        assert mesh["faces"] == BOX.faces.ravel().tolist()
        np.testing.assert_allclose(mesh["extent"], [there.min(0), there.max(0)], atol=1e-9)
        assert mesh["normals of"] == "faceVarying"
        np.testing.assert_allclose(mesh["normals"], np.repeat(flat, 3, axis=0), atol=1e-5)
        assert not mesh["twofold"]
    solids = everything().solids
    places = solids[4].texture.corners.reshape(-1, 2)
    ours = np.column_stack((places[:, 0], 1.0 - places[:, 1]))  # USD counts from below
    np.testing.assert_allclose(meshes["part"]["st"], ours, atol=1e-6)
    light = srgb_to_linear(solids[3].mesh.colors[:, :3])
    np.testing.assert_allclose(meshes["painted"]["colors"], light, atol=1e-5)
    assert meshes["Bo_x_a_b"]["subsets"] == {
        "lid": [[0, 1, 2, 3], "/Model/Materials/lid"],
        "pane": [list(range(4, 12)), "/Model/Materials/pane"],
    }


@pytest.mark.interop
def test_materials_have_our_colours_and_finishes(whole):
    looks = asked_usd(LOOKS, whole)
    lid, pane, inner = looks["lid"], looks["pane"], looks["inner"]
    np.testing.assert_allclose(lid["diffuseColor"], srgb_to_linear((10, 200, 30)), atol=1e-5)
    np.testing.assert_allclose(pane["diffuseColor"], srgb_to_linear((200, 50, 25)), atol=1e-5)
    assert (lid["opacity"], lid["metallic"], inner["metallic"]) == (1.0, 0.0, 1.0)
    assert pane["opacity"] < 0.6
    assert looks["painted"]["diffuseColor"] == "UsdPrimvarReader_float3"
    assert looks["material"]["diffuseColor"] == "UsdUVTexture"


@pytest.mark.interop
@pytest.mark.parametrize(
    ("unit", "up", "metres"), [(None, None, 1.0), ("mm", "z", 0.001), ("in", "y", 0.0254)]
)
def test_unit_and_axis_are_said_and_the_size_stays(tmp_path, unit, up, metres):
    path = tmp_path / "box.usda"
    export(Shapes(solids=(Solid(BOX, "Box"),)), path, handover=Handover(unit=unit, up=up))
    script = """
found = UsdGeom.BBoxCache(0, ["default"]).ComputeWorldBound(stage.GetDefaultPrim())
scale = UsdGeom.GetStageMetersPerUnit(stage)
size = [scale * value for value in found.ComputeAlignedRange().GetSize()]
answer = [UsdGeom.GetStageUpAxis(stage), scale, size]
"""
    axis, scale, size = asked_usd(script, path)
    assert axis == (up or "y").upper()
    assert scale == pytest.approx(metres)
    expected = (0.01, 0.02, 0.04) if up == "z" else (0.01, 0.04, 0.02)
    assert size == pytest.approx(expected, rel=1e-5)


@pytest.mark.interop
@pytest.mark.parametrize("ending", ["usda", "usdz"])
def test_usd_bends_a_figure_as_we_do(tmp_path, ending):
    worm = wagging()
    clip = worm.skin.clips[0]
    path = tmp_path / f"worm.{ending}"
    export(Shapes(solids=(worm,)), path)
    times = (clip.seconds * 24.0).tolist()
    for k, found in enumerate(asked_usd(SKINNED, path, times)):
        ours = posed_at(worm, clip, k) @ Y_UP.T / 1000.0
        np.testing.assert_allclose(found["worm"], ours, atol=2e-7)


@pytest.mark.interop
def test_between_keys_joints_turn_the_short_way(tmp_path):
    worm = wagging()
    clip = worm.skin.clips[0]
    path = tmp_path / "worm.usda"
    export(Shapes(solids=(worm,)), path, handover=Handover(unit="mm", up="z"))
    for k in range(3):
        middle = float(clip.seconds[k] + clip.seconds[k + 1]) / 2
        (found,) = asked_usd(SKINNED, path, [middle * 24.0])
        pairs = zip(clip.turns[k], clip.turns[k + 1], strict=True)
        halves = []
        for one, other in pairs:
            first, last = Rotation.from_quat(one), Rotation.from_quat(other)
            way = (first.inv() * last).as_rotvec() / 2
            halves.append((first * Rotation.from_rotvec(way)).as_quat())
        shifts = (clip.shifts[k] + clip.shifts[k + 1]) / 2
        half = Clip("half", [0.0], np.array(halves)[None], shifts[None])
        np.testing.assert_allclose(found["worm"], posed_at(worm, half, 0), atol=1e-3)


@pytest.mark.interop
def test_a_posed_figure_without_motion_stands_as_it_is_posed(tmp_path):
    worm = skinned(pose=40, turned=True)
    path = tmp_path / "worm.usda"
    export(Shapes(solids=(worm,)), path, handover=Handover(unit="mm", up="z"))
    (found,) = asked_usd(SKINNED, path, [0.0])
    ours = worm.skin.posed(worm.skin.rest).vertices
    np.testing.assert_allclose(found["worm"], ours, atol=1e-4)


@pytest.mark.interop
def test_parts_on_one_rig_share_a_skeleton(tmp_path):
    worm = wagging()
    other = replace(worm, name="coat", path=("clothes",))
    path = tmp_path / "two.usda"
    export(Shapes(solids=(worm, other, wagging(name="eel"))), path)
    tree = asked_usd(TREE, path)
    kinds = [kind for kind, _ in tree.values()]
    assert kinds.count("SkelRoot") == kinds.count("Skeleton") == 2
    assert tree["/Model/worm_rig/clothes/coat"][0] == "Mesh"
    (found,) = asked_usd(SKINNED, path, [0.4 * 24])
    assert found["coat"] == found["worm"]


@pytest.mark.interop
def test_rigid_motion_of_a_film_is_where_it_was_filmed(tmp_path):
    axis = np.array([1.0, 2.0, -0.5])
    frames, seconds = [], [0.0, 0.2, 0.5]
    for k in range(3):
        turn = Rotation.from_rotvec(0.7 * k * axis).as_matrix()
        place = Placement(tuple(turn.ravel().tolist()), 1.0, (5.0 * k, -k, 2.0))
        moving = Solid(BOX.placed(place), "moving")
        frames.append(Shapes(solids=(moving, Solid(BOX, "still"))))
    path = tmp_path / "film.usdz"
    path.write_bytes(write_motion(frames, seconds))
    assert asked_usd(CHECK, path) == []
    found = asked_usd(RIGID, path, [24 * one for one in seconds])
    for frame, there in zip(frames, found, strict=True):
        for part in frame.solids:
            ours = part.mesh.vertices @ Y_UP.T / 1000.0
            np.testing.assert_allclose(there[part.name], ours, atol=1e-7)


@pytest.mark.interop
def test_uvs_are_laid_out_where_they_are_wanted(tmp_path):
    path = tmp_path / "box.usda"
    export(Shapes(solids=(Solid(BOX, "Box"),)), path, handover=Handover(uvs=True))
    places = np.array(asked_usd(MESHES, path)["Box"]["st"]).reshape(-1, 3, 2)
    assert places.min() >= 0.0
    assert places.max() <= 1.0
    across = places[:, 1:] - places[:, :1]
    assert (np.abs(np.linalg.det(across)) > 1e-3).all()


@pytest.mark.interop
def test_blender_shows_it_in_place_with_materials_and_moves_it(tmp_path):
    script = """
bpy.ops.wm.usd_import(filepath=sys.argv[1])
scene = bpy.context.scene
answer = {"fps": scene.render.fps, "meshes": {}, "at": []}
for one in bpy.data.objects:
    if one.type == "MESH":
        links = [
            (link.from_node.type, link.to_socket.name)
            for material in one.data.materials for link in material.node_tree.links
        ]
        answer["meshes"][one.name] = {
            "points": [list(one.matrix_world @ v.co) for v in one.data.vertices],
            "links": links,
            "materials": [material.name for material in one.data.materials],
            "groups": [group.name for group in one.vertex_groups],
        }
for time in json.loads(sys.argv[2]):
    scene.frame_set(int(time), subframe=time % 1.0)
    worm = bpy.data.objects["worm"]
    shown = worm.evaluated_get(bpy.context.evaluated_depsgraph_get()).to_mesh()
    answer["at"].append([list(worm.matrix_world @ v.co) for v in shown.vertices])
"""
    path = tmp_path / "all.usdz"
    export(everything(), path)
    worm = everything().solids[0]
    clip = worm.skin.clips[0]
    found = asked(script, path, (clip.seconds * 24.0).tolist())
    box = found["meshes"]["Bo_x_a_b"]
    np.testing.assert_allclose(box["points"], BOX.vertices / 1000.0, atol=1e-8)
    assert box["materials"] == ["lid", "pane"]
    assert ["TEX_IMAGE", "Base Color"] in found["meshes"]["part"]["links"]
    assert ["ATTRIBUTE", "Base Color"] in found["meshes"]["painted"]["links"]
    assert found["meshes"]["worm"]["groups"] == [f"worm_{k}" for k in range(7)]
    assert found["fps"] == 24
    for k, there in enumerate(found["at"]):
        np.testing.assert_allclose(there, posed_at(worm, clip, k) / 1000.0, atol=1e-5)


def test_a_part_without_a_triangle_is_no_part(tmp_path):
    empty = Mesh(BOX.vertices, np.array([[0, 0, 1]]))
    from bozzetto.geometry import Surface

    shapes = Shapes(solids=(Solid(BOX, "Box"),), surfaces=(Surface(empty, "nothing"),))
    text = prepare_export(shapes, tmp_path / "a.usda").data.decode()
    assert "nothing" not in text
    assert text.count("def Mesh") == 1
