"""Meshes of a glTF file that Draco has compressed (KHR_draco_mesh_compression), unpacked.

Their accessors name no buffer view. They get one of what Draco gives back, so that all others
read them like those of any file. Decoded by DracoPy, the extra ``bozzetto[draco]``, in the process
that reads the file and whose time and memory are limited.
"""

from __future__ import annotations

from typing import Any, Final

import msgspec
import numpy as np

from bozzetto.errors import FormatError, UserError, words_of
from bozzetto.exchange.limits import MAX_FACES, MAX_VERTICES, at_most
from bozzetto.exchange.mesh.gltf_scene import (
    TRIANGLES,
    Accessor,
    Gltf,
    Primitive,
    Record,
    View,
    item,
)
from bozzetto.exchange.mesh.gltf_values import COMPONENTS, WIDTHS, Blobs, view_bytes
from bozzetto.exchange.optional_libraries import library
from bozzetto.typed_data import decode_json

__all__ = ["DRACO", "unpack"]

DRACO: Final = "KHR_draco_mesh_compression"

UNSIGNED_INT: Final = 5125
"""Component type of numbers of 32 bits."""


class Packed(Record):
    """Where the compressed mesh of a primitive is, and its own numbers of the attributes."""

    buffer_view: int
    attributes: dict[str, int] = msgspec.field(default_factory=dict)


def unpack(gltf: Gltf, blobs: Blobs) -> None:
    """Unpack the compressed meshes of a file, in place: one more buffer, and views of it.

    Where the library is not installed and the file does not need it, its other copy of the
    meshes stays.

    Parameters
    ----------
    gltf : Gltf
        The file's description; its accessors get views.
    blobs : list of bytes
        The file's buffers.

    Raises
    ------
    UserError
        If the file needs DracoPy, which is not installed.
    FormatError
        If a mesh is damaged, or is not as the file says.
    """
    packed = [
        (primitive, raw)
        for mesh in gltf.meshes
        for primitive in mesh.primitives
        for raw in (primitive.extensions.get(DRACO),)
        if raw is not None
    ]
    if not packed:
        return
    try:
        draco = library("DracoPy", "draco")
    except UserError as error:
        if DRACO not in gltf.extensions_required:
            return
        raise UserError(f"{error.message}, or export the file again without compression.") from None
    known: dict[int, Any] = {}
    made = bytearray()
    for primitive, raw in packed:
        _unpack(gltf, blobs, primitive, _record(raw), draco, known, made)
    blobs.append(bytes(made))


def _record(raw: msgspec.Raw) -> Packed:
    try:
        packed: Packed = decode_json(raw, Packed)
        return packed
    except msgspec.MsgspecError as error:
        raise FormatError(f"A compressed mesh cannot be understood: {words_of(error)}.") from None


def _unpack(
    gltf: Gltf, blobs: Blobs, primitive: Primitive, packed: Packed, draco: Any,
    known: dict[int, Any], made: bytearray,
) -> None:  # fmt: skip
    """Give the accessors of a primitive views of what was compressed, which goes to `made`."""
    if packed.buffer_view not in known:
        known[packed.buffer_view] = _decoded(draco, view_bytes(gltf, blobs, packed.buffer_view))
    mesh = known[packed.buffer_view]
    by_number = {one["unique_id"]: np.asarray(one["data"]) for one in mesh.attributes}

    def put(accessor: Accessor, values: np.ndarray[Any, Any]) -> None:
        kind, width = COMPONENTS.get(accessor.component_type), WIDTHS.get(accessor.type)
        if kind is None or width is None or values.shape != (accessor.count, width):
            raise FormatError("A compressed mesh is not as the file says. Export it again.")
        content = values.astype(kind).tobytes()
        accessor.buffer_view, accessor.byte_offset = len(gltf.buffer_views), 0
        gltf.buffer_views.append(View(len(content), len(blobs), len(made)))
        made.extend(content + b"\0" * (-len(content) % 4))

    for name, number in packed.attributes.items():
        if name in primitive.attributes:
            if number not in by_number:
                raise FormatError(f"A compressed mesh has no {name[:40]}. Export it again.")
            put(item(gltf.accessors, primitive.attributes[name], "accessor"), by_number[number])
    faces = np.asarray(mesh.faces, np.uint32).reshape(-1, 1)
    if primitive.indices is None:
        primitive.indices = len(gltf.accessors)
        gltf.accessors.append(Accessor(UNSIGNED_INT, len(faces), "SCALAR"))
    indices: Accessor = item(gltf.accessors, primitive.indices, "accessor")
    indices.component_type = UNSIGNED_INT
    put(indices, faces)
    primitive.mode = TRIANGLES  # whatever order Draco had them in


def _decoded(draco: Any, content: bytes) -> Any:
    try:
        mesh = draco.decode(content)
        at_most(len(mesh.points), MAX_VERTICES, "vertices")
        at_most(len(mesh.faces), MAX_FACES, "triangles")
    except FormatError:
        raise
    except Exception as error:
        # The library has exceptions of several kinds for what is no mesh of Draco.
        raise FormatError("A compressed mesh is damaged. Export the file again.") from error
    return mesh
