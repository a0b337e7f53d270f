"""The page in a photograph: its four corners found, and straightened to a rectangle."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from bozzetto.arrays import Array, Flags

COARSE: Final = 256
"""Longest side of the picture in which the page is looked for, pixels."""

LINES: Final = 9
"""Side of the closing that takes lines away there, pixels."""

CONTRAST: Final = 0.15
"""Least share by which what a page lies on is darker, at each of its sides."""

LEAST_MARGIN: Final = 2.0
"""Least distance of a page's corners from the picture's border, pixels of the coarse picture."""

LEVELS: Final = 16
"""Levels of brightness at which a page is looked for."""

PAGE_SHARE: Final = (0.15, 0.97)
"""Smallest and largest share of a picture that a page takes."""

RECTANGULAR: Final = 0.95
"""Least overlap, intersection over union, of a page and the quadrilateral around it."""

FLAT: Final = 1e-3
"""Difference from 1 of k2 and k3 below which opposite sides are parallel."""


def find_page(gray: NDArray[np.float32]) -> Array | None:
    """Find a bright page on a darker ground.

    Parameters
    ----------
    gray : (h, w) float32
        Brightness, 0 … 1.

    Returns
    -------
    (4, 2) float or None
        Corners in pixels, x and y: top left, top right, bottom right, bottom left. None where the
        whole picture is paper, or what is bright is no quadrilateral within the picture.
    """
    from PIL import Image
    from scipy import ndimage

    step = max(1.0, max(gray.shape) / COARSE)
    size = (max(1, round(gray.shape[1] / step)), max(1, round(gray.shape[0] / step)))
    if min(size) < 2 * LINES:
        return None
    small = np.asarray(Image.fromarray(gray).resize(size, Image.Resampling.BOX))
    plain = ndimage.grey_closing(small, size=(LINES, LINES), mode="nearest")
    low, high = np.percentile(plain, (2, 98))
    if high - low < CONTRAST:
        return None
    best, found = RECTANGULAR, None
    # No one level parts a page from its table where a shadow lies on both.
    for level in np.linspace(low, high, LEVELS + 2)[1:-1]:
        corners, overlap = _page_at(plain, float(level))
        if corners is not None and overlap > best:
            best, found = overlap, corners
    if found is None:
        return None
    return _refined(found * np.array(gray.shape[::-1]) / size, gray, 2.0 * step)


def _page_at(plain: NDArray[np.float32], level: float) -> tuple[Array | None, float]:
    """Return the quadrilateral of what is brighter than a level, and how well it fits."""
    from scipy import ndimage
    from skimage.morphology import convex_hull_image

    labels, count = ndimage.label(plain > level)
    if not count:
        return None, 0.0
    largest = 1 + int(np.argmax(np.bincount(labels.ravel())[1:]))
    page: Flags = ndimage.binary_fill_holes(labels == largest)
    if not PAGE_SHARE[0] < page.mean() < PAGE_SHARE[1]:
        return None, 0.0
    corners = _quadrilateral(convex_hull_image(page))
    if corners is None or _least_margin(corners, page.shape) < LEAST_MARGIN:
        return None, 0.0
    if _least_contrast(corners, plain) < CONTRAST:
        return None, 0.0
    return corners, _overlap(corners, page)


def _least_margin(corners: Array, shape: tuple[int, ...]) -> float:
    return float(min(corners.min(), (np.array(shape[::-1]) - corners).min()))


def _least_contrast(corners: Array, plain: NDArray[np.float32]) -> float:
    """Return how much brighter a page is than what lies beside it, at the side with the least."""
    from scipy import ndimage

    found = []
    for start, end in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        outward = np.array([end[1] - start[1], start[0] - end[0]]) / np.linalg.norm(end - start)
        at = start + np.linspace(0.05, 0.95, 40)[:, None] * (end - start)
        inner, outer = (
            ndimage.map_coordinates(
                plain, (places[:, 1] - 0.5, places[:, 0] - 0.5), order=1, mode="nearest"
            )
            for places in (at - 3.0 * outward, at + LEAST_MARGIN * outward)
        )
        found.append(float(np.median(1.0 - outer / np.maximum(inner, 1e-3))))
    return min(found)


def straightened(pixels: NDArray[np.uint8], corners: Array) -> NDArray[np.uint8]:
    """Return the page of a photograph as a rectangle, as large as it is in the picture.

    Parameters
    ----------
    pixels : (h, w, 4) uint8
        RGBA.
    corners : (4, 2) float
        As of `find_page`.

    Returns
    -------
    (h', w', 4) uint8
        RGBA. The ratio of the sides is that of the page itself, where perspective tells it.
    """
    from PIL import Image

    sides = np.linalg.norm(corners - np.roll(corners, -1, axis=0), axis=1)
    width, height = max(sides[0], sides[2]), max(sides[1], sides[3])
    ratio = aspect_ratio(corners, (pixels.shape[1], pixels.shape[0]))
    size = (round(width), round(width / ratio)) if width > height else (
        round(height * ratio), round(height)
    )  # fmt: skip
    size = (max(8, size[0]), max(8, size[1]))
    goal = np.array([(0, 0), (size[0], 0), size, (0, size[1])], float)
    matrix = homography(goal, corners)
    image = Image.fromarray(np.ascontiguousarray(pixels), "RGBA")
    values = (matrix / matrix[2, 2]).ravel()[:8].tolist()
    made = image.transform(size, Image.Transform.PERSPECTIVE, values, Image.Resampling.BICUBIC)
    return np.asarray(made)


def homography(source: Array, target: Array) -> Array:
    """Return the projective map, (3, 3), of four points (4, 2) to four others."""
    rows = []
    for (x, y), (u, v) in zip(source, target, strict=True):
        rows.append((x, y, 1, 0, 0, 0, -u * x, -u * y, -u))
        rows.append((0, 0, 0, x, y, 1, -v * x, -v * y, -v))
    return np.asarray(np.linalg.svd(np.array(rows, float))[2][-1].reshape(3, 3))


def aspect_ratio(corners: Array, size: tuple[int, int]) -> float:
    """Return width over height of a rectangle that was photographed.

    Zhang and He, "Whiteboard scanning and image enhancement" (Digital Signal Processing 17, 2007),
    equations 11, 12, 20 and 21: square pixels and the optical axis in the picture's middle are
    assumed. Where a pair of sides is parallel the picture does not tell the focal length; then, and
    where the equations have no solution, the mean lengths of opposite sides are taken.

    Parameters
    ----------
    corners : (4, 2) float
        As of `find_page`.
    size : (width, height)
        Of the picture, pixels.
    """
    sides = np.linalg.norm(corners - np.roll(corners, -1, axis=0), axis=1)
    plain = float((sides[0] + sides[2]) / (sides[1] + sides[3]))
    centred = corners - 0.5 * np.asarray(size, float)
    # The paper's m1 … m4 are bottom left, bottom right, top left, top right.
    m3, m4, m2, m1 = np.column_stack((centred, np.ones(4)))
    k2 = np.cross(m1, m4) @ m3 / (np.cross(m2, m4) @ m3)
    k3 = np.cross(m1, m4) @ m2 / (np.cross(m3, m4) @ m2)
    if min(abs(k2 - 1.0), abs(k3 - 1.0)) < FLAT:
        return plain
    n2, n3 = k2 * m2 - m1, k3 * m3 - m1
    squared = -(n2[0] * n3[0] + n2[1] * n3[1]) / (n2[2] * n3[2])
    if not squared > 0.0:
        return plain
    weight = np.array([1.0 / squared, 1.0 / squared, 1.0])
    ratio = float(np.sqrt((weight * n2 * n2).sum() / (weight * n3 * n3).sum()))
    return ratio if 0.8 < ratio / plain < 1.25 else plain


def _quadrilateral(hull: Flags) -> Array | None:
    """Return the four corners of a convex region: vertices go whose loss adds the least area."""
    from scipy.spatial import ConvexHull

    border: Array = np.argwhere(hull)[:, ::-1].astype(float) + 0.5
    if len(border) < 8:
        return None
    corners = border[ConvexHull(border).vertices]
    while len(corners) > 4:
        # An edge goes by lengthening its neighbours until they meet.
        best: tuple[float, int, Array] | None = None
        count = len(corners)
        for k in range(count):
            a, b, c, d = (corners[(k + step) % count] for step in (-1, 0, 1, 2))
            along, back = b - a, c - d
            turn = along[0] * back[1] - along[1] * back[0]
            if abs(turn) < 1e-9:
                continue
            share = ((d - a)[0] * back[1] - (d - a)[1] * back[0]) / turn
            if share <= 1.0:
                continue
            meeting = a + share * along
            across, down = c - b, meeting - b
            added = 0.5 * abs(across[0] * down[1] - across[1] * down[0])
            if best is None or added < best[0]:
                best = (added, k, meeting)
        if best is None:
            return None
        _, k, meeting = best
        corners = corners.copy()
        corners[k] = meeting
        corners = np.delete(corners, (k + 1) % count, axis=0)
    return _ordered(corners)


def _ordered(corners: Array) -> Array:
    """Return corners from the top left on, clockwise as they are seen."""
    centred = corners - corners.mean(0)
    turned = corners[np.argsort(np.arctan2(centred[:, 1], centred[:, 0]))]
    return np.roll(turned, -int(turned.sum(1).argmin()), axis=0)


def _overlap(corners: Array, page: Flags) -> float:
    from skimage.draw import polygon2mask

    inside = polygon2mask(page.shape, corners[:, ::-1] - 0.5)
    return float((inside & page).sum() / max(1, (inside | page).sum()))


def _refined(corners: Array, gray: NDArray[np.float32], reach: float) -> Array:
    """Move the sides to where the brightness falls most, and return where they meet."""
    from scipy import ndimage

    lines = []
    offsets = np.arange(-reach, reach + 0.5, 0.5)
    for start, end in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        normal = np.array([end[1] - start[1], start[0] - end[0]]) / np.linalg.norm(end - start)
        at = start + np.linspace(0.1, 0.9, 80)[:, None] * (end - start)
        places = at[:, None] + offsets[:, None] * normal
        values = ndimage.map_coordinates(
            gray, (places[..., 1] - 0.5, places[..., 0] - 0.5), order=1, mode="nearest"
        )
        smooth = ndimage.uniform_filter1d(values, 5, axis=1)
        step = np.abs(smooth[:, 4:] - smooth[:, :-4])
        shift = offsets[2:-2][step.argmax(1)]
        usual = np.abs(shift - np.median(shift)) <= 2.0
        kept = (at + shift[:, None] * normal)[usual]
        middle = kept.mean(0)
        along = np.linalg.svd(kept - middle, full_matrices=False)[2][0]
        across = np.array([-along[1], along[0]])
        lines.append((across, across @ middle))
    met = []
    for k in range(4):
        (one, at_one), (other, at_other) = lines[k - 1], lines[k]
        met.append(np.linalg.solve(np.array([one, other]), np.array([at_one, at_other])))
    return np.array(met)
