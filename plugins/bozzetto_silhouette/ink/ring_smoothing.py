"""A ring smoothed along a stretch: corners and ripples go, the area stays.

Along the arc the ring is filtered by 2 G − G², G a Gaussian: Tukey's twicing (1977). It passes
quadratic arcs unchanged, so that a circle does not shrink (to fourth order), unlike the
Gaussian itself; the same cure as Taubin's two steps, *Curve and surface smoothing without
shrinkage*, 1995, with no second factor to be chosen.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto.errors import UserError
from bozzetto.ink import arc_length, resample

SPACING = 2e-3
"""Spacing of the samples that a ring is filtered on, as a share of the size."""

MOST_SAMPLES = 20_000
"""Samples of one ring: the scalloped rim of a certificate has a tenth of that."""

REACH = 0.06
"""A rub farther than this from every ring, share of the size, is meant for something else."""

FINEST = 0.012
"""Least breadth of a rub, share of the size: that of a hand that follows the line."""

STRENGTH = 3.0
"""Standard deviation of the Gaussian over the breadth of the rub: bends as wide as the rub go."""

COARSEST = 0.1
"""Widest Gaussian, share of the size."""

MOST_PASSES = 9.0
"""Rubbing to and fro more often over a place smooths no more at once."""

BROAD = 90
"""Percentile of the distances between rub and ring that says how broadly the hand rubbed."""


def rubbed_ring(rings: Sequence[Array | None], line: Array, size: float) -> int:
    """Return the number of the ring that a stroke was rubbed along.

    Parameters
    ----------
    rings : sequence of (n, 2) float arrays
        None where a ring is gone.
    line : (m, 2) float array
        The stroke.
    size : float
        Longest side of the whole outline, in the same unit.

    Raises
    ------
    UserError
        If every ring is far away.
    """
    import shapely

    points = shapely.points(line)
    far = [
        np.inf if ring is None else float(np.median(shapely.LinearRing(ring).distance(points)))
        for ring in rings
    ]
    if not far or not min(far) <= REACH * size:
        raise UserError("There is no outline under the stroke. Rub along the line to smooth it.")
    return int(np.argmin(far))


def rubbed(ring: Array, line: Array, size: float) -> Array:
    """Smooth a ring where a stroke was rubbed along it.

    Parameters
    ----------
    ring : (n, 2) float array
        A closed line; the first vertex is not repeated.
    line : (m, 2) float array
        The stroke. How far it strays from the ring says how coarse the smoothing is; how
        often it comes by, how strong.
    size : float
        Longest side of the whole outline, in the same unit.

    Returns
    -------
    (k, 2) float array
        Vertices away from the stroke are those of the ring.
    """
    from scipy.spatial import cKDTree

    fine = _fine(ring, size)
    step = _length(ring) / len(fine)
    path = resample(line, count=int(np.clip(arc_length(line)[-1] / step, 2, MOST_SAMPLES)))
    away, closest = cKDTree(fine).query(path)
    breadth = float(np.percentile(away, BROAD))
    brush = max(breadth, FINEST * size)
    touched = np.zeros(len(fine), bool)
    touched[closest] = True
    # Gaps that the hand left are closed, and a brush's width is added at both ends.
    covered = ~_grown(~_grown(touched, 2.0 * brush / step), brush / step)
    passes = float(
        np.clip(arc_length(path)[-1] / (step * max(int(covered.sum()), 1)), 1, MOST_PASSES)
    )
    sigma = float(np.clip(STRENGTH * brush * np.sqrt(passes), 0.0, COARSEST * size))
    return softened(ring, covered, sigma)


def softened(ring: Array, covered: Flags, sigma: float) -> Array:
    """Filter a ring where it is covered, and blend at the edges of that.

    Parameters
    ----------
    ring : (n, 2) float array
        A closed line; the first vertex is not repeated.
    covered : (k,) bool array
        At k equal steps along the ring, from its first vertex.
    sigma : float
        Standard deviation of the Gaussian, along the ring.

    Returns
    -------
    (m, 2) float array
    """
    closed = np.vstack([ring, ring[:1]])
    arc = arc_length(closed)
    count, length = len(covered), float(arc[-1])
    at = length * np.arange(count) / count
    fine = np.column_stack([np.interp(at, arc, closed[:, axis]) for axis in (0, 1)])
    weight = _faded(covered, sigma * count / length)
    frequency = 2.0 * np.pi * np.arange(count // 2 + 1) / length
    gauss = np.exp(-0.5 * (sigma * frequency) ** 2)
    spectrum = np.fft.rfft(fine, axis=0) * (gauss * (2.0 - gauss))[:, None]
    soft = np.fft.irfft(spectrum, n=count, axis=0)
    moved = fine + weight[:, None] * (soft - fine)
    # Where nothing moves the ring's own vertices stay, elsewhere the samples take their place.
    stays = np.interp(arc[:-1], np.append(at, length), np.append(weight, weight[0])) <= 0.0
    where = np.concatenate([arc[:-1][stays], at[weight > 0.0]])
    points = np.concatenate([ring[stays], moved[weight > 0.0]])
    return points[np.argsort(where, kind="stable")]


def _fine(ring: Array, size: float) -> Array:
    count = int(np.clip(np.ceil(_length(ring) / (SPACING * size)), 16, MOST_SAMPLES))
    return resample(ring, count=count, closed=True)


def _length(ring: Array) -> float:
    return float(arc_length(np.vstack([ring, ring[:1]]))[-1])


def _grown(mask: Flags, steps: float) -> Flags:
    """Grow a cyclic mask by some steps to both sides."""
    reach = int(min(steps, len(mask)))
    if reach == 0 or mask.all() or not mask.any():
        return mask
    return _gap(mask) <= reach


def _gap(mask: Flags) -> Index:
    """Count the steps from each place of a ring to the nearest one where the mask holds."""
    count = len(mask)
    marked = np.flatnonzero(mask)
    around = np.concatenate([marked - count, marked, marked + count])
    here = np.arange(count)
    place = np.searchsorted(around, here)
    gap: Index = np.minimum(around[place] - here, here - around[place - 1])
    return gap


def _faded(covered: Flags, steps: float) -> Array:
    """Return 1 where covered, falling smoothly to 0 over some steps beside it."""
    if covered.all() or not covered.any():
        return covered.astype(np.float64)
    t = np.clip(1.0 - _gap(covered) / max(2.0 * steps, 1.0), 0.0, 1.0)
    return np.asarray(t * t * (3.0 - 2.0 * t), np.float64)
