"""From polynomial patches to B-spline patches that end in the very curves of a loop.

Where half a side is no polynomial of degree five, what it has beyond one, D, is added to the
patch times a fade that is 1 with slope 0 on the side, and 0 to third order on the spoke. What is
missing to the tangent plane along the side is added likewise, times a fade of slope 1. Neither is
felt on a spoke, so the patches stay smooth over the spokes, and a knot of one side is no knot of
any other patch.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.geometry import BSplineSurface
from bozzetto.plugin import remembered
from bozzetto_product.fill.fair_solution import FairSolution
from bozzetto_product.fill.half_sides import HalfSide
from bozzetto_product.fill.quintic import (
    DEGREE,
    FADE,
    FADE_SLOPE,
    bernstein,
    gauss,
    refinement,
)

NODES_PER_SPAN: Final = 8
"""Gauss nodes on every span of a half at which its tangent planes are mended."""


def exact_patches(solution: FairSolution) -> tuple[BSplineSurface, ...]:
    """Return the patches of a solution in mm, with the control points of the curves themselves."""
    loop = solution.loop
    nets = solution.nets * loop.size + loop.origin
    count = len(nets)
    made = []
    for k in range(count):
        along_u = loop.sides[k].halves[0]
        along_v = loop.sides[k - 1].halves[1]
        net = nets[k]
        rows_u, rows_v = refinement(along_u.knots), refinement(along_v.knots)
        rest_u = _rest(along_u, rows_u, net[:, 0])
        rest_v = _rest(along_v, rows_v, net[0])
        mend_u = _mending(along_u, DEGREE * (net[:, 1] - net[:, 0]))
        mend_v = _mending(along_v, DEGREE * (net[1] - net[0]))
        points = np.einsum("ai,ijd,bj->abd", rows_u, net, rows_v)
        points += _faded(rest_u, mend_u, rows_v)
        points += _faded(rest_v, mend_v, rows_u).transpose(1, 0, 2)
        points[:, 0], points[0] = along_u.points, along_v.points
        points[0, 0] = along_u.points[0]
        made.append(BSplineSurface((DEGREE, DEGREE), along_u.knots, along_v.knots, points))
    return tuple(made)


def _faded(rest: Array, mend: Array, rows: Array) -> Array:
    """Return what is added to control points, (m, k, 3), for one side."""
    fade, slope = rows @ FADE, rows @ FADE_SLOPE
    return np.asarray(rest[:, None] * fade[:, None] + mend[:, None] * slope[:, None])


def _rest(half: HalfSide, rows: Array, polynomial: Array) -> Array:
    """Return what the curve of a half has beyond a polynomial, over the knots of the half."""
    if half.is_polynomial:
        return np.zeros_like(half.points)
    rest = half.points - rows @ polynomial
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
    made = np.zeros_like(half.points)
    at, fit = _mending_fit(half.knots)
    normals = half.normals(at)
    if normals is None:
        return made
    wanted = -((bernstein(at) @ across) * normals).sum(axis=1)[:, None] * normals
    made[2:-2] = fit @ wanted
    return made


@remembered(limit=1000, key=lambda knots: knots.tobytes())
def _mending_fit(knots: Array) -> tuple[Array, Array]:
    """Return places along a half, and what takes values there to the inner control values."""
    from scipy.interpolate import BSpline

    nodes, weights = gauss(NODES_PER_SPAN)
    spans = np.unique(knots)
    width = np.diff(spans)
    at = (spans[:-1, None] + width[:, None] * nodes).ravel()
    size = np.sqrt((width[:, None] * weights).ravel())
    rows = BSpline.design_matrix(at, knots, DEGREE).toarray()[:, 2:-2]
    inverse = np.asarray(np.linalg.pinv(size[:, None] * rows), np.float64)
    return at, inverse * size
