"""glTF 2.0, read: what is shown, every node at its place, from `.glb` and from `.gltf`.

Buffers are in the file, in links that hold them (``data:``), or beside it. Compression extensions
are not read.
"""

from __future__ import annotations

import base64
import binascii
from collections.abc import Sequence
from dataclasses import replace
from typing import Final
from urllib.parse import unquote

import msgspec
import numpy as np
from numpy.typing import NDArray

from bozzetto.errors import FormatError, words_of
from bozzetto.exchange.color import linear_to_srgb
from bozzetto.exchange.limits import MAX_FACES, MAX_MESH_BYTES, MAX_VERTICES, at_most
from bozzetto.exchange.mesh.gltf_scene import (
    AXES,
    BIN_CHUNK,
    FLOAT,
    JSON_CHUNK,
    LOOKS,
    MAGIC,
    MM_PER_METRE,
    TRIANGLES,
    Accessor,
    Gltf,
    Material,
    Primitive,
    View,
    item,
    placed_meshes,
)
from bozzetto.exchange.mesh.polygons import check_places, checked_mesh, without_degenerate
from bozzetto.exchange.reading import Reading
from bozzetto.geometry.shapes import FaceGroup, Finish, Shapes, Surface
from bozzetto.json_size import MAX_VALUES, json_values

STRIP: Final = 5
FAN: Final = 6

COMPONENTS: Final = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS: Final = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}

MAX_PARTS: Final = 20_000
"""Primitives that are shown; an assembly of as many screws has not more."""

HARMLESS: Final = ("KHR_materials_", "KHR_texture_transform")
"""Beginnings of extensions that change the looks only, never the geometry."""

MAX_BUFFERS: Final = 64
"""Buffers of one file; most have one."""

Blobs = list[bytes]


def read_shapes(data: bytes, reading: Reading | None = None) -> Shapes:
    """Read the triangles of the scene shown, every node at its place.

    Parameters
    ----------
    data : bytes
        Of a `.glb` or a `.gltf`.
    reading : Reading, optional
        Where buffers lie beside it, and what is told.
    """
    reading = reading or Reading()
    gltf, blob = _opened(data)
    blobs = _buffers(gltf, blob, reading)
    _tell(gltf, reading)
    surfaces: list[Surface] = []
    _check_sum(gltf)
    for name, mesh, matrix in placed_meshes(gltf):
        for alike in _alike(mesh.primitives):
            made = [(_surface(gltf, blobs, one, matrix, name), one) for one in alike]
            parts = [(part, primitive) for part, primitive in made if part is not None]
            if parts:
                surfaces.append(_together(gltf, parts))
    if not surfaces:
        raise FormatError("There are no faces in this file.")
    return Shapes(surfaces=tuple(surfaces))


def _alike(primitives: Sequence[Primitive]) -> list[list[Primitive]]:
    """Return primitives, those that follow one another over the same vertices together."""
    found: list[list[Primitive]] = []
    for primitive in primitives:
        if found and found[-1][0].attributes == primitive.attributes:
            found[-1].append(primitive)
        else:
            found.append([primitive])
    return found


def _together(gltf: Gltf, parts: Sequence[tuple[Surface, Primitive]]) -> Surface:
    """Return one surface with a group for each primitive, called like its material."""
    first = parts[0][0]
    if len(parts) == 1:
        return first
    faces = np.concatenate([part.mesh.faces for part, _ in parts])
    groups = []
    for part, primitive in parts:
        name = part.name
        finish: Finish = "matt"
        if primitive.material is not None:
            material: Material = item(gltf.materials, primitive.material, "material")
            name, finish = material.name or name, _finish(material)
        groups.append(FaceGroup(name, len(part.mesh.faces), part.color, finish))
    return Surface(replace(first.mesh, faces=faces), first.name, groups=tuple(groups))


def _finish(material: Material) -> Finish:
    """Return of what a material seems to be made: the finish whose looks are nearest."""
    looks = material.pbr_metallic_roughness
    own = (looks.metallic_factor, looks.roughness_factor, looks.base_color_factor[3])
    return min(LOOKS, key=lambda finish: float(np.square(np.subtract(LOOKS[finish], own)).sum()))


def _check_sum(gltf: Gltf) -> None:
    """Refuse a scene whose parts are too much together, before any of them is made.

    A few lines can show one mesh a million times, or one row of corners in as many parts.
    """
    counts: dict[int, tuple[int, int, int]] = {}
    parts = vertices = corners = 0
    for _, mesh, _ in placed_meshes(gltf):
        if id(mesh) not in counts:
            sizes = [_sizes(gltf, primitive) for primitive in mesh.primitives]
            counts[id(mesh)] = (len(sizes), sum(v for v, _ in sizes), sum(c for _, c in sizes))
        own = counts[id(mesh)]
        parts, vertices, corners = parts + own[0], vertices + own[1], corners + own[2]
        at_most(parts, MAX_PARTS, "parts")
        at_most(vertices, MAX_VERTICES, "vertices")
        at_most(corners, 3 * MAX_FACES, "corners")


