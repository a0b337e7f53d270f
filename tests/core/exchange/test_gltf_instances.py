"""Copies of one mesh in glTF (EXT_mesh_gpu_instancing)."""

from __future__ import annotations

import base64
import json

import numpy as np
import pytest

from bozzetto.errors import FormatError
from bozzetto.exchange.import_file import read_mesh_file

CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], "<f4")
FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], "<u4")
HALF = float(np.sqrt(0.5))


def file(tmp_path, rows, change=lambda scene: None, *, trusted=True):
    """A file that shows a tetrahedron at these places, 2 m to the right of the middle."""
    names = {"TRANSLATION": "VEC3", "ROTATION": "VEC4", "SCALE": "VEC3"}
    arrays = [CORNERS, FACES.ravel(), *(np.array(v, "<f4") for v in rows.values())]
    types = ["VEC3", "SCALAR", *(names[name] for name in rows)]
    views, accessors, blob = [], [], b""
    for array, kind in zip(arrays, types, strict=True):
        views.append({"buffer": 0, "byteOffset": len(blob), "byteLength": array.nbytes})
        component = 5125 if array.dtype.kind == "u" else 5126
        accessors.append({"bufferView": len(views) - 1, "componentType": component,
                          "count": len(array), "type": kind})  # fmt: skip
        blob += array.tobytes()
    uri = "data:application/octet-stream;base64," + base64.b64encode(blob).decode()
    copies = {"attributes": {name: k + 2 for k, name in enumerate(rows)}}
    scene = {
        "asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}],
        "extensionsUsed": ["EXT_mesh_gpu_instancing"],
        "extensionsRequired": ["EXT_mesh_gpu_instancing"],
        "nodes": [{"name": "bolt", "mesh": 0, "translation": [2, 0, 0],
                   "extensions": {"EXT_mesh_gpu_instancing": copies}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": accessors, "bufferViews": views,
        "buffers": [{"byteLength": len(blob), "uri": uri}],
    }  # fmt: skip
    change(scene)
    (tmp_path / "a.gltf").write_text(json.dumps(scene))
    return read_mesh_file(tmp_path / "a.gltf", trusted=trusted)


def test_every_copy_is_a_part_at_its_place(tmp_path):
    rows = {
        "TRANSLATION": [[0, 0, 0], [5, 0, 0], [0, 0, 7]],
        "ROTATION": [[0, 0, 0, 1], [0, 0, HALF, HALF], [0, 0, 0, 1]],
        "SCALE": [[1, 1, 1], [1, 1, 1], [3, 1, 1]],
    }
    solids = file(tmp_path, rows).shapes.solids
    assert [one.name for one in solids] == ["bolt 1", "bolt 2", "bolt 3"]
    assert all(one.path == ("bolt",) for one in solids)
    # x of the file is ours, its y our z, its z our -y; a quarter turn takes x to y.
    boxes = [np.concatenate([o.mesh.vertices.min(0), o.mesh.vertices.max(0)]) for o in solids]
    wanted = [[2, -1, 0, 3, 0, 1], [6, -1, 0, 7, 0, 1], [2, -8, 0, 5, -7, 1]]
    np.testing.assert_allclose(boxes, 1000.0 * np.array(wanted), atol=1e-2)


def test_colours_of_copies_are_told(tmp_path):
    """three.js writes them; no reader has to know them."""

    def tinted(scene):
        copies = scene["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]
        copies["attributes"]["_COLOR_0"] = 2

    rows = {"TRANSLATION": [[0, 0, 0], [5, 0, 0]]}
    read = file(tmp_path, rows, tinted)
    assert len(read.shapes.solids) == 2
    assert [one for one in read.left_out if "colours of a part's copies" in one]
    assert not file(tmp_path, rows).left_out


@pytest.mark.parametrize(
    ("material", "finish"),
    [
        ({"roughnessFactor": 0.1}, "gloss"),
        ({"roughnessFactor": 0.1, "transmission": 1.0}, "glass"),
        ({"roughnessFactor": 0.1, "transmission": 0.0}, "gloss"),
        ({"roughnessFactor": 0.1, "baseColorFactor": [1, 1, 1, 0.4]}, "glass"),
        ({"roughnessFactor": 0.1, "transmission": "much"}, "gloss"),
    ],
)
def test_what_lets_light_through_is_glass(tmp_path, material, finish):
    def looks(scene):
        own = dict(material)
        through = own.pop("transmission", None)
        scene["materials"] = [{"name": "m", "pbrMetallicRoughness": {"metallicFactor": 0, **own}}]
        if through is not None:
            named = {"KHR_materials_transmission": {"transmissionFactor": through}}
            scene["materials"][0]["extensions"] = named
        scene["meshes"][0]["primitives"][0]["material"] = 0

    (solid,) = file(tmp_path, {"TRANSLATION": [[0, 0, 0]]}, looks).shapes.solids
    assert [group.finish for group in solid.groups] == [finish]


@pytest.mark.parametrize(
    "rows",
    [
        {},
        {"TRANSLATION": [[0, 0, 0]] * 2, "SCALE": [[1, 1, 1]] * 3},
        {"TRANSLATION": [[np.nan, 0, 0]]},
        {"TRANSLATION": [[1e30, 0, 0]]},
    ],
)
def test_copies_that_make_no_sense_are_refused(tmp_path, rows):
    with pytest.raises(FormatError) as caught:
        file(tmp_path, rows)
    assert caught.value.message.endswith(".")


def test_a_record_that_is_none_is_refused(tmp_path):
    def change(scene):
        scene["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"] = {"attributes": [1]}

    with pytest.raises(FormatError, match="Copies of a mesh"):
        file(tmp_path, {"TRANSLATION": [[0, 0, 0]]}, change)


def test_more_copies_than_anybody_can_use_are_refused(tmp_path):
    with pytest.raises(FormatError, match="parts"):
        file(tmp_path, {"TRANSLATION": [[0, 0, 0]] * 20_001}, trusted=False)
