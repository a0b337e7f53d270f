"""Named parts as objects of their own: the same triangles, looks and bones, one node each."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from bozzetto.exchange.export import export, prepare_file
from bozzetto.exchange.formats import writers
from bozzetto.exchange.handover import Handover
from bozzetto.exchange.import_file import read_mesh_file
from bozzetto.exchange.ready_shapes import Ready, Recording
from bozzetto.exchange.separate_parts import separate_parts
from bozzetto.geometry import FaceGroup, Placement, Shapes, Solid
from tests.core.exchange.skinned import skinned, tube
from tests.core.exchange.test_skins import opened

APART = Handover(separate_parts=True)
NAMES = ("Head", "Tail", "Ring")


def figure(**more):
    """A tube in three named groups, one of them in two rows."""
    solid = Solid(tube(), "Worm", (200, 100, 50))
    return grouped(solid, **more)


def grouped(solid, **more):
    count = len(solid.mesh.faces)
    counts = [count // 4, count // 4, count // 3]
    counts.append(count - sum(counts))
    looks = [("Head", (255, 0, 0)), ("Tail", None), ("Ring", (0, 0, 255)), ("Head", (0, 255, 0))]
    groups = tuple(FaceGroup(n, c, color) for (n, color), c in zip(looks, counts, strict=True))
    return Shapes(solids=(replace(solid, groups=groups, **more),))


def corners(shapes):
    """All triangles as places with what they look like, in an order of their own."""
    rows = []
    for part in shapes.meshes():
        groups = part.groups or (FaceGroup(part.name, len(part.mesh.faces), part.color),)
        color = np.repeat([group.color or part.color or (0, 0, 0) for group in groups],
                          [group.count for group in groups], axis=0)  # fmt: skip
        places = part.mesh.vertices[part.mesh.faces].reshape(-1, 9)
        rows.append(np.column_stack((places, color)))
    whole = np.concatenate(rows)
    return whole[np.lexsort(whole.T)]


def test_a_recording_that_separate_parts_cannot_hold_is_told():
    """It belongs to the whole: left out without a word it would be missed too late."""
    motion = [Placement(), Placement(offset=(5.0, 0.0, 0.0))]
    recording = Recording([motion], [0.0, 1.0])
    for handover, is_told in ((Handover(), False), (APART, True)):
        made = prepare_file(Ready(figure(), handover, recording=recording), "a.glb", None)
        assert any("recorded" in note for note in made.notes) == is_told
        assert ("animations" in opened(made.data)[0]) != is_told


def test_the_same_triangles_lie_in_named_parts_of_the_whole():
    shapes = figure()
    (apart,) = separate_parts([shapes])
    assert [(part.name, part.path) for part in apart.meshes()] == [(n, ("Worm",)) for n in NAMES]
    assert (corners(shapes) == corners(apart)).all()
    assert [part.mesh for part in separate_parts([apart])[0].meshes()] == [
        part.mesh for part in apart.meshes()
    ]


def test_what_is_one_piece_stays_what_it_is():
    one = Shapes(solids=(Solid(tube(), "Worm"),))
    assert separate_parts([one])[0].solids[0] is one.solids[0]


def test_normals_stay_as_they_are_where_parts_meet(tmp_path):
    shapes = figure()
    bare = Shapes(
        solids=tuple(replace(s, mesh=replace(s.mesh, normals=None)) for s in shapes.solids)
    )
    for case in (shapes, bare):
        export(case, tmp_path / "whole.glb")
        export(case, tmp_path / "apart.glb", handover=APART)
        whole, apart = (shaded_places(tmp_path / f"{name}.glb") for name in ("whole", "apart"))
        assert whole == apart


def shaded_places(path):
    """Every place of a file with every normal that a triangle has there."""
    gltf, values = opened(path.read_bytes())
    found = set()
    for mesh in gltf["meshes"]:
        for primitive in mesh["primitives"]:
            at = values(primitive["indices"])[:, 0].astype(int)
            rows = [values(primitive["attributes"][key])[at] for key in ("POSITION", "NORMAL")]
            found |= set(map(tuple, np.hstack(rows).round(5).tolist()))
    return found


def nodes_of(path):
    data = path.read_bytes()
    size = int.from_bytes(data[12:16], "little")
    scene = json.loads(data[20 : 20 + size])
    return scene, scene["nodes"]


def test_glb_has_a_node_for_each_part_in_that_of_the_object(tmp_path):
    export(figure(), tmp_path / "a.glb", handover=APART)
    scene, nodes = nodes_of(tmp_path / "a.glb")
    (root,) = scene["scenes"][0]["nodes"]
    assert nodes[root]["name"] == "Worm"
    assert "mesh" not in nodes[root]
    assert [nodes[child]["name"] for child in nodes[root]["children"]] == list(NAMES)
    export(figure(), tmp_path / "b.glb")
    assert len(nodes_of(tmp_path / "b.glb")[1]) == 1


def test_bones_and_pictures_stay(tmp_path):
    solid = skinned(pose=40, texture=True)
    shapes = grouped(solid)
    (apart,) = separate_parts([shapes])
    whole = solid.skin
    rows = {tuple(v): (tuple(j), tuple(w)) for v, j, w in
            zip(solid.mesh.vertices.tolist(), whole.joints.tolist(), whole.weights.tolist(),
                strict=True)}  # fmt: skip
    for part in apart.meshes():
        assert part.skin.rig is whole.rig
        assert part.texture.pixels is solid.texture.pixels
        for v, j, w in zip(part.mesh.vertices.tolist(), part.skin.joints.tolist(),
                           part.skin.weights.tolist(), strict=True):  # fmt: skip
            assert rows[tuple(v)] == (tuple(j), tuple(w))
    texels = np.concatenate([part.texture.corners for part in apart.meshes()])
    assert len(texels) == len(solid.mesh.faces)
    export(shapes, tmp_path / "a.glb", handover=APART)
    scene, _ = nodes_of(tmp_path / "a.glb")
    assert len(scene["skins"]) == 1
    assert len(scene["images"]) == 1
    read = read_mesh_file(tmp_path / "a.glb", trusted=True).shapes
    assert sorted(part.name for part in read.meshes()) == sorted(NAMES)


@pytest.mark.parametrize("uvs", [True, False])
def test_coarser_levels_have_the_same_parts(tmp_path, uvs):
    wanted = replace(APART, levels=True, uvs=uvs)
    export(figure(), tmp_path / "a.glb", handover=wanted)
    scene, nodes = nodes_of(tmp_path / "a.glb")
    fine = [node for node in nodes if "MSFT_lod" in node.get("extensions", {})]
    assert [node["name"] for node in fine] == list(NAMES)
    counts = [
        scene["accessors"][p["indices"]]["count"] for m in scene["meshes"] for p in m["primitives"]
    ]
    assert min(counts) > 0


def test_obj_and_usd_have_an_object_for_each_part(tmp_path):
    export(figure(), tmp_path / "a.obj", handover=APART)
    text = (tmp_path / "a.obj").read_text()
    assert [line[2:] for line in text.splitlines() if line.startswith("o ")] == list(NAMES)
    export(figure(), tmp_path / "a.usda", handover=APART)
    text = (tmp_path / "a.usda").read_text()
    assert text.count("def Mesh ") == 3


def test_formats_that_hold_objects_whole_say_so(tmp_path):
    for one in writers("mesh"):
        made = export(figure(), tmp_path / f"a{one.endings[0]}", handover=APART)
        told = any("hold objects whole" in note for note in made.notes)
        assert told == ("parts" not in one.keeps), one.id
        if told:
            plain = export(figure(), tmp_path / f"b{one.endings[0]}")
            assert one.id == "3mf" or plain.data == made.data
