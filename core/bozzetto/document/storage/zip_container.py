"""The container: a zip whose entries are checked before any of them is read.

Written with all entries STORED, so that arrays lie in the file as they lie in memory, and
are read without being copied. The few dozen lines below are stricter than a general zip
reader, which trusts the directory's sizes, lets entries overlap, and has a dozen ways to
fail; here there is one, `DocumentError`. Zip files made by other programs from the same
entries (deflated, in another order) are read as well.

Source: PKWARE, .ZIP File Format Specification 6.3.10, sections 4.3 and 4.4.
"""

from __future__ import annotations

import math
import struct
import zlib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, BinaryIO, Final, TypeVar

import msgspec
import numpy as np
from numpy.typing import NDArray

from bozzetto import typed_data
from bozzetto.errors import DocumentError, UserError, words_of
from bozzetto.json_size import json_values

DTYPES: Final[dict[str, np.dtype[Any]]] = {
    "f4": np.dtype("<f4"),
    "f8": np.dtype("<f8"),
    "i4": np.dtype("<i4"),
    "u4": np.dtype("<u4"),
    "u1": np.dtype("u1"),
}
"""Element types of stored arrays, by the name that files use."""

MAX_FILE_BYTES: Final = 2**31 - 1
"""Longest file read or written: offsets stay below the zip format's first limit."""
MAX_CONTENT_BYTES: Final = 2**31 - 1
"""Most bytes of all entries together, unpacked."""
MAX_RATIO: Final = 200
"""Largest unpacked size over packed size of an entry …"""
RATIO_FLOOR: Final = 4096
"""… where a packed size below this (bytes) counts as this."""
MAX_GROWTH: Final = 192 << 20
"""Most bytes by which all entries together may grow where they are unpacked; ours do not."""
MAX_ENTRIES: Final = 60_000
"""Most entries; the zip format's first limit is 65,535."""
MAX_NAME_BYTES: Final = 512
"""Longest name of an entry."""
MAX_JSON_BYTES: Final = 64 << 20
"""Longest JSON entry."""
MAX_LIST_VALUES: Final = 10_000_000
"""Most values in one JSON entry: a million strokes have eight million."""
MAX_AXES: Final = 4
"""Most axes of an array."""

ALIGNMENT: Final = 16
"""Arrays start at multiples of this in the file (bytes), as the processor likes them."""
PADDING_ID: Final = 0xD935
"""Extra field that holds the padding: the one Android's zipalign uses for the same."""

LOCAL: Final = struct.Struct("<4s5H3I2H")
CENTRAL: Final = struct.Struct("<4s6H3I5H2I")
END: Final = struct.Struct("<4s4H2IH")
LOCAL_SIGN, CENTRAL_SIGN, END_SIGN = b"PK\x03\x04", b"PK\x01\x02", b"PK\x05\x06"
STORED, DEFLATED = 0, 8
UTF8_FLAG: Final = 0x800
READABLE_FLAGS: Final = UTF8_FLAG | 0x8 | 0x6  # sizes after the data; deflate's level
EPOCH: Final = 0x21  # 1 January 1980: equal documents make equal files


Value = TypeVar("Value")
Content = bytes | memoryview


class Part(msgspec.Struct):
    """Declaration of an array in the manifest."""

    name: str
    dtype: str
    shape: tuple[int, ...]
    crc: int


def dtype_name(array: NDArray[Any]) -> str | None:
    """Return the name by which files call an array's element type, or None if they cannot."""
    return next((name for name, dtype in DTYPES.items() if array.dtype == dtype), None)


def all_finite(array: NDArray[Any]) -> bool:
    """Whether an array holds neither NaN nor infinity.

    The sum is NaN or infinite as soon as one value is, and takes half the time of looking
    at each; finite values whose sum overflows are looked at one by one.
    """
    if array.dtype.kind != "f":
        return True
    with np.errstate(over="ignore", invalid="ignore"):
        return bool(np.isfinite(array.sum()) or np.isfinite(array).all())


def encode_json(value: Any) -> bytes:
    """Encode structs and plain values as JSON; numpy's single numbers become Python's."""
    return msgspec.json.encode(value, enc_hook=_plain)


