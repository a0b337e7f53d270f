"""From polynomial patches to B-spline patches that end in the very curves of a loop.

Where half a side is no polynomial of degree five, what it has beyond one, D, is added to the
patch times a fade that is 1 with slope 0 on the side, and 0 to third order on the spoke. What is
missing to the tangent plane along the side is added likewise, times a fade of slope 1. Neither is
felt on a spoke, so the patches stay smooth over the spokes, and a knot of one side is no knot of
any other patch. What opposite sides have in common, or have in a narrow strip, does not fade but is
carried over the spoke (`opposite_sides`).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bozzetto.arrays import Array
from bozzetto.geometry import BSplineSurface
from bozzetto_product.fill.fair_solution import FairSolution
from bozzetto_product.fill.half_sides import HalfSide
from bozzetto_product.fill.opposite_sides import Carried, carried_rests, refined
from bozzetto_product.fill.quintic import (
    DEGREE,
    FADE,
    FADE_SLOPE,
    bernstein,
    refinement,
    spline_fit,
)


def exact_patches(solution: FairSolution) -> tuple[BSplineSurface, ...]:
    """Return the patches of a solution in mm, with the control points of the curves themselves."""
    loop = solution.loop
    nets = solution.nets * loop.size + loop.origin
    count = len(nets)
    halves = [(loop.sides[k].halves[0], loop.sides[k - 1].halves[1]) for k in range(count)]
    rests = [
        (_rest(along_u, net[:, 0]), _rest(along_v, net[0]))
        for (along_u, along_v), net in zip(halves, nets, strict=True)
    ]
    carried = _carried(solution, halves, rests)
    made = []
    for k, (along_u, along_v) in enumerate(halves):
        net = nets[k]
        over_u, over_v = carried[k - 1], carried[k]
        knots_u = along_u.knots if over_u is None else over_u.knots
        knots_v = along_v.knots if over_v is None else over_v.knots
        rows_u, rows_v = refinement(knots_u), refinement(knots_v)
        mend_u = _mending(along_u, DEGREE * (net[:, 1] - net[:, 0]))
        mend_v = _mending(along_v, DEGREE * (net[1] - net[0]))
        points = np.einsum("ai,ijd,bj->abd", rows_u, net, rows_v)
        points += _faded(along_u.knots, rests[k][0], mend_u, over_u, 1, rows_v)
        points += _faded(along_v.knots, rests[k][1], mend_v, over_v, 0, rows_u).transpose(1, 0, 2)
        points[:, 0] = refined(along_u.knots, along_u.points, knots_u)
        points[0] = refined(along_v.knots, along_v.points, knots_v)
        points[0, 0] = along_u.points[0]
        made.append(BSplineSurface((DEGREE, DEGREE), knots_u, knots_v, points))
    return tuple(made)


def _carried(
    solution: FairSolution,
    halves: Sequence[tuple[HalfSide, HalfSide]],
    rests: Sequence[tuple[Array, Array]],
) -> list[Carried | None]:
    """Return for each spoke what is carried over it; of four sides only have opposite ones."""
    count = len(halves)
    if count != 4 or any(side.bend for side in solution.loop.sides):
        return [None] * count
    return [
        carried_rests(
            solution.space.domain,
            k,
            (halves[k][1], halves[(k + 1) % count][0]),
            (rests[k][1], rests[(k + 1) % count][0]),
        )
        for k in range(count)
    ]


def _faded(
    knots: Array, rest: Array, mend: Array, over: Carried | None, number: int, rows: Array
) -> Array:
    """Return what is added to control points, (m, k, 3), for one side.

    What is carried over the spoke, as the half of a number there, does not fade.
    """
    added: Array | float = 0.0
    if over is not None:
        rest = refined(knots, (1.0 - over.carried) * rest, over.knots)
        mend = refined(knots, mend, over.knots)
        added = over.added(number, rows)
    fade, slope = rows @ FADE, rows @ FADE_SLOPE
    return np.asarray(rest[:, None] * fade[:, None] + mend[:, None] * slope[:, None] + added)


def _rest(half: HalfSide, polynomial: Array) -> Array:
    """Return what the curve of a half has beyond a polynomial, over the knots of the half."""
    if half.is_polynomial:
        return np.zeros_like(half.points)
    rest = half.points - refinement(half.knots) @ polynomial
    rest[[0, -1]] = 0.0
    return rest


def _mending(half: HalfSide, across: Array) -> Array:
    """Return what to add to the derivative across a half so that it lies in the tangent planes.

    Parameters
    ----------
    half : HalfSide
        Whose normals are to be met.
    across : (6, 3) float
        Control values of the derivative.

    Returns
    -------
    (m, 3) float
        Control values over the knots of the half, nought with slope nought at both ends.
    """
    normals = half.fitted_normals
    if normals is None:
        return np.zeros_like(half.points)
    at, fit = spline_fit(half.fit_knots)
    wanted = -((bernstein(at) @ across) * normals).sum(axis=1)[:, None] * normals
    return refined(half.fit_knots, np.pad(fit @ wanted, ((2, 2), (0, 0))), half.knots)
