"""glTF description: the parts that we understand, and the placements of its nodes."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Final

import msgspec
import numpy as np
from numpy.typing import NDArray

from bozzetto.errors import FormatError
from bozzetto.exchange.limits import MAX_COORDINATE, MAX_DEPTH, at_most
from bozzetto.geometry.shapes import Finish

TRIANGLES: Final = 4
FLOAT: Final = 5126
MAGIC: Final = b"glTF"
JSON_CHUNK: Final = 0x4E4F534A
BIN_CHUNK: Final = 0x004E4942

LOOKS: Final[dict[Finish, tuple[float, float, float]]] = {
    "matt": (0.0, 0.8, 1.0),
    "gloss": (0.0, 0.15, 1.0),
    "rubber": (0.0, 0.95, 1.0),
    "metal": (1.0, 0.3, 1.0),
    "glass": (0.0, 0.05, 0.45),
}
"""How metallic, rough and opaque a material is, by its finish."""

AXES: Final = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
"""Rows: glTF's x, y (up) and z from our x, y and z (up)."""

MM_PER_METRE: Final = 1000.0


MAX_NODES: Final = 100_000
"""Places in the tree: three seconds of work."""


class Record(msgspec.Struct, rename="camel"):
    """A JSON object of the file; unknown fields are ignored."""


class View(Record):
    """A stretch of a buffer."""

    byte_length: int
    buffer: int = 0
    byte_offset: int = 0
    byte_stride: int | None = None


class Accessor(Record):
    """Layout of numbers in a buffer view."""

    component_type: int
    count: int
    type: str
    buffer_view: int | None = None
    byte_offset: int = 0
    normalized: bool = False
    sparse: msgspec.Raw | None = None


class Primitive(Record):
    """Triangles with one material."""

    attributes: dict[str, int]
    indices: int | None = None
    material: int | None = None
    mode: int = TRIANGLES


class MeshRecord(Record):
    """Primitives under one name."""

    primitives: list[Primitive]
    name: str = ""


class Node(Record):
    """A place in the tree: a matrix, or its three factors."""

    mesh: int | None = None
    skin: int | None = None
    camera: int | None = None
    children: list[int] = []
    name: str = ""
    matrix: list[float] | None = None
    translation: tuple[float, float, float] = (0.0, 0.0, 0.0)
    rotation: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 1.0)
    scale: tuple[float, float, float] = (1.0, 1.0, 1.0)


class TextureLink(Record):
    """The picture of a surface."""

    index: int = 0


class Looks(Record):
    """The properties of a surface that we keep: a linear colour, metal and roughness, 0 … 1."""

    base_color_factor: tuple[float, float, float, float] = (1.0, 1.0, 1.0, 1.0)
    metallic_factor: float = 1.0
    roughness_factor: float = 1.0
    base_color_texture: TextureLink | None = None


class Material(Record):
    """Looks of a surface."""

    pbr_metallic_roughness: Looks = msgspec.field(default_factory=Looks)
    name: str = ""


class SceneRecord(Record):
    """The roots of what is shown."""

    nodes: list[int] = []


class Buffer(Record):
    """The bytes that follow, or a link to others."""

    byte_length: int = 0
    uri: str | None = None


class Asset(Record):
    """What made the file."""

    version: str = "2.0"


class Gltf(Record):
    """The whole description."""

    asset: Asset = msgspec.field(default_factory=Asset)
    accessors: list[Accessor] = []
    buffer_views: list[View] = []
    buffers: list[Buffer] = []
    meshes: list[MeshRecord] = []
    materials: list[Material] = []
    nodes: list[Node] = []
    scenes: list[SceneRecord] = []
    scene: int | None = None
    extensions_required: list[str] = []
    animations: list[msgspec.Raw] = []


def item(items: list[Any], index: int, what: str) -> Any:
    """Return one of the records by its number, if it exists."""
    if not 0 <= index < len(items):
        raise FormatError(f"It names {what} {index}, which it does not hold.")
    return items[index]


def placed_meshes(gltf: Gltf) -> Iterator[tuple[str, MeshRecord, NDArray[np.float64]]]:
    """Yield every mesh of the scene with its name and its matrix (4, 4), parents first."""
    if gltf.scenes:
        roots = item(gltf.scenes, gltf.scene or 0, "scene").nodes
    elif gltf.nodes:
        inner = {child for node in gltf.nodes for child in node.children}
        roots = [index for index in range(len(gltf.nodes)) if index not in inner]
    else:
        for mesh in gltf.meshes:
            yield mesh.name, mesh, np.eye(4)
        return
    seen: set[int] = set()
    at_most(len(gltf.nodes), MAX_NODES, "nodes")
    stack = [(index, np.eye(4), 0) for index in reversed(roots)]
    while stack:
        index, above, depth = stack.pop()
        if index in seen:
            raise FormatError("Its nodes are not a tree: one has two parents.")
        seen.add(index)
        at_most(depth, MAX_DEPTH, "levels of nodes")
        node: Node = item(gltf.nodes, index, "node")
        with np.errstate(all="ignore"):
            matrix = above @ _matrix(node)
        if not (np.abs(matrix) <= MAX_COORDINATE).all():
            raise FormatError("A node is moved or stretched further than a mesh can reach.")
        if node.mesh is not None:
            mesh = item(gltf.meshes, node.mesh, "mesh")
            yield node.name or mesh.name, mesh, matrix
        stack += [(child, matrix, depth + 1) for child in reversed(node.children)]


def _matrix(node: Node) -> NDArray[np.float64]:
    if node.matrix is not None:
        if len(node.matrix) != 16:
            raise FormatError("A node's matrix does not have sixteen numbers.")
        return np.reshape(node.matrix, (4, 4)).T
    x, y, z, w = node.rotation
    turn = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    matrix = np.eye(4)
    matrix[:3, :3] = turn * node.scale
    matrix[:3, 3] = node.translation
    return matrix