def _plain(value: Any) -> Any:
    if isinstance(value, np.generic):
        return value.item()
    raise NotImplementedError(f"a {type(value).__name__} cannot be written as JSON")


def decode_json(text: bytes, kind: type[Value]) -> Value:
    """Decode typed values from JSON.

    Raises
    ------
    DocumentError
        If the text is not JSON of this type, or holds more values than any document.
    """
    if json_values(text) > MAX_LIST_VALUES:
        raise DocumentError("This document's lists are longer than any document's.")
    with _refusing():
        decoded: Value = typed_data.decode_in_turns(text, kind)
    return decoded


def row_count(text: bytes) -> int:
    """Count the rows of a list in JSON without decoding them; raises as `decode_json`."""
    with _refusing():
        return len(typed_data.decode_json(text, list[msgspec.Raw]))


@contextmanager
def _refusing() -> Iterator[None]:
    """Turn what goes wrong with damaged JSON into a `DocumentError`."""
    try:
        yield
    except (msgspec.MsgspecError, UserError, ValueError, RecursionError) as problem:
        raise DocumentError(f"This document's lists are damaged: {words_of(problem)}.") from problem


def is_safe_name(name: str) -> bool:
    """Whether an entry's name stays inside its container on every system."""
    return (
        0 < len(name.encode("utf-8", "replace")) <= MAX_NAME_BYTES
        and name.isprintable()
        and not set(name) & set('\\:*?"<>|')
        and all(step not in ("", ".", "..") for step in name.split("/"))
    )


class ContainerWriter:
    """Entries to be written; nothing is copied until `write`.

    Parameters
    ----------
    first : tuple of str
        Names of the entries that the file begins with, in this order.

    Attributes
    ----------
    parts : list of Part
        The arrays so far, for the manifest.
    """

    def __init__(self, first: tuple[str, ...] = ()) -> None:
        self._first = first
        self.parts: list[Part] = []
        self._entries: dict[str, tuple[memoryview, int]] = {}
        self._bytes = 0

    def add(self, name: str, content: bytes | memoryview) -> int:
        """Add an entry and return its checksum.

        Raises
        ------
        UserError
            If the file would become too large to be read again.
        """
        if name in self._entries or not is_safe_name(name):
            raise ValueError(f"an entry cannot be called {name!r}, or there are two")
        view = memoryview(content).cast("B")
        crc = zlib.crc32(view)
        self._entries[name] = view, crc
        self._bytes += len(view) + 2 * (len(name.encode()) + CENTRAL.size + ALIGNMENT)
        if self._bytes > MAX_FILE_BYTES or len(self._entries) > MAX_ENTRIES:
            raise UserError(
                "This document is larger than a file may be (2 GB, or "
                f"{MAX_ENTRIES} parts). Save some of its objects as a document of their own."
            )
        return crc

    def __contains__(self, name: str) -> bool:
        return name in self._entries

    def add_json(self, name: str, value: object) -> None:
        """Add a list of the document as JSON.

        Raises
        ------
        UserError
            If it is too long to be read again.
        """
        text = encode_json(value)
        if len(text) > MAX_JSON_BYTES:
            raise UserError("This document has too many parts. Save some of them on their own.")
        self.add(name, text)

    def add_array(self, name: str, array: NDArray[Any]) -> str:
        """Add an array and return its entry's name, which ends in its element type."""
        dtype = dtype_name(array)
        if dtype is None:
            raise ValueError(f"{name}: an array of {array.dtype} cannot be stored")
        raw = np.ascontiguousarray(array, DTYPES[dtype])
        view = raw.reshape(-1).view(np.uint8).data if raw.size else memoryview(b"")
        entry = f"{name}.{dtype}"
        self.parts.append(Part(entry, dtype, array.shape, self.add(entry, view)))
        return entry

    def write(self, file: BinaryIO) -> None:
        """Write the container."""
        order = [*self._first, *(name for name in self._entries if name not in self._first)]
        directory = []
        place = 0
        for name in order:
            view, crc = self._entries[name]
            encoded = name.encode()
            flags = 0 if name.isascii() else UTF8_FLAG
            padding = -(place + LOCAL.size + len(encoded) + 4) % ALIGNMENT
            extra = struct.pack("<2H", PADDING_ID, padding) + bytes(padding)
            facts = (flags, STORED, 0, EPOCH, crc, len(view), len(view), len(encoded))
            head = LOCAL.pack(LOCAL_SIGN, 20, *facts, len(extra)) + encoded + extra
            entry = CENTRAL.pack(CENTRAL_SIGN, 0x0314, 20, *facts, 0, 0, 0, 0, 0o644 << 16, place)
            directory.append(entry + encoded)
            file.write(head)
            file.write(view)
            place += len(head) + len(view)
        listing = b"".join(directory)
        count = len(directory)
        file.write(listing)
        file.write(END.pack(END_SIGN, 0, 0, count, count, len(listing), place, 0))


