"""Numbers of a glTF file: what its accessors and buffer views say that the buffers hold."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.errors import FormatError
from bozzetto.exchange.limits import MAX_FACES, at_most
from bozzetto.exchange.mesh.gltf_scene import Accessor, Gltf, Sparse, View, item

COMPONENTS: Final = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS: Final = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}

Blobs = list[bytes]


def values_of(gltf: Gltf, blobs: Blobs, index: int, width: int | None) -> NDArray[np.float64]:
    """Return the values of an accessor, (n, width); integers are scaled only if normalised.

    Raises
    ------
    FormatError
        If it is damaged, or of another width.
    """
    accessor: Accessor = item(gltf.accessors, index, "accessor")
    kind = COMPONENTS.get(accessor.component_type)
    columns = WIDTHS.get(accessor.type)
    if kind is None or columns is None or (width is not None and columns != width):
        raise FormatError(f"Accessor {index} is of a type that does not fit its use.")
    if columns < 3 and width is None:
        raise FormatError(f"Accessor {index} has too few components for a colour.")
    at_most(accessor.count, 3 * MAX_FACES, "values")
    dtype, shape = np.dtype(kind), (accessor.count, columns)
    if min(accessor.count, accessor.byte_offset) < 0:
        raise FormatError(f"Accessor {index} has a size or an offset below zero.")
    if accessor.buffer_view is None:
        at_most(accessor.count * columns, MAX_FACES, "values that are not in the file")
        raw: NDArray[Any] = np.zeros(shape, dtype)
    else:
        raw = _rows(
            gltf, blobs, accessor.buffer_view, accessor.byte_offset, shape, dtype
        )  # fmt: skip
    if accessor.sparse is not None:
        raw = _with_apart(gltf, blobs, raw, accessor.sparse)
    with np.errstate(invalid="ignore"):  # signalling NaNs; refused later
        values = raw.astype(np.float64)
    if accessor.normalized and dtype.kind != "f":
        values = np.maximum(values / np.iinfo(dtype).max, -1.0)
    return values


def _rows(
    gltf: Gltf, blobs: Blobs, number: int, offset: int, shape: tuple[int, int], dtype: np.dtype[Any]
) -> NDArray[Any]:
    """Return rows of numbers as they stand in a buffer view."""
    view: View = item(gltf.buffer_views, number, "buffer view")
    blob: bytes = item(blobs, view.buffer, "buffer")
    count, columns = shape
    stride = view.byte_stride or dtype.itemsize * columns
    if stride < dtype.itemsize * columns:
        raise FormatError(f"Buffer view {number} has a stride below the size of its values.")
    if min(count, view.byte_offset, offset) < 0:
        raise FormatError(f"Buffer view {number} has a size or an offset below zero.")
    if count == 0:
        return np.zeros(shape, dtype)
    begin = view.byte_offset + offset
    end = begin + stride * (count - 1) + dtype.itemsize * columns
    if end > min(len(blob), view.byte_offset + view.byte_length):
        raise FormatError("This glTF file is damaged or cut short.")
    return np.ndarray(shape, dtype, blob, begin, (stride, dtype.itemsize))


def _with_apart(gltf: Gltf, blobs: Blobs, raw: NDArray[Any], sparse: Sparse) -> NDArray[Any]:
    """Return rows with those that stand apart in their places."""
    kind = COMPONENTS.get(sparse.indices.component_type, "")
    if kind not in ("<u1", "<u2", "<u4"):
        raise FormatError("Numbers of sparse values are of a type that does not fit their use.")
    if not 0 <= sparse.count <= len(raw):
        raise FormatError("There are more sparse values than values.")
    where, what = sparse.indices, sparse.values
    rows = _rows(
        gltf, blobs, where.buffer_view, where.byte_offset, (sparse.count, 1), np.dtype(kind)
    ).ravel()
    if len(rows) and int(rows.max()) >= len(raw):
        raise FormatError("A sparse value belongs to none of the values.")
    shape = (sparse.count, raw.shape[1])
    filled = raw.copy()
    filled[rows] = _rows(gltf, blobs, what.buffer_view, what.byte_offset, shape, raw.dtype)
    return filled


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
