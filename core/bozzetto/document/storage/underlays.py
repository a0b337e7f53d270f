"""Underlay pictures as PNG, the form in which files keep them."""

from __future__ import annotations

import weakref
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.errors import DocumentError, FormatError
from bozzetto.images.png import decode_picture, png_bytes

PNG_EFFORT: Final = 1
"""zlib level: a save must not wait for the last tenth of the size."""

_encoded: dict[int, tuple[weakref.ref[Any], bytes]] = {}
"""PNG of pictures in memory, so that a save does not pack the same picture again."""


def encode_png(pixels: NDArray[np.uint8]) -> bytes:
    """Encode a picture of shape (h, w, 4), RGBA, as PNG; remembered while the array lives."""
    key = id(pixels)
    if key not in _encoded:
        _remember(pixels, png_bytes(pixels, PNG_EFFORT))
    return _encoded[key][1]


def decode_png(content: bytes) -> NDArray[np.uint8]:
    """Decode a PNG to pixels of shape (h, w, 4), RGBA.

    Raises
    ------
    DocumentError
        If it is not a PNG, or larger than `bozzetto.images.png.MAX_PIXELS`.
    """
    try:
        return decode_picture(content)
    except FormatError as problem:
        raise DocumentError(problem.message) from problem


def _remember(pixels: NDArray[np.uint8], png: bytes) -> None:
    key = id(pixels)
    _encoded[key] = weakref.ref(pixels, lambda _: _encoded.pop(key, None)), png
