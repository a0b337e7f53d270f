"""Textures in files: seen by other programs as we meant them."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bozzetto.exchange.export import encode_shapes, export
from bozzetto.exchange.import_file import read_mesh
from bozzetto.geometry import Mesh, Placement, Shapes, Solid, Texture
from tests.core.exchange.test_interop import VALIDATE

SIZE = 60.0

BOX = np.array([[x, y, z] for x in (0.0, SIZE) for y in (0.0, SIZE) for z in (0.0, SIZE)])
SIDES = np.array(
    [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
)
FACES = np.concatenate([SIDES[:, [0, 1, 2]], SIDES[:, [0, 2, 3]]])


def painted_box(color=None) -> Solid:
    """A box whose every side has a strip of the picture: its colour grows along the strip."""
    strip = (np.arange(12) % 6)[:, None]
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    corners = np.concatenate([np.tile(square[[0, 1, 2]], (6, 1, 1)),
                              np.tile(square[[0, 2, 3]], (6, 1, 1))])  # fmt: skip
    corners[..., 1] = (strip + 0.25 + 0.5 * corners[..., 1]) / 8.0
    corners[..., 0] = 0.1 + 0.8 * corners[..., 0]
    pixels = np.full((8 * 16, 64, 4), 255, np.uint8)
    pixels[..., 0] = np.linspace(0, 255, 64).astype(np.uint8)
    pixels[..., 1] = np.repeat(30 * np.arange(8), 16)[:, None]
    pixels[..., 2] = 90
    return Solid(Mesh(BOX, FACES), "box", color, Texture(pixels, corners))


def expected(solid: Solid, face: int, weights: np.ndarray) -> np.ndarray:
    """The colour that we put at a point of a face, from the nearest texel."""
    u, v = weights @ solid.texture.corners[face]
    rows, columns = solid.texture.pixels.shape[:2]
    return solid.texture.pixels[int(v * rows), int(u * columns), :3].astype(float)


def seen_by_trimesh(path: Path, points: np.ndarray) -> np.ndarray:
    trimesh = pytest.importorskip("trimesh")
    (mesh,) = trimesh.load_scene(path, process=False).geometry.values()
    in_file = np.column_stack([points[:, 0], points[:, 2], -points[:, 1]]) / 1000.0
    pairs = np.repeat(mesh.triangles[None], len(in_file), axis=0).reshape(-1, 3, 3)
    near = trimesh.triangles.closest_point(pairs, np.repeat(in_file, len(mesh.faces), axis=0))
    away = np.linalg.norm(near.reshape(len(in_file), -1, 3) - in_file[:, None], axis=2)
    face = away.argmin(axis=1)
    weights = trimesh.triangles.points_to_barycentric(mesh.triangles[face], in_file)
    place = np.einsum("ij,ijk->ik", weights, mesh.visual.uv[mesh.faces[face]])
    image = mesh.visual.material.baseColorTexture
    return trimesh.visual.color.uv_to_interpolated_color(place, image)[:, :3].astype(float)


def inner_points(solid: Solid, random: np.random.Generator, count: int = 60):
    """Points inside faces, and their colours."""
    face = random.integers(0, len(solid.mesh.faces), count)
    weights = random.dirichlet([4.0, 4.0, 4.0], count)
    corners = solid.mesh.vertices[solid.mesh.faces[face]].astype(float)
    points = np.einsum("ij,ijk->ik", weights, corners)
    return points, np.array([expected(solid, f, w) for f, w in zip(face, weights, strict=True)])


@pytest.mark.interop
@pytest.mark.parametrize("mirrored", [False, True])
def test_trimesh_sees_every_place_in_its_colour(tmp_path, mirrored):
    solid = painted_box()
    placement = Placement((-1, 0, 0, 0, 1, 0, 0, 0, 1) if mirrored else Placement().rotation, 2.0)
    points, colors = inner_points(solid, np.random.default_rng(1))
    path = tmp_path / "a.glb"
    export(Shapes(solids=(solid,)).placed(placement), path)
    np.testing.assert_allclose(seen_by_trimesh(path, placement.points(points)), colors, atol=9.0)


def test_corners_that_agree_share_a_vertex():
    data = encode_shapes(Shapes(solids=(painted_box(),)), "a.glb")
    length = int(np.frombuffer(data, "<u4", 1, 12)[0])
    gltf = json.loads(data[20 : 20 + length])
    (primitive,) = gltf["meshes"][0]["primitives"]
    counts = {gltf["accessors"][k]["count"] for k in primitive["attributes"].values()}
    assert counts == {24}
    assert "COLOR_0" not in primitive["attributes"]


def test_what_the_picture_does_not_cover_has_the_colour_of_the_object(tmp_path):
    pytest.importorskip("trimesh")
    solid = painted_box((10, 200, 30))
    pixels = solid.texture.pixels.copy()
    pixels[..., 3] = 0
    clear = replace(solid, texture=Texture(pixels, solid.texture.corners))
    export(Shapes(solids=(clear,)), tmp_path / "a.glb")
    points, _ = inner_points(solid, np.random.default_rng(2))
    seen = seen_by_trimesh(tmp_path / "a.glb", points)
    np.testing.assert_allclose(seen, np.tile([10, 200, 30], (len(seen), 1)), atol=1.0)


@pytest.mark.parametrize("ending", ["glb", "obj", "ply", "stl"])
def test_a_painted_solid_is_still_the_same_solid(tmp_path, ending):
    path = tmp_path / f"a.{ending}"
    export(Shapes(solids=(painted_box(),)), path)
    (solid,) = read_mesh(path).solids
    assert np.ptp(solid.mesh.vertices, axis=0) == pytest.approx([SIZE] * 3)


def test_colours_that_do_not_cover_let_the_objects_colour_through(tmp_path):
    colors = np.tile(np.uint8([200, 0, 0, 255]), (8, 1))
    cover = np.uint8([255, 255, 255, 255, 0, 0, 0, 0])
    box = Solid(Mesh(BOX, FACES, colors=colors, cover=cover), color=(0, 0, 100))
    for ending in ("glb", "ply", "obj"):
        path = tmp_path / f"a.{ending}"
        export(Shapes(solids=(box,)), path)
        (read,) = read_mesh(path).solids
        order = np.lexsort(read.mesh.vertices.T[::-1])
        got = read.mesh.colors[order][:, :3]
        np.testing.assert_array_equal(got[:4], np.tile([200, 0, 0], (4, 1)), ending)
        np.testing.assert_array_equal(got[4:], np.tile([0, 0, 100], (4, 1)), ending)


@pytest.mark.interop
def test_the_khronos_validator_finds_nothing_in_a_textured_file(tmp_path):
    folder = os.environ.get("BOZZETTO_GLTF_VALIDATOR")
    if not folder or not shutil.which("node"):
        pytest.skip("BOZZETTO_GLTF_VALIDATOR names no folder with the npm package, or no node")
    package = next(
        path
        for path in (Path(folder), Path(folder) / "node_modules/gltf-validator")
        if (path / "gltf_validator.dart.js").exists()
    )
    plain = Solid(Mesh(BOX + 100.0, FACES), "plain")
    export(Shapes(solids=(painted_box(), plain, painted_box())), tmp_path / "a.glb")
    done = subprocess.run(
        ["node", "-e", VALIDATE, str(package), str(tmp_path / "a.glb")],
        capture_output=True,
        text=True,
        check=True,
    )
    report = json.loads(done.stdout)
    assert report["issues"]["messages"] == []
    assert report["info"]["hasTextures"]


@pytest.mark.parametrize(
    ("pixels", "corners"),
    [
        (np.zeros((2, 2, 3), np.uint8), np.zeros((12, 3, 2))),
        (np.zeros((0, 2, 4), np.uint8), np.zeros((12, 3, 2))),
        (np.zeros((2, 2, 4), np.uint8), np.zeros((12, 2))),
        (np.zeros((2, 2, 4), np.uint8), np.full((12, 3, 2), np.nan)),
    ],
)
def test_what_is_no_texture_is_refused(pixels, corners):
    with pytest.raises(ValueError, match=r"texture|finite"):
        Texture(pixels, corners)


def test_a_texture_fits_its_mesh():
    with pytest.raises(ValueError, match="every face"):
        Solid(Mesh(BOX, FACES[:5]), texture=painted_box().texture)
