"""glTF 2.0, read: what is shown, every node at its place, with its bones, pictures and motions.

From `.glb` and `.gltf`. Buffers are in the file, in links that hold them (``data:``), or beside it.
Meshes may be compressed by Draco; other compression is not read.
"""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import msgspec
import numpy as np
from numpy.typing import NDArray

from bozzetto.errors import FormatError, words_of
from bozzetto.exchange.color import linear_to_srgb
from bozzetto.exchange.limits import MAX_FACES, MAX_MESH_BYTES, MAX_PARTS, MAX_VERTICES, at_most
from bozzetto.exchange.mesh.gltf_draco import DRACO, unpack
from bozzetto.exchange.mesh.gltf_instances import INSTANCING, place_copies
from bozzetto.exchange.mesh.gltf_pictures import Pictures, has_unused_places, linked_bytes
from bozzetto.exchange.mesh.gltf_scene import (
    AXES,
    BIN_CHUNK,
    FLOAT,
    JSON_CHUNK,
    LOOKS,
    MAGIC,
    MM_PER_METRE,
    TRIANGLES,
    UNIT,
    Gltf,
    Headed,
    Material,
    Primitive,
    ShownMesh,
    Transmission,
    item,
    placed_meshes,
)
from bozzetto.exchange.mesh.gltf_skins import FollowedBones, Skins
from bozzetto.exchange.mesh.gltf_values import Blobs, values_of
from bozzetto.exchange.mesh.polygons import check_places, checked_mesh, without_degenerate
from bozzetto.exchange.reading import Reading
from bozzetto.geometry.mesh import Mesh
from bozzetto.geometry.shapes import FaceGroup, Finish, Shapes, Surface
from bozzetto.geometry.texture import Texture
from bozzetto.json_size import MAX_VALUES, json_values
from bozzetto.typed_data import decode_json

STRIP: Final = 5
FAN: Final = 6

HARMLESS: Final = ("KHR_materials_", "KHR_texture_transform", "KHR_technique", "KHR_lights_")
"""Beginnings of extensions that change the looks only, never the geometry."""

LIGHT: Final = "KHR_lights_punctual"
TRANSMISSION: Final = "KHR_materials_transmission"

UNDERSTOOD: Final = frozenset(("cut", "MSFT_screencoverage", "targetNames"))
"""Notes of nodes and meshes (``extras``) that are read, or whose subject is told."""

MAX_BUFFERS: Final = 10_000
"""Buffers of one file; most have one, some have one for each accessor, within the file."""

_Part = tuple[Surface, Primitive]


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
    place_copies(gltf, blobs)
    _check_sum(gltf)
    unpack(gltf, blobs)
    surfaces: list[Surface] = []
    bodies = Skins(gltf, blobs, reading)
    pictures = Pictures(gltf, blobs, reading)
    for shown in placed_meshes(gltf):
        follow = bodies.followed(shown.place)
        parts = [
            (part, primitive)
            for primitive in shown.mesh.primitives
            for part in (_surface(gltf, blobs, primitive, shown, follow, pictures),)
            if part is not None
        ]
        surfaces += [_together(gltf, alike) for alike in _alike(gltf, parts)]
    _tell(gltf, reading, bodies)
    if not surfaces:
        raise FormatError(" ".join(("There are no faces in this file.", *reading.left_out)))
    return Shapes(surfaces=tuple(surfaces))


def _alike(gltf: Gltf, parts: Sequence[_Part]) -> list[list[_Part]]:
    """Return the primitives of a mesh, those together that can be one part.

    What has another picture is another part. Most programs give every material vertices of its own.
    """
    found: list[list[_Part]] = []
    for part, primitive in parts:
        if found and _are_one(found[-1][0], (part, primitive)):
            if _picture(gltf, found[-1][0][1]) == _picture(gltf, primitive):
                found[-1].append((part, primitive))
                continue
        found.append([(part, primitive)])
    return found


