"""Skins in GLB files: read back number by number, and shown to independent readers."""

from __future__ import annotations

import json

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bozzetto.exchange.export import encode_shapes, export
from bozzetto.exchange.import_file import read_mesh
from bozzetto.geometry import Mesh, Shapes, Solid
from tests.core.exchange.skinned import skinned, tube

KINDS = {5121: "<u1", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
TO_FILE = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]]) / 1000.0


def opened(data):
    """The description, and a function that reads an accessor: from the format's own words."""
    size = int(np.frombuffer(data, "<u4", 1, 12)[0])
    gltf = json.loads(data[20 : 20 + size])
    blob = data[28 + size :]

    def values(number):
        accessor = gltf["accessors"][number]
        view = gltf["bufferViews"][accessor["bufferView"]]
        width = WIDTHS[accessor["type"]]
        kind = KINDS[accessor["componentType"]]
        flat = np.frombuffer(blob, kind, accessor["count"] * width, view["byteOffset"])
        return flat.reshape(-1, width)

    return gltf, values


def shown(data, mesh_node):
    """Where a viewer puts the vertices of a skinned node: glTF 2.0, section 3.7.3.3, in mm."""
    gltf, values = opened(data)
    nodes = gltf["nodes"]
    world = {}

    def walk(number, above):
        node = nodes[number]
        local = np.eye(4)
        local[:3, :3] = Rotation.from_quat(node.get("rotation", [0, 0, 0, 1])).as_matrix()
        local[:3, 3] = node.get("translation", [0, 0, 0])
        world[number] = above @ local
        for child in node.get("children", []):
            walk(child, world[number])

    for root in gltf["scenes"][gltf["scene"]]["nodes"]:
        walk(root, np.eye(4))
    node = nodes[mesh_node]
    skin = gltf["skins"][node["skin"]]
    binds = values(skin["inverseBindMatrices"]).reshape(-1, 4, 4).transpose(0, 2, 1)
    moves = np.array([world[j] @ b for j, b in zip(skin["joints"], binds, strict=True)])
    attributes = gltf["meshes"][node["mesh"]]["primitives"][0]["attributes"]
    places, joints = values(attributes["POSITION"]), values(attributes["JOINTS_0"])
    weights = values(attributes["WEIGHTS_0"])
    mixed = np.einsum("vk,vkij->vij", weights, moves[joints])
    seen = np.einsum("vij,vj->vi", mixed, np.column_stack((places, np.ones(len(places)))))
    return seen[:, :3] @ np.linalg.inv(TO_FILE).T


@pytest.mark.parametrize("joints", [3, 7, 300])
@pytest.mark.parametrize("pose", [None, 90.0])
@pytest.mark.parametrize("turned", [False, True])
def test_a_viewer_sees_the_mesh_as_it_was_posed(joints, pose, turned):
    solid = skinned(joints, pose, turned=turned)
    data = encode_shapes(Shapes(solids=(solid,)), "a.glb")
    np.testing.assert_allclose(shown(data, 0), solid.mesh.vertices, atol=1e-4)


def test_the_file_holds_the_mesh_at_rest_and_joints_that_were_only_moved():
    solid = skinned(7, 90.0)
    gltf, values = opened(encode_shapes(Shapes(solids=(solid,)), "a.glb"))
    attributes = gltf["meshes"][0]["primitives"][0]["attributes"]
    rest = solid.skin.rest.vertices @ TO_FILE.T
    np.testing.assert_allclose(values(attributes["POSITION"]), rest, atol=1e-7)
    binds = values(gltf["skins"][0]["inverseBindMatrices"]).reshape(-1, 4, 4)
    np.testing.assert_array_equal(binds[:, :3, :3], np.tile(np.eye(3), (7, 1, 1)))
    assert [gltf["nodes"][k]["name"] for k in gltf["skins"][0]["joints"]] == list(
        solid.skin.rig.names
    )


def test_joints_with_axes_stand_in_the_file_as_they_are():
    rig = skinned(7, turned=True).skin.rig
    gltf, values = opened(encode_shapes(Shapes(solids=(skinned(7, turned=True),)), "a.glb"))
    binds = values(gltf["skins"][0]["inverseBindMatrices"]).reshape(-1, 4, 4).transpose(0, 2, 1)
    at_rest = np.linalg.inv(binds)
    to_file = TO_FILE * 1000.0
    np.testing.assert_allclose(at_rest[:, :3, :3], to_file @ rig.axes, atol=1e-6)
    np.testing.assert_allclose(at_rest[:, :3, 3], rig.joints @ TO_FILE.T, atol=1e-7)


def test_a_cut_loop_is_told_on_both_of_its_joints():
    gltf, _ = opened(encode_shapes(Shapes(solids=(skinned(5),)), "a.glb"))
    told = {node["name"]: node["extras"] for node in gltf["nodes"] if "extras" in node}
    assert told == {"worm 0": {"cut": ["worm 4"]}, "worm 4": {"cut": ["worm 0"]}}


def test_skins_stand_beside_each_other_and_beside_plain_solids():
    ball = Solid(Mesh(tube().vertices + np.array([0, 0, 40]), tube().faces), "plain")
    shapes = Shapes(solids=(skinned(4, name="a"), ball, skinned(6, 45.0, "b", roots=(0, 3))))
    data = encode_shapes(shapes, "a.glb")
    gltf, _ = opened(data)
    assert [("skin" in node) for node in gltf["nodes"][:3]] == [True, False, True]
    for number in (0, 2):
        np.testing.assert_allclose(
            shown(data, number), shapes.solids[number].mesh.vertices, atol=1e-4
        )


def test_a_textured_skin_is_torn_with_its_picture():
    solid = skinned(7, 60.0, texture=True)
    data = encode_shapes(Shapes(solids=(solid,)), "a.glb")
    gltf, values = opened(data)
    faces = values(gltf["meshes"][0]["primitives"][0]["indices"]).reshape(-1, 3)
    np.testing.assert_allclose(
        shown(data, 0)[faces], solid.mesh.vertices[solid.mesh.faces], atol=1e-4
    )


def test_other_formats_hold_the_mesh_as_it_was_posed(tmp_path):
    solid = skinned(7, 90.0)
    for ending in ("stl", "obj", "ply"):
        export(Shapes(solids=(solid,)), tmp_path / f"a.{ending}")
        back = next(read_mesh(tmp_path / f"a.{ending}").meshes()).mesh
        np.testing.assert_allclose(back.bounds, solid.mesh.bounds, atol=1e-4)


def test_we_open_our_own_skinned_files(tmp_path):
    export(Shapes(solids=(skinned(7),)), tmp_path / "a.glb")
    (part,) = read_mesh(tmp_path / "a.glb").meshes()
    np.testing.assert_allclose(part.mesh.vertices, tube().vertices, atol=1e-4)
