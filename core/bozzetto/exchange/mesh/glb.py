"""glTF 2.0 in its binary form: one node per part; Y up and metres in the file.

Only what the file itself holds is read: no links, no compression extensions.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final

import msgspec
import numpy as np
from numpy.typing import NDArray

from bozzetto.errors import FormatError, words_of
from bozzetto.exchange.color import WHITE, linear_to_srgb, srgb_to_linear
from bozzetto.exchange.limits import MAX_FACES, MAX_VERTICES, at_most
from bozzetto.exchange.mesh.face_groups import proper_groups
from bozzetto.exchange.mesh.gltf_motion import animation, rigid_motions
from bozzetto.exchange.mesh.gltf_scene import (
    TRIANGLES,
    Accessor,
    Buffer,
    Gltf,
    Material,
    Primitive,
    View,
    item,
    placed_meshes,
)
from bozzetto.exchange.mesh.gltf_skin import follows, inverse_binds, rig_nodes
from bozzetto.exchange.mesh.gltf_texture import SAMPLER, corners_of, picture_file
from bozzetto.exchange.mesh.polygons import check_places, checked_mesh, without_degenerate
from bozzetto.geometry.mesh import Mesh
from bozzetto.geometry.placement import Placement
from bozzetto.geometry.shapes import FaceGroup, Finish, Shapes, Solid, Surface
from bozzetto.json_size import MAX_VALUES, json_values

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

TO_FILE: Final = Placement(tuple(AXES.ravel().tolist()), 1.0 / MM_PER_METRE)
"""The change of axes and units as a placement."""

ARRAY_BUFFER: Final = 34962
ELEMENT_ARRAY_BUFFER: Final = 34963
FLOAT: Final = 5126
UNSIGNED_BYTE: Final = 5121
UNSIGNED_SHORT: Final = 5123
UNSIGNED_INT: Final = 5125
STRIP: Final = 5
FAN: Final = 6

COMPONENTS: Final = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS: Final = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}

MAX_PARTS: Final = 20_000
"""Primitives that are shown; an assembly of as many screws has not more."""

HARMLESS: Final = ("KHR_materials_", "KHR_texture_transform")
"""Beginnings of extensions that change the looks only, never the geometry."""


# -- writing -------------------------------------------------------------------------------


def write_motion(frames: Sequence[Shapes], seconds: Sequence[float]) -> bytes:
    """Write GLB of parts that move rigidly, with an animation of their nodes.

    Parameters
    ----------
    frames : sequence of Shapes
        The same parts at each time.
    seconds : sequence of float
        These times, growing.

    Raises
    ------
    UserError
        If parts come, go, or change their shape.
    """
    drawn = [_drawn(frame) for frame in frames]
    return write_shapes(drawn[0], motions=rigid_motions(drawn), seconds=seconds)


def _drawn(shapes: Shapes) -> Shapes:
    """Return the parts of which there is anything to write."""
    parts = [part for part in shapes.meshes() if len(without_degenerate(part.mesh.faces))]
    return Shapes(
        solids=tuple(part for part in parts if isinstance(part, Solid)),
        surfaces=tuple(part for part in parts if isinstance(part, Surface)),
    )


def write_shapes(
    shapes: Shapes,
    *,
    motions: Sequence[Sequence[Placement]] = (),
    seconds: Sequence[float] = (),
) -> bytes:
    """Write GLB with one node and mesh per part, and a material for it or each of its groups.

    A texture takes the place of vertex colours, which glTF would multiply with it. A solid with
    a skin is written at rest, and its joints as they are turned. Motions say where each part is at
    each time, as seen from where it is written.
    """
    parts = [part for part in shapes.meshes() if len(without_degenerate(part.mesh.faces))]
    blob = bytearray()
    views: list[dict[str, Any]] = []
    accessors: list[dict[str, Any]] = []

    def view(content: bytes, **more: int) -> None:
        views.append({"buffer": 0, "byteOffset": len(blob), "byteLength": len(content), **more})
        blob.extend(content + b"\0" * (-len(content) % 4))  # what follows stays aligned

    def put(
        values: NDArray[Any], kind: str, component: int, target: int | None = None, **more: Any
    ) -> int:
        view(values.tobytes(), **({} if target is None else {"target": target}))
        accessor = {"bufferView": len(views) - 1, "componentType": component, "type": kind}
        accessors.append({**accessor, "count": len(values), **more})
        return len(accessors) - 1

    meshes, nodes = [], []
    materials: list[dict[str, Any]] = []
    images: list[dict[str, Any]] = []
    skins: list[dict[str, Any]] = []
    joint_nodes: list[dict[str, Any]] = []
    for number, part in enumerate(parts):
        mesh = part.mesh
        texture = part.texture if isinstance(part, Solid) else None
        skin = part.skin if isinstance(part, Solid) else None
        if skin is not None and skin.rest is not None:
            mesh = replace(mesh, vertices=skin.rest.vertices, normals=skin.rest.normals)
        vertex, faces, texels = corners_of(mesh, texture)
        places = (mesh.vertices[vertex] @ AXES.T / MM_PER_METRE).astype("<f4")
        reach = {"min": places.min(0).tolist(), "max": places.max(0).tolist()}
        attributes = {"POSITION": put(places, "VEC3", FLOAT, ARRAY_BUFFER, **reach)}
        attributes["NORMAL"] = put(_unit_normals(mesh)[vertex], "VEC3", FLOAT, ARRAY_BUFFER)
        base = part.color or WHITE
        colors = mesh.colors_over(base)
        if texels is not None:
            attributes["TEXCOORD_0"] = put(texels.astype("<f4"), "VEC2", FLOAT, ARRAY_BUFFER)
        elif colors is not None:
            linear = _linear_colors(colors[vertex])
            attributes["COLOR_0"] = put(
                linear, "VEC4", UNSIGNED_SHORT, ARRAY_BUFFER, normalized=True
            )
        if skin is not None:
            joints, weights = follows(skin, vertex)
            component = UNSIGNED_BYTE if joints.itemsize == 1 else UNSIGNED_SHORT
            attributes["JOINTS_0"] = put(joints, "VEC4", component, ARRAY_BUFFER)
            attributes["WEIGHTS_0"] = put(weights, "VEC4", FLOAT, ARRAY_BUFFER)
        primitives = []
        begin = 0
        for group in proper_groups(part) or (FaceGroup(part.name, len(faces)),):
            own = faces[begin : begin + group.count].ravel().astype("<u4")
            indices = put(own, "SCALAR", UNSIGNED_INT, ELEMENT_ARRAY_BUFFER)
            primitives.append(
                {"attributes": attributes, "indices": indices, "material": len(materials)}
            )
            materials.append(_material(part, group))
            begin += group.count
        meshes.append({"name": part.name, "primitives": primitives})
        if texture is not None:
            view(picture_file(texture, base))
            for material in materials[-len(primitives) :]:
                material["pbrMetallicRoughness"]["baseColorTexture"] = {"index": len(images)}
            images.append({"bufferView": len(views) - 1, "mimeType": "image/png"})
        nodes.append({"name": part.name, "mesh": number})
        if skin is not None:
            rig = skin.rig.placed(TO_FILE)
            root = len(parts) + len(joint_nodes)
            joint_nodes += rig_nodes(rig, root, part.name)
            nodes[-1]["skin"] = len(skins)
            binds = put(inverse_binds(rig), "MAT4", FLOAT)
            numbers = list(range(root + 1, root + 1 + len(rig.joints)))
            skins.append({"skeleton": root, "joints": numbers, "inverseBindMatrices": binds})
    moving = animation(motions, seconds, TO_FILE, put, FLOAT)
    scene = {
        "asset": {"version": "2.0", "generator": "Bozzetto"},
        "scene": 0,
        "scenes": [{"nodes": [*range(len(nodes)), *(skin["skeleton"] for skin in skins)]}],
        "nodes": nodes + joint_nodes,
        "meshes": meshes,
        "materials": materials,
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(blob)}],
    }
    if skins:
        scene["skins"] = skins
    if moving is not None:
        scene["animations"] = [moving]
    if images:
        scene["images"] = images
        scene["textures"] = [{"source": k, "sampler": 0} for k in range(len(images))]
        scene["samplers"] = [SAMPLER]
    return _packed(msgspec.json.encode(scene), bytes(blob))


def _packed(text: bytes, blob: bytes) -> bytes:
    text += b" " * (-len(text) % 4)

    def chunk(kind: int, content: bytes) -> bytes:
        return np.array([len(content), kind], "<u4").tobytes() + content

    body = chunk(JSON_CHUNK, text) + chunk(BIN_CHUNK, blob)
    return MAGIC + np.array([2, 12 + len(body)], "<u4").tobytes() + body


def _unit_normals(mesh: Mesh) -> NDArray[np.float32]:
    normals = mesh.vertex_normals().astype(np.float64) @ AXES.T
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    up = np.array([0.0, 1.0, 0.0])  # a vertex that no face uses still needs some unit vector
    return np.where(length > 0, normals / np.where(length > 0, length, 1.0), up).astype("<f4")


def _linear_colors(colors: NDArray[np.uint8]) -> NDArray[np.uint16]:
    """Convert vertex colours to glTF's linear ones; 16 bits keep every sRGB byte apart."""
    linear = np.hstack((srgb_to_linear(colors[:, :3]), colors[:, 3:] / 255.0))
    return np.rint(65535.0 * linear).astype("<u2")


