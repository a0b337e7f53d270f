"""Skinned GLB of other programs: what a viewer would show, whatever their conventions are.

The files are made here from bytes; where vertices belong is computed from the words of the format
(glTF 2.0, sections 3.7.3 and 3.11) by `shown`, which knows nothing of the reader.
"""

from __future__ import annotations

import base64
import io
import json

import numpy as np
import pytest
from scipy.spatial.transform import Rotation, Slerp

from bozzetto.exchange.export import encode_shapes
from bozzetto.exchange.import_file import read_mesh_file
from tests.core.exchange.skinned import tube
from tests.core.exchange.test_skins import TO_FILE

JOINTS = 4
KINDS = {"<f4": 5126, "<u1": 5121, "<u2": 5123, "<u4": 5125}
SCALES = {"metres": 1.0, "armature in centimetres": 0.01}


def packed(document, blob):
    """A GLB of a description and its buffer."""
    document["buffers"] = [{"byteLength": len(blob)}]
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    blob += b"\0" * (-len(blob) % 4)
    body = np.array([len(text), 0x4E4F534A], "<u4").tobytes() + text
    body += np.array([len(blob), 0x004E4942], "<u4").tobytes() + blob
    return b"glTF" + np.array([2, 12 + len(body)], "<u4").tobytes() + body


class Maker:
    """A description with accessors that grows."""

    def __init__(self):
        self.document = {"asset": {"version": "2.0"}, "accessors": [], "bufferViews": []}
        self.blob = b""

    def put(self, values, kind, width, **more):
        values = np.ascontiguousarray(values, kind)
        view = {"buffer": 0, "byteOffset": len(self.blob), "byteLength": values.nbytes}
        self.document["bufferViews"].append(view)
        self.blob += values.tobytes() + b"\0" * (-values.nbytes % 4)
        accessor = {"bufferView": len(self.document["bufferViews"]) - 1, "type": width}
        accessor |= {"componentType": KINDS[kind], "count": len(values), **more}
        self.document["accessors"].append(accessor)
        return len(self.document["accessors"]) - 1


def local(node):
    """The matrix of a node in its parent."""
    made = np.eye(4)
    made[:3, :3] = Rotation.from_quat(node.get("rotation", [0, 0, 0, 1])).as_matrix()
    made[:3, :3] *= node.get("scale", [1, 1, 1])
    made[:3, 3] = node.get("translation", [0, 0, 0])
    return made


def worlds(nodes, roots):
    found = {}

    def walk(number, above):
        found[number] = above @ local(nodes[number])
        for child in nodes[number].get("children", []):
            walk(child, found[number])

    for root in roots:
        walk(root, np.eye(4))
    return found


