"""Moving pictures as GIF."""

from __future__ import annotations

import io
from collections.abc import Iterable
from typing import Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.errors import UserError

COLORS: Final = 128
"""Of a GIF."""

SHORTEST: Final = 20
"""Least time of a picture, ms: viewers show shorter ones slowly."""

GRAIN: Final = 10
"""What times in a GIF are multiples of, ms."""


def gif_of_pictures(pictures: Iterable[NDArray[np.uint8]], rate: float) -> bytes:
    """Return a GIF that goes on for ever.

    Parameters
    ----------
    pictures : iterable of (h, w, 4) uint8
        RGBA without transparency, at least one.
    rate : float
        Pictures a second.

    Raises
    ------
    UserError
        If there is no picture.
    """
    from PIL import Image

    images = [
        Image.fromarray(pixels).convert("RGB").quantize(COLORS, dither=Image.Dither.NONE)
        for pixels in pictures
    ]
    if not images:
        raise UserError("A moving picture needs one picture at least.")
    ends = np.rint(np.arange(len(images) + 1) * (1000.0 / GRAIN) / rate).astype(int)
    times = np.maximum(GRAIN * np.diff(ends), SHORTEST)  # together as long as they should be
    data = io.BytesIO()
    images[0].save(
        data,
        "GIF",
        save_all=True,
        append_images=images[1:],
        duration=times.tolist(),
        loop=0,
    )
    return data.getvalue()
