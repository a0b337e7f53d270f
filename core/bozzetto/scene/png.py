"""Pictures as PNG files, without Qt."""

from __future__ import annotations

import io
import os

import numpy as np
from numpy.typing import NDArray

from bozzetto.storage import write_bytes

__all__ = ["png_bytes", "write_png"]


def png_bytes(pixels: NDArray[np.uint8]) -> bytes:
    """A picture as the content of a PNG file.

    Parameters
    ----------
    pixels : (h, w, 4) uint8
        RGBA, straight alpha.

    Raises
    ------
    ValueError
        If the array is not a picture.
    """
    from PIL import Image

    if pixels.ndim != 3 or pixels.shape[2] != 4 or pixels.dtype != np.uint8 or not pixels.size:
        raise ValueError("a picture needs the shape (height, width, 4), bytes, and pixels")
    stream = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(pixels), "RGBA").save(stream, "PNG")
    return stream.getvalue()


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
