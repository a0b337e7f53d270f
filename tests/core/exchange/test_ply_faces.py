"""Colours of faces in PLY files, as other programs write them."""

from __future__ import annotations

import numpy as np
import pytest

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
