"""Pictures made smaller for the sheet: the mean of blocks of pixels, remembered.

A picture that is shown smaller than it is has several pixels for each of the sheet. Taking one
of them would lose the thin lines of a sketch, so its levels of detail (Williams 1983,
"Pyramidal parametrics") are sampled; unlike there, a picture may be reduced across and down
by different numbers, as it needs to be where it is seen at a slant.
"""

from __future__ import annotations

import threading
import weakref
from collections import OrderedDict
from collections.abc import Callable, Hashable
from functools import partial
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from PIL.Image import Image

    from bozzetto.arrays import Array, Bytes, Floats, Index


LEVELS_KEPT: Final = 256_000_000
"""Memory for pictures made smaller, bytes: four of 4096 × 4096 pixels at most."""

QUARTER: Final = 4
"""By how much a level is reduced from another one. By halves would be a little faster, but each
step rounds, and a mean of two is rounded up half of the time: small pictures would be pale."""


AT_ONCE: Final = 1 << 15
"""Places interpolated in one sweep: their arrays stay in the processor's cache."""


class LevelCache:
    """Arrays made of pictures, the latest used ones, for as long as the pictures live.

    Parameters
    ----------
    most : int
        Bytes held at most.
    """

    def __init__(self, most: int) -> None:
        self._most = most
        self._held = 0
        self._known: OrderedDict[Hashable, tuple[weakref.ref[Bytes], Bytes]] = OrderedDict()
        self._lock = threading.RLock()  # frames are made beside the window's thread

    def get(self, pixels: Bytes, name: Hashable, make: Callable[[], Bytes]) -> Bytes:
        """Return what was made of a picture under a name, or make it now."""
        key = (id(pixels), name)
        with self._lock:
            found = self._known.get(key)
            if found is not None and found[0]() is pixels:
                self._known.move_to_end(key)
                return found[1]
        made = make()
        made.flags.writeable = False
        with self._lock:
            self._forget(key)
            self._known[key] = (weakref.ref(pixels, partial(self._gone, key)), made)
            self._held += made.nbytes
            while self._held > self._most:
                self._forget(next(iter(self._known)))
        return made

    @property
    def held(self) -> int:
        """Bytes held now."""
        return self._held

    def _gone(self, key: Hashable, picture: weakref.ref[Bytes]) -> None:
        """Let go of what was made of a picture that is no more."""
        with self._lock:
            found = self._known.get(key)
            if found is not None and found[0] is picture:
                self._forget(key)

    def _forget(self, key: Hashable) -> None:
        _, made = self._known.pop(key, (None, None))
        self._held -= 0 if made is None else made.nbytes


_levels = LevelCache(LEVELS_KEPT)


def rung(footprint: float, size: int) -> int:
    """Return by how much to reduce a picture along one side.

    Parameters
    ----------
    footprint : float
        Pixels of the picture for each of the sheet.
    size : int
        Pixels along that side.

    Returns
    -------
    int
        The nearest of 1, 2, 3, 4, 6, 8, 12 …, by ratio; not more than `size`.
    """
    footprint = min(max(footprint, 1.0), float(size))
    power = 2 ** int(np.log2(footprint))
    rungs = [r for r in (power, 3 * power // 2, 2 * power) if r <= size]
    ratios = [max(r / footprint, footprint / r) for r in rungs]
    return int(rungs[ratios.index(min(ratios))])


def level(pixels: Bytes, across: int, down: int) -> Bytes:
    """Return a picture made smaller, multiplied by its opacity.

    Parameters
    ----------
    pixels : (h, w, 4) uint8
        RGBA, straight alpha.
    across, down : int
        How many columns and rows become one. Where they do not go into the picture's, a few
        more or less do, for a level ends where the picture ends.

    Returns
    -------
    (h / down, w / across, 4) uint8
        Read-only; both sides rounded, and one at least.
    """
    if across == 1 and down == 1:
        return _multiplied(pixels)
    return _levels.get(pixels, (across, down), lambda: _reduced(pixels, across, down))


def _reduced(pixels: Bytes, across: int, down: int) -> Bytes:
    """Reduce a picture, from its quarter-size level where there is one."""
    from PIL import Image

    larger = _multiplied(pixels)
    if across % QUARTER == 0 and down % QUARTER == 0:
        larger = level(pixels, across // QUARTER, down // QUARTER)
    height, width = pixels.shape[:2]
    size = max(1, round(width / across)), max(1, round(height / down))
    return np.array(as_pillow(larger).resize(size, Image.Resampling.BOX))


def _multiplied(pixels: Bytes) -> Bytes:
    """Return a picture multiplied by its opacity; itself where it is opaque."""
    clear = _levels.get(pixels, "clear", lambda: np.array([pixels[..., 3].min() < 255], np.uint8))
    if not clear[0]:
        return pixels
    return _levels.get(pixels, "multiplied", lambda: _made_clear(pixels))


def _made_clear(pixels: Bytes) -> Bytes:
    from PIL import Image

    height, width = pixels.shape[:2]
    image = Image.frombuffer("RGBA", (width, height), pixels, "raw", "RGBA", 0, 1)
    return np.array(image.convert("RGBa"))


def as_pillow(texels: Bytes) -> Image:
    """Return texels (h, w, 4) as an image of four equal channels, without a copy.

    Pillow would multiply and divide by the opacity of "RGBA" at every step; of "CMYK" it
    knows no opacity.
    """
    from PIL import Image

    height, width = texels.shape[:2]
    return Image.frombuffer("CMYK", (width, height), texels, "raw", "CMYK", 0, 1)


def bilinear(texels: Bytes, x: Array, y: Array) -> Floats:
    """Interpolate texels at places, (n, 4); beyond the border the outermost ones are repeated."""
    height, width = texels.shape[:2]
    flat = np.ascontiguousarray(texels).view(np.uint32).ravel()
    result = np.empty((len(x), 4), np.float32)
    for first in range(0, len(x), AT_ONCE):
        part = slice(first, first + AT_ONCE)
        across = np.clip(x[part] - 0.5, 0, width - 1)
        down = np.clip(y[part] - 0.5, 0, height - 1)
        left, top = across.astype(np.int32), down.astype(np.int32)
        s = (across - left).astype(np.float32)[:, None]
        t = (down - top).astype(np.float32)[:, None]
        row, next_row = top * width, np.minimum(top + 1, height - 1) * width
        right = np.minimum(left + 1, width - 1)
        upper = _between(flat, row + left, row + right, s)
        lower = _between(flat, next_row + left, next_row + right, s)
        lower -= upper
        lower *= t
        np.add(upper, lower, out=result[part])
    return result


def _between(flat: NDArray[np.uint32], one: Index, other: Index, share: Floats) -> Floats:
    """Return colours (n, 4) between texels at two flat indices."""
    begin, end = (
        flat.take(index).view(np.uint8).reshape(-1, 4).astype(np.float32) for index in (one, other)
    )
    end -= begin
    end *= share
    end += begin
    return end
