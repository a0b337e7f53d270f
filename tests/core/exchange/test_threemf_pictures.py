"""Pictures in 3MF: ours as others see them, others' as we do, and what is none."""

from __future__ import annotations

import io
import shutil
import subprocess
import zipfile
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from bozzetto.errors import FormatError
from bozzetto.exchange.export import export
from bozzetto.exchange.import_file import read_mesh_file
from bozzetto.geometry import Placement, Shapes
from tests.core.exchange.test_texture import expected, inner_points, painted_box
from tests.core.exchange.test_threemf_reader import model

TETRA = np.array([[0.0, 0, 0], [9, 0, 0], [0, 9, 0], [0, 0, 9]])
FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
VERTICES = "".join(f'<vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in TETRA)


def png(rows):
    data = io.BytesIO()
    Image.fromarray(np.asarray(rows, np.uint8)).save(data, "PNG")
    return data.getvalue()


def checker():
    """Red, green, blue and white, from the top left."""
    return png([[[255, 0, 0], [0, 255, 0]], [[0, 0, 255], [255, 255, 255]]])


def foreign(tmp_path, looks, triangles, **pictures):
    """A tetrahedron of another program, read; what was told, too."""
    rows = "".join(
        f'<triangle v1="{a}" v2="{b}" v3="{c}" {words}/>'
        for (a, b, c), words in zip(FACES, triangles, strict=True)
    )
    mesh = f"<mesh><vertices>{VERTICES}</vertices><triangles>{rows}</triangles></mesh>"
    text = model(f'{looks}<object id="9">{mesh}</object>', '<item objectid="9"/>')
    with zipfile.ZipFile(tmp_path / "a.3mf", "w") as file:
        file.writestr("3D/3dmodel.model", text)
        for name, data in pictures.items():
            file.writestr(f"3D/Textures/{name}.png", data)
    return read_mesh_file(tmp_path / "a.3mf", trusted=True)


def picture(number, name, group, places):
    listed = "".join(f'<m:tex2coord u="{u}" v="{v}"/>' for u, v in places)
    return (
        f'<m:texture2d id="{number}" path="/3D/Textures/{name}.png" contenttype="image/png"/>'
        f'<m:texture2dgroup id="{group}" texid="{number}">{listed}</m:texture2dgroup>'
    )


def middles(solid):
    """The colour in the middle of each face of the tetrahedron, in the order of `FACES`."""
    there = solid.mesh.vertices[solid.mesh.faces].mean(axis=1)
    wanted = TETRA[FACES].mean(axis=1)
    nearest = np.linalg.norm(there[None] - wanted[:, None], axis=2).argmin(axis=1)
    return [expected(solid, face, np.full(3, 1 / 3)).tolist() for face in nearest]


@pytest.mark.parametrize("mirrored", [False, True])
def test_a_painted_part_comes_back_as_it_left(tmp_path, mirrored):
    solid = painted_box()
    placement = Placement((-1, 0, 0, 0, 1, 0, 0, 0, 1) if mirrored else Placement().rotation)
    export(Shapes(solids=(solid,)).placed(placement), tmp_path / "a.3mf")
    (read,) = read_mesh_file(tmp_path / "a.3mf").shapes.solids
    np.testing.assert_array_equal(read.texture.pixels, solid.texture.pixels)
    points, colors = inner_points(solid, np.random.default_rng(4))
    corners = read.mesh.vertices[read.mesh.faces].astype(float)
    for point, color in zip(placement.points(points), colors, strict=True):
        seen = []
        for number, (a, b, c) in enumerate(corners):
            weights, *_ = np.linalg.lstsq(
                np.vstack([np.stack([a, b, c], 1), np.ones(3) * 60]), [*point, 60.0]
            )
            near = np.linalg.norm(weights @ np.stack([a, b, c]) - point) < 1e-3
            if near and weights.min() > 0.0:
                seen.append(expected(read, number, weights))
        np.testing.assert_allclose(seen, color[None], atol=9.0)


def test_equal_pictures_are_in_the_file_once(tmp_path):
    solid = painted_box()
    other = replace(solid, color=(9, 9, 9), name="other")
    export(Shapes(solids=(solid, solid, other)), tmp_path / "a.3mf")
    names = zipfile.ZipFile(tmp_path / "a.3mf").namelist()
    assert [name for name in names if name.endswith(".png")] == [
        "3D/Textures/1.png",
        "3D/Textures/2.png",
    ]


def test_v_points_up_and_places_beyond_the_border_repeat_it(tmp_path):
    quarters = [(0.1, 0.9), (0.2, 0.9), (0.1, 0.6), (1.6, -0.1), (1.9, -0.1), (1.6, -0.4)]
    looks = picture(1, "a", 2, [*quarters, (0.2, 0.2), (0.3, 0.2), (0.2, 0.3)])
    words = [f'pid="2" p1="{k}" p2="{k + 1}" p3="{k + 2}"' for k in (0, 3, 6, 0)]
    file = foreign(tmp_path, looks, words, a=checker())
    (solid,) = file.shapes.solids
    assert middles(solid) == [
        [255, 0, 0], [0, 255, 0], [0, 0, 255], [255, 0, 0],
    ]  # fmt: skip
    assert not file.left_out


def test_two_pictures_and_a_colour_leave_a_solid_whole(tmp_path):
    looks = picture(1, "a", 2, [(0.1, 0.9), (0.2, 0.9), (0.1, 0.6)])
    looks += picture(3, "b", 4, [(0.5, 0.5)])
    looks += '<m:colorgroup id="5"><m:color color="#102030FF"/></m:colorgroup>'
    words = ['pid="2" p1="0" p2="1" p3="2"', 'pid="4" p1="0" p2="0" p3="0"', 'pid="5" p1="0"', ""]
    wide = png(np.full((3, 7, 3), (7, 8, 9)))
    (solid,) = foreign(tmp_path, looks, words, a=checker(), b=wide).shapes.solids
    assert middles(solid) == [
        [255, 0, 0], [7, 8, 9], [16, 32, 48], [200, 200, 200],
    ]  # fmt: skip


@pytest.mark.parametrize(("pictures", "said"), [({}, "not in the file"), ({"a": b"no"}, "picture")])
def test_a_picture_that_cannot_be_read_is_told_and_the_shape_stays(tmp_path, pictures, said):
    looks = picture(1, "a", 2, [(0, 0)])
    file = foreign(tmp_path, looks, ['pid="2" p1="0" p2="0" p3="0"'] * 4, **pictures)
    (solid,) = file.shapes.solids
    assert solid.texture is None
    assert any(said in words for words in file.left_out)


def test_a_picture_that_repeats_within_a_triangle_is_told(tmp_path):
    looks = picture(1, "a", 2, [(0, 0), (3, 0), (0, 3)])
    file = foreign(tmp_path, looks, ['pid="2" p1="0" p2="1" p3="2"'] * 4, a=checker())
    assert any("repeat within a triangle" in words for words in file.left_out)


NO_GROUP = '<m:texture2dgroup id="2" texid="1"><m:tex2coord u="0" v="0"/></m:texture2dgroup>'


@pytest.mark.parametrize(
    "looks",
    [
        NO_GROUP,
        '<m:tex2coord u="0" v="0"/>',
        picture(1, "a", 2, [("nan", 0)]),
        picture(1, "a", 2, [(0, "1e300")]),
        picture(1, "a", 2, [(0, "up")]),
        picture(1, "a", 2, [(0, 0)] * 2),
        '<m:texture2d id="1"/>',
    ],
)
def test_what_makes_no_sense_is_refused_with_a_sentence(tmp_path, looks):
    with pytest.raises(FormatError) as caught:
        foreign(tmp_path, looks, ['pid="2" p1="0" p2="1" p3="2"'] * 4, a=checker())
    assert caught.value.message.endswith(".")


def test_many_copies_of_an_object_share_one_picture(tmp_path):
    looks = picture(1, "a", 2, [(0.5, 0.5)]) + picture(3, "b", 4, [(0.5, 0.5)])
    words = ['pid="2" p1="0" p2="0" p3="0"', 'pid="4" p1="0" p2="0" p3="0"'] * 2
    rows = "".join(
        f'<triangle v1="{a}" v2="{b}" v3="{c}" {said}/>'
        for (a, b, c), said in zip(FACES, words, strict=True)
    )
    mesh = f"<mesh><vertices>{VERTICES}</vertices><triangles>{rows}</triangles></mesh>"
    text = model(f'{looks}<object id="9">{mesh}</object>', '<item objectid="9"/>' * 500)
    large = png(np.zeros((2000, 2000, 3)))
    with zipfile.ZipFile(tmp_path / "a.3mf", "w") as file:
        file.writestr("3D/3dmodel.model", text)
        for name in "ab":
            file.writestr(f"3D/Textures/{name}.png", large)
    solids = read_mesh_file(tmp_path / "a.3mf", trusted=True).shapes.solids
    assert len(solids) == 500
    assert len({one.texture.pixels.ctypes.data for one in solids}) == 1


@pytest.mark.interop
def test_lib3mf_finds_every_place_in_the_picture(tmp_path):
    lib3mf = pytest.importorskip("lib3mf")
    solid = painted_box()
    export(Shapes(solids=(solid,)), tmp_path / "a.3mf")
    read = lib3mf.get_wrapper().CreateModel()
    reader = read.QueryReader("3mf")
    reader.SetStrictModeActive(True)
    reader.ReadFromFile(str(tmp_path / "a.3mf"))
    assert reader.GetWarningCount() == 0
    textures = read.GetTexture2Ds()
    assert textures.MoveNext()
    data = bytes(textures.GetCurrentTexture2D().GetAttachment().WriteToBuffer())
    pixels = np.asarray(Image.open(io.BytesIO(data)).convert("RGBA"))
    np.testing.assert_array_equal(pixels, solid.texture.pixels)
    objects = read.GetMeshObjects()
    objects.MoveNext()
    mesh = objects.GetCurrentMeshObject()
    for face, corners in enumerate(solid.texture.corners):
        properties = mesh.GetTriangleProperties(face)
        group = read.GetTexture2DGroupByID(properties.ResourceID)
        for corner, (u, v) in enumerate(corners):
            place = group.GetTex2Coord(properties.PropertyIDs[corner])
            assert (place.U, 1.0 - place.V) == pytest.approx((u, v), abs=1e-6)


@pytest.mark.interop
@pytest.mark.skipif(shutil.which("prusa-slicer") is None, reason="PrusaSlicer is not here")
def test_prusaslicer_opens_a_painted_part(tmp_path):
    export(Shapes(solids=(painted_box(),)), tmp_path / "a.3mf")
    done = subprocess.run(
        ["prusa-slicer", "--info", str(tmp_path / "a.3mf")],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert "manifold = yes" in done.stdout
    assert "volume = 216000.0" in done.stdout


@pytest.mark.interop
def test_trimesh_reads_the_shape_of_a_painted_part(tmp_path):
    trimesh = pytest.importorskip("trimesh")
    export(Shapes(solids=(painted_box(),)), tmp_path / "a.3mf")
    (mesh,) = trimesh.load_scene(tmp_path / "a.3mf").geometry.values()
    assert mesh.volume == pytest.approx(216_000.0)
