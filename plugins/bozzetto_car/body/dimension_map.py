"""Set the dimensions of a finished body: scaling, then a cubic map along the car.

Kara & Shimada (2008): width, height and length by scaling; front overhang and wheelbase by a
free-form deformation in x alone, the Bezier polynomial

    x(u) = B1(u) P1 + B2(u) P2 + B3(u) L,   u = (x - front) / L,

whose two inner values P1*, P2* are solved for so that both wheels come to where they are wanted
while nose and tail stay. Beyond the body's ends the map goes on straight, for control points
may lie there. Where the slope of the polynomial is nearly zero, it folds the body; such wishes
are refused, and the message names the range that is possible.

The dimensions are wanted of the surface, and moving its control points is not quite the same
as mapping the surface, so the result is measured and the map corrected until it is right.
Dimensions that are not given follow: overhang and wheelbase the length, in proportion. All
wishes are one set that is applied to the body as it was before, so no order of typing them
makes a difference, and a body that has its dimensions already stays as it is to the last bit.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto_car.dimensions import WORDS, Dimensions, measure_dimensions
from bozzetto_car.template.model import Template

EXACT: Final = 1e-6
"""Difference, mm, at which a dimension is what was wanted."""

LEAST_SLOPE: Final = 0.2
"""Least value of the map's slope coefficients, relative to those of the identity map: with less,
a part of the body collapses to a crease."""

CORRECTED_SLOPE: Final = 0.15
"""Least value for a map that is being corrected. It is lower, so that a person can have the whole
range that a message names, to its ends."""

AIMED: Final = 1e-7
"""Difference, mm, that corrections aim at, so that the dimension is exact when measured again."""

MOST_CORRECTIONS: Final = 12
"""Most corrections. The map is nearly linear in the dimensions, so that each correction leaves
about a hundredth of the error."""

TABLE: Final = 97
"""Places, from a length before the body to one behind it, from which the map is inverted."""

INVERSIONS: Final = 6
"""Steps of Newton's method in the inversion; each doubles the number of correct digits."""

ALONG: Final = ("front_overhang", "wheelbase")
"""Dimensions that follow the length where they are not given."""


@dataclass(frozen=True)
class Reshaping:
    """A map of space that changes the dimensions of a car.

    Attributes
    ----------
    front, length : float
        Foremost x and length of the body before the map, mm.
    scale : (float, float, float)
        Factors of length, width and height.
    inner : (float, float)
        P1* and P2* as shares of the length: (1/3, 2/3) changes nothing.
    """

    front: float
    length: float
    scale: tuple[float, float, float]
    inner: tuple[float, float]

    def points(self, points: ArrayLike) -> Array:
        """Move points of the body (…, 3): nodes, control points, styling curves; mm.

        The nose stays, heights are above the ground, and the plane of symmetry is kept.
        """
        places = np.asarray(points, float)
        moved = np.empty(places.shape)
        moved[..., 0] = self.along(places[..., 0])
        moved[..., 1] = places[..., 1] * self.scale[1]
        moved[..., 2] = places[..., 2] * self.scale[2]
        return moved

    def tangents(self, tangents: ArrayLike, places: ArrayLike) -> Array:
        """Return the derivatives (…, 3) of curves at places (…, 3) of the body after the map, mm.

        All tangents at a place undergo the same linear map. So common directions and ratios of
        lengths stay, and lines and surfaces that were smooth stay smooth.
        """
        return np.asarray(tangents, float) * self._slopes(places)

    def points_before(self, points: ArrayLike) -> Array:
        """Return where points of the reshaped body (…, 3) were before the map, mm."""
        places = np.asarray(points, float)
        before = np.empty(places.shape)
        before[..., 0] = self._along_before(places[..., 0])
        before[..., 1] = places[..., 1] / self.scale[1]
        before[..., 2] = places[..., 2] / self.scale[2]
        return before

    def tangents_before(self, tangents: ArrayLike, places: ArrayLike) -> Array:
        """Return derivatives (…, 3) before the map, at places (…, 3) before the map, mm."""
        return np.asarray(tangents, float) / self._slopes(places)

    def _slopes(self, places: ArrayLike) -> Array:
        """Return the derivatives of the map along the three axes, (…, 3)."""
        at = np.asarray(places, float)
        slopes = np.empty(at.shape)
        inside = np.clip((at[..., 0] - self.front) / self.length, 0.0, 1.0)
        slopes[..., 0] = self.scale[0] * self._pace(inside)
        slopes[..., 1:] = self.scale[1:]
        return slopes

    def _pace(self, share: Array) -> Array:
        """Return the derivative of the polynomial along the car at shares of the length, 0 … 1."""
        first, second = self.inner
        rest = 1.0 - share
        steps = first, second - first, 1.0 - second
        return np.asarray(
            3.0 * (steps[0] * rest**2 + 2.0 * steps[1] * share * rest + steps[2] * share**2)
        )

    def _along_before(self, x: Array) -> Array:
        """Invert `along` by Newton's method from a table; the map has no flat place."""
        table = self.front + self.length * np.linspace(-1.0, 2.0, TABLE)
        found = np.interp(x, self.along(table), table)
        for _ in range(INVERSIONS):
            share = np.clip((found - self.front) / self.length, 0.0, 1.0)
            found = found + (x - self.along(found)) / (self.scale[0] * self._pace(share))
        return np.asarray(found)

    def wheels(self, centres: ArrayLike) -> Array:
        """Move centres of wheels (…, 3), mm; their height, which is their radius, stays."""
        places = np.asarray(centres, float)
        moved = self.points(places)
        moved[..., 2] = places[..., 2]
        return moved

    def nodes(self, template: Template, positions: Array) -> Array:
        """Move all nodes of a car (n, 3), mm: those of the body, and the wheels as wheels."""
        moved = self.points(positions)
        wheels = template.wheels.ravel()
        moved[wheels] = self.wheels(positions[wheels])
        return moved

    def along(self, x: ArrayLike) -> Array:
        """Map coordinates along the car, mm."""
        share = (np.asarray(x, float) - self.front) / self.length
        inside = np.clip(share, 0.0, 1.0)
        first, second = self.inner
        rest = 1.0 - inside
        bent = 3.0 * inside * rest**2 * first + 3.0 * inside**2 * rest * second + inside**3
        slope = np.where(share < 0.0, 3.0 * first, 3.0 * (1.0 - second))
        bent = bent + slope * (share - inside)
        return np.asarray(self.front + self.scale[0] * self.length * bent)