def character(scale=1.0, posed=0.0, moved=0.0, shuffled=False, bytes_=False, away=True, seed=0):
    """A tube along x on four bones, under a turned and scaled armature; and where it is seen."""
    chance = np.random.default_rng(seed)
    maker = Maker()
    mesh = tube()
    points = mesh.vertices / 1000.0 / scale  # in the armature's unit, its axes those of the file
    armature = {"name": "Armature", "scale": [scale] * 3, "children": [2]}
    if away:
        armature["rotation"] = Rotation.from_euler("xyz", [0.3, -0.8, 0.4]).as_quat().tolist()
        armature["translation"] = [0.2, -0.1, 0.5]
    nodes = [armature, {"name": "Body", "mesh": 0, "skin": 0}]
    at_rest, pose = [], []
    for joint in range(JOINTS):
        turn = Rotation.random(random_state=joint + 10 * seed)
        place = np.array([0.02 * joint, 0.0, 0.0]) / scale
        whole = np.eye(4)
        whole[:3, :3], whole[:3, 3] = turn.as_matrix(), place
        at_rest.append(whole)
    for joint in range(JOINTS):
        above = np.eye(4) if joint == 0 else at_rest[joint - 1]
        own = np.linalg.inv(above) @ at_rest[joint]
        bend = Rotation.from_rotvec(posed * chance.normal(0, 1, 3)) if posed else None
        turned = Rotation.from_matrix(own[:3, :3])
        turned = turned if bend is None else turned * bend
        shift = moved * chance.normal(0.0, 0.005, 3) / scale
        node = {"name": f"bone.{joint}", "rotation": turned.as_quat().tolist(),
                "translation": (own[:3, 3] + shift).tolist()}  # fmt: skip
        if joint + 1 < JOINTS:
            node["children"] = [3 + joint]
        nodes.append(node)
        pose.append(node)
    order = [2, 0, 3, 1] if shuffled else list(range(JOINTS))
    binds = np.array([np.linalg.inv(at_rest[k]).T for k in order])
    at = np.clip(mesh.vertices[:, 0] / 20.0, 0, JOINTS - 1 - 1e-6)
    low = at.astype(int)
    rank = np.argsort(order)
    joints = np.zeros((len(at), 4), int)
    joints[:, 0], joints[:, 1] = rank[low], rank[np.minimum(low + 1, JOINTS - 1)]
    weights = np.zeros((len(at), 4))
    weights[:, 0], weights[:, 1] = 1 - (at - low), at - low
    kind = {}
    if bytes_:
        weights = np.rint(weights * 255)
        weights[:, 0] = 255 - weights[:, 1]
        kind = {"normalized": True}
    reach = {"min": points.min(0).tolist(), "max": points.max(0).tolist()}
    attributes = {
        "POSITION": maker.put(points, "<f4", "VEC3", **reach),
        "JOINTS_0": maker.put(joints, "<u1", "VEC4"),
        "WEIGHTS_0": maker.put(weights, "<u1" if bytes_ else "<f4", "VEC4", **kind),
    }
    primitive = {
        "attributes": attributes,
        "indices": maker.put(mesh.faces.ravel(), "<u4", "SCALAR"),
    }
    maker.document |= {
        "scene": 0,
        "scenes": [{"nodes": [0, 1]}],
        "nodes": nodes,
        "meshes": [{"primitives": [primitive]}],
        "skins": [
            {"joints": [2 + k for k in order],
             "inverseBindMatrices": maker.put(binds.reshape(-1, 16), "<f4", "MAT4")}
        ],
    }  # fmt: skip
    if bytes_:
        weights = weights / 255.0

    def shown(nodes=nodes):
        whole = worlds(nodes, [0, 1])
        moves = np.array([whole[2 + k] @ np.linalg.inv(at_rest[k]) for k in order])
        mixed = np.einsum("vk,vkij->vij", weights, moves[joints])
        seen = np.einsum("vij,vj->vi", mixed, np.column_stack((points, np.ones(len(points)))))
        return seen[:, :3] @ np.linalg.inv(TO_FILE).T

    return maker, shown


def read(maker, tmp_path, trusted=True):
    (tmp_path / "a.glb").write_bytes(packed(dict(maker.document), maker.blob))
    return read_mesh_file(tmp_path / "a.glb", trusted=trusted)


def only(file):
    (part,) = file.shapes.meshes()
    return part


WAYS = {
    "at rest": {},
    "posed": {"posed": 0.5},
    "joints moved": {"posed": 0.3, "moved": 1.0},
    "joints in no order": {"posed": 0.4, "shuffled": True},
    "weights as bytes": {"posed": 0.4, "bytes_": True},
    "at the origin": {"posed": 0.5, "away": False},
}


@pytest.mark.parametrize("scale", SCALES)
@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("seed", range(3))
def test_it_is_seen_as_a_viewer_shows_it(tmp_path, scale, way, seed):
    maker, shown = character(SCALES[scale], seed=seed, **WAYS[way])
    file = read(maker, tmp_path)
    part = only(file)
    assert file.left_out == ()
    assert part.skin is not None
    np.testing.assert_allclose(part.mesh.vertices, shown(), atol=2e-4)
    assert set(part.skin.rig.names) == {f"bone.{k}" for k in range(JOINTS)}
    assert part.skin.rig.parents.tolist() == [-1, 0, 1, 2]
    assert (part.skin.rig.shifts is not None) == bool(WAYS[way].get("moved"))


