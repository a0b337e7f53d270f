"""The rational B-spline surface: values, derivatives, normals."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import comb
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bozzetto.arrays import Array, frozen
from bozzetto.cached_properties import cached_property
from bozzetto.geometry.basis import basis, lifted

if TYPE_CHECKING:
    from bozzetto.geometry.placement import Placement

FLAT_SINE: Final = 1e-9
"""Sine of the angle between the tangents in u and v below which they tell no tangent plane."""

FLAT: Final = 1e-15
"""Departure of four corners from a parallelogram, as share of the largest coordinate, that is
rounding."""

MOST_AT_ONCE: Final = 512
"""Places up to which all their control points are gathered at once: for more of them that takes
longer than to go through the control points one by one."""

VANISHED: Final = 1e-9
"""Length of a tangent, as share of the size of the control net, that counts as none: a pole."""


@dataclass(frozen=True, eq=False)
class BSplineSurface:
    """A B-spline surface, rational where weights are given.

    Parameters
    ----------
    degrees : (int, int)
        In u and in v, each at least 1.
    knots_u : (m + degrees[0] + 1,) float64
        Full knot vector, not decreasing, clamped: degree + 1 equal knots at both ends, and
        inside none more often than the degree.
    knots_v : (n + degrees[1] + 1,) float64
        Likewise.
    control_points : (m, n, 3) float64
        mm; the first index runs with u. x_u × x_v points outward where there is an outside.
    weights : (m, n) float64, optional
        Positive.

    Raises
    ------
    ValueError
        If the arrays do not belong together, or hold a number that is not finite.
    """

    degrees: tuple[int, int]
    knots_u: NDArray[np.float64]
    knots_v: NDArray[np.float64]
    control_points: NDArray[np.float64]
    weights: NDArray[np.float64] | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "knots_u", frozen(self.knots_u, np.float64))
        object.__setattr__(self, "knots_v", frozen(self.knots_v, np.float64))
        object.__setattr__(self, "control_points", frozen(self.control_points, np.float64))
        if self.control_points.ndim != 3 or self.control_points.shape[2] != 3:
            raise ValueError("a surface needs a net of control points with three coordinates")
        counts = self.control_points.shape[:2]
        for degree, knots, count in zip(self.degrees, self.knots, counts, strict=True):
            _check_knots(degree, knots, count)
        if self.weights is not None:
            object.__setattr__(self, "weights", frozen(self.weights, np.float64))
            if self.weights.shape != counts or (self.weights <= 0).any():
                raise ValueError("a surface needs one positive weight per control point")

    @property
    def knots(self) -> tuple[Array, Array]:
        """Both knot vectors."""
        return self.knots_u, self.knots_v

    @property
    def ranges(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """First and last u, first and last v."""
        u, v = self.knots
        return (float(u[0]), float(u[-1])), (float(v[0]), float(v[-1]))

    @cached_property
    def size(self) -> float:
        """Diagonal of the box around the control points, mm."""
        return float(np.linalg.norm(np.ptp(self.control_points, axis=(0, 1))))

    @property
    def is_plane(self) -> bool:
        """Whether the surface is a parallelogram, evenly parametrised."""
        if self.control_points.shape != (2, 2, 3) or self.weights is not None:
            return False
        (a, b), (c, d) = self.control_points
        largest = float(np.abs(self.control_points).max())
        return bool(np.abs(a - b - c + d).max() <= FLAT * largest)

    # -- evaluation ------------------------------------------------------------------------

    def value(self, u: ArrayLike, v: ArrayLike) -> Array:
        """Return places on the surface.

        Parameters
        ----------
        u, v : (n,) array_like
            Clipped to the ranges.

        Returns
        -------
        (n, 3) float
            mm.
        """
        return self.derivative(u, v, 0, 0)

    def derivative(self, u: ArrayLike, v: ArrayLike, du: int, dv: int) -> Array:
        """Return derivatives by the parameters.

        Parameters
        ----------
        u, v : (n,) array_like
            Clipped to the ranges.
        du, dv : int
            Orders by u and by v; with weights by the quotient rule (Piegl & Tiller 1997, "The
            NURBS book", 4.4).

        Returns
        -------
        (n, 3) float
        """
        u_at = np.clip(np.asarray(u, float), *self.ranges[0])
        v_at = np.clip(np.asarray(v, float), *self.ranges[1])
        if self.weights is None:
            return self._sums(self.control_points, u_at, v_at, du, dv)
        rows = lifted(self.control_points, self.weights)
        orders = [(k, m) for k in range(du + 1) for m in range(dv + 1)]
        sums = {order: self._sums(rows, u_at, v_at, *order) for order in orders}
        whole = sums[0, 0][:, -1:]
        made: dict[tuple[int, int], Array] = {}
        for k, m in orders:
            top = sums[k, m][:, :-1]
            for i in range(k + 1):
                for j in range(m + 1):
                    if i or j:
                        factor = comb(k, i) * comb(m, j)
                        top = top - factor * sums[i, j][:, -1:] * made[k - i, m - j]
            made[k, m] = top / whole
        return made[du, dv]

    def _sums(self, rows: Array, u: Array, v: Array, du: int, dv: int) -> Array:
        """Return sums of control rows (m, n, d) weighed with basis functions, (n, d)."""
        (p, q), (knots_u, knots_v) = self.degrees, self.knots
        first_u, weights_u = basis(p, knots_u, u, du)
        first_v, weights_v = basis(q, knots_v, v, dv)
        width = rows.shape[1]
        flat, corner = rows.reshape(-1, rows.shape[2]), first_u * width + first_v
        shares = (weights_u[:, :, None] * weights_v[:, None, :]).reshape(-1, (p + 1) * (q + 1))
        steps = (np.arange(p + 1)[:, None] * width + np.arange(q + 1)).ravel()
        if len(corner) <= MOST_AT_ONCE:
            return np.asarray(np.einsum("nk,nkd->nd", shares, flat[corner[:, None] + steps]))
        total = np.zeros((len(corner), rows.shape[2]))
        for k, step in enumerate(steps.tolist()):
            total += shares[:, k, None] * flat[corner + step]
        return total

    def normals(self, u: ArrayLike, v: ArrayLike) -> Array:
        """Return unit normals along x_u × x_v.

        Parameters
        ----------
        u, v : (n,) array_like
            Clipped to the ranges.

        Returns
        -------
        (n, 3) float
            At a pole, where one tangent vanishes, the limit from inside; 0 where the surface
            has no tangent plane.
        """
        u, v = np.broadcast_arrays(np.asarray(u, float), np.asarray(v, float))
        first, second = self.derivative(u, v, 1, 0), self.derivative(u, v, 0, 1)
        gone = [
            np.linalg.norm(tangent, axis=1) * (high - low) <= VANISHED * self.size
            for tangent, (low, high) in zip((first, second), self.ranges, strict=True)
        ]
        if np.any(gone):
            # Near a pole the tangent that vanishes is the twist times the way from there.
            twist = self.derivative(u, v, 1, 1)
            middle_u, middle_v = np.mean(self.ranges, axis=1)
            inward_u, inward_v = np.where(u < middle_u, 1, -1), np.where(v < middle_v, 1, -1)
            first = np.where(gone[0][:, None], inward_v[:, None] * twist, first)
            second = np.where(gone[1][:, None], inward_u[:, None] * twist, second)
        return _unit_across(first, second)

    # -- the same surface otherwise --------------------------------------------------------

    def turned_over(self) -> BSplineSurface:
        """Return the same surface with u and v exchanged, so that its normals point back."""
        return BSplineSurface(
            (self.degrees[1], self.degrees[0]),
            self.knots_v,
            self.knots_u,
            self.control_points.transpose(1, 0, 2),
            None if self.weights is None else self.weights.T,
        )

    def placed(self, placement: Placement) -> BSplineSurface:
        """Return the surface moved by a placement; turned over where that mirrors."""
        if placement.is_identity:
            return self
        shape = self.control_points.shape
        moved = replace(self, control_points=placement.points(self.control_points).reshape(shape))
        return moved.turned_over() if placement.mirrors else moved


def _check_knots(degree: int, knots: Array, count: int) -> None:
    if degree < 1 or count <= degree:
        raise ValueError("a surface needs more control points than its degree, both ways")
    if knots.shape != (count + degree + 1,) or (np.diff(knots) < 0).any():
        raise ValueError("a surface's knots must not decrease and must fit its control points")
    if (knots[: degree + 1] != knots[0]).any() or (knots[-degree - 1 :] != knots[-1]).any():
        raise ValueError("a surface's knots must begin and end with degree + 1 equal ones")
    if (knots[1:count] == knots[degree + 1 : count + degree]).any():
        raise ValueError("a surface's inner knots may be equal as often as the degree, no more")


def _unit_across(a: Array, b: Array) -> Array:
    """Return unit vectors (n, 3) across two, 0 where they are parallel."""
    across = np.cross(a, b)
    length = np.linalg.norm(across, axis=1)
    sound = length > FLAT_SINE * np.linalg.norm(a, axis=1) * np.linalg.norm(b, axis=1)
    return np.asarray(across * (sound / np.where(sound, length, 1.0))[:, None])