def _are_one(one: _Part, other: _Part) -> bool:
    """Whether the vertices of two primitives say the same kinds of things."""
    if one[1].attributes == other[1].attributes:
        return True
    kinds = []
    for part, primitive in (one, other):
        mesh, skin = part.mesh, part.skin
        bones = None if skin is None else (skin.joints.shape[1], skin.rest is None)
        kinds.append((
            primitive.attributes.keys(), mesh.normals is None, mesh.colors is None, bones,
            part.texture is None,
        ))  # fmt: skip
    return bool(kinds[0] == kinds[1])


def _picture(gltf: Gltf, primitive: Primitive) -> tuple[int, int] | None:
    """Return which picture is on a primitive, and by which of its places."""
    link = _material(gltf, primitive).pbr_metallic_roughness.base_color_texture
    return None if link is None else (link.index, link.tex_coord)


def _material(gltf: Gltf, primitive: Primitive) -> Material:
    if primitive.material is None:
        return Material()
    found: Material = item(gltf.materials, primitive.material, "material")
    return found


def _together(gltf: Gltf, parts: Sequence[_Part]) -> Surface:
    """Return one surface with a group for each primitive, called like its material.

    A single one that has the name of its material and looks matt is in one piece.
    """
    first = parts[0][0]
    groups = []
    for part, primitive in parts:
        material = _material(gltf, primitive)
        name = material.name or part.name
        finish: Finish = "matt" if primitive.material is None else _finish(material)
        groups.append(FaceGroup(name, len(part.mesh.faces), part.color, finish))
    if len(parts) == 1:
        (group,) = groups
        plain = group.finish == "matt" and group.name in ("", first.name)
        return first if plain else replace(first, color=None, groups=(group,))
    apart: list[Surface] = []
    begins: dict[tuple[tuple[str, int], ...], int] = {}
    count = 0
    rows = []
    for part, primitive in parts:
        named = tuple(sorted(primitive.attributes.items()))
        if named not in begins:
            begins[named] = count
            count += len(part.mesh.vertices)
            apart.append(part)
        rows.append(part.mesh.faces + begins[named])
    faces = np.concatenate(rows)
    mesh = _joined([part.mesh for part in apart], faces)
    skin, texture = first.skin, first.texture
    if skin is not None:
        skins = [part.skin for part in apart if part.skin is not None]
        rests = [one.rest for one in skins if one.rest is not None]
        skin = replace(
            skin,
            joints=np.concatenate([one.joints for one in skins]),
            weights=np.concatenate([one.weights for one in skins]),
            rest=_joined(rests, faces) if rests else None,
        )
    if texture is not None:
        corners = [part.texture.corners for part, _ in parts if part.texture is not None]
        texture = Texture(texture.pixels, np.concatenate(corners))
    return Surface(
        mesh, first.name, groups=tuple(groups), texture=texture, skin=skin, path=first.path
    )


def _joined(meshes: Sequence[Mesh], faces: NDArray[np.int32]) -> Mesh:
    """Return the vertices of several meshes, with these faces."""
    normals = [mesh.normals for mesh in meshes if mesh.normals is not None]
    colors = [mesh.colors for mesh in meshes if mesh.colors is not None]
    return Mesh(
        np.concatenate([mesh.vertices for mesh in meshes]),
        faces,
        np.concatenate(normals) if normals else None,
        colors=np.concatenate(colors) if colors else None,
    )


def _finish(material: Material) -> Finish:
    """Return of what a material seems to be made: the finish whose looks are nearest."""
    looks = material.pbr_metallic_roughness
    opacity = 1.0 if looks.base_color_factor is None else looks.base_color_factor[3]
    raw = material.extensions.get(TRANSMISSION)
    if raw is not None:
        with contextlib.suppress(msgspec.MsgspecError):
            through: Transmission = decode_json(raw, Transmission)
            opacity *= 1.0 - through.transmission_factor
    # All that a look is made of lies between 0 and 1; in a file it may be any number.
    own = np.clip((looks.metallic_factor, looks.roughness_factor, opacity), 0.0, 1.0)
    return min(LOOKS, key=lambda finish: float(np.square(np.subtract(LOOKS[finish], own)).sum()))


