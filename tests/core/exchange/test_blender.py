"""Our files in the hands of Blender: places, axes, sizes, names, materials, and tight meshes."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from bozzetto.cli.main import main
from bozzetto.exchange.export import export
from bozzetto.exchange.handover import Handover
from bozzetto.exchange.mesh import glb
from bozzetto.exchange.quad_budget import within_quads
from bozzetto.geometry import FaceGroup, Mesh, Shapes, Solid
from bozzetto.geometry.mesh_places import closest_on_mesh
from tests.blender import asked
from tests.core.geometry.quads.test_remeshing import ball, mesh_of, shaken

pytestmark = pytest.mark.interop

PLUGINS = Path(__file__).parents[3] / "plugins"

READ = """
path = sys.argv[1]
ending = path.rpartition(".")[2]
if ending == "glb":
    bpy.ops.import_scene.gltf(filepath=path)
else:
    getattr(bpy.ops.wm, ending + "_import")(filepath=path)
found = []
for one in bpy.data.objects:
    if one.type != "MESH":
        continue
    mesh = one.data
    places = [one.matrix_world @ v.co for v in mesh.vertices]
    # Along creases there are several vertices at one place.
    at = {}
    number = [at.setdefault(tuple(place), len(at)) for place in places]
    uses = {}
    for face in mesh.polygons:
        for edge in face.edge_keys:
            key = tuple(sorted(number[k] for k in edge))
            uses[key] = uses.get(key, 0) + 1
    mesh.calc_loop_triangles()
    volume = sum(
        places[a].dot(places[b].cross(places[c])) / 6
        for a, b, c in (t.vertices for t in mesh.loop_triangles)
    )
    materials = []
    for material in mesh.materials:
        nodes = [n for n in material.node_tree.nodes if n.type == "BSDF_PRINCIPLED"]
        values = {k: nodes[0].inputs[k].default_value for k in ("Alpha", "Roughness", "Metallic")}
        color = list(nodes[0].inputs["Base Color"].default_value)[:3]
        materials.append({"name": material.name, "color": color, **values})
    found.append({
        "name": one.name,
        "low": [min(p[k] for p in places) for k in range(3)],
        "high": [max(p[k] for p in places) for k in range(3)],
        "loose": sum(count != 2 for count in uses.values()),
        "volume": volume,
        "materials": materials,
        "faces": len(mesh.polygons),
    })
answer = found
"""

BOX = Mesh(
    [[x, y, z] for x in (0, 10) for y in (0, 20) for z in (0, 40)],
    [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
     [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]],
)  # fmt: skip


@pytest.mark.parametrize(
    ("ending", "unit"), [("glb", 1e-3), ("obj", 1.0), ("stl", 1.0), ("ply", 1.0)]
)
def test_a_box_stands_as_it_was_drawn(tmp_path, ending, unit):
    path = tmp_path / f"box.{ending}"
    export(Shapes(solids=(Solid(BOX, "Box", (200, 50, 25)),)), path)
    (box,) = asked(READ, path)
    assert box["low"] == pytest.approx([0, 0, 0], abs=1e-6 * 40 * unit)  # single precision
    assert box["high"] == pytest.approx([10 * unit, 20 * unit, 40 * unit], rel=1e-6)
    assert box["volume"] == pytest.approx(8000 * unit**3, rel=1e-5)


@pytest.mark.parametrize("ending", ["glb", "obj"])
def test_what_a_part_is_made_of_is_told(tmp_path, ending):
    finishes = {"glass": (150, 200, 255), "rubber": (12, 12, 12), "metal": (230, 230, 230)}
    groups = tuple(FaceGroup(name, 4, color, name) for name, color in finishes.items())
    path = tmp_path / f"box.{ending}"
    export(Shapes(solids=(Solid(BOX, "Box", groups=groups),)), path)
    found = {m["name"]: m for one in asked(READ, path) for m in one["materials"]}
    assert len(found) == 3
    glass, rubber, metal = (next(m for k, m in found.items() if f in k.lower()) for f in finishes)
    assert glass["Alpha"] < 0.6 < rubber["Alpha"] == metal["Alpha"] == 1.0
    assert metal["Metallic"] > 0.9 > 0.1 > rubber["Metallic"]
    assert rubber["Roughness"] > glass["Roughness"]
    for name, one in zip(finishes, (glass, rubber, metal), strict=True):
        expected = np.array(finishes[name]) / 255.0
        if ending == "glb":  # Blender takes the colours of an MTL as they are
            expected = np.where(
                expected <= 0.04045, expected / 12.92, ((expected + 0.055) / 1.055) ** 2.4
            )
        assert one["color"] == pytest.approx(expected.tolist(), abs=0.01)


QUADS = """
path = sys.argv[1]
ending = path.rpartition(".")[2].replace("usda", "usd")
getattr(bpy.ops.wm, ending + "_import")(filepath=path)
(one,) = [o for o in bpy.data.objects if o.type == "MESH"]
sizes = {}
for face in one.data.polygons:
    sizes[len(face.vertices)] = sizes.get(len(face.vertices), 0) + 1