def _sizes(gltf: Gltf, primitive: Primitive) -> tuple[int, int]:
    """Return how many vertices and corners a primitive names."""
    if "POSITION" not in primitive.attributes:
        return 0, 0
    vertices: int = item(gltf.accessors, primitive.attributes["POSITION"], "accessor").count
    if primitive.indices is None:
        return vertices, vertices
    return vertices, item(gltf.accessors, primitive.indices, "accessor").count


def _opened(data: bytes) -> tuple[Gltf, bytes | None]:
    """Return the description, and the binary chunk of a `.glb`."""
    if data[:4] != MAGIC:
        if data.lstrip(b"\xef\xbb\xbf \t\r\n")[:1] != b"{":
            raise FormatError("This is not a glTF file.")
        return _described(data.removeprefix(b"\xef\xbb\xbf")), None
    if len(data) < 20:
        raise FormatError("This is not a GLB file.")
    version, length, size, kind = (int(v) for v in np.frombuffer(data, "<u4", 4, 4))
    if version != 2:
        raise FormatError(f"This is glTF {version}; only glTF 2 can be read.")
    if kind != JSON_CHUNK or 20 + size > min(length, len(data)):
        raise FormatError("This GLB file is damaged or cut short.")
    gltf = _described(data[20 : 20 + size].rstrip(b" \0"))
    at = 20 + size
    if at + 8 <= len(data):
        size, kind = (int(v) for v in np.frombuffer(data, "<u4", 2, at))
        if kind == BIN_CHUNK:
            return gltf, data[at + 8 : at + 8 + size]
    return gltf, None


def _described(text: bytes) -> Gltf:
    """Return the description that is in some JSON."""
    at_most(json_values(text), MAX_VALUES, "values in its description")
    try:
        gltf = msgspec.json.decode(text, type=Gltf)
    except (msgspec.MsgspecError, RecursionError, UnicodeDecodeError) as error:
        raise FormatError(f"Its description cannot be understood: {words_of(error)}.") from error
    if not gltf.asset.version.startswith("2"):
        raise FormatError(f"This is glTF {gltf.asset.version[:9]}; only glTF 2 can be read.")
    missing = [name for name in gltf.extensions_required if not name.startswith(HARMLESS)]
    if missing:
        raise FormatError(
            f"It needs {', '.join(missing)[:200]}, which cannot be read. Export it again "
            "without compression."
        )
    return gltf


def _buffers(gltf: Gltf, blob: bytes | None, reading: Reading) -> list[bytes]:
    """Return the bytes of all buffers; the first one of a `.glb` is its binary chunk."""
    at_most(len(gltf.buffers), MAX_BUFFERS, "buffers")
    found: list[bytes] = []
    size = 0
    for number, buffer in enumerate(gltf.buffers):
        if buffer.uri is not None:
            found.append(_linked(buffer.uri, reading))
        else:
            found.append(blob or b"" if number == 0 else b"")
        size += len(found[-1])
        at_most(size, MAX_MESH_BYTES, "bytes in buffers")
    return found


def _linked(uri: str, reading: Reading) -> bytes:
    """Return the bytes of a link: those that it holds, or those of a file beside."""
    if not uri.startswith("data:"):
        return reading.beside(unquote(uri), "buffer")
    head, comma, text = uri.partition(",")
    if not comma or not head.endswith(";base64"):
        raise FormatError("A buffer in its description is not in base64. Export it again.")
    try:
        return base64.b64decode(text, validate=True)
    except (binascii.Error, ValueError):
        raise FormatError("A buffer in its description is damaged.") from None


def _tell(gltf: Gltf, reading: Reading) -> None:
    """Tell what is left out: pictures, bones, motions, cameras, points and lines."""
    pictured = sum(one.pbr_metallic_roughness.base_color_texture is not None
                   for one in gltf.materials)  # fmt: skip
    thin = sum(one.mode not in (TRIANGLES, STRIP, FAN) for mesh in gltf.meshes
               for one in mesh.primitives)  # fmt: skip
    for count, what, many, why in (
        (pictured, "the picture of a material", "the pictures of {} materials",
         "their colours are kept"),
        (sum(node.skin is not None for node in gltf.nodes), "the bones of a part",
         "the bones of {} parts", "they stand as in the file at rest"),
        (len(gltf.animations), "a motion", "{} motions", "only shapes are read"),
        (sum(node.camera is not None for node in gltf.nodes), "a camera", "{} cameras",
         "only shapes are read"),
        (thin, "a set of points or lines", "{} sets of points or lines", "they have no faces"),
    ):  # fmt: skip
        if count:
            words = what if count == 1 else many.format(count)
            reading.tell(f"Left out of the glTF file: {words} ({why}).")