def _check_sum(gltf: Gltf) -> None:
    """Refuse a scene whose parts are too much together, before any of them is made.

    A few lines can show one mesh a million times, or one row of corners in as many parts.
    """
    counts: dict[int, tuple[int, int, int]] = {}
    parts = vertices = corners = 0
    for _, mesh, _, _ in placed_meshes(gltf):
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
        version = str(decode_json(text, Headed).asset.version)
        if not version.startswith("2"):
            raise FormatError(f"This is glTF {version[:9]}; only glTF 2 can be read.")
        gltf: Gltf = decode_json(text, Gltf)
    except (msgspec.MsgspecError, RecursionError, UnicodeDecodeError) as error:
        raise FormatError(f"Its description cannot be understood: {words_of(error)}.") from error
    missing = [
        name
        for name in gltf.extensions_required
        if name not in (DRACO, INSTANCING) and not name.startswith(HARMLESS)
    ]
    if missing:
        packed = all("compression" in name for name in missing)
        raise FormatError(
            f"It needs {', '.join(missing)[:200]}, which cannot be read. Export it again "
            f"without {'compression' if packed else 'that extension'}."
        )
    return gltf


def _buffers(gltf: Gltf, blob: bytes | None, reading: Reading) -> list[bytes]:
    """Return the bytes of all buffers; the first one of a `.glb` is its binary chunk."""
    at_most(len(gltf.buffers), MAX_BUFFERS, "buffers")
    found: list[bytes] = []
    size = 0
    for number, buffer in enumerate(gltf.buffers):
        if buffer.uri is not None:
            found.append(linked_bytes(buffer.uri, reading, "buffer"))
        else:
            found.append(blob or b"" if number == 0 else b"")
        size += len(found[-1])
        at_most(size, MAX_MESH_BYTES, "bytes in buffers")
    return found


def _tell(gltf: Gltf, reading: Reading, bodies: Skins) -> None:
    """Tell what is left out: pictures of relief and shine, motions, cameras, lights and so on."""
    relief = sum(
        one is not None
        for material in gltf.materials
        for one in (material.normal_texture, material.occlusion_texture, material.emissive_texture)
    )
    thin = sum(one.mode not in (TRIANGLES, STRIP, FAN) for mesh in gltf.meshes
               for one in mesh.primitives)  # fmt: skip
    morphs = sum(bool(one.targets) for mesh in gltf.meshes for one in mesh.primitives)
    levels = sum("MSFT_lod" in node.extensions for node in gltf.nodes)
    lights = sum(LIGHT in node.extensions for node in gltf.nodes)
    noted = [*(node.extras for node in gltf.nodes), *(mesh.extras for mesh in gltf.meshes)]
    tinted = sum(b'COLOR_0"' in bytes(node.extensions.get(INSTANCING, b"")) for node in gltf.nodes)
    notes = sum(isinstance(one, dict) and not one.keys() <= UNDERSTOOD for one in noted)
    if any(has_unused_places(gltf, one) for mesh in gltf.meshes for one in mesh.primitives):
        reading.tell_of_unused_places("glTF")
    for count, what, many, why in (
        (relief, "a picture of relief, shade or glow", "{} pictures of relief, shade or glow",
         "colours are kept"),
        (morphs, "the other forms of a part", "the other forms of {} parts", "its own is read"),
        (bodies.loose_motions, "a motion", "{} motions",
         "only those of bones are read; bind the parts to bones"),
        (levels, "the coarser levels of a part", "the coarser levels of {} parts",
         "the export makes them again"),
        (sum(node.camera is not None for node in gltf.nodes), "a camera", "{} cameras",
         "only shapes are read"),
        (tinted, "the colours of a part's copies", "the colours of {} parts' copies",
         "each has that of its material"),
        (lights, "a light", "{} lights", "only shapes are read"),
        (notes, "what is noted of a part besides", "what is noted of {} parts besides",
         "custom properties are not kept"),
        (thin, "a set of points or lines", "{} sets of points or lines", "they have no faces"),
    ):  # fmt: skip
        if count:
            words = what if count == 1 else many.format(count)
            reading.tell(f"Left out of the glTF file: {words} ({why}).")


