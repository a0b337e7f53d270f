"""Files that Blender writes, read: names, hierarchy, places, materials; nothing is refused."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.exchange.import_file import read_mesh_file
from tests.blender import asked
from tests.core.exchange.test_mesh_formats import volume

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
