"""Warp of a picture onto the sheet.

Those within are interpolated by Pillow, from a level of detail that suits the distance; those
on the border, few, are sampled here with their true share.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.scene.renderer.clipping import Polygon, crossed, cut
from bozzetto.scene.renderer.mipmaps import as_pillow, bilinear, level, rung

if TYPE_CHECKING:
    from bozzetto.arrays import Array, Bytes, Floats
    from bozzetto.scene.renderer.homography import Place

Box = tuple[int, int, int, int]

SHARES: Final = 4
"""Samples along each axis of a pixel on the border, that tell how much of it is covered."""

STRIP: Final = 1.45
"""Ratio of depths within which a picture is reduced by the same numbers."""

STRIPS: Final = 8
"""Most strips of a picture that are reduced differently."""

LEAST_TURN: Final = 0.01
"""By how much a picture may be turned or slanted and count as square on, texels at the far end."""


def warp(pixels: Bytes, place: Place, box: Box) -> Bytes:
    """Return a picture as it is seen in a box of the window.

    Parameters
    ----------
    pixels : (h, w, 4) uint8
        RGBA, straight alpha.
    place : Place
        Place of the picture in the window.
    box : (left, top, right, bottom)
        Pixels of the window.

    Returns
    -------
    (bottom − top, right − left, 4) uint8
        Multiplied by the opacity; 0 beside the picture.
    """
    left, top, right, bottom = box
    strips = _strips(pixels, place)
    result = np.zeros((bottom - top, right - left), np.uint32)
    for outline, near, far, factors in strips:
        low = np.clip(np.floor(outline.min(0)).astype(int) - 1, (left, top), (right, bottom))
        high = np.clip(np.ceil(outline.max(0)).astype(int) + 1, (left, top), (right, bottom))
        (x0, y0), (x1, y1) = low.tolist(), high.tolist()
        if x1 <= x0 or y1 <= y0:
            continue
        part = interpolated(pixels, factors, place.matrix, (x0, y0, x1, y1))
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


def _strips(pixels: Bytes, place: Place) -> list[_Strip]:
    """Split a picture into strips that are reduced by the same numbers, the nearest first.

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
    """Return by how much to reduce a picture across and down where it is seen at a place."""
    u, v, w = matrix @ (*middle, 1.0)
    height, width = pixels.shape[:2]
    slope = (matrix[:2, :2] - np.outer((u / w, v / w), matrix[2, :2])) / w
    by_u, by_v = np.linalg.norm(slope, axis=1)
    return rung(width * by_u, width), rung(height * by_v, height)


def _over(plane: Array, box: Box) -> Floats:
    """Evaluate an affine function at the middles of the pixels of a box, (h, w)."""
    x = plane[0] * (np.arange(box[0], box[2]) + 0.5) + plane[2]
    y = plane[1] * (np.arange(box[1], box[3]) + 0.5)
    return np.asarray(x.astype(np.float32) + y.astype(np.float32)[:, None])


def interpolated(
    pixels: Bytes, factors: tuple[int, int], matrix: Array, box: Box
) -> NDArray[np.uint32]:
    """Sample a reduced picture at the middles of the pixels of a box, bilinear; 0 beside it."""
    from PIL import Image

    left, top, right, bottom = box
    # Pillow divides by the last entry: a corner of the box must not be on the horizon
    shifts = [matrix[2] @ (left - dx, top - dy, 1.0) for dx, dy in ((0, 0), (1, 0), (0, 1))]
    shift = int(np.argmax(np.abs(shifts)))
    left, top = left - (shift == 1), top - (shift == 2)
    texels = level(pixels, *factors)
    height, width = texels.shape[:2]
    scaled = np.diag((width, height, 1.0)) @ matrix
    moved = scaled @ np.array([(1.0, 0.0, left), (0.0, 1.0, top), (0.0, 0.0, 1.0)])
    moved /= moved[2, 2]
    size = (right - left, bottom - top)
    if _is_square_on(moved, size, (width, height)):
        return _scaled(texels, moved, size)[box[1] - top :, box[0] - left :]
    image = as_pillow(texels).transform(
        size,
        Image.Transform.PERSPECTIVE,
        tuple(moved.ravel()[:8].tolist()),
        Image.Resampling.BILINEAR,
    )
    values = np.asarray(image)[box[1] - top :, box[0] - left :]
    return np.ascontiguousarray(values).view(np.uint32)[..., 0]


def _is_square_on(matrix: Array, size: tuple[int, int], texels: tuple[int, int]) -> bool:
    """Whether a matrix from the sheet to texels is a scaling and a shift, to a hundredth texel."""
    turn = max(abs(matrix[0, 1]) * size[1], abs(matrix[1, 0]) * size[0])
    slant = float(np.abs(matrix[2, :2]) @ size) * max(texels)
    upright = matrix[0, 0] > 0 and matrix[1, 1] > 0
    return bool(upright and turn < LEAST_TURN and slant < LEAST_TURN)


def _scaled(texels: Bytes, matrix: Array, size: tuple[int, int]) -> NDArray[np.uint32]:
    """Sample texels that are only scaled and shifted: rows, then columns, which is faster."""
    from PIL import Image

    cells, parts = [], []
    for axis in (0, 1):
        scale, begin = matrix[axis, axis], matrix[axis, 2]
        whole = texels.shape[1 - axis]
        low = int(np.clip(np.ceil(-begin / scale), 0, size[axis]))
        high = int(np.clip(np.floor((whole - begin) / scale), low, size[axis]))
        cells.append((low, high))
        parts.append([min(max(begin + scale * k, 0.0), float(whole)) for k in (low, high)])
    result = np.zeros((size[1], size[0]), np.uint32)
    (left, right), (top, bottom) = cells
    if left < right and top < bottom:
        image = as_pillow(texels).resize(
            (right - left, bottom - top),
            Image.Resampling.BILINEAR,
            box=(parts[0][0], parts[1][0], parts[0][1], parts[1][1]),
        )
        result[top:bottom, left:right] = np.asarray(image).view(np.uint32)[..., 0]
    return result


def _draw_border(
    colors: Bytes,
    pixels: Bytes,
    place: Place,
    strips: Sequence[_Strip],
    box: Box,
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
        values[chosen] = bilinear(texels, mean_u[chosen] * width, mean_v[chosen] * height)
    values *= (count / SHARES**2).astype(np.float32)[:, None]
    colors[cells[:, 1] - top, cells[:, 0] - left] = values + np.float32(0.5)
