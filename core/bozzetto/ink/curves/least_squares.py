"""Least-squares cubic B-splines through points whose parameters are known roughly."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto.geometry.spline import DEGREE, Spline, derived_points, uniform_knots

STIFFNESS: Final = 1e-6
"""Weight of the bending of the control polygon against the ink. It decides only where there
is no ink, and makes the equations solvable whatever the ink is."""

ROUNDS: Final = 10
"""Most rounds of reparametrisation."""

FOOT_STEPS: Final = 1
"""Newton steps to the foot points in each round; the next round continues from there."""

SLIDE: Final = 0.1
"""First weight of a deviation along the curve against one across it."""

GAIN: Final = 0.03
"""Share of the deviation that a round must take away for another one to follow."""

ENOUGH: Final = 1.2
"""Distance (rms, pixels) at which more control points are of no use: below the pen's width."""

NOISE_FACTOR: Final = 1.3
"""`ENOUGH` as a multiple of the ink's own noise: what lies within is not meant."""

FEWEST: Final = 7
"""Control points of the first adaptive fit (Bae, Kijima & Kim 2004 always take seven)."""

MORE: Final = 3
"""Control points added until the fit is good."""

MOST: Final = 25
"""Control points at which adding ends: a hand does not draw more wiggles into one curve."""

LEAST_STEP: Final = 0.02
"""Shortest step from an end to the next control point, as a share of the mean step, where an
end tangent is given: an end tangent against the ink must still be a tangent."""


@dataclass(frozen=True, eq=False)
class Approximation:
    """A spline and the points it was fitted to.

    Attributes
    ----------
    spline : Spline
    parameters : (n,) float
        Foot points.
    rms, worst : float
        Root mean square (weighted) and largest distance of the points from the curve.
    """

    spline: Spline
    parameters: Array
    rms: float
    worst: float


def approximate_adaptively(
    points: Array,
    weights: Array,
    parameters: Array,
    enough: float,
    *,
    closed: bool = False,
    start_tangent: Array | None = None,
    end_tangent: Array | None = None,
) -> Approximation:
    """Fit with as few control points as bring the rms distance below `enough`.

    Arguments as in `approximate`. More control points are tried until they are `MOST`, or
    more than there are points; the best fit is kept. Each starts from the given parameters:
    the foot points on a curve that is too stiff lie on the wrong branches.
    """
    best: Approximation | None = None
    for count in range(FEWEST, MOST + 1, MORE):
        made = approximate(
            points, weights, parameters, count,
            closed=closed, start_tangent=start_tangent, end_tangent=end_tangent,
        )  # fmt: skip
        if best is None or made.rms < best.rms:
            best = made
        if best.rms < enough or count >= len(points):
            break
    assert best is not None
    return best


def approximate(
    points: Array,
    weights: Array,
    parameters: Array,
    count: int,
    *,
    closed: bool = False,
    start_tangent: Array | None = None,
    end_tangent: Array | None = None,
) -> Approximation:
    """Fit a uniform cubic B-spline, moving the points along it to their foot points.

    Hoschek's intrinsic parametrisation, with the distance across the curve weighing more
    than that along it (tangent distance minimisation; Wang, Pottmann & Liu 2006, section
    3.3, damped as in section 4): it arrives in a few rounds where plain alternation takes
    thirty. A round that makes it worse is undone and damped, so the best curve is returned.

    Parameters
    ----------
    points : (n, d) float
        In any order; some must differ.
    weights : (n,) float
        Not negative; some positive.
    parameters : (n,) float
        Roughly where each point belongs, 0 … 1.
    count : int
        Control points that differ, at least 4.
    closed : bool
        Periodic.
    start_tangent, end_tangent : (d,) float, optional
        Directions, along the curve, that the ends of an open curve have exactly.
    """
    system = _System(points, weights, count, closed, start_tangent, end_tangent)
    best = system.moved(system.solved(parameters, None, 1.0), parameters)
    slide = SLIDE
    for _ in range(ROUNDS):
        tried = system.solved(best.parameters, best.spline, slide)
        made = system.moved(tried, best.parameters)
        gain = best.rms - made.rms
        if gain > 0:
            best, slide = made, 0.25 * slide
            if gain < GAIN * best.rms:
                break
        elif slide >= 1.0:
            break
        else:
            slide = min(1.0, 10.0 * slide)
    return best


