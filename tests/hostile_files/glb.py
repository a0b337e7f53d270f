"""Hostile files: GLB."""

from __future__ import annotations

import json
import struct

from tests.hostile_files.families import family, filled


def glb(document: object, blob: bytes = b"") -> bytes:
    text = document if isinstance(document, bytes) else json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    body = struct.pack("<II", len(text), 0x4E4F534A) + text
    body += struct.pack("<II", len(blob), 0x4E4942) + blob
    return b"glTF" + struct.pack("<II", 2, 12 + len(body)) + body


def gltf(count: int, blob: bytes, **more: object) -> dict[str, object]:
    return {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": len(blob)}],
        "bufferViews": [{"buffer": 0, "byteLength": len(blob)}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": count, "type": "VEC3"}],
        **more,
    }


@family("glb primitives times corners")
def _(size):
    count = max(3, size // 24)
    blob = bytes(12 * count)
    primitives = [{"attributes": {"POSITION": 0}}] * max(1, size // 80)
    return glb(gltf(count, blob, meshes=[{"primitives": primitives}]), blob)


@family("glb nodes times primitives")
def _(size):
    blob = bytes(36)
    primitives = [{"attributes": {"POSITION": 0}}] * max(1, size // 80)
    nodes = [{"mesh": 0}] * max(1, size // 30)
    return glb(gltf(3, blob, meshes=[{"primitives": primitives}], nodes=nodes), blob)


@family("glb nodes without end")
def _(size):
    return glb(gltf(3, bytes(36), nodes=[{}] * max(1, size // 4)), bytes(36))


@family("glb a chain of nodes")
def _(size):
    count = max(2, size // 22)
    nodes = [{"children": [k + 1]} for k in range(count - 1)] + [{}]
    return glb(gltf(3, bytes(36), nodes=nodes, scenes=[{"nodes": [0]}]), bytes(36))


@family("glb nodes in a ring")
def _(size):
    nodes = [{"children": [1]}, {"children": [0]}]
    return glb(gltf(3, bytes(36), nodes=nodes, scenes=[{"nodes": [0]}]), bytes(36) + bytes(size))


@family("glb junk in the description")
def _(size):
    return glb(b'{"asset":{"version":"2.0"},"extras":[' + filled(b"[],", size) + b"0]}")


@family("glb nested deeply")
def _(size):
    return glb(b'{"extras":' + b"[" * (size // 2) + b"]" * (size // 2) + b"}")


@family("glb strides of nothing")
def _(size):
    blob = bytes(size)
    document = gltf(size, blob, meshes=[{"primitives": [{"attributes": {"POSITION": 0}}]}])
    document["bufferViews"] = [{"buffer": 0, "byteLength": size, "byteStride": 1}]
    return glb(document, blob)


@family("glb offsets below zero")
def _(size):
    blob = bytes(size)
    document = gltf(3, blob, meshes=[{"primitives": [{"attributes": {"POSITION": 0}}]}])
    document["bufferViews"] = [{"buffer": 0, "byteLength": size, "byteOffset": -(2**62)}]
    return glb(document, blob)


@family("glb counts beyond all bounds")
def _(size):
    blob = bytes(size)
    document = gltf(2**62, blob, meshes=[{"primitives": [{"attributes": {"POSITION": 0}}]}])
    return glb(document, blob)


@family("glb sparse accessors")
def _(size):
    blob = bytes(size)
    document = gltf(3, blob, meshes=[{"primitives": [{"attributes": {"POSITION": 0}}]}])
    document["accessors"][0]["sparse"] = {"count": 2**40}  # type: ignore[index]
    return glb(document, blob)


@family("glb one accessor for everything")
def _(size):
    blob = bytes(max(36, size // 12 * 12))
    named = {"POSITION": 0, "NORMAL": 0, "COLOR_0": 0}
    document = gltf(len(blob) // 12, blob, meshes=[{"primitives": [{"attributes": named}]}])
    return glb(document, blob)


@family("glb matrices that overflow")
def _(size):
    nodes = [{"matrix": [1e300] * 16, "mesh": 0}]
    document = gltf(3, bytes(36), nodes=nodes)
    document["meshes"] = [{"primitives": [{"attributes": {"POSITION": 0}}]}]
    return glb(document, bytes(36) + bytes(size))