def _surface(
    gltf: Gltf, blobs: Blobs, primitive: Primitive, matrix: NDArray[np.float64], name: str
) -> Surface | None:
    """Return one primitive in our axes; None for points and lines."""
    if primitive.mode not in (TRIANGLES, STRIP, FAN) or "POSITION" not in primitive.attributes:
        return None
    local = _values(gltf, blobs, primitive.attributes["POSITION"], 3)
    check_places(local)
    to_world = MM_PER_METRE * AXES.T @ matrix[:3, :3]
    places = local @ to_world.T + MM_PER_METRE * AXES.T @ matrix[:3, 3]
    order = np.arange(len(places))
    if primitive.indices is not None:
        if item(gltf.accessors, primitive.indices, "accessor").component_type == FLOAT:
            raise FormatError("Its indices are not whole numbers.")
        order = _values(gltf, blobs, primitive.indices, 1)[:, 0].astype(np.int64)
    faces = without_degenerate(_faces(order, primitive.mode).astype(np.int64))
    if not len(faces):
        return None
    if np.linalg.det(to_world) < 0:
        faces = faces[:, ::-1]
    colors = None
    if "COLOR_0" in primitive.attributes:
        linear = _values(gltf, blobs, primitive.attributes["COLOR_0"], None)
        alpha = linear[:, 3:4] if linear.shape[1] == 4 else np.ones((len(linear), 1))
        opaque = np.rint(255 * np.clip(np.nan_to_num(alpha), 0, 1)).astype(np.uint8)
        colors = np.hstack((linear_to_srgb(linear[:, :3]), opaque))
    color = None
    if primitive.material is not None:
        material: Material = item(gltf.materials, primitive.material, "material")
        looks = material.pbr_metallic_roughness
        red, green, blue = (int(v) for v in linear_to_srgb(looks.base_color_factor[:3]))
        color = (red, green, blue) if (red, green, blue) != (255, 255, 255) else None
    mesh = checked_mesh(places, faces, _normals(gltf, blobs, primitive, to_world), colors)
    return Surface(mesh, name, color)


def _normals(
    gltf: Gltf, blobs: Blobs, primitive: Primitive, to_world: NDArray[np.float64]
) -> NDArray[np.float64] | None:
    """Return unit normals in our axes; None where the file has none that can be used."""
    if "NORMAL" not in primitive.attributes:
        return None
    local = _values(gltf, blobs, primitive.attributes["NORMAL"], 3)
    with np.errstate(all="ignore"):
        # Normals turn with the cofactors of the matrix, which exist where its inverse does not.
        a, b, c = to_world.T
        cofactors = np.column_stack((np.cross(b, c), np.cross(c, a), np.cross(a, b)))
        turned = local @ cofactors.T * np.sign(np.linalg.det(to_world))
        length = np.linalg.norm(turned, axis=1, keepdims=True)
        return np.asarray(turned / length) if (length > 0).all() else None


def _faces(order: NDArray[np.int64], mode: int) -> NDArray[np.int64]:
    if mode == TRIANGLES:
        return order[: len(order) // 3 * 3].reshape(-1, 3)
    count = max(len(order) - 2, 0)
    if mode == FAN:
        return np.column_stack((order[1:-1], order[2:], np.repeat(order[:1], count)))[:count]
    at = np.arange(count)
    odd = at % 2
    return np.column_stack((order[at], order[at + 1 + odd], order[at + 2 - odd]))


def _values(gltf: Gltf, blobs: Blobs, index: int, width: int | None) -> NDArray[np.float64]:
    """Return the values of an accessor, (n, width); integers are scaled only if normalised."""
    accessor: Accessor = item(gltf.accessors, index, "accessor")
    kind = COMPONENTS.get(accessor.component_type)
    columns = WIDTHS.get(accessor.type)
    if kind is None or columns is None or (width is not None and columns != width):
        raise FormatError(f"Accessor {index} is of a type that does not fit its use.")
    if accessor.sparse is not None or accessor.buffer_view is None:
        raise FormatError("It uses sparse accessors, which cannot be read. Export it again.")
    if columns < 3 and width is None:
        raise FormatError(f"Accessor {index} has too few components for a colour.")
    at_most(accessor.count, 3 * MAX_FACES, "values")
    view: View = item(gltf.buffer_views, accessor.buffer_view, "buffer view")
    blob: bytes = item(blobs, view.buffer, "buffer")
    dtype = np.dtype(kind)
    stride = view.byte_stride or dtype.itemsize * columns
    begin = view.byte_offset + accessor.byte_offset
    end = begin + stride * (accessor.count - 1) + dtype.itemsize * columns
    if stride < dtype.itemsize * columns:
        raise FormatError(f"Accessor {index} has a stride below the size of its values.")
    if min(accessor.count, view.byte_offset, accessor.byte_offset) < 0:
        raise FormatError(f"Accessor {index} has a size or an offset below zero.")
    if accessor.count == 0:
        return np.zeros((0, columns))
    if end > min(len(blob), view.byte_offset + view.byte_length):
        raise FormatError("This glTF file is damaged or cut short.")
    raw = np.ndarray((accessor.count, columns), dtype, blob, begin, (stride, dtype.itemsize))
    with np.errstate(invalid="ignore"):  # signalling NaNs; refused later
        values = raw.astype(np.float64)
    if accessor.normalized and dtype.kind != "f":
        values = np.maximum(values / np.iinfo(dtype).max, -1.0)
    return values
