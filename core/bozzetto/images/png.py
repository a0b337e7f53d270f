"""Pictures as PNG files, without Qt."""

from __future__ import annotations

import io
import os
import struct
from collections.abc import Callable
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.atomic_files import write_bytes
from bozzetto.errors import FormatError, words_of

if TYPE_CHECKING:
    from PIL.Image import Image

MAX_PIXELS: Final = 1 << 26
"""Largest picture that a document holds, pixels: 8192 × 8192, a quarter of a gigabyte."""

PIXELS_AT_ONCE: Final = 1 << 20
"""Pixels that are converted in one go."""

PNG_SIGN: Final = b"\x89PNG\r\n\x1a\n"
PNG_SIZE: Final = struct.Struct(">16s2I")
"""The beginning of a PNG file, with its width and height."""

BEST_EFFORT: Final = 6
"""zlib level of Pillow's own choice."""


def png_bytes(pixels: NDArray[np.uint8], effort: int = BEST_EFFORT) -> bytes:
    """Encode a picture as the content of a PNG file.

    Parameters
    ----------
    pixels : (h, w, 4) uint8
        RGBA, straight alpha.
    effort : int
        zlib level, 0 … 9: scans compress nearly as well at 1 as at 6, in a third of the time.

    Raises
    ------
    ValueError
        If the array is not a picture.
    """
    from PIL import Image

    if pixels.ndim != 3 or pixels.shape[2] != 4 or pixels.dtype != np.uint8 or not pixels.size:
        raise ValueError("a picture needs the shape (height, width, 4), bytes, and pixels")
    stream = io.BytesIO()
    image = Image.fromarray(np.ascontiguousarray(pixels), "RGBA")
    image.save(stream, "PNG", compress_level=effort)
    return stream.getvalue()


def decode_picture(content: bytes, formats: tuple[str, ...] = ("PNG",)) -> NDArray[np.uint8]:
    """Decode a picture that a document holds.

    Parameters
    ----------
    content : bytes
        The file as it is stored.
    formats : tuple of {"PNG", "JPEG"}
        Anything else is refused: the bytes may come from a stranger's file.

    Returns
    -------
    (h, w, 4) uint8
        RGBA, straight alpha.

    Raises
    ------
    FormatError
        If it is damaged, of another format, or has more than `MAX_PIXELS` pixels.
    """
    from PIL import Image

    try:
        with Image.open(io.BytesIO(content), formats=formats) as image:
            # The size stands in the header: a bomb is refused before it is unpacked.
            if image.width * image.height > MAX_PIXELS:
                raise FormatError("A picture of this document is too large. Leave it out.")
            image.load()
            return rgba_pixels(image)
    except FormatError:
        raise
    except Exception as problem:  # the readers have no end of ways to fail on hostile data
        said = words_of(problem)
        raise FormatError(f"A picture of this document is damaged: {said}.") from problem


def rgba_pixels(
    image: Image, prepared: Callable[[Image], Image] = lambda strip: strip
) -> NDArray[np.uint8]:
    """Return the pixels of a decoded picture, converted strip by strip to spare memory.

    Parameters
    ----------
    image : PIL.Image.Image
        The opened picture; it is read now.
    prepared : callable
        What becomes of each strip before it is converted.

    Returns
    -------
    (h, w, 4) uint8
        RGBA, straight alpha.
    """
    width, height = image.size
    pixels = np.empty((height, width, 4), np.uint8)
    rows = max(1, PIXELS_AT_ONCE // max(1, width))
    for first in range(0, height, rows):
        strip = image.crop((0, first, width, min(first + rows, height)))
        pixels[first : first + rows] = np.asarray(prepared(strip).convert("RGBA"))
    return pixels


def pixel_count(content: bytes) -> int:
    """Return the number of pixels that a PNG file announces; 0 for other files."""
    if len(content) < PNG_SIZE.size or not content.startswith(PNG_SIGN):
        return 0
    _, width, height = PNG_SIZE.unpack_from(content)
    return int(width) * int(height)


def write_png(path: str | os.PathLike[str], pixels: NDArray[np.uint8]) -> None:
    """Write a picture; the file appears complete or not at all.

    Parameters
    ----------
    path : path
        Its folder must exist. An existing file is replaced.
    pixels : (h, w, 4) uint8
        RGBA, straight alpha.

    Raises
    ------
    UserError
        If the file cannot be written; an existing one is then unchanged.
    ValueError
        If the array is not a picture.
    """
    write_bytes(path, png_bytes(pixels))
