"""Strips: four sides of which two are long, close together, and no polynomials.

What a long side has beyond one polynomial for each half, D, is a wave along it. Between sides that
are close together for the length of these waves a plate has them in its middle, too.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto_product.fill.half_sides import HalfSide, Side
from bozzetto_product.fill.patch_space import PatchSpace
from bozzetto_product.fill.quintic import refinement, spline_rows
from bozzetto_product.fill.sweep import on_side, square_shares

SAMPLES: Final = 33
"""Places along half a side at which waves are measured."""

SHORT_WAVES: Final = 20.0
"""Wave number times half the width of a strip from which on nothing is left in its middle."""

MIDDLE: Final = 0.5
"""Share of waves that is to be left in the middle of a strip."""

DENT: Final = 0.02
"""Height of waves over the width of a strip from which on they would be seen: a degree."""


def is_strip(sides: Sequence[Side]) -> bool:
    """Whether sides bound a narrow strip whose long sides are creases with waves.

    Parameters
    ----------
    sides : sequence of Side
        Head to tail.
    """
    if len(sides) != 4 or any(side.bend for side in sides):
        return False
    return any(_is_between(sides[first], sides[first + 2]) for first in (0, 1))


def _is_between(one: Side, other: Side) -> bool:
    """Whether two sides have waves that reach from one to the other."""
    told = [half.held_normals is not None for side in (one, other) for half in side.halves]
    if any(told):
        return False
    waves = False
    for first in (0, 1):
        halves = one.halves[first], other.halves[1 - first]
        polynomials = one.polynomials[first], other.polynomials[1 - first]
        rests = [
            half.points - refinement(half.knots) @ each
            for half, each in zip(halves, polynomials, strict=True)
        ]
        height = max(float(np.linalg.norm(rest, axis=1).max()) for rest in rests)
        if is_seen(height, halves):
            waves = True
            if left_in_middle(halves, (rests[0], rests[1])) < MIDDLE:
                return False
    return waves


def is_seen(height: float, halves: tuple[HalfSide, HalfSide]) -> bool:
    """Whether waves of a height, mm, would be seen between two halves of opposite sides."""
    ends = halves[0].points[[0, -1]] - halves[1].points[[0, -1]]
    return height > DENT * float(np.linalg.norm(ends, axis=1).mean())


def width_between(halves: tuple[HalfSide, HalfSide]) -> float:
    """Return the mean distance of two halves of opposite sides, mm."""
    at = np.linspace(0.0, 1.0, SAMPLES)
    return float(np.linalg.norm(halves[0].value(at) - halves[1].value(at), axis=1).mean())


def left_in_middle(halves: tuple[HalfSide, HalfSide], rests: tuple[Array, Array]) -> float:
    """Return the share of the waves of two rests that a clamped strip has in its middle, 0 … 1.

    A plate over a strip that is 2 a wide, and has waves of wave number k along both edges with no
    slope across, solves the biharmonic equation by (A cosh k y + B y sinh k y) cos k x
    (Timoshenko & Woinowsky-Krieger 1959, chapter 6). In its middle that is, with z = k a, the share
    (1 + z coth z) / ((1 + z coth z) cosh z - z sinh z): all of long waves, nothing of short ones.

    Parameters
    ----------
    halves : (HalfSide, HalfSide)
        From opposite sides, each from its corner to its middle.
    rests : ((m, 3) float, (k, 3) float)
        What each has beyond a polynomial, over its own knots; not both nought.
    """
    at = np.linspace(0.0, 1.0, SAMPLES)
    slopes = squares = 0.0
    for half, rest in zip(halves, rests, strict=True):
        speed = np.maximum(np.linalg.norm(half.value(at, 1), axis=1), 1e-300)
        squares += float(((spline_rows(half.knots, at) @ rest) ** 2).sum(axis=1) @ speed)
        slopes += float(((spline_rows(half.knots, at, 1) @ rest) ** 2).sum(axis=1) @ (1.0 / speed))
    z = 0.5 * width_between(halves) * np.sqrt(slopes / squares)
    if not 0.0 < z < SHORT_WAVES:
        return float(z <= 0.0)
    clamped = 1.0 + z / np.tanh(z)
    return float(clamped / (clamped * np.cosh(z) - z * np.sinh(z)))


def strip_places(space: PatchSpace, controls: Array) -> Array:
    """Return places between the polynomials of four sides, for all Gauss points, (4 · 49, 3).

    A Coons patch (Coons 1967): straight from side to side, both ways, less what is counted twice.

    Parameters
    ----------
    space : PatchSpace
        Of four patches.
    controls : (40, 3) float
        Of the sides; see `LoopSides`.
    """
    s, t = square_shares()
    sides = [
        on_side(controls, space.count, side, at) for side, at in enumerate((s, t, 1.0 - s, 1.0 - t))
    ]
    corners = controls.reshape(4, -1, 3)[:, 0]
    s, t = s[:, None], t[:, None]
    both = (1.0 - t) * sides[0] + t * sides[2] + (1.0 - s) * sides[3] + s * sides[1]
    ends = (1.0 - t) * ((1.0 - s) * corners[0] + s * corners[1])
    return np.asarray(both - ends - t * ((1.0 - s) * corners[3] + s * corners[2]))
