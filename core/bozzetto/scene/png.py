"""Pictures as PNG files, without Qt."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

__all__ = ["write_png"]


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
    OSError
        If the file cannot be written; an existing one is then unchanged.
    ValueError
        If the array is not a picture.
    """
    from PIL import Image

    if pixels.ndim != 3 or pixels.shape[2] != 4 or pixels.dtype != np.uint8:
        raise ValueError("a picture needs the shape (height, width, 4) and bytes")
    target = Path(path)
    handle, name = tempfile.mkstemp(dir=target.parent, prefix=f".{target.name}-", suffix=".part")
    try:
        with os.fdopen(handle, "wb") as file:
            Image.fromarray(np.ascontiguousarray(pixels), "RGBA").save(file, "PNG")
            file.flush()
            os.fsync(file.fileno())
        os.replace(name, target)
    except BaseException:
        os.unlink(name)
        raise
