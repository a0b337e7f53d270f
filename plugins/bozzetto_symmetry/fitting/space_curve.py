"""Symmetric curves in space, exact by construction; in the frame of the plane (y = 0), mm."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.geometry import DEGREE, Color, Curve, Spline, uniform_knots
from bozzetto_symmetry.stereo.mirror_camera import MIRROR

Reading = Literal["pair", "self", "plane"]
"""What a curve in space is: one of a mirrored pair, itself symmetric, or in the plane."""


@dataclass(frozen=True, eq=False)
class SpaceCurve:
    """A curve of a symmetric thing.

    Parameters
    ----------
    reading : {"pair", "self", "plane"}
    spline : Spline
        Of a pair the side that was drawn first; of a curve across the plane all of it, made
        by `across` from one half; of a curve in the plane all of it, y exactly 0.
    """

    reading: Reading
    spline: Spline

    @property
    def closed(self) -> bool:
        """Whether the curve returns to its start."""
        return self.spline.closed

    def curves(self) -> tuple[Spline, ...]:
        """Return the spline that was drawn, and of a pair its exact mirror image."""
        if self.reading == "pair":
            return self.spline, self.spline.mirrored((0.0, 1.0, 0.0))
        return (self.spline,)

    def to_curves(self, color: Color | None = None) -> tuple[Curve, ...]:
        """Return `curves` with clamped ends for other programs, mirror images to the last bit.

        Clamping a ring inserts knots, and rounds: the two halves are then made equal again.
        """
        handed = tuple(spline.to_curve(color=color) for spline in self.curves())
        if self.reading != "self":
            return handed
        points = np.asarray(handed[0].control_points)
        return (replace(handed[0], control_points=0.5 * (points + points[::-1] * MIRROR)),)


def across(points: ArrayLike, *, ring: bool = False) -> Spline:
    """Return the symmetric spline across the plane from the control points of one half.

    With knots and control points symmetric about the middle the curve is its own mirror
    image, and it crosses the plane at a right angle with continuous curvature.

    Parameters
    ----------
    points : (k, 3) array_like
        From the control point on the plane outwards; its y counts as 0. Of a ring the
        last one is on the plane again.
    ring : bool
        The curve is closed and crosses the plane twice.

    Returns
    -------
    Spline
        2k − 1 control points over −1 … 1, the middle one first in `points`; the mirror image
        of the place at u is that at −u. A ring has 2k − 2 over 0 … 1: it leaves the plane at
        0, with the half, and is back on it at ½.
    """
    half = np.array(points, float)
    half[0, 1] = 0.0
    if ring:
        half[-1, 1] = 0.0
        # A basis function has its middle one knot before its number: the first goes second.
        once = np.vstack([half[1:2] * MIRROR, half, (half * MIRROR)[-2:1:-1]])
        return Spline(uniform_knots(len(once), True), np.vstack([once, once[:DEGREE]]), closed=True)
    whole = np.vstack([(half * MIRROR)[:0:-1], half])
    upper = uniform_knots(len(whole), False)
    upper = 0.5 * (upper - upper[::-1])
    return Spline(2.0 * upper, whole)