def _material(part: Solid | Surface, group: FaceGroup) -> dict[str, Any]:
    base = [1.0, 1.0, 1.0, 1.0]
    painted = isinstance(part, Solid) and part.texture is not None
    color = group.color or part.color
    if color is not None and part.mesh.colors is None and not painted:
        base[:3] = srgb_to_linear(color).tolist()
    metallic, roughness, opacity = LOOKS[group.finish]
    base[3] = opacity
    looks = {"baseColorFactor": base, "metallicFactor": metallic, "roughnessFactor": roughness}
    material: dict[str, Any] = {"name": group.name, "pbrMetallicRoughness": looks}
    if opacity < 1.0:
        material["alphaMode"] = "BLEND"
    if isinstance(part, Surface):
        material["doubleSided"] = True
    return material


# -- reading -------------------------------------------------------------------------------


def read_shapes(data: bytes) -> Shapes:
    """Read the triangles of the scene shown, every node at its place."""
    gltf, blob = _opened(data)
    surfaces: list[Surface] = []
    _check_sum(gltf)
    for name, mesh, matrix in placed_meshes(gltf):
        for primitive in mesh.primitives:
            part = _surface(gltf, blob, primitive, matrix, name)
            if part is not None:
                surfaces.append(part)
    if not surfaces:
        raise FormatError("There are no faces in this file.")
    return Shapes(surfaces=tuple(surfaces))


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


