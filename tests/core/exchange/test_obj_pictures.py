"""Pictures of OBJ files: our own come back, and those of others."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image

from bozzetto.errors import FormatError
from bozzetto.exchange.export import export
from bozzetto.exchange.import_file import read_mesh_file
from bozzetto.geometry import Shapes
from tests.core.exchange.test_texture import expected, painted_box
from tests.core.exchange.test_threemf_pictures import checker, middles, png

TETRA = "v 0 0 0\nv 9 0 0\nv 0 9 0\nv 0 0 9\n"


def foreign(tmp_path, text, materials, **pictures):
    (tmp_path / "a.obj").write_text(f"mtllib a.mtl\n{text}")
    (tmp_path / "a.mtl").write_text(materials)
    for name, data in pictures.items():
        (tmp_path / f"{name}.png").write_bytes(data)
    return read_mesh_file(tmp_path / "a.obj", trusted=True)


def test_a_painted_part_comes_back_as_it_left(tmp_path):
    solid = painted_box()
    export(Shapes(solids=(solid,)), tmp_path / "a.obj")
    (read,) = read_mesh_file(tmp_path / "a.obj").shapes.solids
    np.testing.assert_array_equal(read.texture.pixels, solid.texture.pixels)
    np.testing.assert_allclose(read.texture.corners, solid.texture.corners, atol=1e-6)


def test_materials_share_a_part_and_quads_and_v_upwards_are_understood(tmp_path):
    text = (
        "v 0 0 0\nv 9 0 0\nv 9 9 0\nv 0 9 0\nvt 0.1 0.9\nvt 0.2 0.9\nvt 0.2 0.6\nvt 0.1 0.6\n"
        "usemtl a\nf 1/-4/1 2/-3/1 3/-2/1 4/-1/1\nusemtl b\nf 4 3 1\n"
    )
    materials = "newmtl a\nmap_Kd -s 1 1 1 -clamp on a b.png\nnewmtl b\nKd 0 1 0\n"
    (part,) = foreign(tmp_path, text, materials, **{"a b": checker()}).shapes.surfaces
    third = np.full(3, 1 / 3)
    colors = [expected(part, face, third).tolist() for face in range(3)]
    assert colors == [[255, 0, 0], [255, 0, 0], [0, 255, 0]]


def test_one_solid_shows_two_pictures_and_one_colour(tmp_path):
    places = "vt 0.1 0.9\nvt 0.2 0.9\nvt 0.1 0.6\n"
    faces = (
        "usemtl a\nf 1/1 3/2 2/3\nusemtl b\nf 1/1 2/1 4/1\nusemtl c\nf 1/1 4/1 3/1\n"
        "usemtl a\nf 2 3 4\n"
    )
    materials = "newmtl a\nKd .5 .5 .5\nmap_Kd a.png\nnewmtl b\nmap_Kd b.png\nnewmtl c\nKd 0 0 1\n"
    file = foreign(
        tmp_path, TETRA + places + faces, materials, a=checker(), b=png(np.full((3, 7, 3), 9))
    )
    (solid,) = file.shapes.solids
    assert middles(solid) == [[255, 0, 0], [9, 9, 9], [0, 0, 255], [128, 128, 128]]
    assert not file.left_out


@pytest.mark.parametrize("picture", ["../a.png", "b.png", "/etc/passwd", "a.obj"])
def test_a_picture_that_is_not_beside_or_none_is_told(tmp_path, picture):
    (tmp_path.parent / "a.png").write_bytes(checker())
    text = f"{TETRA}vt 0 0\nusemtl a\nf 1/1 3/1 2/1\n"
    file = foreign(tmp_path, text, f"newmtl a\nmap_Kd {picture}\n")
    assert file.shapes.surfaces[0].texture is None
    assert any("picture" in words for words in file.left_out)


@pytest.mark.parametrize("places", ["vt a b", "vt nan 0", "vt 1e9 0"])
def test_places_that_are_none_are_refused(tmp_path, places):
    text = f"{TETRA}{places}\nusemtl a\nf 1/1 3/1 2/1\n"
    with pytest.raises(FormatError, match="place in a picture"):
        foreign(tmp_path, text, "newmtl a\nmap_Kd a.png\n", a=checker())


def test_a_place_that_the_file_does_not_hold_is_no_picture(tmp_path):
    text = f"{TETRA}vt 0 1\nusemtl a\nf 1/9 3/9 2/9\nf 1/-7 2/1 4/1\nf 1/1 4/1 3/1\n"
    (part,) = foreign(
        tmp_path, text, "newmtl a\nKd 0 1 0\nmap_Kd a.png\n", a=checker()
    ).shapes.surfaces
    third = np.full(3, 1 / 3)
    colors = [expected(part, face, third).tolist() for face in range(3)]
    assert colors == [[0, 255, 0], [0, 255, 0], [255, 0, 0]]


def test_a_part_without_colours_does_not_take_them_from_others(tmp_path):
    text = (
        "o red\nv 0 0 0 1 0 0\nv 9 0 0 1 0 0\nv 0 9 0 1 0 0\nf 1 2 3\n"
        "o bare\nv 0 0 5\nv 9 0 5\nv 0 9 5\nf 4 5 6\n"
    )
    red, bare = foreign(tmp_path, text, "").shapes.surfaces
    assert red.mesh.colors.tolist() == [[255, 0, 0, 255]] * 3
    assert bare.mesh.colors is None


def test_trimesh_and_we_mean_the_same(tmp_path):
    trimesh = pytest.importorskip("trimesh")
    ball = trimesh.creation.icosphere(subdivisions=1, radius=30.0)
    random = np.random.default_rng(912_000)
    image = Image.fromarray(random.integers(0, 255, (16, 16, 3), np.uint8))
    uv = random.uniform(0.1, 0.9, (len(ball.vertices), 2))
    material = trimesh.visual.material.SimpleMaterial(image=image, diffuse=[255] * 4)
    visual = trimesh.visual.TextureVisuals(uv=uv, material=material)
    for ending in ("obj", "glb"):
        mesh = trimesh.Trimesh(ball.vertices, ball.faces, visual=visual, process=False)
        folder = tmp_path / ending
        folder.mkdir()
        mesh.export(folder / f"a.{ending}")
        (read,) = read_mesh_file(folder / f"a.{ending}").shapes.solids
        np.testing.assert_array_equal(read.texture.pixels[..., :3], np.asarray(image))
        mine = np.sort(read.texture.corners.astype(float), axis=1)
        wanted = uv[ball.faces] * (1.0, -1.0) + (0.0, 1.0)
        assert np.sort(mine.sum(axis=(1, 2))) == pytest.approx(
            np.sort(wanted.sum(axis=(1, 2))), abs=1e-4
        )


def test_words_of_materials_may_stand_behind_tabs(tmp_path):
    text = TETRA + "vt 0 0\nvt 1 0\nvt 0 1\nusemtl a b\nf 1/1 3/2 2/3\n"
    materials = "newmtl\ta b\t\t\n\tKd\t0 0 1\nmap_Kd\t\ta.png \n"
    (part,) = foreign(tmp_path, text, materials, a=checker()).shapes.surfaces
    assert part.texture is not None