modifier = one.modifiers.new("Subdivision", "SUBSURF")
modifier.levels = 2
dense = one.evaluated_get(bpy.context.evaluated_depsgraph_get())
places = [one.matrix_world @ v.co for v in dense.data.vertices]
lengths = [
    (one.matrix_world @ one.data.vertices[a].co - one.matrix_world @ one.data.vertices[b].co).length
    for a, b in one.data.edge_keys
]
answer = {
    "sizes": [sizes.get(3, 0), sizes.get(4, 0), len(one.data.polygons)],
    "places": [list(p) for p in places],
    "side": sum(lengths) / len(lengths),
    "uvs": len(one.data.uv_layers),
}
"""


@pytest.mark.parametrize("ending", ["obj", "ply", "usda"])
def test_quads_stay_quads_and_their_subdivision_stays_on_the_surface(tmp_path, ending):
    """Blender's is that of Catmull and Clark, by OpenSubdiv.

    It sinks below a sphere of radius r by s² / 3r, s the side of a square, by its limit masks.
    """
    mesh = mesh_of(*shaken(*ball((10.0, 20.0, 30.0))))
    shapes = Shapes(solids=(Solid(mesh, "Egg"),))
    path = tmp_path / f"egg.{ending}"
    export(shapes, path, handover=Handover(quads=600, uvs=ending == "obj"))
    made = within_quads(shapes, 600, lambda *_: None)
    found = asked(QUADS, path)
    if ending != "obj":  # there seams cut some quads
        assert found["sizes"] == [made.triangles, made.quads, made.triangles + made.quads]
    else:
        assert found["sizes"][1] > 0.8 * made.quads
        assert found["uvs"] == 1
    places = np.array(found["places"])
    scale = np.ptp(mesh.vertices, axis=0).max() / np.ptp(places, axis=0).max()
    away = closest_on_mesh(mesh, scale * places).distances
    side, least = scale * found["side"], 10.0  # its smallest half axis
    assert away.max() < 0.25 * side
    assert np.median(away) < side**2 / (3.0 * least)


SAMPLES = [
    ("silhouette", "horse.json"),
    ("product", "computer-mouse.json"),
    ("polyhedron", "bracket.json"),
    ("car", "hatchback.json"),
]


@pytest.mark.parametrize(("modeler", "sample"), SAMPLES)
def test_a_sample_comes_whole(tmp_path, modeler, sample):
    path = tmp_path / "a.glb"
    source = PLUGINS / f"bozzetto_{modeler}" / "samples" / sample
    report = tmp_path / "r.json"
    assert main(["build", modeler, str(source), "-o", str(path), "--report", str(report)]) == 0
    said = json.loads(report.read_text())
    found = asked(READ, path)
    assert found
    assert len({one["name"] for one in found}) == len(found)
    low = np.min([one["low"] for one in found], axis=0)
    high = np.max([one["high"] for one in found], axis=0)
    assert (high > low).all()
    assert 0.01 < np.linalg.norm(high - low) < 20.0, "metres"
    if said.get("closed") or modeler == "silhouette":
        assert sum(one["volume"] for one in found) > 0.0
        assert sum(one["loose"] for one in found) == 0


FRAMES = """
bpy.ops.import_scene.gltf(filepath=sys.argv[1])
scene = bpy.context.scene
answer = []
for time in json.loads(sys.argv[2]):
    frame = time * scene.render.fps / scene.render.fps_base
    scene.frame_set(int(frame), subframe=frame - int(frame))
    places = {}
    for one in bpy.data.objects:
        if one.type == "MESH":
            places[one.name] = [list(one.matrix_world @ v.co) for v in one.data.vertices]
    answer.append(places)
"""


def test_a_mechanism_moves_as_it_was_filmed(tmp_path):
    """Two parts, one on the other; between keys within the height of the arc over its chord."""
    from scipy.spatial.transform import Rotation

    def frame(share: float) -> Shapes:
        arm = Rotation.from_rotvec((0, 0, 2.0 * share)).as_matrix()
        hand = Rotation.from_rotvec((0.5 * share, -1.5 * share, 0)).as_matrix()
        return Shapes(solids=(
            Solid(Mesh(BOX.vertices @ arm.T + (50 * share, 0, 0), BOX.faces), "Arm"),
            Solid(Mesh((BOX.vertices @ hand.T + (0, 0, 40)) @ arm.T, BOX.faces), "Hand"),
        ))  # fmt: skip

    shares = np.linspace(0.0, 1.0, 31)
    film = glb.write_motion([frame(share) for share in shares], shares.tolist())
    (tmp_path / "a.glb").write_bytes(film)
    times = (0.0, 0.5, 0.9, 0.517)
    arc = 0.07 * (2.5 / 30) ** 2 / 8  # metres: what is farthest from the axis, in a thirtieth
    for time, seen in zip(times, asked(FRAMES, tmp_path / "a.glb", json.dumps(times)), strict=True):
        assert set(seen) == {"Arm", "Hand"}
        for solid in frame(time).solids:
            places = np.array(seen[solid.name])
            away = np.linalg.norm(places[:, None] - solid.mesh.vertices / 1000.0, axis=2)
            most = arc if time == times[-1] else 2e-6
            assert away.min(axis=1).max() < most
            assert away.min(axis=0).max() < most
