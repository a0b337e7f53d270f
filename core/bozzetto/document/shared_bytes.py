"""Bytes that two snapshots do not share, found by identity."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from typing import Any, Final

import numpy as np

from bozzetto.chunked import Chunked
from bozzetto.ink.stroke import Stroke

OBJECT_BYTES: Final = 96
"""Bytes of an object beside its arrays and texts: pointers, counts, small numbers."""


def difference(before: Any, after: Any) -> tuple[int, int]:
    """Return the bytes reachable only from one and only from the other of two values.

    Values are snapshots made of frozen dataclasses, tuples, chunked sequences, strokes and
    arrays. What is one object in both is not looked into, so the cost follows the change
    and not the document. Something that moved to another place counts on both sides: the
    numbers are upper bounds.

    Returns
    -------
    removed, added : int
    """
    if before is after:
        return 0, 0
    if isinstance(before, Chunked) and isinstance(after, Chunked):
        old, new = _apart(before.chunks, after.chunks)
        old, new = _apart(*([item for chunk in side for item in chunk] for side in (old, new)))
        return _pairs(old, new)
    if isinstance(before, tuple) and isinstance(after, tuple):
        return _pairs(*_apart(before, after))
    if type(before) is type(after) and dataclasses.is_dataclass(before):
        names = [field.name for field in dataclasses.fields(before)]
        removed, added = _pairs(*([getattr(v, name) for name in names] for v in (before, after)))
        return removed + OBJECT_BYTES, added + OBJECT_BYTES
    return _size(before), _size(after)


def _apart(before: Iterable[Any], after: Iterable[Any]) -> tuple[list[Any], list[Any]]:
    """Return what is in one row and not in the other, in order."""
    before, after = tuple(before), tuple(after)
    shared = {id(item) for item in before} & {id(item) for item in after}
    return (
        [item for item in before if id(item) not in shared],
        [item for item in after if id(item) not in shared],
    )


def _pairs(before: list[Any], after: list[Any]) -> tuple[int, int]:
    """Return the differences of rows whose items correspond as far as both go."""
    both = min(len(before), len(after))
    totals = [difference(a, b) for a, b in zip(before, after, strict=False)]
    removed = sum(r for r, _ in totals) + sum(map(_size, before[both:]))
    added = sum(a for _, a in totals) + sum(map(_size, after[both:]))
    return removed, added


def _size(value: Any) -> int:
    """Return the bytes of a value and all that it holds."""
    if isinstance(value, np.ndarray | Stroke):
        return value.nbytes + OBJECT_BYTES
    if isinstance(value, bytes | str):
        return len(value) + OBJECT_BYTES
    if isinstance(value, Chunked | tuple):
        return sum(map(_size, value), OBJECT_BYTES)
    if dataclasses.is_dataclass(value):
        return sum(
            (_size(getattr(value, field.name)) for field in dataclasses.fields(value)),
            OBJECT_BYTES,
        )
    return OBJECT_BYTES // 4
