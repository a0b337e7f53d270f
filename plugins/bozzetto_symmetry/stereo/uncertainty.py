"""How far a point in space may be off when the hand is off by a pixel.

A point is where it has to be so that it is seen at the drawn place, and its mirror image on
the other drawn curve: three equations. Their derivative says what a pixel is worth in space,
place by place. The residual of the rays does not: it is 0 however badly they cross.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bozzetto.arrays import Array
from bozzetto_symmetry.stereo.mirror_camera import MIRROR, Stereo

HAND: Final = 1.5
"""Standard deviation of a hand that draws with care, px."""

YELLOW: Final = 1.5
"""Uncertainty at the noise of a hand from which a place is doubtful, % of the diagonal."""

RED: Final = 4.0
"""Uncertainty at the noise of a hand above which a place is hardly known, %."""

ANYWHERE: Final = 100.0
"""Standard deviation of a point of which nothing is known, in visible heights of the sheet:
far larger than any useful figure, and still a number."""

TOO_NEAR: Final = 1e-9
"""Depth before the eye, in visible heights of the sheet, below which nothing is seen."""


LEFT: Final = 0.93
"""Share of `curve_sigmas` that a fitted curve shows: it evens out the shorter waves of the
tremor. Measured at 30 and 60° with a tremor that stays alike over a 25th of the curve."""


def pair_covariances(
    stereo: Stereo, near: ArrayLike, far: ArrayLike, far_tangents: ArrayLike
) -> Array:
    """Return covariances of points from both sides of a pair, for 1 px of noise on either.

    With p(X) the image of a point, the point drawn as `near` and `far` satisfies
    ``p(X) = near`` and ``n · p(M X) = n · far``, where n is the normal of the far curve: the
    noise along that curve does nothing, because the partner is looked for along it. So the
    covariance is that of the inverse of the 3 × 3 derivative of these three equations. It
    holds the short baseline of a view along the plane as well as a far curve that runs along
    its epipolar line.

    Parameters
    ----------
    stereo : Stereo
        The camera of the view and its mirror image.
    near, far : (n, 2) array_like
        Pairs on common epipolar lines, px.
    far_tangents : (n, 2) array_like
        Unit directions of the far curve at `far`.

    Returns
    -------
    (n, 3, 3) float
        mm² per px², positive definite. Where a pair says nothing at all about a direction,
        or there is no partner (NaN), the standard deviation in it is a hundred visible
        heights of the sheet.
    """
    return point_covariances(stereo, stereo.intersected(near, far), far_tangents)


def point_covariances(stereo: Stereo, points: ArrayLike, far_tangents: ArrayLike) -> Array:
    """Return covariances as `pair_covariances` of points (n, 3) mm that are known already."""
    place = np.reshape(np.asarray(points, float), (-1, 3))
    tangents = np.reshape(np.asarray(far_tangents, float), (-1, 2))
    normals = np.nan_to_num(np.column_stack((-tangents[:, 1], tangents[:, 0])))
    mirrored = image_slopes(stereo, place * MIRROR) * MIRROR
    across = np.einsum("ni,nij->nj", normals, mirrored)[:, None]
    return _inverted(stereo, np.concatenate((image_slopes(stereo, place), across), axis=1))


def plane_covariances(stereo: Stereo, pixels: ArrayLike) -> Array:
    """Return covariances of points in the centre plane, for 1 px of noise on the sheet.

    Parameters
    ----------
    stereo : Stereo
        The camera of the view and its mirror image.
    pixels : (n, 2) array_like
        Places on the sheet.

    Returns
    -------
    (n, 3, 3) float
        mm² per px²; nothing across the plane. Capped as in `pair_covariances`.
    """
    slopes = image_slopes(stereo, stereo.on_plane(pixels))
    made = np.zeros((len(slopes), 3, 3))
    made[:, ::2, ::2] = _inverted(stereo, slopes[:, :, ::2])
    return made


def curve_sigmas(
    near: Sequence[Stereo],
    far: Sequence[Stereo],
    points: ArrayLike,
    tangents: ArrayLike,
    *,
    flat: bool = False,
) -> Array:
    """Return how far a curve in space may be off across itself, for 1 px of noise in every view.

    A hand errs slowly, and a fit follows it: what smoothing takes off the noise of single
    places says nothing about this. So every view that shows a place has one error there,
    across its image, and the covariance is that of all views together. It cannot be far more
    than that of a place close by, since the distance from the true curve grows no faster than
    the way between them; that is what is left where the views say nothing.

    Parameters
    ----------
    near, far : sequence of Stereo
        The views with ink of the curve, and those with ink of its mirror image.
    points : (n, 3) array_like
        Places along the curve, mm.
    tangents : (n, 3) array_like
        Directions of the curve there, of any length.
    flat : bool
        The curve is in the centre plane, and errs in it alone.

    Returns
    -------
    (n,) float
        mm per px.
    """
    place = np.reshape(np.asarray(points, float), (-1, 3))
    along = np.reshape(np.asarray(tangents, float), (-1, 3))
    rows = [across_image(image_slopes(stereo, place), along) for stereo in near]
    rows += [across_image(image_slopes(stereo, place * MIRROR) * MIRROR, along) for stereo in far]
    known = np.stack(rows, axis=1)
    if flat:
        known[:, :, 1] = 0.0
    # No row holds anything along the curve: that eigenvalue is 0, the first, and left out.
    stretch = np.linalg.eigvalsh(np.swapaxes(known, 1, 2) @ known)[:, 2 if flat else 1 :]
    least = 1.0 / (ANYWHERE * max(stereo.camera.visible_height for stereo in (*near, *far)))
    sigma = np.sqrt((1.0 / (np.maximum(stretch, 0.0) + least**2)).sum(axis=1))
    apart = np.linalg.norm(place[:, None] - place, axis=2)
    return np.asarray((sigma + apart).min(axis=1, initial=np.inf))


def sigmas(covariances: ArrayLike) -> Array:
    """Return the root mean square distance from the true place, (n,): the root of the trace."""
    trace = np.trace(np.asarray(covariances, float), axis1=1, axis2=2)
    return np.asarray(np.sqrt(np.maximum(trace, 0.0)))


def heat(sigma: ArrayLike, diagonal: float) -> NDArray[np.int8]:
    """Return how much to trust each place.

    Parameters
    ----------
    sigma : (n,) array_like
        mm for 1 px of noise; what is not finite counts as beyond all bounds.
    diagonal : float
        Of the box, mm.

    Returns
    -------
    (n,) int8
        0 well known, 1 doubtful, 2 nearly unknown.
    """
    share = 100.0 * HAND / diagonal * np.asarray(sigma, float)
    share = np.where(np.isfinite(share), share, np.inf)
    return ((share >= YELLOW).astype(np.int8) + (share > RED)).astype(np.int8)


def image_slopes(stereo: Stereo, points: ArrayLike) -> Array:
    """Return derivatives of the image by the point, (n, 2, 3) px/mm; 0 where nothing is seen."""
    camera = stereo.camera
    right, up, forward = camera.axes
    sheet = np.stack((right, -up))
    place = np.reshape(np.asarray(points, float), (-1, 3))
    known = np.asarray(np.isfinite(place).all(axis=1))
    if stereo.parallel:
        return np.asarray(known[:, None, None] * sheet * camera.pixels_per_mm)
    seen = camera.view_space(np.where(known[:, None], place, camera.target))
    depth = seen[:, 2]
    known = known & (depth > TOO_NEAR * camera.visible_height)
    depth = np.where(known, depth, camera.distance)
    tilt = seen[:, :2] * (1.0, -1.0) / depth[:, None]
    focal = camera.pixels_per_mm * camera.distance
    slopes = (focal / depth)[:, None, None] * (sheet - tilt[:, :, None] * forward)
    return np.asarray(np.where(known[:, None, None], slopes, 0.0))


def across_image(slopes: Array, along: Array) -> Array:
    """Return derivatives of the image across the image of a curve, (n, 3)."""
    seen = np.einsum("nij,nj->ni", slopes, along)
    length = np.linalg.norm(seen, axis=1, keepdims=True)
    unit = np.divide(seen, length, out=np.zeros_like(seen), where=length > 0.0)
    return np.asarray(unit[:, :1] * slopes[:, 1] - unit[:, 1:] * slopes[:, 0])


def _inverted(stereo: Stereo, slopes: Array) -> Array:
    """Return covariances from derivatives (n, k, k), with as little prior knowledge as can be."""
    _, stretch, axes = np.linalg.svd(slopes)
    least = 1.0 / (ANYWHERE * stereo.camera.visible_height)
    return np.asarray(np.swapaxes(axes, 1, 2) / (stretch**2 + least**2)[:, None] @ axes)
