"""The pictures of all parts of a file, side by side in one: a material less for each of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final, TypeVar

import numpy as np

from bozzetto.arrays import Bytes, frozen
from bozzetto.exchange.color import WHITE
from bozzetto.exchange.mesh.gltf_texture import flat_pixels
from bozzetto.geometry.shapes import Color, FaceGroup, Shapes, Solid, Surface
from bozzetto.geometry.texture import Texture

PADDING: Final = 8
"""Texels around a picture that repeat its border: copies down to an eighth mix no more."""

MOST: Final = 8192
"""Longest side of the picture, texels: what all but old graphics cards take."""

NAME: Final = "Painted"
"""The material of parts that had none with a name."""

BEYOND: Final = 1e-4
"""Share of a picture by which places lie outside at most; else it is repeated, and stays alone."""

_Key = tuple[int, Color]
_Part = TypeVar("_Part", Solid, Surface)


def in_one_picture(levels: Sequence[Shapes]) -> list[Shapes]:
    """Return shapes whose parts share one picture, if they have several and these fit.

    Parameters
    ----------
    levels : sequence of Shapes
        The same parts in several resolutions.
    """
    pictures: dict[_Key, Bytes] = {}
    for shapes in levels:
        for part in shapes.meshes():
            if part.texture is not None and _lies_within(part.texture):
                key = _key(part, part.texture)
                if key not in pictures:
                    pictures[key] = flat_pixels(part.texture, key[1])
    if len(pictures) < 2:
        return list(levels)
    places, (width, height) = _shelved([sheet.shape[:2] for sheet in pictures.values()])
    if max(width, height) > MOST:
        return list(levels)
    whole = np.full((height, width, 4), 255, np.uint8)
    spots: dict[_Key, tuple[int, int, int, int]] = {}
    for (key, sheet), (row, column) in zip(pictures.items(), places, strict=True):
        rows, columns = sheet.shape[:2]
        spots[key] = column + PADDING, row + PADDING, columns, rows
        around = ((PADDING, PADDING), (PADDING, PADDING), (0, 0))
        whole[row : row + rows + 2 * PADDING, column : column + columns + 2 * PADDING] = np.pad(
            sheet, around, "edge"
        )
    pixels = frozen(whole, np.uint8)

    def moved(part: _Part) -> _Part:
        texture = part.texture
        if texture is None or _key(part, texture) not in spots:
            return part
        left, top, columns, rows = spots[_key(part, texture)]
        corners = texture.corners.astype(np.float64) * (columns, rows) + (left, top)
        groups = part.groups or (FaceGroup(NAME, len(part.mesh.faces)),)
        laid = Texture(pixels, (corners / (width, height)).astype(np.float32))
        return replace(part, texture=laid, color=None, groups=groups)

    return [
        replace(
            shapes,
            solids=tuple(moved(part) for part in shapes.solids),
            surfaces=tuple(moved(part) for part in shapes.surfaces),
        )
        for shapes in levels
    ]


def _key(part: Solid | Surface, texture: Texture) -> _Key:
    return id(texture.pixels), part.color or WHITE


def _lies_within(texture: Texture) -> bool:
    corners = texture.corners
    return bool(corners.min(initial=0.0) >= -BEYOND and corners.max(initial=1.0) <= 1.0 + BEYOND)


def _shelved(sizes: Sequence[tuple[int, int]]) -> tuple[list[tuple[int, int]], tuple[int, int]]:
    """Put pictures on shelves, the highest first: rows and columns, and width and height of all.

    Of the widths at which a shelf is full, the one whose square around all is the smallest.
    """
    boxes = [(rows + 2 * PADDING, columns + 2 * PADDING) for rows, columns in sizes]
    order = sorted(range(len(boxes)), key=lambda k: (-boxes[k][0], k))
    widest = max(columns for _, columns in boxes)
    sums = np.cumsum([boxes[k][1] for k in order]).tolist()
    best: tuple[list[tuple[int, int]], tuple[int, int]] | None = None
    for wide in sorted({max(widest, total) for total in sums}):
        places, x, y, shelf = [(0, 0)] * len(boxes), 0, 0, 0
        for k in order:
            rows, columns = boxes[k]
            if x + columns > wide:
                x, y, shelf = 0, y + shelf, 0
            places[k] = y, x
            x, shelf = x + columns, max(shelf, rows)
        found = places, (wide, y + shelf)
        if best is None or max(found[1]) < max(best[1]):
            best = found
    if best is None:
        raise ValueError("there are no pictures")
    return best