class _System:
    """The normal equations of one fit, for all coordinates together."""

    def __init__(
        self,
        points: Array,
        weights: Array,
        count: int,
        closed: bool,
        start_tangent: Array | None,
        end_tangent: Array | None,
    ) -> None:
        self.points, self.closed, self.count = points, closed, count
        self.weights = weights / weights.sum()
        self.center = self.weights @ points
        self.scale = float(np.abs(points - self.center).max())
        self.knots = uniform_knots(count, closed)
        self.least_step = LEAST_STEP * self.scale / count
        self.tangents = (
            (0, 1, start_tangent),
            (count - 1, count - 2, None if end_tangent is None else -end_tangent),
        )
        self.bending = self._bending()

    def moved(self, spline: Spline, before: Array) -> Approximation:
        """Return the points at their feet on a new curve, the ends of the ink at its ends."""
        parameters = spline.foot_points(self.points, before, steps=FOOT_STEPS)
        if not self.closed:
            parameters[np.argmin(before)], parameters[np.argmax(before)] = 0.0, 1.0
        distance = np.linalg.norm(spline.value(parameters) - self.points, axis=1)
        rms = float(np.sqrt(self.weights @ distance**2))
        return Approximation(spline, parameters, rms, float(distance.max()))

    def solved(self, parameters: Array, before: Spline | None, slide: float) -> Spline:
        """Fit the best curve for given parameters, and tangents of the curve before."""
        basis = self._basis(parameters)
        count, size = self.count, self.points.shape[1]
        target = self.points - self.center
        across = np.broadcast_to(np.eye(size), (len(target), size, size))
        if before is not None:
            across = self._across(parameters, before, slide)
        matrix = np.zeros((count, size, count, size))
        weighted = basis * self.weights[:, None]
        for a in range(size):
            for b in range(a, size):
                block = weighted.T @ (basis * across[:, a, b, None])
                matrix[:, a, :, b] = matrix[:, b, :, a] = block
            matrix[:, a, :, a] += self.bending
        right = weighted.T @ (across * target[:, None, :]).sum(axis=2)
        made = self._constrained(matrix.reshape(count * size, -1), right.ravel())
        return Spline.uniform(made.reshape(count, size) + self.center, closed=self.closed)

    def _basis(self, parameters: Array) -> Array:
        from scipy.interpolate import BSpline

        at = np.mod(parameters, 1.0) if self.closed else np.clip(parameters, 0.0, 1.0)
        basis = BSpline.design_matrix(at, self.knots, DEGREE).toarray()
        if self.closed:
            basis[:, :DEGREE] += basis[:, self.count :]
            basis = basis[:, : self.count]
        return np.asarray(basis)

    def _across(self, parameters: Array, before: Spline, slide: float) -> Array:
        """Return the weight of a deviation, a matrix for each point: less along the curve."""
        tangent = before.derivative(parameters)
        tangent /= np.maximum(np.linalg.norm(tangent, axis=1, keepdims=True), 1e-300)
        release = np.full(len(tangent), 1.0 - slide)
        if not self.closed:  # beyond its ends the curve cannot slide
            release[(parameters <= 0.0) | (parameters >= 1.0)] = 0.0
        outer = tangent[:, :, None] * tangent[:, None, :]
        return np.asarray(np.eye(tangent.shape[1]) - release[:, None, None] * outer)

    def _bending(self) -> Array:
        """Squared second derivatives of the control polygon; 0 for straight lines."""
        identity = np.eye(self.count)
        if self.closed:
            identity = np.vstack((identity, identity[:DEGREE]))
        first = derived_points(self.knots, identity, DEGREE)
        second = derived_points(self.knots[1:-1], first, DEGREE - 1) / self.count**2
        return np.asarray(STIFFNESS * second.T @ second / self.count + 1e-14 * np.eye(self.count))

    def _constrained(self, matrix: Array, right: Array) -> Array:
        """Solve with the end tangents: the control points beside the ends move along them.

        A solution that would move one backwards is solved again with the least step forward.
        """
        pinned: set[int] = set()
        while True:
            given, leads, shift, basis = self._freedom(pinned)
            if not given:
                return np.asarray(np.linalg.solve(matrix, right))
            reduced = np.linalg.solve(basis.T @ matrix @ basis, basis.T @ (right - matrix @ shift))
            made = basis @ reduced + shift
            backwards = {
                end
                for end, (ahead, behind, direction) in leads.items()
                if (made[ahead] - made[behind]) @ direction < self.least_step
            }
            if not backwards - pinned:
                return np.asarray(made)
            pinned |= backwards

    def _freedom(
        self, pinned: set[int]
    ) -> tuple[bool, dict[int, tuple[Index, Index, Array]], Array, Array]:
        """Return the ways in which the control points can move with the end tangents.

        Returns
        -------
        given : bool
            Whether there is a tangent at all.
        leads : dict
            For each end with a tangent that is not pinned: the numbers of the coordinates of
            the control points beside and at the end, and the direction between them.
        shift : (k d,) float
            What the pinned ends add.
        basis : (k d, free) float
        """
        count, size = self.count, self.points.shape[1]
        basis, shift = np.eye(count * size), np.zeros(count * size)
        dropped: list[int] = []
        leads: dict[int, tuple[Index, Index, Array]] = {}
        for end, beside, tangent in self.tangents:
            if tangent is None:
                continue
            at, ahead = np.arange(size) + end * size, np.arange(size) + beside * size
            direction = tangent / np.linalg.norm(tangent)
            basis[ahead] = 0.0
            basis[ahead, at] = 1.0
            if end in pinned:
                shift[ahead] = self.least_step * direction
                dropped += list(ahead)
            else:
                basis[ahead, ahead[0]] = direction
                dropped += list(ahead[1:])
                leads[end] = ahead, at, direction
        given = any(tangent is not None for _, _, tangent in self.tangents)
        return given, leads, shift, np.delete(basis, dropped, axis=1)
