"""Arrays: names of their types, and copies that stay as they are, backed by immutable memory."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

__all__ = ["Array", "Bytes", "Faces", "Flags", "Floats", "Index", "cross_product", "frozen"]

Array = NDArray[np.float64]
"""Numbers of double precision: what is computed with."""

Floats = NDArray[np.float32]
"""Numbers of single precision: what is shown, and the vertices of meshes."""

Index = NDArray[np.intp]
"""Numbers of items."""

Flags = NDArray[np.bool_]
"""Yes or no for each item."""

Faces = NDArray[np.int32]
"""Numbers of the three corners of each triangle."""

Bytes = NDArray[np.uint8]
"""Bytes, such as the channels of pixels."""


_AHEAD: Final = np.array((1, 2, 0))
_BEHIND: Final = np.array((2, 0, 1))


def cross_product(one: Array, other: Array) -> Array:
    """Return cross products of vectors (..., 3), to the last bit those of `numpy.cross`.

    That spends twenty times as long on checks of shapes as on a few products.
    """
    ahead = one.take(_AHEAD, -1) * other.take(_BEHIND, -1)
    return np.asarray(ahead - one.take(_BEHIND, -1) * other.take(_AHEAD, -1))


def frozen(values: ArrayLike, dtype: DTypeLike, columns: int | None = None) -> NDArray[Any]:
    """Return values as an array nobody can write to, copying only where needed.

    Parameters
    ----------
    values : array_like
        Numbers; they are copied only where needed.
    dtype : dtype
        float32, float64, int32, uint32, uint16 or uint8.
    columns : int, optional
        The shape is (n, columns) then.

    Raises
    ------
    ValueError
        If the shape does not fit, or a float is not finite.
    """
    array = np.asarray(values)
    if columns is not None:
        array = array.reshape(-1, columns) if array.size else np.zeros((0, columns), dtype)
    kind = np.dtype(dtype)
    if array.dtype == kind and _is_immutable(_root(array)) and array.flags.c_contiguous:
        return array
    made = np.frombuffer(np.ascontiguousarray(array, kind).tobytes(), kind).reshape(array.shape)
    if kind.kind == "f" and not np.isfinite(made).all():
        raise ValueError("an array holds values that are not finite")
    return made


def _is_immutable(memory: object) -> bool:
    """Whether memory cannot be written to: ``bytes``, or a read-only view of a file's content."""
    return isinstance(memory, bytes) or (isinstance(memory, memoryview) and memory.readonly)


def _root(array: NDArray[Any]) -> object:
    owner: object = array
    while isinstance(owner, np.ndarray):
        owner = owner.base
    return owner
