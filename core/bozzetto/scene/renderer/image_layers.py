"""Pictures on rectangles in space, drawn once for each pixel and laid over each other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from bozzetto.arrays import Array, Bytes, Floats, Index
from bozzetto.scene.renderer.compositing import Sheet, blend_sheets
from bozzetto.scene.renderer.homography import place_of
from bozzetto.scene.renderer.image_warp import warp
from bozzetto.scene.renderer.mipmaps import LevelCache

if TYPE_CHECKING:
    from bozzetto.scene.display_list import Image
    from bozzetto.scene.renderer.view_transform import ViewTransform

SAME_DEPTH: Final = 1e-9
"""Difference of nearness, relative to the nearest, that is none: the later picture is on top."""

SHOWN_KEPT: Final = 64_000_000
"""Memory for pictures as they were on the sheet, bytes: with a camera that rests they are
drawn once."""

_shown = LevelCache(SHOWN_KEPT)


@dataclass(frozen=True, eq=False)
class PlacedPicture:
    """A picture as it is on a window of the sheet.

    Attributes
    ----------
    left, top : int
        Corner of its part of the window, px.
    colors : (h, w, 4) uint8
        Multiplied by the picture's own opacity; 0 beside it.
    plane : (3,) float
        Nearness of its plane at (x, y, 1), px of the window.
    opacity : float
        Opacity of the whole picture, 0 … 1.
    """

    left: int
    top: int
    colors: Bytes
    plane: Array
    opacity: float

    @property
    def right(self) -> int:
        """Column after the last."""
        return self.left + int(self.colors.shape[1])

    @property
    def bottom(self) -> int:
        """Row after the last."""
        return self.top + int(self.colors.shape[0])


def place_picture(image: Image, sight: ViewTransform) -> PlacedPicture | None:
    """Place a picture on the sheet; None if nothing of it is visible."""
    height, width = image.pixels.shape[:2]
    place = place_of(image, sight) if height and width and image.opacity > 0 else None
    if place is None:
        return None
    low = np.clip(np.floor(place.outline.min(0)) - 1, 0, None).astype(int)
    high = np.ceil(place.outline.max(0)).astype(int) + 1
    left, top = low.tolist()
    right, bottom = np.minimum(high, (sight.width, sight.height)).tolist()
    if right <= left or bottom <= top:
        return None
    box = (left, top, right, bottom)
    name = (place.matrix.tobytes(), box, place.nearest)
    colors = _shown.get(image.pixels, name, lambda: warp(image.pixels, place, box))
    return PlacedPicture(left, top, colors, place.plane, min(float(image.opacity), 1.0))


def blend_pictures(pixels: Floats, pictures: Sequence[PlacedPicture], sight: ViewTransform) -> None:
    """Blend pictures over what is there, the farthest first.

    Parameters
    ----------
    pixels : (h · w, 4) float32
        Written to: colour (0 … 255) multiplied by opacity, opacity (0 … 1).
    pictures : sequence of PlacedPicture
        The pictures to blend, in any order.
    sight : ViewTransform
        The transform of the window.
    """
    ordered = _from_far(pictures)
    if ordered is None:
        every = np.arange(sight.width * sight.height)
        blend_sheets(pixels, [sheet_at(picture, every, sight.width) for picture in pictures])
        return
    for picture in ordered:
        rows = np.s_[picture.top : picture.bottom, picture.left : picture.right]
        target = pixels.reshape(sight.height, sight.width, 4)[rows]
        own = picture.colors.astype(np.float32)
        own *= np.float32(picture.opacity)
        own[..., 3] *= np.float32(1 / 255)
        target *= 1 - own[..., 3:]
        target += own


def apart(
    pictures: Sequence[PlacedPicture], corners: Array | None
) -> tuple[Sequence[PlacedPicture], Sequence[PlacedPicture]]:
    """Split pictures into those to paint before meshes, and those that may come after.

    Parameters
    ----------
    pictures : sequence of PlacedPicture
        The pictures, in any order.
    corners : (n, 3) float or None
        Corners of boxes round the meshes: x, y (px), nearness. None where some are behind the eye.

    Returns
    -------
    before, after : sequences of PlacedPicture
        What is laid after is in front of all meshes, and of all that is laid before.
    """
    ordered = _from_far(pictures)
    if ordered is None or corners is None:
        return pictures, ()
    count = len(ordered)
    while count and _is_before(ordered[count - 1], corners):
        count -= 1
    return ordered[:count], ordered[count:]


def _is_before(picture: PlacedPicture, corners: Array) -> bool:
    """Whether a picture's plane is nearer than some boxes: then it is where their corners are."""
    nearness = corners[:, :2] @ picture.plane[:2] + picture.plane[2]
    return bool((nearness > corners[:, 2]).all())


def sheet_at(
    picture: PlacedPicture,
    samples: Index,
    width: int,
    offset: tuple[int, int] = (0, 0),
    fineness: int = 1,
) -> Sheet:
    """Return the colours of a picture at some samples.

    Parameters
    ----------
    picture : PlacedPicture
        The picture in its place.
    samples : (n,) int
        Row by row in a window of its own.
    width : int
        Samples in a row.
    offset : (x, y)
        Where that window begins, px of the picture's window.
    fineness : int
        Samples per pixel along each axis.
    """
    row, column = np.divmod(samples, width)
    x, y = column // fineness + offset[0], row // fineness + offset[1]
    inside = (x >= picture.left) & (x < picture.right) & (y >= picture.top) & (y < picture.bottom)
    colors = picture.colors[y[inside] - picture.top, x[inside] - picture.left]
    seen = np.flatnonzero(inside)[colors[:, 3] > 0]
    colors = colors[colors[:, 3] > 0].astype(np.float32)
    right = (column[seen] + 0.5) / fineness + offset[0]
    low = (row[seen] + 0.5) / fineness + offset[1]
    nearness = picture.plane[0] * right + picture.plane[1] * low + picture.plane[2]
    alpha = colors[:, 3] / np.float32(255)
    return Sheet(
        samples[seen],
        nearness.astype(np.float32),
        colors[:, :3] / alpha[:, None],
        alpha * np.float32(picture.opacity),
    )


def _from_far(pictures: Sequence[PlacedPicture]) -> list[PlacedPicture] | None:
    """Return the order in which to paint pictures; None if no order fits all places."""
    left = list(range(len(pictures)))
    order: list[PlacedPicture] = []
    while left:
        free = [i for i in left if all(i == j or _may_be_under(pictures, i, j) for j in left)]
        if not free:
            return None
        order.append(pictures[free[0]])
        left.remove(free[0])
    return order


def _may_be_under(pictures: Sequence[PlacedPicture], one: int, other: int) -> bool:
    """Whether a picture may be laid before another: it is behind it wherever both are."""
    a, b = pictures[one], pictures[other]
    x = max(a.left, b.left), min(a.right, b.right)
    y = max(a.top, b.top), min(a.bottom, b.bottom)
    if x[0] >= x[1] or y[0] >= y[1]:
        return True
    corners = np.array([(i, j, 1.0) for i in x for j in y])
    nearness = corners @ np.column_stack((a.plane, b.plane))
    slack = SAME_DEPTH * float(np.abs(nearness).max())
    ahead = nearness[:, 0] - nearness[:, 1]
    if one < other:
        return bool((ahead <= slack).all())
    return bool((ahead < -slack).all())
