"""Strokes as raw columns and one row of facts each: the form in which files keep them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import islice, pairwise
from operator import attrgetter
from typing import Any, Final

import msgspec
import numpy as np
from numpy.typing import NDArray

from bozzetto.document.storage.zip_container import DTYPES, decode_json
from bozzetto.errors import DocumentError, UserError
from bozzetto.ink.stroke import COLUMNS, MAX_SAMPLES, Stroke, StrokeTool, frozen_column
from bozzetto.view.camera import Camera

MAX_STROKES: Final = 1_000_000
"""Most strokes in one file."""

JOINED_AT_ONCE: Final = 256
"""Strokes whose samples are gathered in one go."""


class _Row(msgspec.Struct, array_like=True, forbid_unknown_fields=True):
    """Facts about a stroke beside its samples."""

    camera: int
    tool: StrokeTool
    color: tuple[int, int, int] | None
    group: str
    has_pressure: bool
    has_time: bool


class _Sheet(msgspec.Struct):
    """``strokes.meta.json``: cameras are shared, one row per stroke."""

    cameras: list[Camera]
    strokes: list[_Row]


def pack_strokes(strokes: Sequence[Stroke]) -> tuple[object, dict[str, NDArray[Any]]]:
    """Return strokes as one list of facts and common columns.

    Returns
    -------
    meta : object
        Cameras and one row per stroke, to be written as JSON.
    columns : dict of str to array
        ``offsets`` (n + 1,) uint32, and the sample columns as float32, one after the
        other. Columns that no stroke has been given are left out.

    Raises
    ------
    UserError
        If there are more than `MAX_STROKES`.
    """
    if len(strokes) > MAX_STROKES:
        raise UserError(f"A document holds {MAX_STROKES} strokes at most. Save some on their own.")
    cameras: dict[Camera, int] = {}
    seen: dict[int, int] = {}  # by identity first: hashing a camera takes a microsecond
    for stroke in strokes:
        if id(stroke.camera) not in seen:
            seen[id(stroke.camera)] = cameras.setdefault(stroke.camera, len(cameras))
    rows = [
        _Row(
            seen[id(stroke.camera)],
            stroke.tool,
            stroke.color,
            stroke.group,
            stroke.has_pressure,
            stroke.has_time,
        )
        for stroke in strokes
    ]
    counts = np.fromiter((stroke.x.size for stroke in strokes), np.uint32, len(strokes))
    offsets = np.concatenate(([0], np.cumsum(counts))).astype(np.uint32)
    columns: dict[str, NDArray[Any]] = {"offsets": offsets}
    always = {"x", "y"}
    always |= {"pressure"} if any(row.has_pressure for row in rows) else set()
    always |= {"t"} if any(row.has_time for row in rows) else set()
    # One block for all columns: the system hands out large pages for it.
    block = np.empty((len(COLUMNS), int(offsets[-1])), np.float32)
    for name in COLUMNS if strokes else ():
        if name in always or name not in ("pressure", "t"):
            column = block[len(columns) - 1]
            _gather(map(attrgetter(name), strokes), column)
            if name in always or column.any():
                columns[name] = column
    return _Sheet(list(cameras), rows), columns


def _gather(parts: Iterator[Any], column: NDArray[np.float32]) -> None:
    """Concatenate the strokes' parts of a column."""
    end = 0
    # Joined as bytes, in pieces that stay in the cache: half the time of numpy's concatenate.
    while piece := b"".join(islice(parts, JOINED_AT_ONCE)):
        values = np.frombuffer(piece, np.float32)
        column[end : end + len(values)] = values
        end += len(values)


def unpack_strokes(meta: bytes, columns: Mapping[str, NDArray[Any]]) -> list[Stroke]:
    """Return the strokes that `pack_strokes` took apart; the columns are shared, not copied.

    Parameters
    ----------
    meta : bytes
        The JSON.
    columns : mapping of str to array
        Already checked to be finite, of one axis, and backed by ``bytes``.

    Raises
    ------
    DocumentError
        If anything does not fit together.
    """
    sheet = decode_json(meta, _Sheet)
    count = len(sheet.strokes)
    if count > MAX_STROKES:
        raise DocumentError(f"This document has {count} strokes; at most {MAX_STROKES} are read.")
    starts = _starts(columns, count)
    for row in sheet.strokes:
        if not 0 <= row.camera < len(sheet.cameras):
            raise DocumentError("This document has a stroke without a camera.")
        if row.color is not None and not all(0 <= c <= 255 for c in row.color):
            raise DocumentError("This document has a stroke of an impossible colour.")
    pairs = list(pairwise(starts))
    known = {
        "pressure": [row.has_pressure for row in sheet.strokes],
        "t": [row.has_time for row in sheet.strokes],
    }
    sliced = [_sliced(columns.get(name), name, pairs, known.get(name)) for name in COLUMNS]
    return [
        Stroke.from_columns(
            parts,
            sheet.cameras[row.camera],
            row.tool,
            row.color,
            row.group,
            row.has_pressure,
            row.has_time,
        )
        for row, parts in zip(sheet.strokes, zip(*sliced, strict=True), strict=True)
    ]


def _sliced(
    column: NDArray[Any] | None,
    name: str,
    pairs: Sequence[tuple[int, int]],
    known: Sequence[bool] | None,
) -> list[NDArray[np.float32]]:
    """Return each stroke's part of a column; where it has none, its length of the default value."""
    if column is not None and (known is None or all(known)):
        return [column[start:end] for start, end in pairs]
    fill = _Constant(0.5 if name == "pressure" else 0.0)
    if column is None or known is None:
        return [fill(end - start) for start, end in pairs]
    return [
        column[start:end] if given else fill(end - start)
        for (start, end), given in zip(pairs, known, strict=True)
    ]


class _Constant:
    """Columns of one value, shared by all strokes of one length."""

    def __init__(self, value: float) -> None:
        self._value = value
        self._made: dict[int, NDArray[np.float32]] = {}

    def __call__(self, count: int) -> NDArray[np.float32]:
        if count not in self._made:
            self._made[count] = frozen_column(np.full(count, self._value, np.float32))
        return self._made[count]


def _starts(columns: Mapping[str, NDArray[Any]], count: int) -> list[int]:
    """Return where each stroke starts in the columns, and where the last one ends."""
    offsets = columns.get("offsets")
    if offsets is None or offsets.dtype != DTYPES["u4"] or offsets.shape != (count + 1,):
        raise DocumentError("This document's strokes have no usable list of lengths.")
    lengths = np.diff(offsets.astype(np.int64))
    if offsets[0] != 0 or (lengths < 1).any() or (lengths > MAX_SAMPLES).any():
        raise DocumentError("This document has a stroke of an impossible length.")
    if count and not {"x", "y"} <= columns.keys():
        raise DocumentError("This document has strokes without positions.")
    for name in columns.keys() & set(COLUMNS):
        if columns[name].dtype != DTYPES["f4"] or columns[name].shape != (offsets[-1],):
            raise DocumentError(f"This document's column {name} does not fit its strokes.")
    starts: list[int] = offsets.tolist()
    return starts
