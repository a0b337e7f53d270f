"""A filter for the tremor of a hand: waves much longer than samples lie apart.

A hand trembles six to twelve times a second (Elble and Koller, *Tremor*, 1990), which on a drawing
are waves of a 30th to a tenth of its size. A tablet tells them by ten samples or more each: from
sample to sample that ink is smooth, and `jitter_filter`, which looks at neighbours, finds no noise.
Here the ring is looked at in steps of a quarter of such a wave.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto_silhouette.ink.ring_fits import (
    SPACING,
    corners_of,
    differing_bends,
    quadratic,
    resampled,
    widened,
    with_corners,
)

STEP: Final = 0.018
"""Step at which tremor is looked for, as a share of the size."""

LEAST_STEPS: Final = 40
"""A ring of fewer such steps is too small to tell its tremor from its form."""

LONGEST: Final = 0.03
"""Longest edge of ink that tells tremor: with longer ones it is a polygon, or sparse."""

UNNOTICED: Final = 1.8e-4
"""Tremor below this share of the size is left alone."""

MOST: Final = 2e-3
"""Tremor that is filtered at most: what is larger may be meant."""

HALF: Final = 5
"""Half width of the narrowest fit, in samples `SPACING` apart."""

WIDER: Final = (1.4, 2.0, 2.8, 4.0, 5.6)
"""Half widths of further fits, in that of the first."""

SURE: Final = 3.0
"""Farthest, in standard deviations of the tremor, that a wider fit may lie from the narrowest."""

CORNER_HALF, CORNER_ARM, CORNER_TURN = 4, 10, np.deg2rad(45.0)
"""Half width of the fit in which corners are looked for, samples to either side over which they
turn, and by how much: narrower ones would take a wave for a corner."""

QUARTILE, MEDIAN = 0.3186, 0.6745
"""The same quantiles of the size of a normal variable, in standard deviations."""


def tremor_of(ring: Array) -> float:
    """Estimate the tremor in a ring, a share of the size.

    Parameters
    ----------
    ring : (n, 2) float array
        Longest side of the drawing about 1.

    Notes
    -----
    The lower of what the first and the second quartile of `differing_bends` tell: a form that
    bends here and there has its bends in the upper half.
    """
    if float(np.hypot(*(np.roll(ring, -1, axis=0) - ring).T).max()) > LONGEST:
        return 0.0
    steps = resampled(ring, STEP)
    if len(steps) < LEAST_STEPS:
        return 0.0
    quartile, median = np.quantile(np.abs(differing_bends(steps)), (0.25, 0.5))
    return float(min(quartile / QUARTILE, median / MEDIAN))


def without_tremor(ring: Array) -> Array:
    """Smooth a ring as far as its tremor says; corners stand.

    Parameters
    ----------
    ring : (n, 2) float array
        Longest side of the drawing about 1.

    Returns
    -------
    (m, 2) float array
        The ring itself when it is calm.
    """
    tremor = min(tremor_of(ring), MOST)
    dense = resampled(ring, SPACING)
    if tremor < UNNOTICED or len(dense) < 4 * HALF:
        return ring
    calm = quadratic(dense, HALF)
    corners = corners_of(quadratic(dense, CORNER_HALF), CORNER_ARM, CORNER_TURN)
    smooth = widened(dense, calm, corners, HALF, WIDER, SURE * tremor)
    return with_corners(dense, smooth, corners, HALF)
