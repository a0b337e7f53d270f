"""Curves drawn across the symmetry plane that are meant to be their own mirror images."""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto.geometry import DEGREE, Spline
from bozzetto.ink import resample, spline_weights
from bozzetto_product.model.planes import Plane
from bozzetto_product.network.reflection import Reflection, size_of

UNEVEN: Final = 0.1
"""Share of a curve's size by which the halves of one that is meant to be symmetric may be off what
they have in common. Hands missed by up to 8 % over a rounded end; a straight line that is drawn
askew on purpose, 12° and more, is off by more."""

LOOKS: Final = 257
"""Places at which a curve is looked at."""

PLACES: Final = 65
"""Places on each half of a closed curve that its symmetric form is fitted to."""

ROUNDS: Final = 3
"""How often the places are moved to their feet on the fitted curve."""


def as_own_image(spline: Spline, plane: Plane) -> Spline | None:
    """Return a curve across a plane as its own mirror image: what both halves have in common.

    Parameters
    ----------
    spline : Spline
        In space, mm.
    plane : Plane
        Of symmetry.

    Returns
    -------
    Spline or None
        Its own mirror image to rounding. None where the curve does not go through the plane once,
        or twice if it is closed, or where the halves differ more than a hand misses (`UNEVEN`).
    """
    reflection = Reflection(plane)
    points = spline.sampled(LOOKS)
    heights = reflection.heights(points)
    above = heights > 0.0
    crossings = np.flatnonzero(above[1:] != above[:-1])
    if len(crossings) != (2 if spline.closed else 1):
        return None
    if spline.closed:
        around = _evened(points, heights, crossings, reflection)
        made = _fitted(around, len(spline.control_points) - DEGREE, reflection)
    else:
        (whole,) = spline.split()
        made = reflection.symmetric(whole)
    off = np.linalg.norm(made.value(made.foot_points(points)) - points, axis=1)
    return made if off.max() <= UNEVEN * size_of(spline) else None


def _evened(points: Array, heights: Array, crossings: Index, reflection: Reflection) -> Array:
    """Return places once around a closed curve, from the plane on, each half the other's image."""
    share = heights[crossings] / (heights[crossings] - heights[crossings + 1])
    ends = points[crossings] + share[:, None] * (points[crossings + 1] - points[crossings])
    first, second = crossings
    one = np.vstack((ends[:1], points[first + 1 : second + 1], ends[1:]))
    other = np.vstack((ends[1:], points[second + 1 : -1], points[: first + 1], ends[:1]))[::-1]
    halves = [resample(half, count=PLACES) for half in (one, reflection.points(other))]
    half = (halves[0] + halves[1]) / 2.0
    half[[0, -1]] = reflection.onto(half[[0, -1]])
    return np.vstack((half, reflection.points(half[-2:0:-1])))


def _fitted(around: Array, count: int, reflection: Reflection) -> Spline:
    """Return the closed curve of so many control points through symmetric places, seam first."""
    steps = np.linalg.norm(np.diff(around, axis=0, append=around[:1]), axis=1)
    at = np.concatenate(([0.0], np.cumsum(steps[:-1]))) / steps.sum()
    spline = Spline.uniform(np.zeros((count, 3)), closed=True)
    partner = (2 - np.arange(count)) % count  # of a control point, mirrored in the seam
    for _ in range(ROUNDS):
        found = np.asarray(np.linalg.lstsq(spline_weights(spline, at), around, rcond=None)[0])
        spline = Spline.uniform((found + reflection.points(found[partner])) / 2.0, closed=True)
        at = spline.foot_points(around, at)
    return spline