def fit_reshaping(
    wanted: Dimensions, box: ArrayLike, wheels: ArrayLike, measure: Callable[[Reshaping], ArrayLike]
) -> Reshaping | None:
    """Return the map that gives a car the dimensions that are wanted.

    Parameters
    ----------
    wanted : Dimensions
        The dimensions that are wanted; the others follow.
    box : (2, 3) array_like
        Least and greatest coordinates of the surface as it is, mm.
    wheels : (2,) array_like
        x of the centres of the front and the rear wheel, mm.
    measure : callable
        The box (2, 3) of the surface after a map has been applied to it.

    Returns
    -------
    Reshaping or None
        None if the car has these dimensions already.

    Raises
    ------
    UserError
        If a dimension is not a length that a car can have, or the wheels cannot get there
        without folding the body; the message names the range that is possible.
    """
    wishes = wanted.wanted()
    extents = np.asarray(box, float)
    front, rear = np.asarray(wheels, float).tolist()
    now = measure_dimensions(extents, front, rear).given()
    if all(abs(now[name] - value) <= EXACT for name, value in wishes.items()):
        return None
    growth = wishes.get("length", now["length"]) / now["length"]
    goal = {name: value * growth if name in ALONG else value for name, value in now.items()}
    goal.update(wishes)
    asked = dict(goal)
    for number in range(MOST_CORRECTIONS):
        least = CORRECTED_SLOPE if number else LEAST_SLOPE
        made = _mapping(asked, goal, now, float(extents[0, 0]), least)
        ends = made.along([front, rear]).tolist()
        found = measure_dimensions(np.asarray(measure(made), float), ends[0], ends[1]).given()
        if all(abs(found[name] - value) <= AIMED for name, value in goal.items()):
            return made
        asked = {name: asked[name] + goal[name] - found[name] for name in goal}
    raise UserError(
        "The body cannot take these dimensions. Choose values nearer to those that it has."
    )


def _mapping(
    asked: dict[str, float],
    goal: dict[str, float],
    now: dict[str, float],
    nose: float,
    least: float,
) -> Reshaping:
    """Return the map for the dimensions `asked`, which are corrected, on the way to `goal`."""
    length = asked["length"]
    at = np.array([now["front_overhang"], now["front_overhang"] + now["wheelbase"]])
    to = np.array([asked["front_overhang"], asked["front_overhang"] + asked["wheelbase"]])
    share = at / now["length"]
    if not (0.0 < share[0] < share[1] < 1.0):
        raise UserError(
            "The wheels of this car do not stand within its body, one behind the other. Move "
            "them there first."
        )
    weights = 3.0 * np.stack((share * (1.0 - share) ** 2, share**2 * (1.0 - share)), axis=1)
    solving = np.asarray(np.linalg.inv(weights), float)
    inner = solving @ (to / length - share**3)
    steps = np.array([inner[0], inner[1] - inner[0], 1.0 - inner[1]])
    if steps.min() < least / 3.0:
        raise UserError(_folding(goal, share, solving))
    factors = length / now["length"], asked["width"] / now["width"], asked["height"] / now["height"]
    return Reshaping(nose, now["length"], factors, (float(inner[0]), float(inner[1])))


def _folding(goal: dict[str, float], share: Array, solving: Array) -> str:
    """Return the message that refuses an overhang and a wheelbase, with ranges to choose from."""
    length = goal["length"]
    ranges = []
    for name, direction in (("wheelbase", np.array([0.0, 1.0])), ("front_overhang", np.ones(2))):
        # The three slope coefficients are linear in the dimension; each gives one bound.
        rest = (
            np.array([goal["front_overhang"]] * 2)
            if name == "wheelbase"
            else np.array([0.0, goal["wheelbase"]])
        )
        base = solving @ (rest / length - share**3)
        change = solving @ direction / length
        lows = np.array([base[0], base[1] - base[0], 1.0 - base[1]]) - LEAST_SLOPE / 3.0
        rises = np.array([change[0], change[1] - change[0], -change[1]])
        least = float(np.max(-lows[rises > 0.0] / rises[rises > 0.0], initial=0.0))
        most = float(np.min(-lows[rises < 0.0] / rises[rises < 0.0], initial=np.inf))
        if least < most:
            ranges.append(f"a {WORDS[name]} from {np.ceil(least):g} to {np.floor(most):g} mm")
    asked = (
        f"A front overhang of {goal['front_overhang']:g} mm with a wheelbase of "
        f"{goal['wheelbase']:g} mm would fold a body of {length:g} mm."
    )
    if not ranges:
        return f"{asked} Choose both nearer to those that it has."
    return f"{asked} Choose {', or '.join(ranges)}."
