"""Whether two values are the same all through, down to the bytes of their arrays."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from bozzetto.ink.stroke import Strokes

__all__ = ["same"]


def same(one: Any, other: Any) -> bool:
    """Compare states, results, shapes or scenes deeply.

    Dataclasses are compared field by field, whatever their own ``==`` says; arrays by
    type, shape and bytes. A layer's `revision` does not count.
    """
    if type(one) is not type(other):
        return False
    if isinstance(one, np.ndarray):
        alike = one.dtype == other.dtype and one.shape == other.shape
        return bool(alike and one.tobytes() == other.tobytes())
    if dataclasses.is_dataclass(one):
        return all(
            same(getattr(one, entry.name), getattr(other, entry.name))
            for entry in dataclasses.fields(one)
            if entry.name != "revision"
        )
    if isinstance(one, tuple | list | Strokes):
        return len(one) == len(other) and all(map(same, one, other))
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(same(one[key], other[key]) for key in one)
    return bool(one == other)
