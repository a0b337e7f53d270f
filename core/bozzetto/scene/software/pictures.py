"""Pictures on rectangles in space, drawn by the homography from the sheet to the picture.

From a place on the sheet a picture's own coordinates follow by one 3 × 3 matrix (Hartley &
Zisserman, "Multiple View Geometry", 2nd ed., section 2.3), whose third row is the nearness of the
picture's plane: it tells what is in front, and where the plane goes behind the eye. Pixels within
are interpolated by Pillow; those on the border, few, are sampled here with their true share.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.scene.display_list import Image
from bozzetto.scene.software.compositing import Sheet, lay_over
from bozzetto.scene.software.outlines import Polygon, crossed, cut, cut_to_window
from bozzetto.scene.software.sight import Sight
from bozzetto.scene.software.textures import Kept, as_pillow, level, rung

__all__ = ["Hung", "hang", "lay_pictures", "sheet_at"]

Array = NDArray[np.float64]
Floats = NDArray[np.float32]
Bytes = NDArray[np.uint8]

EDGE_ON: Final = 1e-9
"""Volume of the box of both sides and the way to the corner, per product of their lengths,
below which a picture is seen edge on."""

SHARES: Final = 4
"""Samples along each axis of a pixel on the border, that tell how much of it is covered."""

STRIP: Final = 1.45
"""Ratio of depths within which a picture is reduced by the same numbers."""

STRIPS: Final = 8
"""Most strips of a picture that are reduced differently."""

SAME_DEPTH: Final = 1e-9
"""Difference of nearness, relative to the nearest, that is none: the later picture is on top."""

SHOWN_KEPT: Final = 64_000_000
"""Memory for pictures as they were on the sheet, bytes: with a camera that rests they are
drawn once."""

_shown = Kept(SHOWN_KEPT)


@dataclass(frozen=True, eq=False)
class Hung:
    """A picture as it is on a window of the sheet.

    Attributes
    ----------
    left, top : int
        Of its part of the window, px.
    colors : (h, w, 4) uint8
        Multiplied by the picture's own opacity; 0 beside it.
    plane : (3,) float
        Nearness of its plane at (x, y, 1), px of the window.
    opacity : float
        Of the whole, 0 … 1.
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


@dataclass(frozen=True, eq=False)
class _Place:
    """Where a picture is on the sheet.

    Attributes
    ----------
    matrix : (3, 3) float
        (x, y, 1) on the window to (u, v, 1) · w: parts of the picture's width and height.
    plane : (3,) float
        (x, y, 1) to nearness; the third row of the matrix but for a factor, in perspective.
    outline : (n, 2) float
        The part of the rectangle that is in the window, px.
    nearest : float
        Nearness beyond which nothing is shown.
    is_cut : bool
        Whether some of it is too near to be shown, or behind the eye.
    """

    matrix: Array
    plane: Array
    outline: Polygon
    nearest: float
    is_cut: bool


def hang(image: Image, sight: Sight) -> Hung | None:
    """A picture on the sheet; None if nothing of it is to be seen."""
    height, width = image.pixels.shape[:2]
    place = _place_of(image, sight) if height and width and image.opacity > 0 else None
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
    colors = _shown.get(image.pixels, name, lambda: _drawn(image.pixels, place, box))
    return Hung(left, top, colors, place.plane, min(float(image.opacity), 1.0))


def _place_of(image: Image, sight: Sight) -> _Place | None:
    corner = sight.seen([image.corner])[0]
    across, down = (
        sight.axes @ np.asarray(side, np.float64) for side in (image.across, image.down)
    )
    corners = corner + np.array([0 * across, across, across + down, down])
    shown = cut(corners, (0.0, 0.0, 1.0), sight.near) if sight.perspective else corners
    if len(shown) < 3:
        return None
    outline = cut_to_window(sight.placed(shown)[:, :2], sight.width, sight.height)
    if len(outline) < 3:
        return None
    x, y = sight.middle
    unit = 1.0 / sight.focal
    sides = np.column_stack((across, down, corner))
    if not sight.perspective:
        sides[2] = 0.0, 0.0, 1.0
    lengths = np.linalg.norm(sides, axis=0)
    if not lengths.all() or abs(np.linalg.det(sides / lengths)) < EDGE_ON:
        return None
    # the ray through a place: right, up and forward in perspective, right, up and 1 in parallel
    ray = np.array([(unit, 0.0, -x * unit), (0.0, -unit, y * unit), (0.0, 0.0, 1.0)])
    matrix = np.linalg.solve(sides, ray)
    if sight.perspective:
        plane = sight.reference * matrix[2]
        return _Place(
            matrix,
            plane,
            outline,
            sight.reference / sight.near,
            bool((corners[:, 2] < sight.near).any()),
        )
    depth = across[2] * matrix[0] + down[2] * matrix[1]
    plane = np.array((0.0, 0.0, sight.reference - corner[2])) - depth
    return _Place(matrix, plane, outline, np.inf, False)


