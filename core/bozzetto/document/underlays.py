"""Underlay pictures as PNG, the form in which files keep them."""

from __future__ import annotations

import io
import weakref
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.document.model import MAX_PIXELS
from bozzetto.errors import DocumentError

__all__ = ["decode_png", "encode_png"]

PNG_EFFORT: Final = 1
"""zlib level: scans compress nearly as well as at 6, in a third of the time."""

_encoded: dict[int, tuple[weakref.ref[Any], bytes]] = {}
"""PNG of pictures in memory, so that a save does not pack the same picture again."""


def encode_png(pixels: NDArray[np.uint8]) -> bytes:
    """A picture of shape (h, w, 4), RGBA, as PNG; remembered while the array lives."""
    from PIL import Image

    key = id(pixels)
    if key not in _encoded:
        file = io.BytesIO()
        Image.fromarray(pixels, "RGBA").save(file, "PNG", compress_level=PNG_EFFORT)
        _remember(pixels, file.getvalue())
    return _encoded[key][1]


def decode_png(content: bytes) -> NDArray[np.uint8]:
    """The pixels of a PNG, shape (h, w, 4), RGBA.

    Raises
    ------
    DocumentError
        If it is not a PNG, or larger than `MAX_PIXELS`.
    """
    from PIL import Image

    try:
        with Image.open(io.BytesIO(content), formats=("PNG",)) as image:
            if image.width * image.height > MAX_PIXELS:
                raise DocumentError("An underlay picture of this document is too large.")
            pixels = np.asarray(image.convert("RGBA"))
    except DocumentError:
        raise
    except Exception as problem:  # the PNG reader has no end of ways to fail on hostile data
        raise DocumentError(f"An underlay picture is damaged: {problem}.") from problem
    return pixels


def _remember(pixels: NDArray[np.uint8], png: bytes) -> None:
    key = id(pixels)
    _encoded[key] = weakref.ref(pixels, lambda _: _encoded.pop(key, None)), png
