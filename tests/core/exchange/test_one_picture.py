"""One picture for all painted parts of a file: it looks as it did, in our eyes and in others'."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.exchange.export import prepare_export
from bozzetto.exchange.handover import Handover
from bozzetto.exchange.import_file import read_mesh_file
from bozzetto.exchange.mesh import one_picture
from bozzetto.exchange.mesh.one_picture import in_one_picture
from bozzetto.geometry import FaceGroup, Shapes, Solid, Texture
from tests import blender, threejs
from tests.core.exchange.test_handover import ball
from tests.core.exchange.test_skins import opened
from tests.core.exchange.test_texture import expected, painted_box

UVS = Handover(uvs=True)


def beside(part, x, name):
    mesh = replace(part.mesh, vertices=part.mesh.vertices + np.float32([x, 0, 0]))
    return replace(part, mesh=mesh, name=name)


def clear_box(color):
    """A box whose picture lets its colour through in every second column."""
    part = painted_box(color)
    pixels = part.texture.pixels[:96, :40].copy()
    pixels[:, ::8, 3] = 0
    return replace(part, texture=Texture(pixels, part.texture.corners))


def several() -> Shapes:
    """Three painted parts, of which two share a picture but not what shows through; one is bare."""
    one, clear = painted_box(), clear_box((200, 30, 60))
    return Shapes(solids=(
        beside(one, 0.0, "one"), beside(clear, 80.0, "red"),
        beside(replace(clear, color=(10, 200, 90)), 160.0, "green"),
        beside(Solid(ball()), 260.0, "bare"),
    ))  # fmt: skip


def seen(part: Solid, face: int, weights: np.ndarray) -> np.ndarray:
    """The colour at a point of a face, over that of the part."""
    u, v = weights @ part.texture.corners[face]
    rows, columns = part.texture.pixels.shape[:2]
    *color, alpha = part.texture.pixels[int(v * rows), int(u * columns)].tolist()
    return np.array(color if alpha else part.color or (255, 255, 255), float)


def test_every_place_has_the_colour_that_it_had():
    before = several()
    (after,) = in_one_picture([before])
    painted = [part for part in after.solids if part.texture is not None]
    assert len({id(part.texture.pixels) for part in painted}) == 1
    random = np.random.default_rng(911_000)
    for old, new in zip(before.solids[:3], painted, strict=True):
        for face in range(12):
            for weights in random.dirichlet([3.0, 3.0, 3.0], 20):
                np.testing.assert_array_equal(
                    expected(new, face, weights), seen(old, face, weights)
                )
    assert after.solids[3] == before.solids[3]


def test_pictures_lie_apart_and_their_borders_go_on():
    (after,) = in_one_picture([several()])
    pixels = after.solids[0].texture.pixels
    size = np.array(pixels.shape[1::-1])
    boxes = [
        np.concatenate([c.min(axis=(0, 1)), c.max(axis=(0, 1))]) * np.tile(size, 2)
        for c in (part.texture.corners for part in after.solids[:3])
    ]
    for k, (left, top, right, bottom) in enumerate(boxes):
        for other in boxes[:k]:
            gap = max(left - other[2], other[0] - right, top - other[3], other[1] - bottom)
            assert gap >= 2 * one_picture.PADDING


def test_coarser_levels_share_it():
    first = several()
    levels = in_one_picture([first, Shapes(solids=first.solids[:2])])
    found = {id(part.texture.pixels) for s in levels for part in s.solids if part.texture}
    assert len(found) == 1


@pytest.mark.parametrize("change", ["large", "repeated", "alone"])
def test_what_does_not_fit_stays_as_it_is(monkeypatch, change):
    shapes = several()
    if change == "large":
        monkeypatch.setattr(one_picture, "MOST", 100)
    if change == "repeated":
        parts = [
            replace(part, texture=Texture(part.texture.pixels, part.texture.corners * 3.0))
            for part in shapes.solids[:3]
        ]
        shapes = Shapes(solids=tuple(parts))
    if change == "alone":
        shapes = Shapes(solids=(shapes.solids[0], shapes.solids[3]))
    (after,) = in_one_picture([shapes])
    assert after.solids == shapes.solids
    notes = prepare_export(shapes, "a.glb", handover=UVS).notes
    assert any("stay apart" in note for note in notes) == (change != "alone")


def test_a_glb_holds_one_picture_and_one_material_for_all(tmp_path):
    made = prepare_export(several(), "a.glb", handover=UVS)
    gltf, _ = opened(made.data)
    assert len(gltf["images"]) == 1
    used = {p["material"] for mesh in gltf["meshes"][:3] for p in mesh["primitives"]}
    assert len(used) == 1
    made.write(tmp_path / "a.glb")
    read = {p.name: p for p in read_mesh_file(tmp_path / "a.glb").shapes.meshes()}
    assert {"one", "red", "green", "bare"} == set(read)
    assert not made.notes


def test_groups_keep_their_names():
    part = painted_box()
    groups = (FaceGroup("lid", 4, None, "gloss"), FaceGroup("base", 8))
    shapes = Shapes(solids=(replace(part, groups=groups), *several().solids[1:]))
    (after,) = in_one_picture([shapes])
    assert after.solids[0].groups == groups


def test_an_obj_names_one_picture_and_one_material(tmp_path):
    made = prepare_export(several(), "a.obj", handover=UVS)
    made.write(tmp_path / "a.obj")
    text = (tmp_path / "a.mtl").read_text()
    assert text.count("map_Kd a-1.png") == text.count("map_Kd") == 1
    assert [path.name for path in tmp_path.glob("*.png")] == ["a-1.png"]
    lines = (tmp_path / "a.obj").read_text().splitlines()
    assert len({line for line in lines if line.startswith("usemtl")}) == 2  # and the bare one's


@pytest.mark.interop
def test_threejs_shows_it_as_it_showed_all_pictures():
    shapes = several()
    apart, together = (
        threejs.asked(prepare_export(shapes, "a.glb", handover=h).data, painted=True)
        for h in (Handover(), UVS)
    )
    painted = [one for one in together["meshes"] if one["map"]]
    assert len(painted) == 3
    assert len({one["material"] for one in painted}) == len({one["map"] for one in painted}) == 1
    assert len({one["map"] for one in apart["meshes"] if one["map"]}) == 3
    away = np.abs(apart["picture"].astype(int) - together["picture"]).max(axis=2)
    assert (apart["picture"].min(axis=2) < 250).mean() > 0.03
    assert (away > 12).mean() < 0.002


BAKE = """
bpy.ops.import_scene.gltf(filepath=sys.argv[1])
found = {}
for one in bpy.data.objects:
    if one.type != "MESH" or not one.data.materials:
        continue
    nodes = one.data.materials[0].node_tree.nodes
    images = [n.image for n in nodes if n.type == "TEX_IMAGE"]
    if not images:
        continue
    image, uv = images[0], one.data.uv_layers[0].data
    wide, high = image.size
    pixels = list(image.pixels)
    row = []
    for face in one.data.polygons:
        u = sum(uv[k].uv[0] for k in face.loop_indices) / 3
        v = sum(uv[k].uv[1] for k in face.loop_indices) / 3
        at = 4 * (min(int(v * high), high - 1) * wide + min(int(u * wide), wide - 1))
        row.append([round(255 * c) for c in pixels[at:at + 3]])
    found[one.name] = {"row": row, "image": image.name, "material": one.data.materials[0].name}
answer = found
"""


@pytest.mark.interop
def test_blender_finds_the_colour_of_every_face_in_one_picture(tmp_path):
    shapes = several()
    prepare_export(shapes, "a.glb", handover=UVS).write(tmp_path / "a.glb")
    found = blender.asked(BAKE, tmp_path / "a.glb")
    assert set(found) == {"one", "red", "green"}
    assert len({(one["image"], one["material"]) for one in found.values()}) == 1
    third = np.full(3, 1 / 3)
    for part in shapes.solids[:3]:
        wanted = [seen(part, face, third).tolist() for face in range(12)]
        np.testing.assert_allclose(found[part.name]["row"], wanted, atol=1.5)


def test_a_usd_names_one_picture_and_one_material(tmp_path):
    made = prepare_export(several(), "a.usda", handover=UVS)
    made.write(tmp_path / "a.usda")
    assert len(list(tmp_path.glob("*.png"))) == 1
    text = (tmp_path / "a.usda").read_text()
    assert text.count("asset inputs:file") == 1
    assert text.count('def Material "') == 2  # and the bare one's
