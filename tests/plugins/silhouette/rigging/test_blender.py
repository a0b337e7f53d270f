"""Rigs in the hands of Blender: bones, axes, sides, and what a motion does to the skin."""

from __future__ import annotations

import json

import numpy as np
import pytest
from scipy.spatial import cKDTree

from bozzetto.exchange.export import export
from bozzetto.geometry import Shapes
from bozzetto.plugin import Context, Job
from bozzetto_silhouette.modeler import Silhouette
from tests.blender import asked
from tests.plugins.silhouette.outlines import COMMITTED, svg_rings
from tests.plugins.silhouette.rigging.characters import fitted, man, state_of_rings

pytestmark = pytest.mark.interop

READ = """
bpy.ops.import_scene.gltf(filepath=sys.argv[1])
scene = bpy.context.scene
rig = next(o for o in bpy.data.objects if o.type == "ARMATURE")
mesh = next(o for o in bpy.data.objects if o.type == "MESH" and o.find_armature())
bones = {}
for bone in rig.data.bones:
    axes = (rig.matrix_world @ bone.matrix_local).to_3x3()
    bones[bone.name] = {
        "parent": bone.parent.name if bone.parent else "",
        "head": list(rig.matrix_world @ bone.head_local),
        "tail": list(rig.matrix_world @ bone.tail_local),
        "axes": [list(row) for row in axes],
    }
actions = [action.name for action in bpy.data.actions]
frames = []
for seconds in json.loads(sys.argv[2]):
    frame = seconds * scene.render.fps
    scene.frame_set(int(frame), subframe=frame - int(frame))
    seen = mesh.evaluated_get(bpy.context.evaluated_depsgraph_get())
    made = seen.to_mesh()
    frames.append([list(seen.matrix_world @ v.co) for v in made.vertices])
groups = [group.name for group in mesh.vertex_groups]
answer = {"bones": bones, "actions": actions, "frames": frames, "groups": groups}
"""

MODELER = Silhouette()
COMMANDS = {command.id: command for command in MODELER.commands()}
TOOL = next(tool for tool in MODELER.tools() if tool.id == "animate")
TIMES = (0.0, 0.11, 0.37, 0.7)


def read(path, times):
    return asked(READ, path, json.dumps(times))


def solid_of(state):
    return MODELER.shapes(state, MODELER.solve(state, Job("preview"))).solids[0]


@pytest.mark.parametrize("name", ["man", "horse_skimage"])
def test_blender_has_our_bones_and_moves_the_skin_as_we_do(tmp_path, name):
    rings = [man()] if name == "man" else fitted(svg_rings(COMMITTED / f"{name}.svg"))
    state = COMMANDS["walk"].run(state_of_rings(rings, 48), Context())
    solid = solid_of(state)
    rig = solid.skin.rig
    export(Shapes(solids=(solid,)), tmp_path / "a.glb")
    seen = read(tmp_path / "a.glb", TIMES)

    bones = seen["bones"]
    assert list(bones) == list(rig.names)
    assert set(seen["groups"]) == set(rig.names)
    assert len(seen["actions"]) == 1
    assert seen["actions"][0].startswith("walk")
    for joint, (bone, place) in enumerate(zip(rig.names, rig.joints, strict=True)):
        found = bones[bone]
        above = int(rig.parents[joint])
        assert found["parent"] == ("" if above < 0 else rig.names[above])
        np.testing.assert_allclose(np.array(found["head"]) * 1000.0, place, atol=1e-3)
        axes = np.array(found["axes"])
        np.testing.assert_allclose(axes, rig.axes[joint], atol=1e-5)
        np.testing.assert_allclose(axes[:, 2], [0, -1, 0], atol=1e-5)  # Blender's front
        way = np.subtract(found["tail"], found["head"])
        np.testing.assert_allclose(way / np.linalg.norm(way), axes[:, 1], atol=1e-4)
        assert np.linalg.norm(way) * 1000.0 > 1.0, "no stub"
    now, before = state, 0.0
    for seconds, frame in zip(TIMES, seen["frames"], strict=True):
        now, before = TOOL.step(now, None, seconds - before, Context()), seconds
        expected = solid_of(now).mesh.vertices
        found = np.array(frame) * 1000.0
        assert len(found) == len(expected)
        np.testing.assert_allclose(found.mean(axis=0), expected.mean(axis=0), atol=1e-2)
        # Blender's order of vertices may differ.
        assert cKDTree(found).query(expected)[0].max() < 0.02
