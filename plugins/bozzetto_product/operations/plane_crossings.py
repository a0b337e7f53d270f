"""Where curves cross a plane, and which lie in it."""

from __future__ import annotations

import itertools
from typing import Final

import numpy as np

from bozzetto.geometry import Spline
from bozzetto_product.model.curves import Curve
from bozzetto_product.model.planes import Plane
from bozzetto_product.operations.meetings import share_at
from bozzetto_product.projection.planes import heights

FLAT: Final = 1e-9
"""Distance from the symmetry plane, as a share of the size of a curve, at which it lies in it."""

LOOKS: Final = 257
"""Places by which crossings of a plane are sought."""

BISECTIONS: Final = 60
"""Halvings by which a crossing is located: to the last bit."""


def lies_in(curve: Curve, plane: Plane) -> bool:
    """Whether a curve lies in a plane."""
    if curve.spline is None:
        return False
    if curve.plane == plane:
        return True
    points = curve.spline.control_points
    size = float(np.ptp(points, axis=0).max())
    return bool(np.abs(heights(points, plane)).max() <= FLAT * size)


def plane_crossings(spline: Spline, plane: Plane) -> list[float]:
    """Return the shares at which a curve goes from one side of a plane to the other."""
    at = np.linspace(*spline.range, LOOKS)
    height = heights(spline.value(at), plane)
    noise = 1e-9 * max(1e-300, float(np.ptp(spline.control_points, axis=0).max()))
    side = np.sign(np.where(np.abs(height) <= noise, 0.0, height))
    known = np.flatnonzero(side)
    found = []
    for one, other in itertools.pairwise(known):
        if side[one] == side[other]:
            continue
        low, high = float(at[one]), float(at[other])
        for _ in range(BISECTIONS):
            middle = 0.5 * (low + high)
            if np.sign(float(heights(spline.value([middle])[0], plane))) == side[one]:
                low = middle
            else:
                high = middle
        found.append(share_at(spline, 0.5 * (low + high)))
    return found