@dataclass(frozen=True)
class _Entry:
    start: int
    packed: int
    size: int
    crc: int
    method: int


class ContainerReader:
    """A container whose directory has been checked.

    Parameters
    ----------
    data : bytes or read-only memoryview
        The whole file. Arrays that were STORED are views into it.

    Raises
    ------
    DocumentError
        If the directory is not beyond doubt.
    """

    def __init__(self, data: Content) -> None:
        self._data = data
        self._entries = _directory(data)
        self._parts: dict[str, Part] = {}
        self._unread = dict.fromkeys(self._entries)

    def __contains__(self, name: str) -> bool:
        return name in self._entries

    def unread(self) -> tuple[str, ...]:
        """Return the entries that nobody has read yet, in the order of the directory."""
        return tuple(self._unread)

    @property
    def arrays(self) -> tuple[str, ...]:
        """Entries that were declared as arrays, in that order."""
        return tuple(self._parts)

    def __len__(self) -> int:
        return len(self._entries)

    def declare(self, parts: Sequence[Part]) -> None:
        """Say which entries are arrays, as the manifest does."""
        self._parts = {part.name: part for part in parts}
        if len(self._parts) < len(parts):
            raise DocumentError("This document lists an array twice.")

    def read(self, name: str, limit: int = MAX_CONTENT_BYTES) -> bytes:
        """Return an entry's content.

        Raises
        ------
        DocumentError
            If there is no such entry, it is longer than `limit`, or its checksum fails.
        """
        if self._entry(name).size > limit:
            raise DocumentError(f"This document's part {name} is longer than it can be.")
        return bytes(self._content(name))

    def json(self, name: str) -> bytes:
        """Return a JSON entry's text, of bounded length."""
        return self.read(name, MAX_JSON_BYTES)

    def array(self, name: str) -> NDArray[Any]:
        """Return a read-only array that was declared; finite if it is of floats."""
        part = self._parts.get(name)
        if part is None:
            raise DocumentError(f"This document's array {name} is of an unknown kind.")
        dtype = DTYPES.get(part.dtype)
        if dtype is None or len(part.shape) > MAX_AXES or any(n < 0 for n in part.shape):
            raise DocumentError(f"This document's array {name} is of an unknown kind.")
        entry = self._entry(name)
        count = math.prod(part.shape)
        if count * dtype.itemsize != entry.size or part.crc != entry.crc:
            raise DocumentError(f"This document's array {name} is not what its list says.")
        content = self._content(name)
        if entry.method == STORED and entry.start % dtype.itemsize == 0:
            array = np.frombuffer(self._data, dtype, count, entry.start)
        else:
            array = np.frombuffer(bytes(content), dtype, count)
        if not all_finite(array):
            raise DocumentError(f"This document's array {name} holds no finite numbers.")
        shaped: NDArray[Any] = array.reshape(part.shape)
        return shaped

    def _entry(self, name: str) -> _Entry:
        if name not in self._entries:
            raise DocumentError(f"This document lacks its part {name}.")
        return self._entries[name]

    def _content(self, name: str) -> Content:
        entry = self._entry(name)
        self._unread.pop(name, None)
        content: Content = memoryview(self._data)[entry.start : entry.start + entry.packed]
        if entry.method == DEFLATED:
            inflate = zlib.decompressobj(-zlib.MAX_WBITS)
            try:
                content = inflate.decompress(content, entry.size + 1)
            except zlib.error:
                raise DocumentError(f"This document's part {name} cannot be unpacked.") from None
        if len(content) != entry.size or zlib.crc32(content) != entry.crc:
            raise DocumentError(f"This document's part {name} is damaged. Open a backup of it.")
        return content


