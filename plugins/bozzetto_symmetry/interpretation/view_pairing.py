"""One side of a thing drawn in one view, and its mirror image in another one.

The second camera, mirrored in the centre plane, sees what the first side shows: two views of one
curve, whatever their kinds. Two places belong together where their rays nearly meet, and all
places in order say whether the sides do.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array, Flags
from bozzetto.ink import resample
from bozzetto.view import Rays
from bozzetto_symmetry.ink.sides import Side
from bozzetto_symmetry.interpretation.candidate import OUTSIDE, Read, price
from bozzetto_symmetry.interpretation.stereo_triangulation import HalfInSpace
from bozzetto_symmetry.stereo.dynamic_time_warping import Warping, warpings
from bozzetto_symmetry.stereo.mirror_camera import MIRROR, Stereo
from bozzetto_symmetry.stereo.uncertainty import image_slopes, sigmas

SAMPLES: Final = 120
"""Places along each side that are matched."""

UNEVEN: Final = 1.0
"""Price of a step along one side only, px."""

OPEN_END: Final = 2.5
"""Price of a sample without a partner at an end, px."""

FAR: Final = 1e3
"""Distance of rays, px, that counts where they do not meet before both eyes."""

SOFT: Final = 3.0
"""Standard deviation, samples, with which the stations of partners are smoothed."""

STIFF: Final = 25.0
"""Price of uneven stations in their least squares, px for each sample of second difference."""

STILL: Final = 1e-6
"""Weight that holds stations where nothing else does, px² for a sample squared."""

ROUNDS: Final = 6
"""Most steps of the stations."""

NUDGE: Final = 0.25
"""Step, samples, by which slopes are taken."""

SETTLED: Final = 1e-3
"""Step, samples, below which stations stay."""

MISFIT: Final = 2.0
"""Weight of the distance of rays in the cost, px: each of two hands errs."""

BENT: Final = 4.0
"""Weight in the cost of uneven stations (root mean square of their second differences)."""

LEAST: Final = 0.5
"""Share of both sides that must find partners."""

ROUNDING: Final = 1e-12
"""Share of what views say of a place that rounding may take from its least told direction."""

KNOWN: Final = 1e-9
"""Information, per mm², that every direction has."""

REFUSED: Final = 5.0
"""Angle between the rays of two places, degrees, below which they say next to nothing of depth."""

WARNED: Final = 12.0
"""The same, below which they say little."""

NO_DEPTH: Final = (
    "The two views show the two sides alike, and so next to no depth: draw one side again in a "
    "view turned by about 15°."
)
LITTLE_DEPTH: Final = (
    "The two views show the two sides nearly alike, and so little depth: draw one side again in a "
    "view turned a little."
)

TWO_VIEWS: Final = "two views"
"""Beginning of the source of a pair across views."""

SURE: Final = 5.0
"""Cost, px, below which a side in one view and one in another are a pair. With 1 px of tremor true
ones cost 3.7 at most, and sides of different curves 7 and more (40 drawings each)."""


def pair_across(
    views: Sequence[tuple[Stereo, Sequence[Side]]], alone: Sequence[float], box: Array | None
) -> tuple[int, Read] | None:
    """Return the best pair of a side in one view and one in another, and which view comes first.

    Parameters
    ----------
    views : sequence of (Stereo, sequence of Side)
        The sides of one curve in each view; only open ones that are alone in their view pair.
    alone : sequence of float
        What the ink of each view costs if it is read by itself, px.
    box : (2, 3) float or None
        Least and greatest corner of the box, mm.

    Returns
    -------
    tuple or None
        None where no pair explains the ink of two views better than each by itself.
    """
    found = []
    single = [
        (number, stereo, sides[0].pixels)
        for number, (stereo, sides) in enumerate(views)
        if len(sides) == 1 and not sides[0].closed
    ]
    for (i, one, near), (j, other, far) in combinations(single, 2):
        pair = pair_of_views(one, near, other, far, box)
        if pair is not None and pair.cost < min(SURE, alone[i] + alone[j]):
            found.append((pair.cost, i, pair))
    return min(found, key=lambda each: each[:2])[1:] if found else None


def is_whole_pair(read: Read) -> bool:
    """Return whether a reading takes all of a side in one view for all of one in another."""
    return read.source[:1] == (TWO_VIEWS,) and read.coverage == 1.0


def pair_of_views(
    first: Stereo,
    near: ArrayLike,
    second: Stereo,
    far: ArrayLike,
    box: Array | None = None,
) -> Read | None:
    """Read a side in one view and one in another view as mirror images.

    Parameters
    ----------
    first, second : Stereo
        The cameras of both views, in the frame of the centre plane.
    near, far : (n, 2) array_like
        The open sides as drawn, px, in any sense.
    box : (2, 3) float, optional
        Least and greatest corner of the box, mm.

    Returns
    -------
    Read or None
        The pair, along the first side, with the ink of the first view; its cost is comparable to
        those of other readings. None where the sides fit in neither sense.
    """
    lines = [np.asarray(side, float) for side in (near, far)]
    if not all(len(line) > 1 and np.ptp(line, axis=0).any() for line in lines):
        return None
    one, other = (resample(line, count=SAMPLES) for line in lines)
    rays, image = first.rays(one), _mirrored(second.rays(other))
    apart = _apart(first, second, rays, image)
    tables = np.stack((apart, apart[:, ::-1]))
    found = []
    for end in (np.inf, OPEN_END):
        ways = warpings(tables, step=UNEVEN, begin=end, end=end)
        for way, back in zip(ways, (False, True), strict=True):
            read = _read(first, second, (lines[0], one, other), way, back, box)
            if read is not None:
                found.append(read)
    return min(found, key=lambda read: read.cost, default=None)


def _mirrored(rays: Rays) -> Rays:
    return Rays(rays.origins * MIRROR, rays.directions * MIRROR)


def _met(one: Rays, other: Rays) -> tuple[Array, Array, Flags]:
    """Return the ways along rays to where they are nearest to one another, and whether before.

    Rays are matched by broadcasting.
    """
    between = other.origins - one.origins
    cosine = (one.directions * other.directions).sum(axis=-1)
    along = (between * one.directions).sum(axis=-1)
    against = (between * other.directions).sum(axis=-1)
    squared = 1.0 - cosine**2
    with np.errstate(divide="ignore", invalid="ignore"):
        first = (along - cosine * against) / squared
        second = (cosine * along - against) / squared
    return first, second, np.asarray(np.isfinite(first) & np.isfinite(second))


def _apart(first: Stereo, second: Stereo, one: Rays, other: Rays) -> Array:
    """Return how far all rays of two views pass one another, (n, m) px."""
    broad = Rays(one.origins[:, None], one.directions[:, None])
    wide = Rays(other.origins[None], other.directions[None])
    ahead, behind, met = _met(broad, wide)
    met &= (first.parallel | (ahead > 0.0)) & (second.parallel | (behind > 0.0))
    places = broad.origins + ahead[..., None] * broad.directions
    partners = wide.origins + behind[..., None] * wide.directions
    gap = np.linalg.norm(partners - places, axis=-1)
    fine = 1.0 / _size(first, ahead) ** 2 + 1.0 / _size(second, behind) ** 2
    with np.errstate(invalid="ignore"):
        return np.asarray(np.where(met, np.minimum(gap * np.sqrt(0.5 * fine), FAR), FAR))


def _size(stereo: Stereo, way: Array) -> Array:
    """Return the size of a pixel, mm, at ways along the rays."""
    camera = stereo.camera
    height = float(camera.viewport[1])
    if stereo.parallel:
        return np.full(way.shape, camera.height / height)
    opening = 2.0 * float(np.tan(0.5 * np.radians(camera.fov_y))) / height
    return np.asarray(np.maximum(np.nan_to_num(way, nan=1.0), 1e-6) * opening)


def _read(
    first: Stereo,
    second: Stereo,
    drawn: tuple[Array, Array, Array],
    way: Warping,
    back: bool,
    box: Array | None,
) -> Read | None:
    """Return the reading of a matching of evenly spaced places."""
    side, one, other = drawn
    path = way.path
    covered = [float(np.ptp(path[:, axis])) / (SAMPLES - 1.0) for axis in (0, 1)]
    if min(covered) < LEAST:
        return None
    places, counts = np.unique(path[:, 0], return_counts=True)
    stations = np.bincount(path[:, 0], path[:, 1])[places] / counts
    stations[[0, -1]] = path[[0, -1], 1]
    seconds = other[::-1] if back else other
    rays = first.rays(one[places])
    stations, off = _settled(first, second, rays, seconds, _smoothed(stations))
    partners = _at(seconds, stations)
    image = _mirrored(second.rays(partners))
    ahead, behind, met = _met(rays, image)
    if not met.all():
        return None
    points = 0.5 * (
        rays.origins + ahead[:, None] * rays.directions
        + image.origins + behind[:, None] * image.directions
    )  # fmt: skip
    covariances = _covariances(first, second, points, np.gradient(partners, axis=0))
    half = _half(points, covariances)
    uneven = float(np.sqrt(np.mean(np.diff(stations, 2) ** 2)))
    cost = price(MISFIT * off + BENT * uneven, half, 1.0 - float(np.mean(covered)))
    return Read(
        "pair", cost + OUTSIDE * half.share_outside(box), float(np.mean(covered)), points,
        covariances, None, np.zeros((0, 2)), (side,), (), source=(TWO_VIEWS, back),
        warnings=_flatly_seen(rays, image),
    )  # fmt: skip


def _flatly_seen(rays: Rays, image: Rays) -> tuple[str, ...]:
    """Return what is to be said of views that are nearly each other's mirror images."""
    sine = np.linalg.norm(np.cross(rays.directions, image.directions), axis=1)
    apart = float(np.degrees(np.arcsin(min(1.0, float(np.median(sine))))))
    return (NO_DEPTH,) if apart < REFUSED else (LITTLE_DEPTH,) if apart < WARNED else ()


