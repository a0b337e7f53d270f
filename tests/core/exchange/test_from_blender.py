"""Files that Blender writes, read: names, hierarchy, places, materials; nothing is refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.exchange.export import export
from bozzetto.exchange.import_file import read_mesh_file
from bozzetto.geometry.shapes import FaceGroup
from tests.blender import asked
from tests.core.exchange.test_mesh_formats import volume
from tests.core.exchange.test_usd import everything

pytestmark = pytest.mark.interop

WRITE = """
path, wanted = sys.argv[1:3]


def material(name, color, metallic):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    inputs = made.node_tree.nodes["Principled BSDF"].inputs
    inputs["Base Color"].default_value = (*color, 1.0)
    inputs["Metallic"].default_value = metallic
    return made


red, chrome = material("Red", (1, 0, 0), 0.0), material("Chrome", (0.2, 0.8, 0.1), 1.0)


def cube(name, place, scale, held, first):
    bpy.ops.mesh.primitive_cube_add(size=1, location=place)
    made = bpy.context.object
    made.name, made.scale, made.parent = name, scale, held
    made.data.materials.append(first)
    return made


base = cube("Base", (1, 2, 3), (1, 2, 3), None, red)
base.rotation_euler = (0.3, 0.2, 0.5)
cube("Arm", (1, 0, 0), (0.5, 0.5, 0.5), base, chrome)
cube("Mirrored", (4, 0, 0), (-1, 1, 2), None, red)
group = bpy.data.objects.new("Group", None)
bpy.context.collection.objects.link(group)
group.location = (0, 5, 0)
held = cube("Held", (0, 0, 1), (1, 1, 1), group, chrome)
if wanted == "keys":
    held.shape_key_add(name="Basis")
    for point in held.shape_key_add(name="Tall").data:
        point.co.z *= 2
two = cube("Two", (8, 0, 0), (1, 1, 1), None, red)
two.data.materials.append(chrome)
for face in two.data.polygons:
    face.material_index = face.index % 2
bpy.context.view_layer.update()
answer = {}
for one in bpy.data.objects:
    if one.type == "MESH":
        places = [one.matrix_world @ v.co for v in one.data.vertices]
        answer[one.name] = [
            [1000 * kind(p[k] for p in places) for k in range(3)] for kind in (min, max)
        ]
bpy.ops.export_scene.gltf(
    filepath=path,
    export_format="GLTF_SEPARATE" if path.endswith(".gltf") else "GLB",
    export_draco_mesh_compression_enable=wanted == "draco",
)
"""


@pytest.mark.parametrize(
    ("ending", "wanted"), [("glb", "plain"), ("glb", "keys"), ("gltf", "keys")]
)
def test_objects_come_as_they_stand(tmp_path, ending, wanted):
    path = tmp_path / f"a.{ending}"
    places = asked(WRITE, path, wanted)
    found = read_mesh_file(path)
    parts = {part.name: part for part in found.shapes.solids}
    assert len(list(found.shapes.meshes())) == len(parts)
    assert parts.keys() == places.keys()
    for name, (low, high) in places.items():
        vertices = parts[name].mesh.vertices
        np.testing.assert_allclose(vertices.min(axis=0), low, atol=2e-3)
        np.testing.assert_allclose(vertices.max(axis=0), high, atol=2e-3)
    volumes = {name: volume(part.mesh) for name, part in parts.items()}
    assert volumes == pytest.approx(
        {"Base": 6e9, "Arm": 0.75e9, "Mirrored": 2e9, "Held": 1e9, "Two": 1e9}, rel=1e-4
    )
    assert (parts["Arm"].path, parts["Held"].path) == (("Base",), ("Group",))
    groups = [(one.name, one.count, one.finish) for one in parts["Two"].groups]
    assert groups == [("Red", 6, "matt"), ("Chrome", 6, "metal")]
    assert any("other forms" in line for line in found.left_out) == (wanted == "keys")


def test_compressed_meshes_come_as_the_others(tmp_path):
    pytest.importorskip("DracoPy", reason="the extra “draco” is not installed")
    places = asked(WRITE, tmp_path / "a.glb", "draco")
    assert b"KHR_draco_mesh_compression" in (tmp_path / "a.glb").read_bytes()
    parts = {part.name: part for part in read_mesh_file(tmp_path / "a.glb").shapes.solids}
    assert parts.keys() == places.keys()
    for name, (low, high) in places.items():
        vertices, size = parts[name].mesh.vertices, np.subtract(high, low).max()
        # Blender keeps 14 of the bits of places.
        np.testing.assert_allclose(vertices.min(axis=0), low, atol=size / 2**13)
        np.testing.assert_allclose(vertices.max(axis=0), high, atol=size / 2**13)
    groups = [(one.name, one.count, one.finish) for one in parts["Two"].groups]
    assert groups == [("Red", 6, "matt"), ("Chrome", 6, "metal")]


RICH = """
path = sys.argv[1]
folder = os.path.dirname(path)