def _directory(data: Content) -> dict[str, _Entry]:
    """Read the entries of a file, none of which overlaps another or promises too much."""
    end = len(data) - END.size
    if not 0 <= end <= MAX_FILE_BYTES:
        raise DocumentError("This is not a Bozzetto document, or it was cut short.")
    sign, disk, other, here, count, length, start, comment = END.unpack_from(data, end)
    if sign != END_SIGN or disk or other or comment or here != count:
        raise DocumentError("This is not a Bozzetto document, or it was cut short.")
    if start + length != end or count > MAX_ENTRIES:
        raise DocumentError("This document's directory is damaged. Open a backup of it.")
    entries: dict[str, _Entry] = {}
    spans = [(start, end)]
    content = growth = 0
    place = start
    for _ in range(count):
        name, entry, local, place = _central(data, place, end)
        begins = _local(data, local, name, entry, start)
        spans.append((local, begins + entry.packed))
        content += entry.size
        growth += max(0, entry.size - entry.packed)
        if growth > MAX_GROWTH:
            raise DocumentError("This document unpacks to far more than its size allows.")
        if entry.size > MAX_RATIO * max(entry.packed, RATIO_FLOOR) or content > MAX_CONTENT_BYTES:
            raise DocumentError("This document unpacks to far more than its size allows.")
        if name.endswith("/") and not entry.size:
            continue  # a folder, as other zip programs note them
        if name in entries or not is_safe_name(name):
            raise DocumentError(f"This document has an entry of a forbidden name ({name!r}).")
        entries[name] = replace(entry, start=begins)
    if place != end:
        raise DocumentError("This document's directory is damaged. Open a backup of it.")
    spans.sort()
    if any(after < until for (_, until), (after, _) in pairwise(spans)):
        raise DocumentError("This document's parts overlap. It was made to do harm, or damaged.")
    return entries


def _central(data: Content, place: int, end: int) -> tuple[str, _Entry, int, int]:
    """Return name, entry, place of the local header, and place of the next record."""
    if place + CENTRAL.size > end:
        raise DocumentError("This document's directory is damaged. Open a backup of it.")
    record = CENTRAL.unpack_from(data, place)
    sign, _, _, flags, method, _, _, crc, packed, size = record[:10]
    name_length, extra, comment, disk, _, _, local = record[10:]
    begins = place + CENTRAL.size
    following = begins + name_length + extra + comment
    if sign != CENTRAL_SIGN or following > end or disk or flags & ~READABLE_FLAGS:
        raise DocumentError("This document's directory is damaged or encrypted.")
    if method not in (STORED, DEFLATED) or (method == STORED and packed != size):
        raise DocumentError("This document is packed in a way that is not known here.")
    try:
        name = bytes(data[begins : begins + name_length]).decode()
    except UnicodeDecodeError:
        raise DocumentError("This document has an entry of a forbidden name.") from None
    return name, _Entry(0, packed, size, crc, method), local, following


def _local(data: Content, place: int, name: str, entry: _Entry, end: int) -> int:
    """Return where an entry's content begins; its own header must agree with the directory."""
    begins = place + LOCAL.size
    if begins > end:
        raise DocumentError("This document's directory is damaged. Open a backup of it.")
    sign, _, _, method, _, _, _, _, _, name_length, extra = LOCAL.unpack_from(data, place)
    encoded = name.encode()
    if (
        sign != LOCAL_SIGN
        or method != entry.method
        or data[begins : begins + name_length] != encoded
        or begins + name_length + extra + entry.packed > end
    ):
        raise DocumentError("This document's directory is damaged. Open a backup of it.")
    return int(begins + name_length + extra)
