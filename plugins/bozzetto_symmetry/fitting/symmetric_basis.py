"""All symmetric curves of one kind and number of control points, as one linear space.

A curve of a symmetric thing is known from the control points of a half. Those of the whole
spline come from them by copying and by changing the sign of y, so every coordinate of the
curve is a sum of basis functions that are even (x and z) or odd (y) in the mirror: a least
squares fit in this space is symmetric by construction, and never has to be made so.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array, Flags
from bozzetto.geometry import DEGREE, Spline, derived_points
from bozzetto.plugin import cached_property
from bozzetto_symmetry.fitting.space_curve import Reading, SpaceCurve, across


@dataclass(frozen=True)
class SymmetricBasis:
    """The curves of one reading with `count` control points in a half.

    Parameters
    ----------
    reading : {"pair", "self", "plane"}
        Of a pair a half is one side; of a curve in the plane it is the whole curve.
    count : int
        At least 4.
    closed : bool
        A half returns to its start; of a curve across the plane `ring` says so.
    ring : bool
        The curve across the plane is closed.
    """

    reading: Reading
    count: int
    closed: bool = False
    ring: bool = False

    @property
    def periodic(self) -> bool:
        """Whether the whole spline returns to its start."""
        return self.ring if self.reading == "self" else self.closed

    @property
    def half(self) -> tuple[float, float]:
        """First and last parameter of the half; if the curve crosses the plane, it begins on it."""
        return (0.0, 0.5) if self.reading == "self" and self.ring else (0.0, 1.0)

    def curve(self, points: ArrayLike) -> SpaceCurve:
        """Return the curve from the control points of a half, (count, 3) mm."""
        return SpaceCurve(self.reading, self._spline(points))

    def _spline(self, points: ArrayLike) -> Spline:
        place = np.array(points, float)
        if self.reading == "self":
            return across(place, ring=self.ring)
        if self.reading == "plane":
            place[:, 1] = 0.0
        return Spline.uniform(place, closed=self.closed)

    # -- the basis -----------------------------------------------------------------------------

    @cached_property
    def whole(self) -> Spline:
        """A spline of this kind, for its knots."""
        return self._spline(np.zeros((self.count, 3)))

    @cached_property
    def _parts(self) -> Array:
        """Control points of the whole by those of the half: (m, 2 count), even and odd."""
        one = np.eye(self.count)
        columns = [self._spline(np.column_stack((c, c, 0.0 * c))).control_points for c in one]
        parts = np.stack(columns, axis=2)
        return np.hstack((parts[:, 0], parts[:, 1]))

    @cached_property
    def free(self) -> Flags:
        """Which of the coordinates (count × 3, point by point) can differ from 0."""
        odd = np.asarray((self._parts[:, self.count :] != 0).any(axis=0))
        return np.asarray(np.column_stack((np.ones_like(odd), odd, np.ones_like(odd))).ravel())

    def values(self, parameters: ArrayLike, order: int = 0) -> Array:
        """Return basis functions, or their derivatives, at parameters of the whole spline.

        Returns
        -------
        (n, 3, count) float
            What each control point of the half counts for x, y and z.
        """
        from scipy.interpolate import BSpline

        knots, parts, degree = self._derived(order)
        at = self.whole.within(parameters)
        made = np.asarray(BSpline.construct_fast(knots, parts, degree)(at))
        even, odd = made[:, : self.count], made[:, self.count :]
        return np.stack((even, odd, even), axis=1)

    def bending(self) -> Array:
        """Return third derivatives along a half, as rows for the coordinates that are free.

        The sum of their squares is the integral of the squared third derivative, by a
        parameter that runs from 0 to 1 along the half, over it.

        Returns
        -------
        (rows, free) float
        """
        knots, parts, _ = self._derived(DEGREE)
        low, high = self.half
        inside = (knots[:-1] >= low - 1e-12) & (knots[1:] <= high + 1e-12) & (np.diff(knots) > 0)
        steps = np.diff(knots)[inside] / (high - low)
        third = parts[inside] * ((high - low) ** 3 * np.sqrt(steps))[:, None]
        even, odd = third[:, : self.count], third[:, self.count :]
        rows = np.zeros((3, len(third), self.count, 3))
        for axis, part in enumerate((even, odd, even)):
            rows[axis, :, :, axis] = part
        return np.asarray(rows.reshape(3 * len(third), -1)[:, self.free])

    def rows(self, values: Array, slopes: Array) -> Array:
        """Return derivatives by the free coordinates of what is linear in places on the curve.

        Parameters
        ----------
        values : (n, 3, count) float
            Of the basis at these places.
        slopes : (n, 3) float
            Derivatives by the places.

        Returns
        -------
        (n, free) float
        """
        made = np.swapaxes(values * slopes[:, :, None], 1, 2)
        return np.asarray(made.reshape(-1, 3 * self.count)[:, self.free])

    def at(self, values: Array, points: Array) -> Array:
        """Return places (n, 3) from basis values (n, 3, count) and control points of the half."""
        return np.asarray(np.einsum("nak,ka->na", values, points))

    def moved(self, points: Array, step: Array) -> Array:
        """Return the control points of the half after a step in the free coordinates."""
        made = points.ravel().copy()
        made[self.free] += step
        return made.reshape(-1, 3)

    def _derived(self, order: int) -> tuple[Array, Array, int]:
        knots, parts, degree = self.whole.knots, self._parts, DEGREE
        for _ in range(order):
            parts = derived_points(knots, parts, degree)
            knots, degree = knots[1:-1], degree - 1
        return knots, parts, degree