# -- pixels ------------------------------------------------------------------------------------


def _drawn(pixels: Bytes, place: _Place, box: tuple[int, int, int, int]) -> Bytes:
    left, top, right, bottom = box
    strips = _strips(pixels, place)
    result = np.zeros((bottom - top, right - left), np.uint32)
    for outline, near, far, factors in strips:
        low = np.clip(np.floor(outline.min(0)).astype(int) - 1, (left, top), (right, bottom))
        high = np.clip(np.ceil(outline.max(0)).astype(int) + 1, (left, top), (right, bottom))
        (x0, y0), (x1, y1) = low.tolist(), high.tolist()
        if x1 <= x0 or y1 <= y0:
            continue
        part = _interpolated(pixels, factors, place.matrix, (x0, y0, x1, y1))
        target = result[y0 - top : y1 - top, x0 - left : x1 - left]
        if len(strips) == 1 and not place.is_cut:
            target[:] = part
        else:
            nearness = _over(place.plane, (x0, y0, x1, y1))
            np.copyto(target, part, where=(nearness > far) & (nearness <= near))
    colors = result.view(np.uint8).reshape(bottom - top, right - left, 4)
    _draw_border(colors, pixels, place, strips, box)
    return colors


_Strip = tuple[Polygon, float, float, tuple[int, int]]


def _strips(pixels: Bytes, place: _Place) -> list[_Strip]:
    """Parts of a picture that are reduced by the same numbers, the nearest first.

    Each with its outline, the greatest and the least nearness in it, and the numbers.
    """
    nearness = place.outline @ place.plane[:2] + place.plane[2]
    nearest, farthest = float(nearness.max()), float(nearness.min())
    parallel = np.isinf(place.nearest)
    count = 1
    if not parallel and farthest > 0:
        count = int(np.clip(np.ceil(np.log(nearest / farthest) / np.log(STRIP)), 1, STRIPS))
    bounds = np.geomspace(nearest, farthest, count + 1) if count > 1 else np.zeros(0)
    found: list[_Strip] = []
    for k in range(count):
        outline = place.outline
        if count > 1:
            outline = cut(outline, place.plane[:2], bounds[k + 1] - place.plane[2])
            outline = cut(outline, -place.plane[:2], place.plane[2] - bounds[k])
        if len(outline) < 3:
            continue
        factors = _factors(pixels, place.matrix, outline.mean(0))
        near = bounds[k] if k else place.nearest
        far = bounds[k + 1] if k + 1 < count else (-np.inf if parallel else 0.0)
        if found and found[-1][3] == factors:
            before = found.pop()
            outline, near = np.concatenate((before[0], outline)), before[1]
        found.append((outline, float(near), float(far), factors))
    return found


def _factors(pixels: Bytes, matrix: Array, middle: Array) -> tuple[int, int]:
    """By how much to reduce a picture across and down where it is seen at a place."""
    u, v, w = matrix @ (*middle, 1.0)
    height, width = pixels.shape[:2]
    slope = (matrix[:2, :2] - np.outer((u / w, v / w), matrix[2, :2])) / w
    by_u, by_v = np.linalg.norm(slope, axis=1)
    return rung(width * by_u, width), rung(height * by_v, height)


def _over(plane: Array, box: tuple[int, int, int, int]) -> Floats:
    """An affine function at the middles of the pixels of a box, (h, w)."""
    x = plane[0] * (np.arange(box[0], box[2]) + 0.5) + plane[2]
    y = plane[1] * (np.arange(box[1], box[3]) + 0.5)
    return np.asarray(x.astype(np.float32) + y.astype(np.float32)[:, None])


def _interpolated(
    pixels: Bytes, factors: tuple[int, int], matrix: Array, box: tuple[int, int, int, int]
) -> NDArray[np.uint32]:
    """A reduced picture at the middles of the pixels of a box, bilinear; 0 beside it."""
    from PIL import Image as Pillow

    left, top, right, bottom = box
    # Pillow divides by the last entry: a corner of the box must not be on the horizon
    shifts = [matrix[2] @ (left - dx, top - dy, 1.0) for dx, dy in ((0, 0), (1, 0), (0, 1))]
    shift = int(np.argmax(np.abs(shifts)))
    left, top = left - (shift == 1), top - (shift == 2)
    texels = level(pixels, *factors)
    height, width = texels.shape[:2]
    scaled = np.diag((width, height, 1.0)) @ matrix
    moved = scaled @ np.array([(1.0, 0.0, left), (0.0, 1.0, top), (0.0, 0.0, 1.0)])
    image = as_pillow(texels).transform(
        (right - left, bottom - top),
        Pillow.Transform.PERSPECTIVE,
        tuple((moved / moved[2, 2]).ravel()[:8].tolist()),
        Pillow.Resampling.BILINEAR,
    )
    values = np.asarray(image)[box[1] - top :, box[0] - left :]
    return np.ascontiguousarray(values).view(np.uint32)[..., 0]


