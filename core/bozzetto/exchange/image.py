"""Pictures to lay under a drawing: PNG, JPEG, TIFF, WebP, BMP."""

from __future__ import annotations

import io
from collections.abc import Iterator
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.errors import FormatError, words_of
from bozzetto.exchange.limits import MAX_PIXELS, at_most
from bozzetto.images.png import rgba_pixels

if TYPE_CHECKING:
    from PIL import Image

DECODERS: Final = ("PNG", "JPEG", "TIFF", "WEBP", "BMP")

BYTES_PER_PIXEL: Final = {"PNG": 8, "JPEG": 8, "BMP": 8, "TIFF": 8, "WEBP": 20}
"""Memory that decoding takes, with what is handed over: measured, the decoders' own included."""

MAX_BYTES: Final = 600_000_000
"""Bytes of all that together; within the `Budget`."""

ROWS_AT_ONCE: Final = 64
"""Rows of grey of more than eight bits that are looked at in one go."""


def read_pixels(data: bytes) -> NDArray[np.uint8]:
    """Decode a picture; the first one where there are several.

    Returns
    -------
    (h, w, 4) uint8
        RGBA, turned the way the camera was held. Sixteen bits are reduced to eight.

    Raises
    ------
    FormatError
        If it is damaged, of another format, or has more than `MAX_PIXELS` pixels.
    """
    from PIL import Image, ImageOps, UnidentifiedImageError

    try:
        with Image.open(io.BytesIO(data), formats=DECODERS) as picture:
            # The size stands in the header: a bomb is refused before it is unpacked.
            pixels = picture.width * picture.height
            at_most(pixels, MAX_PIXELS, "pixels")
            cost = BYTES_PER_PIXEL.get(picture.format or "", BYTES_PER_PIXEL["PNG"])
            at_most(cost * pixels, MAX_BYTES, "bytes once it is unpacked")
            picture.load()
            ImageOps.exif_transpose(picture, in_place=True)
            top = _top(picture)
            return rgba_pixels(picture, lambda strip: _eight_bits(strip, top))
    except FormatError:
        raise
    except Image.DecompressionBombError:
        raise FormatError(
            f"This picture has more than the {MAX_PIXELS:,} pixels that can be read. "
            "Make it smaller first."
        ) from None
    except UnidentifiedImageError:
        raise FormatError("This is not a picture in a format that can be read.") from None
    except MemoryError:
        raise
    except Exception as error:
        # Decoders leak all kinds of exceptions on damaged files; there is no list of them.
        raise FormatError(f"This picture cannot be read: {words_of(error)}.") from error


def _strips(picture: Image.Image) -> Iterator[NDArray[np.float64]]:
    """Yield the values of a picture of one channel, some rows at a time."""
    width, height = picture.size
    for first in range(0, height, ROWS_AT_ONCE):
        strip = picture.crop((0, first, width, min(first + ROWS_AT_ONCE, height)))
        yield np.nan_to_num(np.asarray(strip, np.float64))


def _top(picture: Image.Image) -> float:
    """Return the value of white, where there are more than eight bits; of floats the largest."""
    if picture.mode.startswith("I"):
        return 65535.0
    if not picture.mode.startswith("F"):
        return 255.0
    return max(*(float(strip.max(initial=0)) for strip in _strips(picture)), 1e-300)


def _eight_bits(picture: Image.Image, top: float) -> Image.Image:
    """Scale grey of more than eight bits, which Pillow would clip instead."""
    from PIL import Image

    if not picture.mode.startswith(("I", "F")):
        return picture
    values = np.nan_to_num(np.asarray(picture, np.float64))
    return Image.fromarray(np.clip(255.0 / top * values, 0, 255).astype(np.uint8))
