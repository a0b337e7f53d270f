"""Whether two values are the same all through, down to the bytes of their arrays."""

from __future__ import annotations

import dataclasses
import hashlib
from typing import Any

import numpy as np

from bozzetto.ink.stroke import Stroke, Strokes

__all__ = ["fingerprint", "same"]


def same(one: Any, other: Any) -> bool:
    """Compare states, shapes or scenes deeply.

    Dataclasses are compared field by field, whatever their own ``==`` says; arrays by
    type, shape and bytes; numbers and texts with their types. A layer's `revision` does
    not count.
    """
    return fingerprint(one) == fingerprint(other)


def fingerprint(value: Any) -> str:
    """Name the content of a state, shapes or a scene; the same in every process."""
    digest = hashlib.blake2b(digest_size=16)
    _feed(digest, value)
    return digest.hexdigest()


def _feed(digest: hashlib.blake2b, value: Any) -> None:
    digest.update(f"{type(value).__qualname__}:".encode())
    if isinstance(value, np.ndarray):
        digest.update(f"{value.dtype}{value.shape}".encode())
        digest.update(value.tobytes())
    elif isinstance(value, Stroke):
        digest.update(value.digest)
    elif dataclasses.is_dataclass(value):
        for entry in dataclasses.fields(value):
            if entry.name != "revision":
                _feed(digest, getattr(value, entry.name))
    elif isinstance(value, tuple | list | Strokes):
        digest.update(f"{len(value)}:".encode())
        for part in value:
            _feed(digest, part)
    elif isinstance(value, dict):
        _feed(digest, sorted(value.items(), key=repr))
    else:
        text = repr(value).encode("utf-8", "surrogatepass")
        digest.update(b"%d:%b" % (len(text), text))
