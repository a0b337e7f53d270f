"""Noise of ink, from the ink alone: how much the pen shakes and the device rounds."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.ink.curves.resample import arc_length, distinct

ROUNDED: Final = 0.3
"""Standard deviation, in pixels, that rounding to whole pixels leaves (1 / sqrt 12)."""

BESIDE: Final = 2
"""Samples on each side that a sample is compared with: a cubic goes through four."""


def sample_noise(points: ArrayLike, *, pixel: float = 1.0) -> float:
    """Estimate the standard deviation of samples across the curve, from one sample to the next.

    Each sample is compared with the cubic through its four neighbours (parameters are
    chord lengths), and the median of the differences is taken: bends that several samples
    show are no noise, and corners do not count. A slow tremor is not seen.

    Parameters
    ----------
    points : (n, d) array_like
        Samples in the order in which they were drawn.
    pixel : float
        Length of a pixel in the units of the points.

    Returns
    -------
    float
        In the units of the points. 0 for fewer than six samples that differ. Points that all
        lie on whole pixels were rounded, and have 0.3 px at least.
    """
    place = np.asarray(points, float)
    place = place[distinct(place)]
    if len(place) < 2 * BESIDE + 2:
        return 0.0
    along, last = arc_length(place), len(place) - 2 * BESIDE
    around = [slice(k, k + last) for k in range(2 * BESIDE + 1) if k != BESIDE]
    middle = slice(BESIDE, BESIDE + last)
    apart, gain = place[middle].copy(), np.ones(last)
    for one in around:  # Lagrange's weights at the middle sample
        share = np.ones(last)
        for other in around:
            if other != one:
                share *= (along[middle] - along[other]) / (along[one] - along[other])
        apart -= share[:, None] * place[one]
        gain += share**2
    ahead = place[BESIDE + 1 : BESIDE + 1 + last] - place[BESIDE - 1 : BESIDE - 1 + last]
    squared = np.maximum((ahead**2).sum(axis=1), 1e-300)
    aside = apart - ((apart * ahead).sum(axis=1) / squared)[:, None] * ahead
    # In space there are two directions across: the length is that of one of them.
    spread = np.sqrt((aside**2).sum(axis=1) / (gain * max(1, place.shape[1] - 1)))
    found = float(1.4826 * np.median(spread))
    rounded = (np.round(place / pixel) * pixel == place).all()
    return max(found, ROUNDED * pixel) if rounded else found
