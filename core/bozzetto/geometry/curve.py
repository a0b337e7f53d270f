"""The B-spline curve in space, as it is handed over: of any degree, rational or not."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bozzetto.arrays import Array, frozen
from bozzetto.geometry.basis import curve_derivative, lifted, lowered, span_parameters
from bozzetto.geometry.kept_answers import kept
from bozzetto.geometry.refinement import refined

if TYPE_CHECKING:
    from bozzetto.geometry.placement import Placement

Color = tuple[int, int, int]
"""Red, green and blue, 0 … 255, sRGB."""


@dataclass(frozen=True, eq=False)
class Curve:
    """A B-spline curve, rational where weights are given; or a polyline (degree 1).

    Parameters
    ----------
    degree : int
    knots : (m + degree + 1,) float64
        Full knot vector, not decreasing.
    control_points : (m, 3) float64
        mm.
    weights : (m,) float64, optional
    closed : bool
        Whether the curve returns to its start.
    """

    degree: int
    knots: NDArray[np.float64]
    control_points: NDArray[np.float64]
    weights: NDArray[np.float64] | None = None
    closed: bool = False
    name: str = "curve"
    color: Color | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "knots", frozen(self.knots, np.float64))
        object.__setattr__(self, "control_points", frozen(self.control_points, np.float64, 3))
        if self.weights is not None:
            object.__setattr__(self, "weights", frozen(self.weights, np.float64))
        count = len(self.control_points)
        if self.degree < 1 or count <= self.degree:
            raise ValueError("a curve needs more control points than its degree")
        if len(self.knots) != count + self.degree + 1 or (np.diff(self.knots) < 0).any():
            raise ValueError("a curve's knots must not decrease and must fit its control points")
        if self.weights is not None and (len(self.weights) != count or (self.weights <= 0).any()):
            raise ValueError("a curve needs one positive weight per control point")

    @property
    def range(self) -> tuple[float, float]:
        """First and last parameter."""
        return float(self.knots[self.degree]), float(self.knots[len(self.control_points)])

    @property
    def is_clamped(self) -> bool:
        """Whether the curve begins and ends in its first and last control point."""
        first, last = self.knots[: self.degree + 1], self.knots[-self.degree - 1 :]
        return bool((first == first[0]).all() and (last == last[0]).all())

    def value(self, parameters: ArrayLike) -> Array:
        """Return places on the curve.

        Parameters
        ----------
        parameters : (n,) array_like
            Clipped to the range.

        Returns
        -------
        (n, 3) float
            mm.
        """
        return self.derivative(parameters, 0)

    def derivative(self, parameters: ArrayLike, order: int = 1) -> Array:
        """Return derivatives by the parameter, shape (n, 3); parameters as in `value`."""
        at = np.clip(np.asarray(parameters, float), *self.range)
        return curve_derivative(
            self.degree, self.knots, self.control_points, self.weights, at, order
        )

    def polyline(self, steps: int) -> tuple[Array, Array]:
        """Return parameters, (n,), and places of a polyline near the curve, (n, 3) mm.

        Parameters
        ----------
        steps : int
            Segments for every span; straight ones get one.
        """

        def made() -> tuple[Array, Array]:
            at = span_parameters(self.degree, self.knots, steps if self.degree > 1 else 1)
            return at, self.value(at)

        return kept(self, ("polyline", steps), made)

    def placed(self, placement: Placement) -> Curve:
        """Return the curve moved by a placement."""
        return replace(self, control_points=placement.points(self.control_points))

    def clamped(self) -> Curve:
        """Return the same curve with its first and last control point for ends."""
        if self.is_clamped:
            return self
        (begin, end), ends = self.range, np.ones(self.degree + 1)
        inner = self.knots[(self.knots > begin) & (self.knots < end)]
        return self.with_knots(np.concatenate((begin * ends, inner, end * ends)))

    def with_knots(self, knots: ArrayLike) -> Curve:
        """Return the same curve over a knot vector that holds all of its knots."""
        new = np.asarray(knots, float)
        rows = refined(self.degree, self.knots, lifted(self.control_points, self.weights), new)
        points, weights = lowered(rows)
        if self.weights is None:
            weights = None
        return replace(self, knots=new, control_points=points, weights=weights)

    def reversed(self) -> Curve:
        """Return the same curve from its end to its start, over the same range."""
        begin, end = self.range
        return replace(
            self,
            knots=(begin + end) - self.knots[::-1],
            control_points=self.control_points[::-1],
            weights=None if self.weights is None else self.weights[::-1],
        )
