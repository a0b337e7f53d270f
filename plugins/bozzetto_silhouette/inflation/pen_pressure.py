"""Thickness from the pressure of the pen along the outline."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bozzetto.arrays import Array
from bozzetto_silhouette.model.state import Oversketch, Part
from bozzetto_silhouette.outline.domain_mesh import Plan
from bozzetto_silhouette.outline.fem import Elements, factorised
from bozzetto_silhouette.outline.from_ink import points_on_sheet
from bozzetto_silhouette.outline.normalized import Frame
from bozzetto_silhouette.outline.signed_distance import RimDistance

LEAST, MOST = 0.4, 2.5
"""Bounds of the factor: a pen that hardly touches the sheet does not make a leaf of metal."""

SPACING = 5e-3
"""Spacing at which ink is read, as a share of the size: pens leave samples far apart where
they are quick."""


@dataclass(frozen=True, eq=False)
class PenPressure:
    """Pressure relative to its median along the outline, continued to the inside.

    Attributes
    ----------
    places : (k, 2) float array
        Ink in the object frame.
    pressure : (k,) float array
        0 to 1; NaN where the device gave none.
    strength : float
        0 to 1: how much of it tells.
    """

    places: Array
    pressure: Array
    strength: float

    @classmethod
    def of(cls, part: Part) -> PenPressure:
        """Read the pressure along a part's ink and along what was drawn over it."""
        over = (edit.stroke for edit in part.edits if isinstance(edit, Oversketch))
        strokes = [*part.strokes, *over]
        places, pressure = [np.zeros((0, 2))], [np.zeros(0)]
        for stroke, xy in zip(strokes, points_on_sheet(strokes, part.sheet), strict=True):
            known = (
                stroke.pressure.astype(float) if stroke.has_pressure else np.full(len(xy), np.nan)
            )
            arc = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(xy, axis=0).T))])
            size = float(np.ptp(xy, axis=0).max())
            between = np.linspace(0.0, arc[-1], 2 + int(arc[-1] / max(SPACING * size, 1e-300)))
            at = np.union1d(arc, between if size > 0.0 else arc[:1])
            places.append(np.stack([np.interp(at, arc, column) for column in xy.T], axis=1))
            pressure.append(np.interp(at, arc, known))
        return cls(np.concatenate(places), np.concatenate(pressure), part.pressure)

    def factors(self, frame: Frame, plan: Plan, front: Array, back: Array) -> tuple[Array, Array]:
        """Return factors, above 1 where the pen was pressed harder than usual."""
        from scipy.spatial import cKDTree

        rim = frame.rim
        _, near = cKDTree(self.places).query(rim.points * frame.scale + frame.origin)
        pressure = self.pressure[near]
        known = np.isfinite(pressure)
        usual = float(np.median(pressure[known])) if known.any() else 0.0
        if usual <= 0.0:
            same = np.ones(len(plan.points))
            return same, same
        ratio = np.where(known, pressure / usual, 1.0)
        power = rim.averaged(self.strength * np.log(np.clip(ratio, LEAST, MOST)))
        closest = RimDistance(rim.points, rim.after)(plan.points[: len(plan.after)])
        on_rim = (1.0 - closest.along) * power[closest.segment] + closest.along * power[
            rim.after[closest.segment]
        ]
        same = np.exp(continued_harmonically(plan, on_rim))
        return same, same


def continued_harmonically(plan: Plan, on_rim: Array) -> Array:
    """Solve for the harmonic function (n,) on a plan with given values (m,) on its rim."""
    count = len(plan.after)
    values = np.zeros(len(plan.points))
    values[:count] = on_rim
    stiffness = Elements.of(plan).stiffness()
    pull = (stiffness @ values)[count:]
    values[count:] = -factorised(stiffness[count:, count:]).solve(pull)
    # On obtuse triangles the discrete solution may leave the bounds that the true one keeps.
    return np.clip(values, on_rim.min(), on_rim.max())
