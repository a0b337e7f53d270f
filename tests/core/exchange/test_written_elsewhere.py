"""What other programs write besides shapes: it is kept as they mean it, or told."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image

from bozzetto.exchange.import_file import read_mesh_file
from tests.core.exchange import test_foreign_skins as gltf
from tests.core.exchange.test_usd_reader import SQUARE
from tests.core.exchange.test_usd_reader import read as read_usd

PLACES = np.array([[0.1, 0.2], [0.4, 0.2], [0.4, 0.3], [0.1, 0.3]])


def told(file, word):
    return [line for line in file.left_out if word in line]


# -- glTF --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("rows", "has_picture", "lost"),
    [((0,), False, True), ((0,), True, False), ((0, 1), True, True), ((), False, False)],
)
def test_texture_coordinates_that_no_picture_uses_are_told(tmp_path, rows, has_picture, lost):
    maker, _ = gltf.character()
    document = maker.document
    primitive = document["meshes"][0]["primitives"][0]
    count = len(gltf.tube().vertices)
    for row in rows:
        places = maker.put(np.full((count, 2), 0.5), "<f4", "VEC2")
        primitive["attributes"][f"TEXCOORD_{row}"] = places
    document["materials"] = [{"name": "skin"}]
    primitive["material"] = 0
    if has_picture:
        Image.new("RGB", (4, 4), (9, 9, 9)).save(tmp_path / "p.png")
        document["images"], document["textures"] = [{"uri": "p.png"}], [{"source": 0}]
        document["materials"][0]["pbrMetallicRoughness"] = {"baseColorTexture": {"index": 0}}
    file = gltf.read(maker, tmp_path)
    assert bool(told(file, "texture coordinates")) == lost


def test_lights_and_notes_are_told_and_what_we_note_ourselves_is_not(tmp_path):
    maker, _ = gltf.character()
    assert gltf.read(maker, tmp_path).left_out == ()
    document = maker.document
    document["meshes"][0]["extras"] = {"targetNames": ["a"]}
    document["nodes"][0]["extras"] = {"cut": []}
    assert not told(gltf.read(maker, tmp_path), "noted")
    document["meshes"][0]["extras"] = {"maker": "somebody"}
    document["nodes"][0]["extensions"] = {"KHR_lights_punctual": {"light": 0}}
    file = gltf.read(maker, tmp_path)
    assert "a light" in told(file, "light")[0]
    assert "a part" in told(file, "noted")[0]


# -- OBJ and PLY -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("said", "finish"),
    [("d 0.3", "glass"), ("Tr 0.7", "glass"), ("d 1.0", "matt"), ("d 0.9", "matt"),
     ("d 0.5\nillum 9\nNs 250", "glass"), ("d 0.3\nPm 0.0\nPr 0.1", "glass"),
     ("d 1\nPm 1.0\nPr 0.2", "metal")],
)  # fmt: skip
def test_what_lets_light_through_in_obj_is_glass(tmp_path, said, finish):
    (tmp_path / "a.mtl").write_text(f"newmtl pane\nKd 0.1 0.4 0.9\n{said}\n")
    corners = "v 0 0 0\nv 9 0 0\nv 9 9 0\nv 0 9 0\n"
    (tmp_path / "a.obj").write_text(f"mtllib a.mtl\no box\n{corners}usemtl pane\nf 1 2 3 4\n")
    (part,) = read_mesh_file(tmp_path / "a.obj").shapes.meshes()
    found = part.groups[0].finish if part.groups else "matt"
    assert found == finish
    assert (part.groups[0].color if part.groups else part.color) == (26, 102, 230)


def test_texture_coordinates_without_a_picture_are_told_in_obj_and_ply(tmp_path):
    corners = "v 0 0 0\nv 9 0 0\nv 9 9 0\n"
    for extra, lost in (("vt 0 0\nvt 1 0\nvt 1 1\nf 1/1 2/2 3/3\n", True), ("f 1 2 3\n", False)):
        (tmp_path / "a.obj").write_text(corners + extra)
        assert bool(told(read_mesh_file(tmp_path / "a.obj"), "texture coordinates")) == lost
    for names in (("s", "t"), ("u", "v"), ()):
        columns = "".join(f"property float {name}\n" for name in ("x", "y", "z", *names))
        tail = " 0 0" if names else ""
        rows = "\n".join(row + tail for row in ("0 0 0", "9 0 0", "9 9 0"))
        (tmp_path / "a.ply").write_text(
            f"ply\nformat ascii 1.0\nelement vertex 3\n{columns}element face 1\n"
            f"property list uchar int vertex_indices\nend_header\n{rows}\n3 0 1 2\n"
        )
        file = read_mesh_file(tmp_path / "a.ply")
        assert bool(told(file, "texture coordinates")) == bool(names)


# -- USD ---------------------------------------------------------------------------------------


def places(name, rows):
    shown = ", ".join(f"({x}, {y})" for x, y in rows)
    return f'texCoord2f[] primvars:{name} = [{shown}] (interpolation = "faceVarying")\n'


def painted(mesh, links, more=""):
    """A square with a picture whose places come by some links."""
    return f"""
    def Material "look" {{
        token outputs:surface.connect = </look/surface.outputs:surface>
        def Shader "surface" {{
            uniform token info:id = "UsdPreviewSurface"
            color3f inputs:diffuseColor.connect = </look/picture.outputs:rgb>
        }}
        def Shader "picture" {{
            uniform token info:id = "UsdUVTexture"
            asset inputs:file = @p.png@
            float2 inputs:st.connect = </look/{links}.outputs:result>
        }}
        {more}
    }}
    def Mesh "m" (prepend apiSchemas = ["MaterialBindingAPI"]) {{{SQUARE}{mesh}
        rel material:binding = </look>
    }}"""


def reader(name):
    return f"""def Shader "reader" {{
        uniform token info:id = "UsdPrimvarReader_float2"
        string inputs:varname = "{name}"
    }}"""


def corners_of(tmp_path, *body):
    Image.new("RGB", (4, 4), (9, 9, 9)).save(tmp_path / "p.png")
    file = read_usd(tmp_path, painted(*body))
    (part,) = file.shapes.meshes()
    return file, part.texture.corners


@pytest.mark.parametrize("name", ["st", "Second", "map1"])
def test_a_picture_lies_by_the_places_that_its_material_names(tmp_path, name):
    _, expected = corners_of(tmp_path, places("st", PLACES), "reader", reader("st"))
    others = "".join(places(one, PLACES * 2) for one in ("st", "map1") if one != name)
    mesh = others + places(name, PLACES)
    file, found = corners_of(tmp_path, mesh, "reader", reader(name))
    np.testing.assert_allclose(found, expected, atol=1e-6)
    assert told(file, "texture coordinates")


def test_a_picture_that_is_moved_lies_where_it_was_moved_to(tmp_path):
    """Scaled, then turned against the clock, then shifted: UsdPreviewSurface, UsdTransform2d."""
    x, y = PLACES.T
    moved = np.stack([0.6 - y, 0.1 + 2 * x], axis=1)
    _, expected = corners_of(tmp_path, places("st", moved), "reader", reader("st"))
    between = """def Shader "moved" {
        uniform token info:id = "UsdTransform2d"
        float2 inputs:in.connect = </look/reader.outputs:result>
        float inputs:rotation = 90
        float2 inputs:scale = (2, 1)
        float2 inputs:translation = (0.6, 0.1)
    }"""
    file, found = corners_of(tmp_path, places("st", PLACES), "moved", reader("st") + between)
    np.testing.assert_allclose(found, expected, atol=1e-6)
    assert file.left_out == ()


def test_parts_are_called_as_blender_calls_their_objects(tmp_path):
    body = f"""
    def Xform "root" {{
        def Xform "Holder_001" {{
            custom string userProperties:blender:object_name = "Holder.001"
            def Xform "Left_hand" {{
                custom string userProperties:blender:object_name = "Left hand"
                def Mesh "Cube_004" {{{SQUARE}
                    custom string userProperties:blender:data_name = "Cube.004"
                }}
            }}
        }}
    }}"""
    file = read_usd(tmp_path, body)
    (part,) = file.shapes.meshes()
    assert (part.path, part.name) == (("Holder.001",), "Left hand")
    assert file.left_out == ()


def test_lights_and_notes_in_usd_are_told(tmp_path):
    body = f"""
    def Mesh "m" {{{SQUARE}
        custom string userProperties:maker = "somebody"
    }}
    def SphereLight "lamp" {{}}"""
    file = read_usd(tmp_path, body)
    assert told(file, "a light")
    assert told(file, "noted of a part")