def _surface(
    gltf: Gltf,
    blobs: Blobs,
    primitive: Primitive,
    shown: ShownMesh,
    follow: FollowedBones | None,
    pictures: Pictures,
) -> Surface | None:
    """Return one primitive in our axes; None for points and lines."""
    if primitive.mode not in (TRIANGLES, STRIP, FAN) or "POSITION" not in primitive.attributes:
        return None
    local = values_of(gltf, blobs, primitive.attributes["POSITION"], 3)
    check_places(local)
    skin = None if follow is None else follow.skin(primitive, len(local))
    matrix = shown.place.matrix if follow is None or skin is None else follow.change
    to_world = MM_PER_METRE * AXES.T @ matrix[:3, :3]
    places = local @ to_world.T + MM_PER_METRE * AXES.T @ matrix[:3, 3]
    order = np.arange(len(places))
    if primitive.indices is not None:
        if item(gltf.accessors, primitive.indices, "accessor").component_type == FLOAT:
            raise FormatError("Its indices are not whole numbers.")
        order = values_of(gltf, blobs, primitive.indices, 1)[:, 0].astype(np.int64)
    faces = without_degenerate(_faces(order, primitive.mode).astype(np.int64))
    if not len(faces):
        return None
    with np.errstate(all="ignore"):  # whose numbers may be extreme
        mirrored = np.linalg.det(to_world) < 0
    if mirrored:
        faces = faces[:, ::-1]
    colors = None
    if "COLOR_0" in primitive.attributes:
        linear = values_of(gltf, blobs, primitive.attributes["COLOR_0"], None)
        alpha = linear[:, 3:4] if linear.shape[1] == 4 else np.ones((len(linear), 1))
        opaque = np.rint(255 * np.clip(np.nan_to_num(alpha), 0, 1)).astype(np.uint8)
        colors = np.hstack((linear_to_srgb(linear[:, :3]), opaque))
    color = None
    mesh = checked_mesh(places, faces, _normals(gltf, blobs, primitive, to_world), colors)
    material = _material(gltf, primitive)
    texture = pictures.texture(primitive, material, faces.astype(np.int64))
    factor = material.pbr_metallic_roughness.base_color_factor
    if texture is not None:
        mesh = replace(mesh, colors=None)
    elif factor is not None:
        red, green, blue = (int(v) for v in linear_to_srgb(factor[:3]))
        color = (red, green, blue)
    if skin is not None and skin.rig.is_posed:
        posed = skin.posed(mesh)
        check_places(posed.vertices)
        mesh, skin = posed, replace(skin, rest=mesh)
    return Surface(mesh, shown.name, color, texture=texture, skin=skin, path=shown.path)


def _normals(
    gltf: Gltf, blobs: Blobs, primitive: Primitive, to_world: NDArray[np.float64]
) -> NDArray[np.float64] | None:
    """Return unit normals in our axes; None where the file has none that can be used."""
    if "NORMAL" not in primitive.attributes:
        return None
    local = values_of(gltf, blobs, primitive.attributes["NORMAL"], 3)
    with np.errstate(all="ignore"):
        # Normals turn with the cofactors of the matrix, which exist where its inverse does not.
        a, b, c = to_world.T / MM_PER_METRE
        cofactors = np.column_stack((np.cross(b, c), np.cross(c, a), np.cross(a, b)))
        turned = local @ cofactors.T * np.sign(np.linalg.det(to_world))
        length = np.linalg.norm(turned, axis=1, keepdims=True)
        length[np.abs(length - 1.0) <= UNIT] = 1.0  # as it was written
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