def _opened(data: bytes) -> tuple[Gltf, bytes]:
    """Return the decoded JSON chunk and the binary one."""
    if data[:4] != MAGIC or len(data) < 20:
        raise FormatError("This is not a GLB file.")
    version, length, size, kind = (int(v) for v in np.frombuffer(data, "<u4", 4, 4))
    if version != 2:
        raise FormatError(f"This is glTF {version}; only glTF 2 can be read.")
    if kind != JSON_CHUNK or 20 + size > min(length, len(data)):
        raise FormatError("This GLB file is damaged or cut short.")
    at_most(json_values(data[20 : 20 + size]), MAX_VALUES, "values in its description")
    try:
        gltf = msgspec.json.decode(data[20 : 20 + size].rstrip(b" \0"), type=Gltf)
    except (msgspec.MsgspecError, RecursionError, UnicodeDecodeError) as error:
        raise FormatError(f"Its description cannot be understood: {words_of(error)}.") from error
    missing = [name for name in gltf.extensions_required if not name.startswith(HARMLESS)]
    if missing:
        raise FormatError(
            f"It needs {', '.join(missing)[:200]}, which cannot be read. Export it again "
            "without compression."
        )
    blob, at = b"", 20 + size
    if at + 8 <= len(data):
        size, kind = (int(v) for v in np.frombuffer(data, "<u4", 2, at))
        if kind == BIN_CHUNK:
            blob = data[at + 8 : at + 8 + size]
    return gltf, blob