@pytest.mark.parametrize("way", ["at rest", "joints moved"])
def test_it_is_handed_on_as_it_came(tmp_path, way):
    maker, shown = character(0.01, **WAYS[way])
    shapes = read(maker, tmp_path, trusted=False).shapes
    data = encode_shapes(shapes, "b.glb")
    (tmp_path / "b.glb").write_bytes(data)
    again = read_mesh_file(tmp_path / "b.glb", trusted=True)
    np.testing.assert_allclose(only(again).mesh.vertices, shown(), atol=2e-4)
    assert encode_shapes(again.shapes, "b.glb") == data


def moving(maker, interpolation, path, joint, keys):
    """Add a motion of one bone; values are its own."""
    times = np.linspace(0.0, 1.0, len(keys)).astype("<f4")
    rows = np.asarray(keys, float)
    if interpolation == "CUBICSPLINE":
        flat = np.zeros_like(rows)
        rows = np.stack((flat, rows, flat), axis=1).reshape(-1, rows.shape[1])
    document = maker.document
    document.setdefault("animations", []).append(
        {
            "name": f"{path} {interpolation}",
            "samplers": [
                {
                    "input": maker.put(times, "<f4", "SCALAR", min=[0.0], max=[1.0]),
                    "output": maker.put(rows, "<f4", f"VEC{rows.shape[1]}"),
                    "interpolation": interpolation,
                }
            ],
            "channels": [{"sampler": 0, "target": {"node": 2 + joint, "path": path}}],
        }
    )


def at(keys, path, interpolation, time):
    """The value of a motion at a time, from the words of the format (appendix C)."""
    times = np.linspace(0.0, 1.0, len(keys))
    k = min(int(np.searchsorted(times, time, side="right")) - 1, len(keys) - 2)
    share = (time - times[k]) / (times[k + 1] - times[k])
    if interpolation == "STEP":
        return keys[k] if share < 1 else keys[k + 1]
    if interpolation == "CUBICSPLINE":
        share = share * share * (3 - 2 * share)  # its tangents are zero
        if path == "rotation":
            mixed = (1 - share) * np.asarray(keys[k]) + share * np.asarray(keys[k + 1])
            return mixed / np.linalg.norm(mixed)
    if path == "rotation":
        return Slerp([0, 1], Rotation.from_quat(keys[k : k + 2]))(share).as_quat()
    return (1 - share) * np.asarray(keys[k]) + share * np.asarray(keys[k + 1])


