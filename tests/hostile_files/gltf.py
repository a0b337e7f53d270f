"""Hostile files: glTF."""

from __future__ import annotations

import base64
import json

from tests.hostile_files.families import family
from tests.hostile_files.glb import gltf


def beside(document: object) -> bytes:
    return json.dumps(document).encode()


@family("gltf a buffer in the text")
def _(size):
    blob = bytes(max(36, size // 48 * 36))
    document = gltf(
        len(blob) // 12, blob, meshes=[{"primitives": [{"attributes": {"POSITION": 0}}]}]
    )
    uri = "data:application/octet-stream;base64," + base64.b64encode(blob).decode()
    return beside(document | {"buffers": [{"byteLength": len(blob), "uri": uri}]})


@family("gltf buffers without end")
def _(size):
    one = {"byteLength": 36, "uri": "data:application/octet-stream;base64," + "AAAA" * 12}
    return beside(gltf(3, bytes(36)) | {"buffers": [one] * max(1, size // 110)})


@family("gltf buffers that lie beside")
def _(size):
    names = [{"byteLength": 36, "uri": f"{k}.bin"} for k in range(max(1, size // 40))]
    return beside(gltf(3, bytes(36)) | {"buffers": names})


@family("gltf a buffer that leads out of the folder")
def _(size):
    one = {"byteLength": 36, "uri": "../" * (size // 3) + "etc/passwd"}
    primitives = [{"attributes": {"POSITION": 0}}]
    return beside(gltf(3, bytes(36), meshes=[{"primitives": primitives}]) | {"buffers": [one]})


@family("gltf one node with all meshes' names")
def _(size):
    nodes = [{"mesh": 0, "name": "a" * size, "scale": [1e200] * 3}]
    primitives = [{"attributes": {"POSITION": 0}}]
    return beside(gltf(3, bytes(36), meshes=[{"primitives": primitives}], nodes=nodes))


@family("gltf a deep pile of lists")
def _(size):
    return b'{"asset":{"version":"2.0"},"extras":' + b"[" * (size // 2) + b"]" * (size // 2) + b"}"