def _surface(
    gltf: Gltf, blob: bytes, primitive: Primitive, matrix: NDArray[np.float64], name: str
) -> Surface | None:
    """Return one primitive in our axes; None for points and lines."""
    if primitive.mode not in (TRIANGLES, STRIP, FAN) or "POSITION" not in primitive.attributes:
        return None
    local = _values(gltf, blob, primitive.attributes["POSITION"], 3)
    check_places(local)
    to_world = MM_PER_METRE * AXES.T @ matrix[:3, :3]
    places = local @ to_world.T + MM_PER_METRE * AXES.T @ matrix[:3, 3]
    order = np.arange(len(places))
    if primitive.indices is not None:
        if item(gltf.accessors, primitive.indices, "accessor").component_type == FLOAT:
            raise FormatError("Its indices are not whole numbers.")
        order = _values(gltf, blob, primitive.indices, 1)[:, 0].astype(np.int64)
    faces = without_degenerate(_faces(order, primitive.mode).astype(np.int64))
    if not len(faces):
        return None
    if np.linalg.det(to_world) < 0:
        faces = faces[:, ::-1]
    colors = None
    if "COLOR_0" in primitive.attributes:
        linear = _values(gltf, blob, primitive.attributes["COLOR_0"], None)
        alpha = linear[:, 3:4] if linear.shape[1] == 4 else np.ones((len(linear), 1))
        opaque = np.rint(255 * np.clip(np.nan_to_num(alpha), 0, 1)).astype(np.uint8)
        colors = np.hstack((linear_to_srgb(linear[:, :3]), opaque))
    color = None
    if primitive.material is not None:
        material: Material = item(gltf.materials, primitive.material, "material")
        looks = material.pbr_metallic_roughness
        red, green, blue = (int(v) for v in linear_to_srgb(looks.base_color_factor[:3]))
        color = (red, green, blue) if (red, green, blue) != (255, 255, 255) else None
    mesh = checked_mesh(places, faces, _normals(gltf, blob, primitive, to_world), colors)
    return Surface(mesh, name, color)


def _normals(
    gltf: Gltf, blob: bytes, primitive: Primitive, to_world: NDArray[np.float64]
) -> NDArray[np.float64] | None:
    """Return unit normals in our axes; None where the file has none that can be used."""
    if "NORMAL" not in primitive.attributes:
        return None
    local = _values(gltf, blob, primitive.attributes["NORMAL"], 3)
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


def _values(gltf: Gltf, blob: bytes, index: int, width: int | None) -> NDArray[np.float64]:
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
    buffer: Buffer = item(gltf.buffers, view.buffer, "buffer")
    if view.buffer != 0 or buffer.uri is not None:
        raise FormatError("Its data lies in another file. Export it again as one GLB file.")
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
        raise FormatError("This GLB file is damaged or cut short.")
    raw = np.ndarray((accessor.count, columns), dtype, blob, begin, (stride, dtype.itemsize))
    with np.errstate(invalid="ignore"):  # signalling NaNs; refused later
        values = raw.astype(np.float64)
    if accessor.normalized and dtype.kind != "f":
        values = np.maximum(values / np.iinfo(dtype).max, -1.0)
    return values
