"""Curves as a camera sees them: cubic Bézier pieces, as the paths of SVG have them.

A camera is a matrix on homogeneous points, so the picture of a B-spline is one rational Bézier
piece for every span. Of curves without weights up to the third degree a parallel view shows
cubics: they are exact. All else is approximated by cubics within a bound that is proved.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.exchange.cad.cad_curves import bezier_pieces
from bozzetto.exchange.svg.path_data import Subpath
from bozzetto.geometry.shapes import Curve
from bozzetto.view.camera import Camera

NEAREST: Final = 1e-3
"""Depth at which pictures are cut off, as a share of the distance from eye to target: what
lies nearer fills the canvas many times over."""

FAR_OFF: Final = 1e-9
"""Share of their own coordinates within which pieces are right at best: it matters only a
million pixels off the canvas, where rounding could ask for halving without end."""

SMALLEST: Final = 2.0**-24
"""Share of a span below which nothing is halved. What is left then lies on the plane of the cut."""

FRONT: Final = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, -1.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
"""The front view in millimetres of the world: (x, y, z) is seen at (x, −z)."""
FRONT.flags.writeable = False

PLAN: Final = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, -1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
"""The view from above in millimetres of the world: (x, y, z) is seen at (x, −y)."""
PLAN.flags.writeable = False


def camera_matrix(camera: Camera) -> Array:
    """Return the matrix from homogeneous points, mm, to homogeneous pixels.

    Returns
    -------
    (3, 4) float64
        The last row gives the depth in distances of the target (perspective), or one.
    """
    right, up, forward = camera.axes
    middle = 0.5 * np.asarray(camera.viewport)
    flat = camera.pixels_per_mm * np.vstack((right, -up))
    if camera.kind == "orthographic":
        rows, shift = np.vstack((flat, np.zeros(3))), np.append(middle, 1.0)
    else:
        depth = forward / camera.distance
        rows, shift = np.vstack((flat + np.outer(middle, depth), depth)), np.zeros(3)
    return np.column_stack((rows, shift - rows @ np.asarray(camera.eye)))


def picture(curve: Curve, matrix: Array, tolerance: float) -> list[Subpath]:
    """Return the visible part of a curve.

    Parameters
    ----------
    curve : Curve
        As `checked_curves` gives it.
    matrix : (3, 4) float
        `FRONT`, or that of a camera.
    tolerance : float
        Farthest that a cubic may stray from the picture, in the units of the picture.

    Returns
    -------
    list of Subpath
        The stretches before the eye; of a curve of degree one they are straight lines.
    """
    lifted = bezier_pieces(curve)
    flat = lifted @ matrix.T
    ahead = flat[..., 2] - NEAREST * lifted[..., 3]  # positive where the curve is seen
    if curve.degree == 1:
        cubics, begin, end = _lines(flat, ahead)
    else:
        cubics, begin, end = _cubics(flat, ahead, tolerance)
    breaks = np.flatnonzero(begin[1:] != end[:-1]) + 1
    stretches = [stretch for stretch in np.split(cubics, breaks) if len(stretch)]
    if len(stretches) == 1:
        (ring,) = stretches
        gap = float(np.abs(ring[0, 0] - ring[-1, 3]).max())
        if gap <= (tolerance if curve.closed else 0.0):
            ring[-1, 3] = ring[0, 0]
            return [Subpath(ring, True)]
    return [Subpath(stretch, False) for stretch in stretches]


def _lines(flat: Array, ahead: Array) -> tuple[Array, Array, Array]:
    """Return straight spans, cut where they pass the eye, and their ends, in spans."""
    seen = (ahead > 0).any(axis=1)
    flat, (first, last) = flat[seen], ahead[seen].T
    crossing = first / np.where(first == last, 1.0, first - last)
    low, high = np.where(first > 0, 0.0, crossing), np.where(last > 0, 1.0, crossing)
    ends = [
        (1 - share)[:, None] * flat[:, 0] + share[:, None] * flat[:, 1] for share in (low, high)
    ]
    begin, end = (place[:, :2] / place[:, 2:] for place in ends)
    thirds = (begin, begin + (end - begin) / 3, end - (end - begin) / 3, end)
    number = np.flatnonzero(seen).astype(np.float64)
    return np.stack(thirds, axis=1), number + low, number + high


def _cubics(flat: Array, ahead: Array, tolerance: float) -> tuple[Array, Array, Array]:
    """Return cubics near enough to rational pieces, and their ends, in spans.

    Whatever is not near enough, or not altogether before the eye, is halved.
    """
    pieces = np.concatenate((flat, ahead[..., None]), axis=2)
    begin = np.arange(len(pieces), dtype=np.float64)
    size = 1.0
    found: list[tuple[Array, Array, Array]] = []
    while len(pieces) and size > SMALLEST:
        seen = pieces[..., 3] > 0
        good = np.asarray(seen.all(axis=1))
        cubics, strays = _fitted(pieces[good, :, :3])
        near = strays <= np.maximum(tolerance, FAR_OFF * np.abs(cubics).max(axis=(1, 2)))
        good[good] = near
        found.append((cubics[near], begin[good], begin[good] + size))
        rest = seen.any(axis=1) & ~good
        size /= 2
        begin = (begin[rest, None] + (0.0, size)).ravel()
        pieces = _halves(pieces[rest])
    cubics, begin, end = (np.concatenate(column) for column in zip(*found, strict=True))
    order = np.argsort(begin)
    return cubics[order], begin[order], end[order]


def _fitted(pieces: Array) -> tuple[Array, Array]:
    """Fit cubics to the ends and end derivatives of rational pieces; return their errors, too.

    With the piece n / w and the cubic c, the polynomial c w − n lies within its Bézier
    coefficients (Farin, "Curves and Surfaces for CAGD", on products and the convex hull); their
    largest over the smallest coefficient of w bounds the distance.

    Parameters
    ----------
    pieces : (k, degree + 1, 3) float
        Homogeneous; third coordinate above zero.

    Returns
    -------
    cubics : (k, 4, 2) float
    strays : (k,) float
    """
    degree = pieces.shape[1] - 1
    places, w = pieces[..., :2], pieces[..., 2:]
    begin, end = places[:, 0] / w[:, 0], places[:, -1] / w[:, -1]
    out = degree / 3 * (places[:, 1] - begin * w[:, 1]) / w[:, 0]
    back = degree / 3 * (places[:, -2] - end * w[:, -2]) / w[:, -1]
    cubics = np.stack((begin, begin + out, end + back, end), axis=1)
    excess = np.zeros((len(pieces), degree + 4, 2))
    for i, corner in enumerate(np.moveaxis(cubics, 1, 0)):
        part = _binomials(3)[i] * _binomials(degree)[:, None]
        excess[:, i : i + degree + 1] += part * (corner[:, None] * w - places)
    excess /= _binomials(degree + 3)[:, None]
    return cubics, np.linalg.norm(excess, axis=2).max(axis=1) / w.min(axis=(1, 2))


def _binomials(degree: int) -> Array:
    from scipy.special import binom

    return np.asarray(binom(degree, np.arange(degree + 1)))


def _halves(pieces: Array) -> Array:
    """Cut Bézier pieces in the middle (de Casteljau), shape (2 k, degree + 1, n)."""
    left, right = [pieces[:, 0]], [pieces[:, -1]]
    while pieces.shape[1] > 1:
        pieces = (pieces[:, :-1] + pieces[:, 1:]) / 2
        left.append(pieces[:, 0])
        right.append(pieces[:, -1])
    both = np.stack((np.stack(left, axis=1), np.stack(right[::-1], axis=1)), axis=1)
    return both.reshape(-1, *both.shape[2:])
