"""Faces of PLY files, as other programs write them: colours, strips, pictures."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image

from bozzetto.errors import FormatError
from bozzetto.exchange.import_file import read_mesh_file

HEAD = """ply
format ascii 1.0
element vertex 5
property float x
property float y
property float z
element face {count}
property list uchar int vertex_indices
property uchar red
property uchar green
property uchar blue
end_header
0 0 0
90 0 0
90 90 0
0 90 0
45 45 60
"""


def read(tmp_path, rows):
    (tmp_path / "a.ply").write_text(HEAD.format(count=len(rows)) + "\n".join(rows) + "\n")
    return read_mesh_file(tmp_path / "a.ply", trusted=True)


def colors_at(part):
    """The colours of faces by the places of their middles."""
    rows = np.repeat([g.color for g in part.groups], [g.count for g in part.groups], axis=0)
    middles = part.mesh.vertices[part.mesh.faces].mean(axis=1)
    return {
        tuple(m.round().tolist()): tuple(c) for m, c in zip(middles, rows.tolist(), strict=True)
    }


def test_faces_of_one_colour_are_a_group_and_the_solid_stays_whole(tmp_path):
    rows = ["4 3 2 1 0 9 9 9", "3 0 1 4 255 0 0", "3 1 2 4 0 0 255", "3 2 3 4 255 0 0",
            "3 3 0 4 255 0 0"]  # fmt: skip
    (solid,) = read(tmp_path, rows).shapes.solids
    assert [(g.name, g.count) for g in solid.groups] == [
        ("#090909", 2), ("#ff0000", 3), ("#0000ff", 1),
    ]  # fmt: skip
    found = colors_at(solid)
    assert found[75.0, 45.0, 20.0] == (0, 0, 255)
    assert found[45.0, 15.0, 20.0] == (255, 0, 0)


def test_one_colour_is_that_of_the_part(tmp_path):
    (part,) = read(tmp_path, ["3 0 1 4 7 8 9", "3 1 2 4 7 8 9"]).shapes.surfaces
    assert part.color == (7, 8, 9)
    assert part.groups == ()


def test_very_many_are_told(tmp_path):
    rows = [f"3 0 1 4 {k % 250} {k // 250} 0" for k in range(1_100)]
    file = read(tmp_path, rows)
    assert any("colours of its faces" in words for words in file.left_out)


def test_trimesh_and_we_mean_the_same(tmp_path):
    trimesh = pytest.importorskip("trimesh")
    box = trimesh.creation.box((30.0, 20.0, 10.0))
    wanted = np.random.default_rng(913_000).integers(0, 255, (12, 4), np.uint8)
    box.visual.face_colors = wanted
    box.export(tmp_path / "a.ply")
    (solid,) = read_mesh_file(tmp_path / "a.ply", trusted=True).shapes.solids
    found = colors_at(solid)
    for middle, color in zip(box.triangles_center, wanted.tolist(), strict=True):
        assert found[tuple(middle.round().tolist())] == tuple(color[:3])


# -- as scanners' programs write them ----------------------------------------------------------

POINTS = [(x, y, 0.0) for x in (0, 1, 2) for y in (0, 1)] + [(0.0, 0.0, 1.0), (1.0, 0.0, 1.0)]


def strips_file(strips, points=POINTS):
    """A binary file as of the Stanford models."""
    head = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\n"
        "property float x\nproperty float y\nproperty float z\n"
        f"element tristrips {len(strips)}\nproperty list int int vertex_indices\nend_header\n"
    )
    rows = [np.array([len(strip), *strip], "<i4").tobytes() for strip in strips]
    return head.encode() + np.array(points, "<f4").tobytes() + b"".join(rows)


@pytest.mark.parametrize(
    "strips", [[[0, 1, 2, 3, 4, 5, -1, 0, 2, 6, 7, -1]], [[0, 1, 2, 3, 4, 5], [-1, 0, 2, 6, 7]]]
)
def test_strips_are_triangles_that_all_turn_one_way(tmp_path, strips):
    (tmp_path / "a.ply").write_bytes(strips_file(strips))
    (part,) = read_mesh_file(tmp_path / "a.ply", trusted=True).shapes.surfaces
    a, b, c = (part.mesh.vertices[part.mesh.faces[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    flat, upright = normals[:4], normals[4:]
    assert len(normals) == 6
    assert (flat == [0, 0, flat[0, 2]]).all()
    assert (upright == [0, upright[0, 1], 0]).all()
    assert np.abs(normals).max(axis=1).tolist() == [1.0] * 6


def test_rows_longer_than_the_header_says_lose_no_face(tmp_path):
    """As old MeshLab wrote colours of the corners of faces."""
    content = HEAD.format(count=3) + "".join(
        f"3 {row} 9 1 1 1 1 1 1 1 1 1\n" for row in ("0 1 4", "1 2 4", "2 3 4")
    )
    (tmp_path / "a.ply").write_text(content)
    read = read_mesh_file(tmp_path / "a.ply", trusted=True)
    assert len(read.shapes.surfaces[0].mesh.faces) == 3
    assert any("not in its header" in said for said in read.left_out)
    (tmp_path / "a.ply").write_text(content.replace("3 2 3 4", "3 2"))
    with pytest.raises(FormatError):
        read_mesh_file(tmp_path / "a.ply", trusted=True)


@pytest.mark.parametrize("how", ["vertices", "corners"])
def test_pictures_lie_where_the_file_says(tmp_path, how):
    Image.new("RGB", (4, 4), "red").save(tmp_path / "two words.png")
    square = [(0, 0), (1, 0), (1, 1), (0, 1)]
    vertex = "property float s\nproperty float t\n" if how == "vertices" else ""
    face = "property list uchar float texcoord\n" if how == "corners" else ""
    rows = [f"{9 * x} {9 * y} 0" + (f" {x} {y}" if vertex else "") for x, y in square]
    corners = " 8 " + " ".join(f"{x} {y}" for x, y in square) if face else ""
    (tmp_path / "a.ply").write_text(
        "ply\nformat ascii 1.0\ncomment TextureFile two words.png\n"
        f"element vertex 5\nproperty float x\nproperty float y\nproperty float z\n{vertex}"
        f"element face 1\nproperty list uchar int vertex_indices\n{face}end_header\n"
        + "\n".join([*rows, "500 500 500" + (" 0 0" if vertex else ""), f"4 0 1 2 3{corners}"])
    )
    read = read_mesh_file(tmp_path / "a.ply", trusted=True)
    (part,) = read.shapes.surfaces
    assert (part.name, part.texture.pixels.shape, read.left_out) == ("a", (4, 4, 4), ())
    places = part.mesh.vertices[part.mesh.faces][..., :2] / 9.0
    assert part.texture.corners == pytest.approx(places * [1, -1] + [0, 1])
    assert part.mesh.bounds[1].tolist() == [9, 9, 0]  # the stray point counts for nothing


def test_points_alone_are_refused_with_what_to_do(tmp_path):
    (tmp_path / "a.ply").write_bytes(strips_file([]))
    with pytest.raises(FormatError, match=r"only points.*MeshLab"):
        read_mesh_file(tmp_path / "a.ply", trusted=True)
