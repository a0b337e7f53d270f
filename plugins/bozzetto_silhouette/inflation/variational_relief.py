"""The variational surface as a solid of heights: its zero above every point of a plan."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bozzetto.arrays import Array
from bozzetto_silhouette.implicit.interpolation_constraints import fitted
from bozzetto_silhouette.implicit.variational import VariationalSurface
from bozzetto_silhouette.inflation.height_fairing import faired
from bozzetto_silhouette.outline.boundary_sampling import Rim
from bozzetto_silhouette.outline.domain_mesh import Plan
from bozzetto_silhouette.outline.normalized import Frame
from bozzetto_silhouette.outline.signed_distance import RimDistance

FADE = 0.9
"""Depth, in local radii, at which what the function misses on the outline is forgotten."""

LOWEST = 0.4
"""No squared height falls below this share of a round section: in tips that no height
constraint reaches there is still a body."""

HIGHEST = 2.0
"""No squared height rises above this multiple of it, where the function has no zero."""

ROUNDS = 12
"""Rounds of Newton's method; three are enough nearly everywhere."""

LAST_STEP = 3e-3
"""Newton's method ends with a step below this share of the square. It squares the error with
every step, so what is left is a hundred times less."""


@dataclass(frozen=True)
class VariationalHeights:
    """The variational surface through the outline, corrected at the rim."""

    def squares(self, frame: Frame, rim: Rim, plan: Plan) -> Array:
        """Return the squared half thickness at a plan's points."""
        surface = fitted(frame).surface
        first = len(plan.after)
        xy = plan.points[first:]
        closest = RimDistance(rim.points, rim.after)(xy)
        after = rim.after[closest.segment]

        def between(values: Array) -> Array:
            return (1.0 - closest.along) * values[closest.segment] + closest.along * values[after]

        flat = np.column_stack([rim.points, np.zeros(len(rim.points))])
        radius, depth = between(rim.radius), np.maximum(closest.distance, 1e-9)
        lift = -between(surface.level(flat))
        lift *= np.square(np.clip(1.0 - np.square(depth / (FADE * radius)), 0.0, 1.0))
        shallow = np.minimum(depth, radius)
        section = shallow * (2.0 * radius - shallow)
        balls = np.square(frame.skeleton.heights(xy))
        low, high = LOWEST * section, HIGHEST * np.maximum(section, balls)
        square = np.zeros(len(plan.points))
        square[first:] = _zeros(surface, xy, lift, low, high, np.maximum(section, balls))
        return faired(plan, square, closest.distance)


def _zeros(
    surface: VariationalSurface, xy: Array, lift: Array, low: Array, high: Array, start: Array
) -> Array:
    """Solve for the squared heights u (n,) at which the lifted function vanishes.

    In u the function is nearly linear. Newton's method in it, halving the interval that is
    known to hold the zero whenever a step leaves that.
    """
    low, high, square = low.copy(), high.copy(), np.clip(start, low, high)
    active = np.arange(len(xy))
    for _ in range(ROUNDS):
        u = square[active]
        z = np.sqrt(u)
        level, gradient = surface.level_and_slope(np.column_stack([xy[active], z]))
        level += lift[active]
        fall = gradient[:, 2] / (2.0 * np.maximum(z, 1e-12))
        above, below = active[level > 0.0], active[level <= 0.0]
        low[above], high[below] = square[above], square[below]
        with np.errstate(divide="ignore", invalid="ignore"):
            new = u - level / fall
        new = np.where(np.isfinite(new), new, np.inf)
        a, b = low[active], high[active]
        # A step downhill to nowhere or out of the interval is not to be trusted.
        new = np.where((fall < 0.0) & (new > a) & (new < b), new, 0.5 * (a + b))
        square[active] = new
        active = active[np.abs(new - u) > LAST_STEP * u]
        if not len(active):
            break
    return square
