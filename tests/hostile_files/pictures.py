"""Hostile files: pictures."""

from __future__ import annotations

import io
import math
import struct
import zlib

from tests.hostile_files.families import family, filled


def png_chunk(kind: bytes, body: bytes) -> bytes:
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))


def png(width: int, height: int, rows: bytes, *more: bytes, depth: int = 8, kind: int = 2) -> bytes:
    header = struct.pack(">IIBBBBB", width, height, depth, kind, 0, 0, 0)
    chunks = png_chunk(b"IHDR", header) + b"".join(more)
    return b"\x89PNG\r\n\x1a\n" + chunks + png_chunk(b"IDAT", rows) + png_chunk(b"IEND", b"")


def encoded(width: int, height: int, form: str, mode: str = "RGB", **how: object) -> bytes:
    from PIL import Image

    file = io.BytesIO()
    Image.new(mode, (width, height)).save(file, form, **how)
    return file.getvalue()


def side_of(size: int) -> int:
    """A side so that a file of 64 MB stands for the largest picture that could be asked for."""
    return max(8, min(8400, int(math.sqrt(size))))


@family("png of black, large")
def _(size):
    side = side_of(size)
    return png(side, side, zlib.compress(bytes((3 * side + 1) * side), 1))


@family("png with little data")
def _(size):
    return png(60_000, 60_000, zlib.compress(b"\0"))


@family("png without an end of data")
def _(size):
    return png(8000, 8000, zlib.compress(bytes(size)))


@family("png a text that unpacks to much")
def _(size):
    packed = zlib.compress(bytes(16 * size), 9)
    return png(1, 1, zlib.compress(b"\0abc"), png_chunk(b"zTXt", b"a\0\0" + packed))


@family("png a profile that unpacks to much")
def _(size):
    packed = zlib.compress(bytes(16 * size), 9)
    return png(1, 1, zlib.compress(b"\0abc"), png_chunk(b"iCCP", b"a\0\0" + packed))


@family("png of empty chunks")
def _(size):
    return png(1, 1, zlib.compress(b"\0abc"), filled(png_chunk(b"tEXt", b"a\0b"), size))


@family("png of sixteen bits, large")
def _(size):
    side = side_of(size)
    rows = zlib.compress(bytes((2 * side + 1) * side), 1)
    return png(side, side, rows, depth=16, kind=0)


@family("tif of black, large")
def _(size):
    return encoded(side_of(size), side_of(size), "TIFF", compression="tiff_deflate")


@family("tif of floats, large")
def _(size):
    return encoded(side_of(size), side_of(size), "TIFF", "F", compression="tiff_deflate")


@family("tif directories in a ring")
def _(size):
    entries = struct.pack("<H", 1) + struct.pack("<HHII", 256, 4, 1, 9) + struct.pack("<I", 8)
    return b"II*\0" + struct.pack("<I", 8) + entries + bytes(size)


@family("tif with a table of 2^32 entries")
def _(size):
    rows = [(256, 4, 1, 9), (257, 4, 1, 9), (273, 4, 2**32 - 1, 8), (279, 4, 2**32 - 1, 8)]
    entries = struct.pack("<H", len(rows)) + b"".join(struct.pack("<HHII", *row) for row in rows)
    return b"II*\0" + struct.pack("<I", 8) + entries + bytes(4) + bytes(size)


@family("webp of black, large")
def _(size):
    return encoded(side_of(size), side_of(size), "WEBP", lossless=True, method=0, quality=0)


@family("webp of many frames")
def _(size):
    from PIL import Image

    file = io.BytesIO()
    frames = [Image.new("RGB", (900, 900), (k % 256, 0, 0)) for k in range(min(60, size // 800))]
    frames[0].save(file, "WEBP", save_all=True, append_images=frames[1:], method=0)
    return file.getvalue()


@family("jpg of black, large")
def _(size):
    return encoded(side_of(size), side_of(size), "JPEG")


@family("jpg of black, large, progressive")
def _(size):
    return encoded(side_of(size), side_of(size), "JPEG", progressive=True)


@family("jpg with damaged facts")
def _(size):
    exif = b"Exif\0\0II*\0" + struct.pack("<I", 8) + b"\xff\xff" + b"\x12\x01\x03\0" * 9999
    plain = encoded(8, 8, "JPEG")
    return plain[:2] + b"\xff\xe1" + struct.pack(">H", len(exif) + 2) + exif + plain[2:]


@family("jpg of empty segments")
def _(size):
    plain = encoded(8, 8, "JPEG")
    return plain[:2] + filled(b"\xff\xfe\0\2", size) + plain[2:]


@family("bmp of 2^60 pixels")
def _(size):
    header = struct.pack("<IiiHHIIiiII", 40, 2**30, 2**30, 1, 24, *[0] * 6)
    return b"BM" + bytes(12) + header + bytes(size)


@family("bmp of runs, large")
def _(size):
    header = struct.pack("<IiiHHIIiiII", 40, 8000, 8000, 1, 8, 1, 0, 0, 0, 256, 0)
    return b"BM" + struct.pack("<IHHI", 0, 0, 0, 54 + 1024) + header + bytes(1024) + bytes(size)