def _smoothed(stations: Array) -> Array:
    """Return stations without the steps of a table, (n,)."""
    from scipy.ndimage import gaussian_filter1d

    slope = np.linspace(stations[0], stations[-1], len(stations))
    return np.asarray(slope + gaussian_filter1d(stations - slope, SOFT, mode="nearest"))


def _at(line: Array, stations: Array) -> Array:
    """Return places of a line at numbers of its samples, with shares, (n, 2) px."""
    index = np.arange(len(line))
    return np.column_stack([np.interp(stations, index, column) for column in line.T])


def _settled(
    first: Stereo, second: Stereo, rays: Rays, line: Array, stations: Array
) -> tuple[Array, float]:
    """Return the stations at which rays meet, and how far they pass one another (rms, px).

    Least squares of what rays pass one another by, and of uneven stations, which decides where the
    epipolar lines run along the sides and the rays do not say which places belong together.
    """
    from scipy.linalg import solveh_banded

    last = len(line) - 1.0
    stiff = _stiffness(len(stations))
    gaps = _gaps(first, second, rays, _at(line, stations))
    for _ in range(ROUNDS):
        ahead = np.clip(stations + NUDGE, 0.0, last)
        back = np.clip(stations - NUDGE, 0.0, last)
        slope = (
            _gaps(first, second, rays, _at(line, ahead))
            - _gaps(first, second, rays, _at(line, back))
        ) / np.maximum(ahead - back, 1e-9)
        known = np.isfinite(slope) & np.isfinite(gaps)
        slope, rest = np.where(known, slope, 0.0), np.where(known, gaps, 0.0)
        normal = stiff.copy()
        normal[-1] += slope**2 + STILL
        step = solveh_banded(normal, -(slope * rest + _bent(stations)), check_finite=False)
        moved = np.maximum.accumulate(np.clip(stations + np.clip(step, -1.5, 1.5), 0.0, last))
        found = _gaps(first, second, rays, _at(line, moved))
        if not np.isfinite(found).all():
            break
        stations, gaps = moved, found
        if np.abs(step).max() < SETTLED:
            break
    return stations, float(np.sqrt(np.mean(np.nan_to_num(gaps, nan=FAR) ** 2)))


