"""Faces cut out of one surface along curves in its parameters, with their exact edges."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto.geometry import Brep, BSplineSurface, Curve, Face, ParameterCurve, Trim, frozen

WHOLE: Final = (0.0, 1.0)
"""Range of the parameters of every surface and every edge here."""

KNOTS: Final = {degree: frozen(np.repeat(WHOLE, degree + 1), np.float64) for degree in (1, 3)}
"""Knots with which a B-spline of one span is a Bézier curve, by degree."""

FINEST: Final = 384
"""Most spans of an edge along a curve that is no line in the parameters."""

CLOSE: Final = 1e-6
"""Distance of such an edge from its surface, mm: a fraction of what a `Brep` allows on a car."""

POLE: Final = 1e-9
"""Length of an edge, mm, that counts as none."""


def local(side: int, along: float, inward: float) -> tuple[float, float]:
    """Return u and v of a place told by its way along a side of a patch and inward from it."""
    turned = ((along, inward), (1.0 - inward, along), (1.0 - along, 1.0 - inward),
              (inward, 1.0 - along))  # fmt: skip
    return turned[side]


def polyline(places: Sequence[tuple[float, float]]) -> list[ParameterCurve]:
    """Return the straight pieces through places (u, v), those without length left out."""
    return [ParameterCurve.line(a, b, WHOLE) for a, b in pairwise(places) if a != b]


def side_of(net: Array, side: int) -> Array:
    """Return the control points of a side of a patch in the sense of its loop, (4, 3)."""
    return np.asarray((net[:, 0], net[-1], net[::-1, -1], net[0, ::-1])[side])


def cubic_piece(points: Array, start: float, end: float) -> Array:
    """Return the control points (4, …) of a piece of Bézier cubics, told along the first axis.

    The end may lie before the start; then the piece is run backwards.
    """
    places = start + (end - start) * _EVEN
    return np.asarray(np.tensordot(_FROM_EVEN @ _bernstein(places), points, axes=1))


def bezier(net: Array) -> BSplineSurface:
    """Return a surface of one span from its control net (2 or 4, 2 or 4, 3)."""
    u, v = net.shape[0] - 1, net.shape[1] - 1
    return BSplineSurface((u, v), KNOTS[u], KNOTS[v], net)


def face_within(
    surface: BSplineSurface,
    loops: Sequence[Sequence[ParameterCurve]],
    edge_of: Callable[[ParameterCurve], Curve] | None = None,
) -> Brep:
    """Return the part of a surface that loops enclose, as one face with edges of its own.

    Parameters
    ----------
    surface : BSplineSurface
        Both parameters run from 0 to 1.
    loops : sequence of sequence of ParameterCurve
        Sides in the order and the sense in which each loop runs; the first loop is the outer one
        and runs counter-clockwise, others run clockwise.
    edge_of : callable, optional
        Gives the edge of a side in space; `edge_along` if absent.
    """
    edges: list[Curve] = []
    made = []
    for loop in loops:
        trims = []
        for path in loop:
            edge = edge_along(surface, path) if edge_of is None else edge_of(path)
            pole = bool(np.ptp(edge.control_points, axis=0).max() <= POLE)
            trims.append(Trim(None if pole else len(edges), True, path))
            if not pole:
                edges.append(edge)
        made.append(tuple(trims))
    return Brep(tuple(edges), (Face(surface, tuple(made)),))


def edge_along(surface: BSplineSurface, path: ParameterCurve) -> Curve:
    """Return a curve of a surface in space, exact along lines of constant u or v.

    Any other is a cubic spline within `CLOSE` of the surface at equal parameters, if `FINEST`
    spans can do that.
    """
    ends = path.control_points[[0, -1]]
    moving = np.flatnonzero(ends[0] != ends[1])
    if path.degree == 1 and len(moving) == 1 and _one_span(surface, moving[0]):
        degree = surface.degrees[moving[0]]
        at = np.linspace(0.0, 1.0, degree + 1)
        points = surface.value(*path.value(at).T)
        return Curve(degree, KNOTS[degree], _FROM_EVEN @ points if degree == 3 else points)
    return _interpolated(surface, path)


def _one_span(surface: BSplineSurface, direction: int) -> bool:
    return bool(surface.control_points.shape[direction] == surface.degrees[direction] + 1)


def _interpolated(surface: BSplineSurface, path: ParameterCurve) -> Curve:
    from scipy.interpolate import make_interp_spline

    # Where a piece of the path ends its third derivative jumps: there an edge has a knot, too.
    at = _halved(np.unique(path.knots), slice(None))
    while True:
        fit = make_interp_spline(at, surface.value(*path.value(at).T), k=3)
        curve = Curve(3, fit.t, fit.c)
        between = (at[:-1, None] + np.diff(at)[:, None] * (0.25, 0.5, 0.75)).ravel()
        away = np.linalg.norm(curve.value(between) - surface.value(*path.value(between).T), axis=1)
        wide = np.flatnonzero(away.reshape(-1, 3).max(axis=1) > CLOSE)
        if not len(wide) or len(at) > FINEST:
            return curve
        at = _halved(at, wide)


def _halved(at: Array, which: Index | slice) -> Array:
    """Return places with the middles of some of the intervals between them."""
    return np.sort(np.append(at, (0.5 * (at[:-1] + at[1:]))[which]))


def _bernstein(at: Array) -> Array:
    s = 1.0 - at
    return np.stack((s**3, 3.0 * at * s**2, 3.0 * at**2 * s, at**3), axis=1)


_EVEN: Final = np.linspace(0.0, 1.0, 4)
_FROM_EVEN: Final = np.linalg.inv(_bernstein(_EVEN))
"""Control points of a cubic from its places at 0, 1/3, 2/3 and 1."""