def material(name, color, picture=None, layer=""):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    nodes, links = made.node_tree.nodes, made.node_tree.links
    inputs = nodes["Principled BSDF"].inputs
    inputs["Base Color"].default_value = (*color, 1.0)
    if picture:
        shown, places = nodes.new("ShaderNodeTexImage"), nodes.new("ShaderNodeUVMap")
        shown.image, places.uv_map = picture, layer
        links.new(places.outputs["UV"], shown.inputs["Vector"])
        links.new(shown.outputs["Color"], inputs["Base Color"])
    return made


picture = bpy.data.images.new("checks", 8, 8)
picture.pixels = [value for k in range(64) for value in (k % 2, 0.1, 0.1, 1.0)]
picture.filepath_raw, picture.file_format = os.path.join(folder, "checks.png"), "PNG"
picture.save()
red = material("Red", (1, 0, 0))
scene = bpy.context.scene.collection

bpy.ops.mesh.primitive_cube_add(size=2, location=(4, 0, 1))
two = bpy.context.object
two.name, two["maker"] = "Two maps", "somebody"
first, second = two.data.uv_layers[0], two.data.uv_layers.new(name="Second")
for here, there in zip(first.data, second.data):
    there.uv = here.uv * 0.5
two.data.materials.append(material("Checks", (1, 1, 1), picture, "Second"))

bpy.ops.mesh.primitive_cylinder_add(vertices=12, radius=0.3, depth=4, location=(0, 0, 2))
limb = bpy.context.object
limb.name = "Limb"
limb.data.materials.append(red)
rig = bpy.data.objects.new("Rig", bpy.data.armatures.new("Bones"))
scene.objects.link(rig)
bpy.context.view_layer.objects.active = rig
bpy.ops.object.mode_set(mode="EDIT")
upper, lower = (rig.data.edit_bones.new(name) for name in ("upper", "lower"))
upper.head, upper.tail, lower.head, lower.tail = (0, 0, 0), (0, 0, 2), (0, 0, 2), (0, 0, 4)
lower.parent = upper
bpy.ops.object.mode_set(mode="OBJECT")
limb.select_set(True)
rig.select_set(True)
bpy.ops.object.parent_set(type="ARMATURE_AUTO")
bone = rig.pose.bones["lower"]
bone.rotation_mode = "QUATERNION"
for name, x in (("Wave", 0.4), ("Nod", -0.3)):
    action = bpy.data.actions.new(name)
    rig.animation_data_create().action = action
    for frame, turn in ((1, 0.0), (12, x), (24, 0.0)):
        bone.rotation_quaternion = ((1 - turn**2) ** 0.5, turn, 0, 0)
        bone.keyframe_insert("rotation_quaternion", frame=frame)
    track = rig.animation_data.nla_tracks.new()
    track.name = name
    track.strips.new(name, 1, action)
    rig.animation_data.action = None
bone.rotation_quaternion = (1, 0, 0, 0)

kit = bpy.data.collections.new("Kit")
scene.children.link(kit)
bpy.ops.mesh.primitive_cone_add(vertices=12, radius1=0.5, depth=1, location=(0, 6, 0))
cone = bpy.context.object
cone.name = "Cone"
cone.data.materials.append(red)
for one in list(cone.users_collection):
    one.objects.unlink(cone)
kit.objects.link(cone)
copy = bpy.data.objects.new("Copy", None)
copy.instance_type, copy.instance_collection, copy.location = "COLLECTION", kit, (3, 0, 0)
scene.objects.link(copy)

holder = bpy.data.objects.new("Holder", None)
holder.location, holder.rotation_euler, holder.scale = (0, -5, 0), (0, 0, 0.6), (2, 2, 2)
scene.objects.link(holder)
bpy.ops.mesh.primitive_cube_add(size=1, location=(1, 0, 0))
flipped = bpy.context.object
flipped.name, flipped.scale, flipped.parent = "Flipped", (-1, 1, 2), holder
flipped.data.materials.append(red)
bpy.ops.mesh.primitive_cube_add(size=1, location=(-5, 0, 0))
row = bpy.context.object
row.name = "Row"
row.data.materials.append(red)
array = row.modifiers.new("Array", "ARRAY")
array.count, array.relative_offset_displace = 3, (2, 0, 0)

bpy.context.view_layer.update()
answer = []
graph = bpy.context.evaluated_depsgraph_get()
for one in graph.object_instances:
    if one.object.type == "MESH":
        places = [one.matrix_world @ v.co for v in one.object.to_mesh().vertices]
        corners = [[1000 * kind(p[k] for p in places) for k in range(3)] for kind in (min, max)]
        answer.append([one.object.name, corners])
if path.endswith(".usda"):
    bpy.ops.wm.usd_export(filepath=path, export_animation=True)
else:
    bpy.ops.export_scene.gltf(
        filepath=path,
        export_format="GLTF_SEPARATE" if path.endswith(".gltf") else "GLB",
        export_apply=True,
        export_extras=True,
        export_animation_mode="NLA_TRACKS",
    )
