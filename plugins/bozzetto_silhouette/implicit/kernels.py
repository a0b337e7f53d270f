"""The kernels of the papers, integrated along segments in closed form.

A segment from p to q of length l with unit vector u carries a weight that is linear along
it, ``w(t) = w0 + k t``. With x = (r - p) . u the foot of a point r on its line, d2 its
squared distance from that line and s = t - x, the field is

    F(r) = (w0 + k x) [I0] + k [I1],   I0 = integral of h ds,   I1 = integral of s h ds,

both taken from -x to l - x (Sherstyuk, "Kernel functions in convolution surfaces", 1999;
Tai, Zhang and Fong, "Prototype modeling from sketched silhouettes based on convolution
surfaces", 2004). Two families hold the five kernels: powers of the distance, of which
Cauchy's is one with a core that is not a point, and compact powers.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import comb
from typing import Protocol

import numpy as np

from bozzetto.arrays import Array, Index

NEARLY_COLLINEAR = 0.03
"""Squared distance from the line, as a share of that from the segment, below which the
antiderivatives at both ends are nearly equal, and a series is summed instead."""

TERMS = 12
"""Terms of that series; the first term left out is below 0.03^12."""

POINT = 1e-12
"""Squared core (in squares of the size) of the kernels that have a pole on the skeleton."""


class Kernel(Protocol):
    """A falling function h of the distance, and what belongs to it."""

    def moments(self, a: Array, b: Array, d2: Array) -> tuple[Array, Array]:
        """Return I0 and I1 over ``a <= s <= b`` at squared distances d2 from the line, (n,)."""
        ...

    def falls(self, a: Array, b: Array, d2: Array) -> tuple[Array, Array]:
        """Return the derivatives of I0 and I1 by d2, (n,) each; a and b are held."""
        ...

    def cylinder(self, radius: Array) -> Array:
        """Return the field at a distance from an endless line of weight 1."""
        ...

    def level(self, total: Array) -> tuple[Array, Array]:
        """Convert the field F, in units of the iso-value, to a level that is linear in squares.

        Around an endless line of radius r, ``level(F) = (r^2 - distance^2) / square(r)``.
        Returned with its derivative by F, which is positive.
        """
        ...

    def square(self, radius: Array) -> Array:
        """Return the factor that turns the level at a radius into a squared length."""
        ...


@dataclass(frozen=True)
class InversePower:
    """``h = (core2 + r^2)^(-power / 2)``: long-range, never zero.

    Attributes
    ----------
    power : int
        3 or 4. With 4 and a core of 1 / S it is Cauchy's kernel but for a factor.
    core2 : float
        Squared core.
    """

    power: int
    core2: float = POINT

    def moments(self, a: Array, b: Array, d2: Array) -> tuple[Array, Array]:
        """Return I0 and I1."""
        return self._zeroth(a, b, d2 + self.core2), self._first(self.power, a, b, d2 + self.core2)

    def falls(self, a: Array, b: Array, d2: Array) -> tuple[Array, Array]:
        """Return the derivatives by d2: the same integrals with a power two higher."""
        p, c2 = self.power, d2 + self.core2
        ends = b * (c2 + b * b) ** (-0.5 * p) - a * (c2 + a * a) ** (-0.5 * p)
        higher = (ends + (p - 1) * self._zeroth(a, b, c2)) / (p * c2)
        series, where = _collinear(p + 2, a, b, c2)
        higher[where] = series
        return -0.5 * p * higher, -0.5 * p * self._first(p + 2, a, b, c2)

    def _zeroth(self, a: Array, b: Array, c2: Array) -> Array:
        if self.power == 3:
            result = (b / np.sqrt(c2 + b * b) - a / np.sqrt(c2 + a * a)) / c2
        else:
            c = np.sqrt(c2)
            turn = np.arctan2(c * (b - a), c2 + a * b)
            result = (b / (c2 + b * b) - a / (c2 + a * a) + turn / c) / (2.0 * c2)
        series, where = _collinear(self.power, a, b, c2)
        result[where] = series
        return result

    @staticmethod
    def _first(power: int, a: Array, b: Array, c2: Array) -> Array:
        rest = 0.5 * power - 1.0
        result: Array = ((c2 + a * a) ** -rest - (c2 + b * b) ** -rest) / (2.0 * rest)
        return result

    def cylinder(self, radius: Array) -> Array:
        """Return 2 / c^2 for the cube and pi / (2 c^3) for the fourth power."""
        c2 = np.square(radius) + self.core2
        return 2.0 / c2 if self.power == 3 else 0.5 * np.pi * c2**-1.5

    def level(self, total: Array) -> tuple[Array, Array]:
        """Return 1 - F**(-2 / (power - 1)) and its derivative."""
        root = -2.0 / (self.power - 1.0)
        power = total**root
        return 1.0 - power, -root * power / total

    def square(self, radius: Array) -> Array:
        """Return the squared radius plus the squared core."""
        return np.square(radius) + self.core2


def _collinear(power: int, a: Array, b: Array, c2: Array) -> tuple[Array, Index]:
    """Integrate ``(c2 + s^2)^(-power / 2)`` where the interval lies far off to one side."""
    nearest2 = np.square(np.minimum(np.abs(a), np.abs(b)))
    where = np.flatnonzero((a * b > 0.0) & (c2 < NEARLY_COLLINEAR * nearest2))
    # By symmetry to the positive side.
    low, high = np.sort(np.abs(np.stack([a[where], b[where]])), axis=0)
    total, coefficient = np.zeros(len(where)), 1.0
    for k in range(TERMS):
        degree = 1 - power - 2 * k
        total += coefficient * c2[where] ** k * (high**degree - low**degree) / degree
        coefficient *= -(0.5 * power + k) / (k + 1)
    return total, where


@dataclass(frozen=True)
class Compact:
    """``h = (1 - r^2 / reach^2)^power`` up to the reach, zero beyond.

    Attributes
    ----------
    power : int
        2 for the quartic, 3 for the sextic (Wyvill) kernel.
    reach : float
        The same for all segments: this is what makes it fail on bellies with fingers.
    """

    power: int
    reach: float

    def moments(self, a: Array, b: Array, d2: Array) -> tuple[Array, Array]:
        """Return I0 and I1."""
        return self._integrated(self.power, a, b, d2)

    def falls(self, a: Array, b: Array, d2: Array) -> tuple[Array, Array]:
        """Return the derivatives by d2: the same integrals with a power one lower."""
        factor = -self.power / self.reach**2
        zeroth, first = self._integrated(self.power - 1, a, b, d2)
        return factor * zeroth, factor * first

    def _integrated(self, power: int, a: Array, b: Array, d2: Array) -> tuple[Array, Array]:
        # In units of the reach; of the line, the part within it.
        m = np.maximum(1.0 - d2 / self.reach**2, 0.0)
        end = np.sqrt(m)
        low, high = np.clip(a / self.reach, -end, end), np.clip(b / self.reach, -end, end)
        zeroth = np.zeros_like(m)
        for k in range(power + 1):
            n = 2 * k + 1
            zeroth += comb(power, k) * (-1) ** k * m ** (power - k) * (high**n - low**n) / n
        first = ((m - low**2) ** (power + 1) - (m - high**2) ** (power + 1)) / (2 * power + 2)
        return self.reach * zeroth, self.reach**2 * first

    def cylinder(self, radius: Array) -> Array:
        """Return the integral over the chord of the ball of support."""
        m = np.maximum(1.0 - np.square(radius / self.reach), 0.0)
        whole = 16.0 / 15.0 if self.power == 2 else 32.0 / 35.0
        return self.reach * whole * m ** (self.power + 0.5)

    def level(self, total: Array) -> tuple[Array, Array]:
        """Return F**(2 / (2 power + 1)) - 1 and its derivative."""
        root = 1.0 / (self.power + 0.5)
        power = total**root
        return power - 1.0, root * power / total

    def square(self, radius: Array) -> Array:
        """Return the squared reach minus the squared radius."""
        return np.maximum(self.reach**2 - np.square(radius), 0.0)