@pytest.mark.parametrize("interpolation", ["LINEAR", "STEP", "CUBICSPLINE"])
@pytest.mark.parametrize("path", ["rotation", "translation"])
def test_motions_play_as_a_viewer_plays_them(tmp_path, interpolation, path):
    from dataclasses import replace

    maker, shown = character(0.01, posed=0.2)
    chance = np.random.default_rng(7)
    own = maker.document["nodes"][3][path]
    keys = (
        Rotation.from_rotvec(chance.normal(0, 0.5, (4, 3))).as_quat()
        if path == "rotation"
        else np.asarray(own) + chance.normal(0, 0.5, (4, 3))
    )
    moving(maker, interpolation, path, 1, keys)
    file = read(maker, tmp_path)
    assert file.left_out == ()
    part = only(file)
    (clip,) = part.skin.clips
    rest = part.skin.rest or part.mesh
    coarse = 0.35 if interpolation == "CUBICSPLINE" else 3e-4  # straight pieces of a curve, mm
    for time in clip.seconds[:: max(1, len(clip.seconds) // 9)].tolist():
        k = int(np.searchsorted(clip.seconds, time))
        shifts = None if clip.shifts is None else clip.shifts[k]
        posed = replace(part.skin, rig=replace(part.skin.rig, turns=clip.turns[k], shifts=shifts))
        nodes = json.loads(json.dumps(maker.document["nodes"]))
        nodes[3][path] = list(map(float, at(keys, path, interpolation, time)))
        np.testing.assert_allclose(posed.posed(rest).vertices, shown(nodes), atol=coarse)


def test_a_bone_that_a_vertex_names_twice_counts_once(tmp_path):
    maker, _ = character()
    attributes = maker.document["meshes"][0]["primitives"][0]["attributes"]
    count = len(tube().vertices)
    attributes["JOINTS_1"] = maker.put(np.tile([0, 1, 2, 3], (count, 1)), "<u1", "VEC4")
    attributes["WEIGHTS_1"] = maker.put(np.full((count, 4), 0.1), "<f4", "VEC4")
    file = read(maker, tmp_path)
    assert file.left_out == ()
    part = only(file)
    np.testing.assert_allclose(part.skin.weights.sum(axis=1), 1.0, atol=1e-5)
    ranked = np.sort(np.where(part.skin.weights > 0, part.skin.joints.astype(int), -1), axis=1)
    assert not ((ranked[:, 1:] == ranked[:, :-1]) & (ranked[:, 1:] >= 0)).any()


@pytest.mark.parametrize(
    "broken",
    [
        lambda d: d["skins"][0].update(joints=[2, 3]),
        lambda d: d["skins"][0].update(joints=[2, 3, 4, 99]),
        lambda d: d["skins"][0].update(joints=[2, 2, 3, 4]),
        lambda d: d["skins"][0].update(inverseBindMatrices=0),
        lambda d: d["skins"][0].update(inverseBindMatrices=77),
        lambda d: d["nodes"][1].update(skin=5),
        lambda d: d["meshes"][0]["primitives"][0]["attributes"].pop("WEIGHTS_0"),
        lambda d: d["nodes"][2].update(scale=[0, 0, 0]),
        lambda d: d["nodes"][0].update(scale=[-1, 1, 1]),
    ],
)
def test_bones_that_make_no_sense_are_told_and_the_mesh_is_kept(tmp_path, broken):
    maker, _ = character()
    broken(maker.document)
    file = read(maker, tmp_path)
    assert "the bones of a part" in " ".join(file.left_out)
    assert only(file).skin is None
    assert len(only(file).mesh.faces) == len(tube().faces)


@pytest.mark.parametrize("wrong", ["times", "count", "sampler", "node", "zero"])
def test_a_motion_that_makes_no_sense_is_told_and_the_bones_are_kept(tmp_path, wrong):
    maker, _ = character()
    moving(maker, "LINEAR", "rotation", 1, Rotation.random(4, random_state=1).as_quat())
    animation = maker.document["animations"][0]
    if wrong == "times":
        animation["samplers"][0]["input"] = maker.put([0.0, 2.0, 1.0, 3.0], "<f4", "SCALAR")
    elif wrong == "count":
        animation["samplers"][0]["input"] = maker.put([0.0, 1.0], "<f4", "SCALAR")
    elif wrong == "sampler":
        animation["channels"][0]["sampler"] = 9
    elif wrong == "node":
        animation["channels"][0]["target"]["node"] = 77
    else:
        animation["samplers"][0]["output"] = maker.put(np.zeros((4, 4)), "<f4", "VEC4")
    file = read(maker, tmp_path)
    assert "motion" in " ".join(file.left_out)
    assert only(file).skin is not None
    assert only(file).skin.clips == ()


def test_a_picture_of_another_program_comes_along_and_a_repeated_one_is_laid_once(tmp_path):
    from PIL import Image

    maker, _ = character()
    stream = io.BytesIO()
    chance = np.random.default_rng(3)
    Image.fromarray(chance.integers(0, 256, (8, 8, 3), np.uint8)).save(stream, "PNG")
    view = {"buffer": 0, "byteOffset": len(maker.blob), "byteLength": len(stream.getvalue())}
    maker.document["bufferViews"].append(view)
    maker.blob += stream.getvalue() + b"\0" * (-len(stream.getvalue()) % 4)
    document = maker.document
    document["images"] = [{"bufferView": len(document["bufferViews"]) - 1, "mimeType": "image/png"}]
    document["textures"] = [{"source": 0}]
    half = {"baseColorTexture": {"index": 0}, "baseColorFactor": [1.0, 0.5, 0.0, 1.0]}
    document["materials"] = [{"name": "skin", "pbrMetallicRoughness": half}]
    places = np.tile([[2.25, -0.75]], (len(tube().vertices), 1))
    primitive = document["meshes"][0]["primitives"][0]
    primitive["material"] = 0
    primitive["attributes"]["TEXCOORD_0"] = maker.put(places, "<f4", "VEC2")
    part = only(read(maker, tmp_path, trusted=False))
    np.testing.assert_allclose(part.texture.corners, np.tile([0.25, 0.25], (1280, 3, 1))[: len(
        part.mesh.faces)], atol=1e-6)  # fmt: skip
    original = np.asarray(Image.open(io.BytesIO(stream.getvalue())).convert("RGB"))
    assert (part.texture.pixels[..., 2] == 0).all()
    np.testing.assert_array_equal(part.texture.pixels[..., 0], original[..., 0])
    assert (part.texture.pixels[..., 1] <= original[..., 1]).all()


@pytest.mark.parametrize(
    ("moved", "where"),
    [
        # The tip of the arrow in Khronos's TextureTransformTest lies at (88, 88) of 128 pixels,
        # and has to be seen where the surface has these places.
        ({"offset": [0.5, 0.0]}, (0.1875, 0.6875)),
        ({"rotation": np.pi / 8}, (0.372, 0.898)),
        ({"scale": [1.5, 1.5]}, (0.4583, 0.4583)),
        ({"texCoord": 1, "scale": [2.0, 1.0]}, (0.34375, 0.6875)),
    ],
)
def test_pictures_lie_as_their_transform_says(tmp_path, moved, where):
    from PIL import Image

    maker, _ = character()
    stream = io.BytesIO()
    Image.fromarray(np.zeros((8, 8, 3), np.uint8)).save(stream, "PNG")
    uri = "data:image/png;base64," + base64.b64encode(stream.getvalue()).decode()
    document = maker.document
    document["images"], document["textures"] = [{"uri": uri}], [{"source": 0}]
    link = {"index": 0, "extensions": {"KHR_texture_transform": moved}}
    document["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": link}}]
    primitive = document["meshes"][0]["primitives"][0]
    primitive["material"] = 0
    count = len(tube().vertices)
    rows = {"TEXCOORD_0": np.zeros((count, 2)), "TEXCOORD_1": np.zeros((count, 2))}
    rows[f"TEXCOORD_{moved.get('texCoord', 0)}"][:] = where
    for name, places in rows.items():
        primitive["attributes"][name] = maker.put(places, "<f4", "VEC2")
    part = only(read(maker, tmp_path))
    np.testing.assert_allclose(part.texture.corners, 0.6875, atol=1e-3)


@pytest.mark.parametrize("moved", [{"offset": 3}, {"scale": [1e300, 1e300]}, {"rotation": "a"}])
def test_a_transform_that_is_none_costs_the_picture_only(tmp_path, moved):
    maker, _ = character()
    document = maker.document
    document["images"], document["textures"] = [{"uri": "data:;base64,"}], [{"source": 0}]
    link = {"index": 0, "extensions": {"KHR_texture_transform": moved}}
    document["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": link}}]
    primitive = document["meshes"][0]["primitives"][0]
    primitive["material"] = 0
    places = np.full((len(tube().vertices), 2), 0.5)
    primitive["attributes"]["TEXCOORD_0"] = maker.put(places, "<f4", "VEC2")
    file = read(maker, tmp_path)
    assert only(file).texture is None
    assert "the picture of a material" in " ".join(file.left_out)