def _draw_border(
    colors: Bytes,
    pixels: Bytes,
    place: _Place,
    strips: Sequence[_Strip],
    box: tuple[int, int, int, int],
) -> None:
    """Sample the pixels that the outline crosses, with the share of each that is covered."""
    left, top, right, bottom = box
    cells = crossed(place.outline)
    inside = (cells >= (left, top)).all(1) & (cells < (right, bottom)).all(1)
    cells = cells[inside]
    if not len(cells):
        return
    parts = (np.arange(SHARES) + 0.5) / SHARES
    at = np.stack(np.meshgrid(parts, parts), -1).reshape(-1, 2)
    places = (cells[:, None] + at).reshape(-1, 2)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        u, v, w = place.matrix @ np.column_stack((places, np.ones(len(places)))).T
        u, v = u / w, v / w
    nearness = places @ place.plane[:2] + place.plane[2]
    covered = (u >= 0) & (u < 1) & (v >= 0) & (v < 1) & (nearness <= place.nearest)
    if np.isfinite(place.nearest):
        covered &= nearness > 0
    count = covered.reshape(len(cells), -1).sum(1)
    # where the covered samples of a pixel are on the mean
    sums = (np.where(covered, c, 0.0).reshape(len(cells), -1).sum(1) for c in (u, v, nearness))
    mean_u, mean_v, mean_near = (total / np.maximum(count, 1) for total in sums)
    values = np.zeros((len(cells), 4), np.float32)
    for _, near, far, factors in strips:
        chosen = np.flatnonzero((mean_near > far) & (mean_near <= near) & (count > 0))
        texels = level(pixels, *factors)
        height, width = texels.shape[:2]
        values[chosen] = _bilinear(texels, mean_u[chosen] * width, mean_v[chosen] * height)
    values *= (count / SHARES**2).astype(np.float32)[:, None]
    colors[cells[:, 1] - top, cells[:, 0] - left] = values + np.float32(0.5)


def _bilinear(texels: Bytes, x: Array, y: Array) -> Floats:
    """Texels interpolated at places, (n, 4); beyond the border the outermost go on."""
    height, width = texels.shape[:2]
    x, y = np.clip(x - 0.5, 0, width - 1), np.clip(y - 0.5, 0, height - 1)
    left, top = x.astype(np.intp), y.astype(np.intp)
    right, below = np.minimum(left + 1, width - 1), np.minimum(top + 1, height - 1)
    s, t = (x - left)[:, None], (y - top)[:, None]
    upper = texels[top, left] * (1 - s) + texels[top, right] * s
    lower = texels[below, left] * (1 - s) + texels[below, right] * s
    return np.asarray(upper * (1 - t) + lower * t, np.float32)


# -- over each other ---------------------------------------------------------------------------


def lay_pictures(pixels: Floats, pictures: Sequence[Hung], sight: Sight) -> None:
    """Blend pictures over what is there, the farthest first.

    Parameters
    ----------
    pixels : (h · w, 4) float32
        Written to: colour (0 … 255) multiplied by opacity, opacity (0 … 1).
    pictures : sequence of Hung
    sight : Sight
        Of the window.
    """
    ordered = _from_far(pictures)
    if ordered is None:
        every = np.arange(sight.width * sight.height)
        lay_over(pixels, [sheet_at(picture, every, sight.width) for picture in pictures])
        return
    for picture in ordered:
        rows = np.s_[picture.top : picture.bottom, picture.left : picture.right]
        target = pixels.reshape(sight.height, sight.width, 4)[rows]
        own = picture.colors.astype(np.float32)
        own *= np.float32(picture.opacity)
        own[..., 3] *= np.float32(1 / 255)
        target *= 1 - own[..., 3:]
        target += own


def sheet_at(
    picture: Hung,
    samples: NDArray[np.intp],
    width: int,
    offset: tuple[int, int] = (0, 0),
    fineness: int = 1,
) -> Sheet:
    """What a picture shows at some samples.

    Parameters
    ----------
    picture : Hung
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


def _from_far(pictures: Sequence[Hung]) -> list[Hung] | None:
    """The order in which to lay pictures over each other; None if there is none for all places."""
    left = list(range(len(pictures)))
    order: list[Hung] = []
    while left:
        free = [i for i in left if all(i == j or _may_be_under(pictures, i, j) for j in left)]
        if not free:
            return None
        order.append(pictures[free[0]])
        left.remove(free[0])
    return order


def _may_be_under(pictures: Sequence[Hung], one: int, other: int) -> bool:
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
