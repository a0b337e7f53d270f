"""glTF description: the parts that we understand, and the placements of its nodes."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, Final, NamedTuple

import msgspec
import numpy as np
from numpy.typing import NDArray

from bozzetto.errors import FormatError
from bozzetto.exchange.limits import MAX_COORDINATE, at_most
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

UNIT: Final = 1e-6
"""Difference from a length of one that is left as it is: the rounding of a file."""


MAX_LEVELS: Final = 1000
"""Nodes within one another: a chain of as many links."""

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


class SparseIndices(Record):
    """Where the numbers of the values stand that are not as the others."""

    buffer_view: int
    component_type: int
    byte_offset: int = 0


class SparseValues(Record):
    """Where these values stand."""

    buffer_view: int
    byte_offset: int = 0


class Sparse(Record):
    """Values that stand apart."""

    count: int
    indices: SparseIndices
    values: SparseValues


class Accessor(Record):
    """Layout of numbers in a buffer view."""

    component_type: int
    count: int
    type: str
    buffer_view: int | None = None
    byte_offset: int = 0
    normalized: bool = False
    sparse: Sparse | None = None


class Primitive(Record):
    """Triangles with one material."""

    attributes: dict[str, int]
    indices: int | None = None
    material: int | None = None
    mode: int = TRIANGLES
    targets: list[msgspec.Raw] = []
    extensions: dict[str, msgspec.Raw] = {}


class MeshRecord(Record):
    """Primitives under one name."""

    primitives: list[Primitive]
    name: str = ""
    extras: Any = None


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
    extras: Any = None
    extensions: dict[str, msgspec.Raw] = {}


class TextureLink(Record):
    """The picture of a surface, and the row of places in it that is meant."""

    index: int = 0
    tex_coord: int = 0
    extensions: dict[str, msgspec.Raw] = {}


class TextureTransform(Record):
    """Where a picture lies on a surface (KHR_texture_transform).

    Its places are scaled, turned (radians) and shifted, in this order.
    """

    offset: tuple[float, float] = (0.0, 0.0)
    rotation: float = 0.0
    scale: tuple[float, float] = (1.0, 1.0)
    tex_coord: int | None = None


class TextureRecord(Record):
    """A picture, and how it is laid on; of that we keep nothing."""

    source: int | None = None


class ImageRecord(Record):
    """A picture: in a buffer view, or in a link."""

    uri: str | None = None
    buffer_view: int | None = None


class SkinRecord(Record):
    """The nodes that vertices follow, and the matrices that bring the mesh to each at rest."""

    joints: list[int] = []
    inverse_bind_matrices: int | None = None


class Target(Record):
    """Property of a node that a channel of an animation moves."""

    path: str
    node: int | None = None


class Channel(Record):
    """One thing that moves, and its motion."""

    sampler: int
    target: Target


class Sampler(Record):
    """Times, and values at these."""

    input: int
    output: int
    interpolation: str = "LINEAR"


class AnimationRecord(Record):
    """A motion of nodes."""

    channels: list[Channel] = []
    samplers: list[Sampler] = []
    name: str = ""


class Looks(Record):
    """The properties of a surface that we keep: a linear colour, metal and roughness, 0 … 1."""

    base_color_factor: tuple[float, float, float, float] | None = None
    metallic_factor: float = 1.0
    roughness_factor: float = 1.0
    base_color_texture: TextureLink | None = None


class Material(Record):
    """Looks of a surface."""

    pbr_metallic_roughness: Looks = msgspec.field(default_factory=Looks)
    name: str = ""
    alpha_mode: str = "OPAQUE"
    normal_texture: Any = None
    occlusion_texture: Any = None
    emissive_texture: Any = None
    extensions: dict[str, msgspec.Raw] = {}


class Transmission(Record):
    """The share of light that passes through (KHR_materials_transmission)."""

    transmission_factor: float = 0.0


class SceneRecord(Record):
    """The roots of what is shown."""

    nodes: list[int] = []


class Buffer(Record):
    """The bytes that follow, or a link to others."""

    byte_length: int = 0
    uri: str | None = None


class Asset(Record):
    """Program that made the file."""

    version: str | float = "2.0"


class Headed(Record):
    """A description of any version."""

    asset: Asset = msgspec.field(default_factory=Asset)


class Gltf(Headed):
    """The whole description of version 2."""

    accessors: list[Accessor] = []
    buffer_views: list[View] = []
    buffers: list[Buffer] = []
    meshes: list[MeshRecord] = []
    materials: list[Material] = []
    nodes: list[Node] = []
    scenes: list[SceneRecord] = []
    scene: int | None = None
    extensions_required: list[str] = []
    skins: list[SkinRecord] = []
    animations: list[AnimationRecord] = []
    textures: list[TextureRecord] = []
    images: list[ImageRecord] = []


def item(items: list[Any], index: int, what: str) -> Any:
    """Return one of the records by its number, if it exists."""
    if not 0 <= index < len(items):
        raise FormatError(f"It names {what} {index}, which it does not hold.")
    return items[index]


class Place(NamedTuple):
    """A node of the scene.

    Attributes
    ----------
    node : int
        Its number.
    parent : int
        Number of the node that it is in, -1 for roots.
    matrix : (4, 4) array
        From its own axes to those of the scene.
    depth : int
        How many nodes it is in.
    """

    node: int
    parent: int
    matrix: NDArray[np.float64]
    depth: int


NOWHERE: Final = Place(-1, -1, np.eye(4), -1)
"""The place of what is in no node."""


class ShownMesh(NamedTuple):
    """A mesh of the scene.

    Attributes
    ----------
    name : str
    mesh : MeshRecord
    place : Place
    path : tuple of str
        Names of the nodes that it is in, the outermost first.
    """

    name: str
    mesh: MeshRecord
    place: Place
    path: tuple[str, ...]


def places_of(gltf: Gltf) -> Iterator[Place]:
    """Yield every node of the scene, parents before what is in them."""
    if gltf.scenes:
        roots = item(gltf.scenes, gltf.scene or 0, "scene").nodes
    else:
        inner = {child for node in gltf.nodes for child in node.children}
        roots = [index for index in range(len(gltf.nodes)) if index not in inner]
    seen: set[int] = set()
    at_most(len(gltf.nodes), MAX_NODES, "nodes")
    stack = [(index, NOWHERE) for index in reversed(roots)]
    while stack:
        index, above = stack.pop()
        if index in seen:
            raise FormatError("Its nodes are not a tree: one has two parents.")
        seen.add(index)
        node: Node = item(gltf.nodes, index, "node")
        at_most(above.depth + 1, MAX_LEVELS, "levels of nodes")
        with np.errstate(all="ignore"):
            matrix = above.matrix @ _matrix(node)
        if not (np.abs(matrix) <= MAX_COORDINATE).all():
            raise FormatError("A node is moved or stretched further than a mesh can reach.")
        place = Place(index, above.node, matrix, above.depth + 1)
        yield place
        stack += [(child, place) for child in reversed(node.children)]


def placed_meshes(gltf: Gltf) -> Iterator[ShownMesh]:
    """Yield every mesh of the scene, parents first."""
    if not gltf.scenes and not gltf.nodes:
        for mesh in gltf.meshes:
            yield ShownMesh(mesh.name, mesh, NOWHERE, ())
        return
    above: dict[int, int] = {}
    for place in places_of(gltf):
        above[place.node] = place.parent
        node = gltf.nodes[place.node]
        if node.mesh is not None:
            mesh = item(gltf.meshes, node.mesh, "mesh")
            path: list[str] = []
            holder = place.parent
            while holder >= 0:
                path.append(gltf.nodes[holder].name)
                holder = above[holder]
            yield ShownMesh(node.name or mesh.name, mesh, place, tuple(reversed(path)))


def _matrix(node: Node) -> NDArray[np.float64]:
    if node.matrix is not None:
        if len(node.matrix) != 16:
            raise FormatError("A node's matrix does not have sixteen numbers.")
        return np.reshape(node.matrix, (4, 4)).T
    x, y, z, w = node.rotation
    length = math.hypot(x, y, z, w)
    if abs(length - 1.0) < UNIT:  # rounded
        x, y, z, w = x / length, y / length, z / length, w / length
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