"""


@pytest.mark.parametrize("ending", ["glb", "gltf", "usda"])
def test_a_rich_scene_comes_whole(tmp_path, ending):
    """Copies, mirrors, modifiers, bones with motions, and a picture by its second places."""
    places = asked(RICH, tmp_path / f"a.{ending}")
    found = read_mesh_file(tmp_path / f"a.{ending}")
    parts = [(p.name, [p.mesh.vertices.min(axis=0), p.mesh.vertices.max(axis=0)])
             for p in found.shapes.solids]  # fmt: skip
    assert len(list(found.shapes.meshes())) == len(parts) == len(places) == 6
    for name, corners in places:
        off = [np.abs(np.subtract(seen, corners)).max() for one, seen in parts if one == name]
        assert min(off) < 5e-3, name
    named = {part.name: part for part in found.shapes.solids}
    assert named["Flipped"].path == ("Holder",)
    assert volume(named["Flipped"].mesh) == pytest.approx(16e9, rel=1e-4)
    assert volume(named["Row"].mesh) == pytest.approx(3e9, rel=1e-4)
    skin = named["Limb"].skin
    assert skin.rig.names == ("upper", "lower")
    motions = {clip.name for clip in skin.clips}
    assert motions == {"Wave", "Nod"} if ending != "usda" else len(motions) == 1
    picture = named["Two maps"].texture
    assert picture.pixels.shape[:2] == (8, 8)
    across = np.ptp(picture.corners.reshape(-1, 2), axis=0)
    np.testing.assert_allclose(across, [0.375, 0.5], atol=1e-5)  # of its first places twice that
    for word in ("texture coordinates", "noted of a part"):
        assert any(word in line for line in found.left_out), word


CHANGED = """
from mathutils import Quaternion
source, folder = sys.argv[1:3]
bpy.ops.import_scene.gltf(filepath=source)
bpy.data.objects.remove(bpy.data.objects["Icosphere"])  # what the importer shows bones by
rig = next(o for o in bpy.data.objects if o.type == "ARMATURE")
rig.animation_data_clear()
bone = rig.pose.bones[1]
bone.rotation_mode = "QUATERNION"
bone.rotation_quaternion = Quaternion((1.0, 0.0, 0.0), 0.5)
bone.bone.name = "Bend"
worm = next(o for o in bpy.data.objects if o.type == "MESH" and o.find_armature())
worm.name = "Snake 2"
color = worm.data.materials[0].node_tree.nodes["Principled BSDF"].inputs["Base Color"]
color.default_value = (0.8, 0.1, 0.05, 1.0)
worm.data.materials[0].name = "Scales"
bpy.context.view_layer.update()
graph = bpy.context.evaluated_depsgraph_get()
answer = {}
for one in bpy.data.objects:
    if one.type == "MESH":
        places = [one.matrix_world @ v.co for v in one.evaluated_get(graph).to_mesh().vertices]
        answer[one.name] = [
            [1000 * kind(p[k] for p in places) for k in range(3)] for kind in (min, max)
        ]
path = os.path.join(folder, "a")
bpy.ops.export_scene.gltf(filepath=path + ".glb", export_rest_position_armature=False)
for ending in ("usda", "usdc", "usdz"):
    bpy.ops.wm.usd_export(filepath=f"{path}.{ending}")
bpy.ops.wm.obj_export(filepath=path + ".obj")
"""


def test_what_is_ours_comes_back_from_blender_as_it_was_changed_there(tmp_path):
    """A posed, renamed and repainted figure among other parts, in five formats."""
    export(everything(), tmp_path / "ours.glb")
    boxes = asked(CHANGED, tmp_path / "ours.glb", tmp_path)
    before = {part.name: part for part in everything().meshes()}
    (worm,) = (part for part in before.values() if part.skin is not None)
    names = {"Bend" if k == 1 else name for k, name in enumerate(worm.skin.rig.names)}
    for ending in ("glb", "usda", "usdc", "usdz", "obj"):
        found = read_mesh_file(tmp_path / f"a.{ending}")
        guess = found.guess and replace(found.guess, up="y", unit="m")  # as Blender writes them
        shapes = replace(found, guess=guess).upright
        parts = {part.name.replace("_", " "): part for part in shapes.meshes()}
        assert parts.keys() == boxes.keys(), ending
        for name, box in boxes.items():
            np.testing.assert_allclose(parts[name].mesh.bounds, box, atol=2e-3, err_msg=ending)
        snake = parts["Snake 2"]
        (group,) = snake.groups or (FaceGroup("Scales", 0, snake.color),)
        assert group.name == "Scales"
        assert (group.color or snake.color) == (231, 89, 63), ending
        assert (snake.skin is None) == (ending == "obj")
        if snake.skin is not None:
            assert {name.replace("_", " ") for name in snake.skin.rig.names} == names
            assert snake.skin.rig.is_posed
        for name, part in parts.items():
            if ending == "obj" or name not in before:
                continue
            assert (part.texture is None) == (before[name].texture is None), (ending, name)
            painted = part.mesh.colors is None
            assert painted == (before[name].mesh.colors is None), (ending, name)
            assert len(part.groups) == len(before[name].groups) or len(part.groups) <= 1
            if ending == "glb":
                assert part.path == before[name].path
