"""Carrying of what opposite sides have in common over the spoke between them.

Rails that bend alike over an edge are no polynomials: what each has beyond one, D, fades out on the
way to the centre of the fill, and the surface sags between the rails. So the share of it that both
have runs through instead, from one's own to the other's, as in a surface that is swept. Between
sides that are close together for the waves of D, as of a long wall, all of it does.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.plugin import cached_property
from bozzetto_product.fill.domain import Domain, cross
from bozzetto_product.fill.half_sides import HalfSide
from bozzetto_product.fill.quintic import (
    DEGREE,
    POINTS,
    bernstein,
    insertion,
    spline_fit,
    spline_rows,
)
from bozzetto_product.fill.thin_strips import is_seen, left_in_middle

ALIKE: Final = 0.5
"""Likeness of two rests, 0 … 1, up to which nothing is carried: what two hands tremble differs. As
much of a wave is to be left in the middle of the strip."""

SAMPLES: Final = 33
"""Places at which rests are compared."""

SAME: Final = 1e-12
"""Distance of knots up to which they are one."""

SLIVER: Final = 1e-6
"""Distance of knots below which the span between them is too small."""

OFTEN: Final = 4
"""How often inner knots stand: patches are smooth once over them, as the slopes of curves are."""

TURN_IN: Final = np.array((0.0, 0.0, 0.0, 0.0, -0.2, 0.0))
"""Control values of v⁴ (v - 1): slope one at 1, nought there, and nought to third order at 0."""


@dataclass(frozen=True, eq=False)
class Carried:
    """The rests of two halves that end in one spoke, from opposite sides.

    Parameters
    ----------
    knots : (m + 6,) float
        Along the spoke: those of both halves.
    rests : (2, m, 3) float
        The shares that are carried, over these knots; nought at both ends, with slope nought.
    share : float
        Of the first side's patch in the way from side to side.
    turns : (2, m, 3) float
        Derivatives across the spoke by which each patch is turned to be smooth over it.
    carried : float
        Share of the rests that is carried.
    """

    knots: Array
    rests: Array
    share: float
    turns: Array
    carried: float

    def added(self, number: int, rows: Array) -> Array:
        """Return what is added to the patch of a half, (m, k, 3), along and across the spoke.

        Parameters
        ----------
        number : int
            0 for the patch of the first half, 1 for the other.
        rows : (k, 6) float
            From a polynomial across to the control points of the patch there.
        """
        own, other = rows @ self.weights[number], rows @ (1.0 - self.weights[number])
        made = self.rests[number][:, None] * own[:, None]
        made += self.rests[1 - number][:, None] * other[:, None]
        return np.asarray(made + self.turns[number][:, None] * (rows @ TURN_IN)[:, None])

    @cached_property
    def weights(self) -> tuple[Array, Array]:
        """Control values of each patch's weight of its own rest, from its side to the spoke."""
        return _weight(self.share), _weight(1.0 - self.share)


def _weight(share: float) -> Array:
    """Return control values of 1 - 3 w² + 2 w³ for w = share · v."""
    at = np.linspace(0.0, 1.0, DEGREE + 1)
    w = share * at
    return np.asarray(np.linalg.solve(bernstein(at), 1.0 - 3.0 * w**2 + 2.0 * w**3))


def carried_rests(
    domain: Domain, spoke: int, halves: tuple[HalfSide, HalfSide], rests: tuple[Array, Array]
) -> Carried | None:
    """Return what runs through from half to half; None where that is nothing.

    It is what both have in common, or what is left of waves in the middle of a narrow strip.

    Parameters
    ----------
    domain : Domain
        Of four sides.
    spoke : int
        To which side it leads.
    halves : (HalfSide, HalfSide)
        Of the sides before and after that one, each from its corner there to its middle.
    rests : ((m, 3) float, (k, 3) float)
        What each has beyond a polynomial, over its own knots.
    """
    at = np.linspace(0.0, 1.0, SAMPLES)
    one, two = (
        spline_rows(half.knots, at) @ rest for half, rest in zip(halves, rests, strict=True)
    )
    whole = float((one**2).sum() + (two**2).sum())
    if whole == 0.0:
        return None
    alike = 2.0 * float((one * two).sum()) / whole
    height = float(np.sqrt(max((one**2).sum(axis=1).max(), (two**2).sum(axis=1).max())))
    if is_seen(height, halves):
        alike = max(alike, left_in_middle(halves, rests))
    share = (alike - ALIKE) / (1.0 - ALIKE)
    if share <= 0.0:
        return None
    knots = _common_knots(halves[0].knots, halves[1].knots)
    if knots is None:
        return None
    both = share * np.stack(
        [refined(half.knots, rest, knots) for half, rest in zip(halves, rests, strict=True)]
    )
    return _smooth_over(domain, spoke, knots, both, share)


def _smooth_over(domain: Domain, spoke: int, knots: Array, rests: Array, carried: float) -> Carried:
    """Return carried rests with the turns that make both patches one smooth function there.

    What is missing is what the condition of `patch_space` leaves over the spoke.
    """
    at, fit = spline_fit(knots)
    t = at[:, None]
    after = (spoke + 1) % 4
    corner, middle = domain.corners, domain.middles[spoke]
    way = domain.centre - middle
    left = (1 - t) * (middle - corner[spoke]) + t * (domain.centre - domain.middles[spoke - 1])
    right = (1 - t) * (middle - corner[after]) + t * (domain.centre - domain.middles[after])
    first, second, along = cross(right, way), cross(way, left), cross(left, right)
    share = float(np.mean(second) / (np.mean(second) + np.mean(first)))
    w = share
    weight, slope = 1.0 - 3.0 * w**2 + 2.0 * w**3, 6.0 * w**2 - 6.0 * w
    values = spline_rows(knots, at) @ rests
    slopes = spline_rows(knots, at, 1) @ rests
    over = slope * (values[0] - values[1])
    by_first, by_second = w * over, -(1.0 - w) * over
    by_spoke = weight * slopes[0] + (1.0 - weight) * slopes[1]
    missing = first[:, None] * by_first + second[:, None] * by_second + along[:, None] * by_spoke
    turns = np.zeros_like(rests)
    for number, factor in enumerate((first, second)):
        turns[number, 2:-2] = fit @ (-0.5 * missing / factor[:, None])
    return Carried(knots, rests, share, turns, carried)


def _common_knots(one: Array, two: Array) -> Array | None:
    """Return the knots of both; None if some nearly meet.

    Inner ones stand so often that the derivative of a rest is in the space, for the turns.
    """
    places = np.union1d(one, two)
    apart = np.diff(places, prepend=-1.0)
    if ((apart > SAME) & (apart < SLIVER)).any():
        return None
    places = places[apart > SAME]
    counts = np.full(len(places), OFTEN)
    counts[[0, -1]] = POINTS
    return np.repeat(places, counts)


def refined(knots: Array, points: Array, finer: Array) -> Array:
    """Return control points of the same spline over more knots."""
    return points if np.array_equal(knots, finer) else insertion(knots, finer) @ points