def _stiffness(count: int) -> Array:
    """Return the matrix of the squares of uneven stations, as its upper bands (3, n)."""
    bands = np.zeros((3, count))
    for row in range(count - 2):
        bands[2, row : row + 3] += (1.0, 4.0, 1.0)
        bands[1, row + 1 : row + 3] -= 2.0
        bands[0, row + 2] += 1.0
    return STIFF**2 * bands


def _bent(stations: Array) -> Array:
    """Return half the slope of the squares of uneven stations, (n,)."""
    bent = STIFF**2 * np.diff(stations, 2)
    slope = np.zeros(len(stations))
    slope[:-2] += bent
    slope[1:-1] -= 2.0 * bent
    slope[2:] += bent
    return slope


def _gaps(first: Stereo, second: Stereo, rays: Rays, places: Array) -> Array:
    """Return how far rays pass those of places in the other view, on which side, (n,) px."""
    image = _mirrored(second.rays(places))
    ahead, behind, met = _met(rays, image)
    between = image.origins - rays.origins
    across = np.cross(rays.directions, image.directions)
    length = np.linalg.norm(across, axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        gap = (between * across).sum(axis=1) / length
        fine = 1.0 / _size(first, ahead) ** 2 + 1.0 / _size(second, behind) ** 2
        return np.asarray(np.where(met, gap * np.sqrt(0.5 * fine), np.nan))


def _covariances(first: Stereo, second: Stereo, points: Array, ways: Array) -> Array:
    """Return covariances for 1 px: of a place in one view, and across the other side."""
    rows = image_slopes(first, points)
    mirrored = image_slopes(second, points * MIRROR) * MIRROR
    length = np.linalg.norm(ways, axis=1, keepdims=True)
    unit = np.divide(ways, length, out=np.zeros_like(ways), where=length > 0)
    normals = np.column_stack((-unit[:, 1], unit[:, 0]))
    across = np.einsum("ni,nij->nj", normals, mirrored)[:, None]
    every = np.nan_to_num(np.concatenate((rows, across), axis=1), posinf=0.0, neginf=0.0)
    told = np.swapaxes(every, 1, 2) @ every
    # Beside an eye a view says so much of two directions that rounding takes what is known besides.
    least = KNOWN + ROUNDING * np.trace(told, axis1=1, axis2=2)[:, None, None]
    information = told + least * np.eye(3)
    return np.asarray(np.linalg.inv(information))


def _half(points: Array, covariances: Array) -> HalfInSpace:
    extent = float(np.linalg.norm(np.ptp(points, axis=0)))
    trust = 1.0 / (sigmas(covariances) + 0.01 * extent + 1e-300) ** 2
    trust /= trust.sum()
    left, right = (float(trust @ np.maximum(way * points[:, 1], 0.0)) for way in (1.0, -1.0))
    astride = 2.0 * min(left, right) / max(left + right, 1e-300)
    return HalfInSpace(points, covariances, trust, 1.0, astride, 0.0)
