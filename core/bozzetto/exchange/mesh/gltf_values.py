"""Numbers of a glTF file: what its accessors and buffer views say that the buffers hold."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.errors import FormatError
from bozzetto.exchange.limits import MAX_FACES, at_most
from bozzetto.exchange.mesh.gltf_scene import Accessor, Gltf, View, item

COMPONENTS: Final = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS: Final = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}

Blobs = list[bytes]


def values_of(gltf: Gltf, blobs: Blobs, index: int, width: int | None) -> NDArray[np.float64]:
    """Return the values of an accessor, (n, width); integers are scaled only if normalised.

    Raises
    ------
    FormatError
        If it is damaged, of another width, or sparse.
    """
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
