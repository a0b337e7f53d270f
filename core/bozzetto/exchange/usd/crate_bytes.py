"""Bytes of USD's binary form: numbers at places, LZ4 blocks, and integers of few bits.

LZ4 is that of Y. Collet, *LZ4 Block Format Description*; what is compressed by it begins with the
number of its chunks, 0 for a single one. Integers are differences to the one before: two bits for
each say how many bytes its difference takes, or that it is the most frequent one.
"""

from __future__ import annotations

import struct
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.errors import FormatError
from bozzetto.exchange.limits import MAX_MESH_BYTES, at_most

CHUNK: Final = 0x7E000000
"""Bytes that one chunk of LZ4 holds at most."""

MAX_NUMBERS: Final = 60_000_000
"""Of one array: three for each of as many vertices as a file may hold."""

WIDTHS: Final = {4: np.array([0, 1, 2, 4]), 8: np.array([0, 2, 4, 8])}
"""Bytes of a difference by its two bits, for integers of four and of eight bytes."""


def damaged() -> FormatError:
    """Return what is raised where bytes make no sense."""
    return FormatError("It is damaged or cut short. Save it again where it was made.")


class Cursor:
    """A place in some bytes, from where on they are read."""

    def __init__(self, data: bytes, at: int = 0) -> None:
        self.data, self.at = data, at

    def take(self, count: int) -> bytes:
        """Return so many bytes.

        Raises
        ------
        FormatError
            If there are not as many; so do all others.
        """
        if not 0 <= self.at <= self.at + count <= len(self.data):
            raise damaged()
        self.at += count
        return self.data[self.at - count : self.at]

    def numbers(self, form: str) -> tuple[Any, ...]:
        """Return numbers as a format of `struct` says, little-endian."""
        return struct.unpack(f"<{form}", self.take(struct.calcsize(f"<{form}")))

    def count(self, of: str, most: int = MAX_NUMBERS) -> int:
        """Return a count that stands here in eight bytes, if it is no larger than allowed."""
        (found,) = self.numbers("Q")
        at_most(found, most, of)
        return int(found)

    def array(self, dtype: str, count: int) -> NDArray[Any]:
        """Return numbers of a kind, such as "<f4"."""
        at_most(count, MAX_NUMBERS, "numbers")
        return np.frombuffer(self.take(count * np.dtype(dtype).itemsize), dtype)

    def packed(self, size: int) -> bytes:
        """Return what is compressed here, in as many bytes as stand before it."""
        return unpacked(self.take(self.count("bytes", len(self.data))), size)

    def integers(self, count: int, width: int = 4) -> NDArray[np.int64]:
        """Return compressed integers of four or eight bytes each."""
        at_most(count, MAX_NUMBERS, "numbers")
        most = width + (2 * count + 7) // 8 + width * count
        return integers(self.packed(most), count, width)


def unpacked(packed: bytes, most: int) -> bytes:
    """Return the content of compressed bytes, which has no more than `most` bytes."""
    at_most(most, MAX_MESH_BYTES, "bytes")
    if not packed:
        raise damaged()
    if packed[0] == 0:
        return lz4_block(packed[1:], most)
    cursor, found = Cursor(packed, 1), bytearray()
    for _ in range(packed[0]):
        (size,) = cursor.numbers("i")
        found += lz4_block(cursor.take(size), min(CHUNK, most - len(found)))
    return bytes(found)


def lz4_block(packed: bytes, most: int) -> bytes:
    """Return the content of a block: in turn bytes as they are, and copies of what came before."""
    found = bytearray()
    at, end = 0, len(packed)
    try:
        while at < end:
            token = packed[at]
            at += 1
            size = token >> 4
            if size == 15:
                while packed[at] == 255:
                    size += 255
                    at += 1
                size += packed[at]
                at += 1
            found += packed[at : at + size]
            at += size
            if at >= end:
                break
            back = packed[at] | packed[at + 1] << 8
            at += 2
            size = (token & 15) + 4
            if size == 19:
                while packed[at] == 255:
                    size += 255
                    at += 1
                size += packed[at]
                at += 1
            begin = len(found) - back
            if back == 0 or begin < 0 or len(found) + size > most:
                raise damaged()
            if back >= size:
                found += found[begin : begin + size]
            else:  # it repeats itself
                found += (found[begin:] * (size // back + 1))[:size]
    except IndexError:
        raise damaged() from None
    if at > end or len(found) > most:
        raise damaged()
    return bytes(found)


def integers(data: bytes, count: int, width: int) -> NDArray[np.int64]:
    """Return integers of so many bytes that are told by their differences, (count,)."""
    cursor = Cursor(data)
    if not count:
        return np.zeros(0, np.int64)
    common = int(np.frombuffer(cursor.take(width), f"<i{width}")[0])
    bits = np.frombuffer(cursor.take((2 * count + 7) // 8), np.uint8)
    codes = (bits[:, None] >> np.array([0, 2, 4, 6], np.uint8) & 3).ravel()[:count]
    sizes = WIDTHS[width][codes]
    begins = np.cumsum(sizes) - sizes
    body = np.frombuffer(cursor.take(int(sizes.sum())), np.uint8)
    steps = np.full(count, common, np.int64)
    for code, size in enumerate(WIDTHS[width].tolist()):
        if code:
            which = np.flatnonzero(codes == code)
            rows = body[begins[which, None] + np.arange(size)]
            steps[which] = np.ascontiguousarray(rows).view(f"<i{size}")[:, 0]
    total = np.cumsum(steps)
    return total if width == 8 else total.astype(np.int32).astype(np.int64)
