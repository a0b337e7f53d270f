"""Pictures on rectangles in space."""

from __future__ import annotations

import weakref
from collections import OrderedDict

import numpy as np
from numpy.typing import NDArray

from bozzetto.geometry.mesh import Mesh
from bozzetto.scene.display_list import Image
from bozzetto.scene.software.sight import Sight
from bozzetto.scene.software.soup import Soup, gather

__all__ = ["rectangle", "sampled"]

Floats = NDArray[np.float32]

KEPT = 8
"""How many reduced pictures are remembered."""

AT_ONCE = 1 << 14
"""Places whose colours are mixed in one go: what is in hand stays in the cache."""

WHOLE = 255.0
"""Texture coordinates run from 0 to this, in the columns that hold colours elsewhere."""

_reduced: OrderedDict[tuple[int, int], tuple[weakref.ref[NDArray[np.uint8]], Floats]] = (
    OrderedDict()
)


def rectangle(image: Image, sight: Sight) -> Soup:
    """Two triangles whose red and green are the place across and down the picture."""
    corner, across, down = (
        np.asarray(v, np.float64) for v in (image.corner, image.across, image.down)
    )
    vertices = np.stack((corner, corner + across, corner + across + down, corner + down))
    mesh = Mesh(vertices.astype(np.float32), np.array([(0, 3, 2), (0, 2, 1)], np.int32))
    place = np.zeros((4, 4))
    place[[1, 2], 0] = place[[2, 3], 1] = WHOLE
    return gather([mesh], [place], sight)


def sampled(image: Image, place: Floats, soup: Soup) -> Floats:
    """Colours of a picture at places on it.

    Parameters
    ----------
    image : Image
    place : (n, 2 or more) float32
        0 … `WHOLE` across and down.
    soup : Soup
        The picture's rectangle on the sheet: says how much it is reduced.

    Returns
    -------
    (n, 4) float32
        Red, green, blue (0 … 255, not multiplied) and opacity 0 … 1.
    """
    height, width = image.pixels.shape[:2]
    if not height or not width:
        return np.zeros((len(place), 4), np.float32)
    area = 0.5 * float(np.abs(soup.doubled_areas()).sum())
    stride = int(np.sqrt(height * width / max(area, 1.0)))
    texels = _texels(image.pixels, max(1, min(stride, height, width)))
    colors = np.empty((len(place), 4), np.float32)
    for begin in range(0, len(place), AT_ONCE):
        part = slice(begin, begin + AT_ONCE)
        colors[part] = _mixed(texels, place[part, 0], place[part, 1])
    return colors


def _mixed(texels: Floats, across: Floats, down: Floats) -> Floats:
    """Bilinear mixtures of the texels around places; (n, 4), not multiplied."""
    height, width = texels.shape[:2]
    x = np.clip(across * np.float32(width / WHOLE) - np.float32(0.5), 0, width - 1)
    y = np.clip(down * np.float32(height / WHOLE) - np.float32(0.5), 0, height - 1)
    left, top = x.astype(np.int32), y.astype(np.int32)
    u = (x - left.astype(np.float32))[:, None]
    v = (y - top.astype(np.float32))[:, None]
    right = (left < width - 1).astype(np.int32)
    below = np.where(top < height - 1, np.int32(width), np.int32(0))
    rows = texels.reshape(-1, 4)
    first = top * np.int32(width) + left
    mixed = _between(rows.take(first, 0), rows.take(first + right, 0), u)
    first += below
    lower = _between(rows.take(first, 0), rows.take(first + right, 0), u)
    mixed = _between(mixed, lower, v)
    alpha = mixed[:, 3:]
    np.divide(mixed[:, :3], alpha, out=mixed[:, :3], where=alpha > 0)
    return mixed


def _between(one: Floats, other: Floats, share: Floats) -> Floats:
    """Part of the way from one to the other; both arrays are used up."""
    other -= one
    other *= share
    one += other
    return one


def _texels(pixels: NDArray[np.uint8], stride: int) -> Floats:
    """The picture reduced by a whole number, multiplied by its opacity."""
    key = (id(pixels), stride)
    known = _reduced.get(key)
    if known is not None and known[0]() is pixels:
        return known[1]
    height, width = pixels.shape[:2]
    rows, columns = height // stride, width // stride
    part = pixels[: rows * stride, : columns * stride].astype(np.float32)
    part[..., 3] /= 255.0
    part[..., :3] *= part[..., 3:]
    texels: Floats = part.reshape(rows, stride, columns, stride, 4).mean((1, 3))
    _reduced[key] = (weakref.ref(pixels), texels)
    while len(_reduced) > KEPT:
        _reduced.popitem(last=False)
    return texels
