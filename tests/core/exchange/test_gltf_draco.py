"""Meshes of glTF files that Draco has compressed, compared with what was compressed."""

from __future__ import annotations

import json
import random
import sys

import numpy as np
import pytest

from bozzetto.errors import FormatError, UserError
from bozzetto.exchange.import_file import read_mesh_file
from bozzetto.exchange.mesh.gltf_draco import DRACO
from tests.core.exchange.test_mesh_formats import box, glb, volume


def draco():
    return pytest.importorskip("DracoPy", reason="the extra “draco” is not installed")


def compressed(content, number, vertices, corners, *, required=True):
    """Return a document whose one mesh is compressed; `number` is Draco's of the places."""
    document = {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": len(content)}],
        "bufferViews": [{"buffer": 0, "byteLength": len(content)}],
        "accessors": [
            {"componentType": 5126, "count": vertices, "type": "VEC3"},
            {"componentType": 5123, "count": corners, "type": "SCALAR"},
        ],
        "meshes": [{"name": "box", "primitives": [{
            "attributes": {"POSITION": 0}, "indices": 1,
            "extensions": {DRACO: {"bufferView": 0, "attributes": {"POSITION": number}}},
        }]}],
        "nodes": [{"mesh": 0}], "scenes": [{"nodes": [0]}], "extensionsUsed": [DRACO],
    }  # fmt: skip
    if required:
        document["extensionsRequired"] = [DRACO]
    return document


def packed_box():
    """Return the compressed bytes of a box in metres, Draco's number of its places, and sizes."""
    library = draco()
    mesh = box()
    content = library.encode(
        mesh.vertices.astype(np.float32) / 1000, mesh.faces.astype(np.uint32),
        quantization_bits=16,
    )  # fmt: skip
    back = library.decode(content)
    (places,) = [one for one in back.attributes if one["attribute_type"] == 0]
    return content, places["unique_id"], len(back.points), 3 * len(back.faces)


@pytest.mark.parametrize("trusted", [True, False])
def test_a_compressed_mesh_is_that_mesh(tmp_path, trusted):
    content, *sizes = packed_box()
    (tmp_path / "a.glb").write_bytes(glb(compressed(content, *sizes), content))
    (solid,) = read_mesh_file(tmp_path / "a.glb", trusted=trusted).shapes.solids
    assert solid.name == "box"
    assert volume(solid.mesh) == pytest.approx(volume(box()), rel=1e-3)
    np.testing.assert_allclose(
        np.sort(np.ptp(solid.mesh.vertices, axis=0)), np.sort(np.ptp(box().vertices, axis=0)),
        rtol=1e-3,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda d: d["accessors"][0].update(count=7), "not as the file says"),
        (lambda d: d["accessors"][0].update(type="VEC2"), "not as the file says"),
        (lambda d: d["accessors"][1].update(count=3), "not as the file says"),
        (lambda d: d["bufferViews"][0].update(byteLength=20), "damaged"),
        (lambda d: d["bufferViews"][0].update(byteLength=10**9), "cut short"),
        (lambda d: d["meshes"][0]["primitives"][0]["extensions"][DRACO].update(bufferView=4), "4"),
        (lambda d: d["meshes"][0]["primitives"][0]["extensions"][DRACO].update(bufferView="a"),
         "cannot be understood"),
        (lambda d: d["meshes"][0]["primitives"][0]["extensions"][DRACO].update(
            attributes={"POSITION": 77}), "has no POSITION"),
    ],
)  # fmt: skip
def test_what_does_not_fit_is_refused(tmp_path, change, said):
    content, *sizes = packed_box()
    document = compressed(content, *sizes)
    change(document)
    (tmp_path / "a.glb").write_bytes(glb(document, content))
    with pytest.raises(FormatError, match=said):
        read_mesh_file(tmp_path / "a.glb", trusted=True)


def test_damaged_meshes_end_in_a_sentence(tmp_path):
    """They are read in a process of their own: the library may do there what it will."""
    content, *sizes = packed_box()
    chance, said = random.Random(5), []
    for number in range(25):
        bad = bytearray(content)
        for _ in range(chance.randint(1, 6)):
            bad[chance.randrange(len(bad))] = chance.randrange(256)
        path = tmp_path / f"{number}.glb"
        path.write_bytes(glb(compressed(bytes(bad), *sizes), bytes(bad)))
        try:
            read_mesh_file(path)
        except UserError as error:
            said.append(error.message)
    assert said
    assert all(said)


def test_without_the_library_it_is_said_what_to_do(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "DracoPy", None)
    content = bytes(64)
    (tmp_path / "a.glb").write_bytes(glb(compressed(content, 0, 8, 36), content))
    with pytest.raises(UserError, match=r"bozzetto\[draco\]'.*without compression"):
        read_mesh_file(tmp_path / "a.glb", trusted=True)


def test_a_file_that_has_both_is_read_without_the_library(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "DracoPy", None)
    places = box().vertices.astype("<f4").tobytes()
    faces = box().faces.astype("<u2").tobytes()
    document = compressed(bytes(4), 0, len(box().vertices), box().faces.size, required=False)
    document["bufferViews"] += [
        {"buffer": 0, "byteLength": len(places)},
        {"buffer": 0, "byteOffset": len(places), "byteLength": len(faces)},
    ]
    document["accessors"][0]["bufferView"], document["accessors"][1]["bufferView"] = 1, 2
    document["buffers"][0]["byteLength"] = len(places + faces)
    (tmp_path / "a.glb").write_bytes(glb(json.loads(json.dumps(document)), places + faces))
    (solid,) = read_mesh_file(tmp_path / "a.glb", trusted=True).shapes.solids
    assert len(solid.mesh.faces) == len(box().faces)
