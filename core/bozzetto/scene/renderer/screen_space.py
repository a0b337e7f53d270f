"""Effects from the depth buffer alone: dark hollows, and contour lines."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from bozzetto.arrays import Floats
    from bozzetto.scene.renderer.view_transform import ViewTransform
    from bozzetto.scene.renderer.zbuffer import DepthBuffer

STRIDE = 4
"""Pixels (at one sample each) between the places where hollows are measured."""

REACH = 5
"""Radius of the neighbourhood, in strides."""

DEEPEST = 0.34
"""Most light that a hollow keeps out."""

STEEPEST = 8.0
"""Greatest slope of depth that a surface is believed to have."""

JUMP = 3.0
"""Step in depth beyond what the slope foretells that makes a contour, in pixel sizes."""

GROWTH = 2.0
"""How many times steeper a smooth surface may get from one pixel to the next; it does so
towards its horizon."""

BEND = 0.62
"""Cosine between neighbouring normals below which an inner edge is drawn."""

OUTER, INNER = 0.62, 0.26
"""Strength of contours and of inner edges."""


def _depth(buffer: DepthBuffer, sight: ViewTransform) -> Floats:
    """Return depth in pixel sizes at the target; infinite where nothing is seen."""
    near = buffer.nearness.reshape(buffer.height, buffer.width)
    if not sight.perspective:
        return np.float32(-sight.focal) * near
    with np.errstate(divide="ignore"):
        # a pixel measures z / focal, so on this scale log z has slopes of one pixel size
        depth = np.float32(-sight.focal) * np.log(np.maximum(near, 0))
    return np.asarray(depth, np.float32)


def cavities(buffer: DepthBuffer, sight: ViewTransform, normal: Floats, fineness: int) -> Floats:
    """Return how much light hollows keep out, shape (h, w), 0 … 1.

    The depth buffer is compared with its own blurred copy: what lies deeper than its
    neighbourhood is dark (Luft, Colditz & Deussen, "Image enhancement by unsharp masking
    the depth buffer", 2006, section 3). Two departures: the blur leaves out the
    background, so a shape in front of nothing is not changed; and what is expected in
    the neighbourhood is the plane through the place itself, so a flat face stays even up
    to its edges, where its neighbourhood is one-sided.

    Parameters
    ----------
    buffer : Buffer
        Nearness and triangle of each sample.
    sight : ViewTransform
        The transform of the window.
    normal : (3, h, w) float32
        Right, up, towards the eye.
    fineness : int
        Samples per pixel along each axis.
    """
    stride = STRIDE * fineness
    depth = _depth(buffer, sight)[::stride, ::stride]
    across, up, near = normal[:, ::stride, ::stride]
    there = np.isfinite(depth)
    weight = there.astype(np.float32)
    row, column = np.indices(depth.shape, np.float32)
    total = np.stack((weight, np.where(there, depth, 0), column * weight, row * weight))
    total = _box(_box(total))  # two boxes make a tent
    share = np.maximum(total[0], np.float32(1e-6))
    mean, mean_column, mean_row = total[1:] / share
    steep = np.float32(stride) / np.maximum(near, np.float32(1.0 / STEEPEST))
    expected = depth + steep * ((mean_column - column) * across - (mean_row - row) * up)
    below = np.where(there, expected - mean, 0.0) / np.float32(stride * REACH)
    dark = (np.float32(DEEPEST) * np.clip(below, 0.0, 1.0)).astype(np.float32)
    # Carried one place over the border, for the interpolation there.
    carried, share = _spread(dark), _spread(weight)
    dark = np.where(there, dark, carried / np.maximum(share, np.float32(1e-6)))
    return _enlarged(dark.astype(np.float32), stride, buffer.height, buffer.width)


def _spread(image: Floats) -> Floats:
    """Return the sum over the 3 × 3 pixels around each."""
    padded = np.pad(image, 1)
    rows = padded[:-2] + padded[1:-1] + padded[2:]
    return np.asarray(rows[:, :-2] + rows[:, 1:-1] + rows[:, 2:], np.float32)


def _box(images: Floats) -> Floats:
    """Return the mean over (2 REACH + 1)² pixels of several images; zero beyond the border."""
    size = 2 * REACH + 1
    result = images.astype(np.float64)
    for axis in (1, 2):
        padding = [(0, 0), (0, 0), (0, 0)]
        padding[axis] = (REACH + 1, REACH)
        total = np.moveaxis(np.cumsum(np.pad(result, padding), axis), axis, 0)
        result = np.moveaxis(total[size:] - total[:-size], 0, axis) / size
    return result.astype(np.float32)


def _enlarged(image: Floats, stride: int, height: int, width: int) -> Floats:
    """Enlarge by bilinear interpolation."""
    result = image
    for axis, size in ((0, height), (1, width)):
        place = np.arange(size, dtype=np.float32) / np.float32(stride)
        low = np.minimum(place.astype(np.intp), result.shape[axis] - 1)
        high = np.minimum(low + 1, result.shape[axis] - 1)
        t = place - low
        t = t[:, None] if axis == 0 else t[None, :]
        a, b = np.take(result, low, axis), np.take(result, high, axis)
        result = a + (b - a) * t
    return result


def contours(buffer: DepthBuffer, sight: ViewTransform, normal: Floats, fineness: int) -> Floats:
    """Return the strength of contour lines at each pixel, shape (h, w), 0 … 1.

    A contour runs along the nearer side where depth jumps by more than the slope
    foretells; an inner edge where the normal jumps.

    Parameters
    ----------
    buffer : Buffer
        Nearness and triangle of each sample.
    sight : ViewTransform
        The transform of the window.
    normal : (3, h, w) float32
        Normals of what is seen.
    fineness : int
        Samples per pixel along each axis; lines are as wide as a pixel.
    """
    depth = _depth(buffer, sight)
    there = np.isfinite(depth)
    # a far, even ground behind everything
    depth = np.where(there, depth, np.float32(1e9))
    strength = np.zeros(depth.shape, np.float32)
    for axis in (0, 1):
        d = depth if axis == 0 else depth.T
        line = strength if axis == 0 else strength.T
        seen = there if axis == 0 else there.T
        step = np.diff(d, axis=0)
        steep = np.abs(step)  # the smaller slope on either side; at the border the only one
        slope = np.concatenate((steep[:1], np.minimum(steep[:-1], steep[1:]), steep[-1:]))
        bound = np.float32(JUMP) + np.float32(GROWTH) * slope
        farther = seen[:-1] & (step > bound[:-1])
        line[:-1][farther] = OUTER
        nearer = seen[1:] & (-step > bound[1:])
        line[1:][nearer] = OUTER
        n = normal if axis == 0 else normal.transpose(0, 2, 1)
        same = np.einsum("kij,kij->ij", n[:, :-1], n[:, 1:])
        edge = (same < BEND) & seen[:-1] & seen[1:] & (line[:-1] == 0)
        line[:-1][edge] = INNER
    return strength if fineness == 1 else _widened(strength)


def _widened(image: Floats) -> Floats:
    """Return the greatest value of each pixel and its four neighbours."""
    result = image.copy()
    np.maximum(result[1:], image[:-1], out=result[1:])
    np.maximum(result[:-1], image[1:], out=result[:-1])
    np.maximum(result[:, 1:], image[:, :-1], out=result[:, 1:])
    np.maximum(result[:, :-1], image[:, 1:], out=result[:, :-1])
    return result
