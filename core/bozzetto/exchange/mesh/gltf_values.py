"""Numbers of a glTF file: what its accessors and buffer views say that the buffers hold."""

from __future__ import annotations

from typing import Final

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from bozzetto.errors import FormatError
from bozzetto.exchange.limits import MAX_FACES, at_most
from bozzetto.exchange.mesh.gltf_scene import Accessor, Gltf, Rows, View, item

COMPONENTS: Final = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS: Final = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}

Blobs = list[bytes]


def values_of(gltf: Gltf, blobs: Blobs, index: int, width: int | None) -> NDArray[np.float64]:
    """Return the values of an accessor, (n, width); integers are scaled only if normalised.

    A sparse accessor (glTF 2.0, section 3.6.2.3) holds the values of its view, zeros without
    one, but for those that it names.

    Raises
    ------
    FormatError
        If it is damaged, or of another width.
    """
    accessor: Accessor = item(gltf.accessors, index, "accessor")
    columns = WIDTHS.get(accessor.type, 0)
    if accessor.component_type not in COMPONENTS or columns != (width or columns) or not columns:
        raise FormatError(f"Accessor {index} is of a type that does not fit its use.")
    if columns < 3 and width is None:
        raise FormatError(f"Accessor {index} has too few components for a colour.")
    at_most(accessor.count, 3 * MAX_FACES, "values")
    if accessor.count < 0:
        raise FormatError(f"Accessor {index} has a size below zero.")
    rows = Rows(accessor.buffer_view, accessor.byte_offset, accessor.component_type)
    if accessor.buffer_view is None:
        at_most(accessor.count * columns, MAX_FACES, "values that are not in the file")
        values = np.zeros((accessor.count, columns))
    else:
        values = _stored(gltf, blobs, rows, accessor.count, columns)
    if accessor.sparse is not None:
        count = accessor.sparse.count
        if not 0 <= count <= accessor.count:
            raise FormatError(f"Accessor {index} names more values than it holds.")
        at = _stored(gltf, blobs, accessor.sparse.indices, count, 1)[:, 0]
        if not (at < accessor.count).all():
            raise FormatError(f"Accessor {index} names a value that it does not hold.")
        named = replace(accessor.sparse.values, component_type=accessor.component_type)
        values[at.astype(np.int64)] = _stored(gltf, blobs, named, count, columns)
    kind = np.dtype(COMPONENTS[accessor.component_type])
    if accessor.normalized and kind.kind != "f":
        values = np.maximum(values / np.iinfo(kind).max, -1.0)
    return values


def _stored(gltf: Gltf, blobs: Blobs, rows: Rows, count: int, columns: int) -> NDArray[np.float64]:
    """Return rows of numbers that lie in a buffer view, (count, columns), not scaled."""
    kind = COMPONENTS.get(rows.component_type)
    if kind is None or rows.buffer_view is None:
        raise FormatError("Its accessors name numbers of a kind that glTF does not know.")
    view: View = item(gltf.buffer_views, rows.buffer_view, "buffer view")
    blob: bytes = item(blobs, view.buffer, "buffer")
    dtype = np.dtype(kind)
    stride = view.byte_stride or dtype.itemsize * columns
    begin = view.byte_offset + rows.byte_offset
    end = begin + stride * (count - 1) + dtype.itemsize * columns
    if stride < dtype.itemsize * columns:
        raise FormatError("A buffer view has a stride below the size of its values.")
    if min(view.byte_offset, rows.byte_offset) < 0:
        raise FormatError("A buffer view has an offset below zero.")
    if count == 0:
        return np.zeros((0, columns))
    if end > min(len(blob), view.byte_offset + view.byte_length):
        raise FormatError("This glTF file is damaged or cut short.")
    raw = np.ndarray((count, columns), dtype, blob, begin, (stride, dtype.itemsize))
    with np.errstate(invalid="ignore"):  # signalling NaNs; refused later
        return raw.astype(np.float64)


def view_bytes(gltf: Gltf, blobs: Blobs, index: int) -> bytes:
    """Return the bytes of a buffer view.

    Raises
    ------
    FormatError
        If there are fewer.
    """
    view: View = item(gltf.buffer_views, index, "buffer view")
    blob: bytes = item(blobs, view.buffer, "buffer")
    end = view.byte_offset + view.byte_length
    if min(view.byte_offset, view.byte_length) < 0 or end > len(blob):
        raise FormatError("This glTF file is damaged or cut short.")
    return blob[view.byte_offset : end]
