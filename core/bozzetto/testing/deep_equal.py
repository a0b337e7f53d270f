"""Deep comparison of values, down to the bytes of their arrays."""

from __future__ import annotations

import dataclasses
import hashlib
from typing import Any

import numpy as np

from bozzetto.ink.stroke import Stroke, Strokes


def same(one: Any, other: Any) -> bool:
    """Compare states, shapes or scenes deeply.

    Dataclasses are compared field by field, whatever their own ``==`` says; arrays by
    type, shape and bytes; numbers and texts with their types. A layer's `revision` does
    not count.
    """
    return fingerprint(one) == fingerprint(other)


def difference(one: Any, other: Any, where: str) -> str:
    """Say where two values are not the `same`, and how; "" if they are."""
    if same(one, other):
        return ""
    if type(one) is type(other):
        if dataclasses.is_dataclass(one) and not isinstance(one, Stroke):
            parts = [(f".{entry.name}", entry.name) for entry in dataclasses.fields(one)]
            pairs = [(at, getattr(one, name), getattr(other, name)) for at, name in parts]
        elif isinstance(one, tuple | list) and len(one) == len(other):
            pairs = [(f"[{i}]", *both) for i, both in enumerate(zip(one, other, strict=True))]
        else:
            pairs = []
        found = [difference(this, that, where + at) for at, this, that in pairs]
        return next((text for text in found if text), f"{where} differs")
    return f"{where}: {type(one).__name__} became {type(other).__name__}"


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
