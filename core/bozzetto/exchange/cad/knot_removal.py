"""Knots at which a surface or an edge may have a corner and has none, taken out.

Pieces that were put together one by one have a knot of the multiplicity of the degree at each
joint, where CAD programs expect a corner and cut, or complain. With h and k the spans before and
after such a knot and P the control point on it, between A and B, the derivative is continuous just
where P = (k A + h B) / (h + k); then P and one knot are idle (L. Piegl and W. Tiller, *The NURBS
book*, 1997, 5.4). The parameters stay what they were.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.geometry.brep.brep import Brep, GapError
from bozzetto.geometry.brep.surface import BSplineSurface
from bozzetto.geometry.curve import Curve

IDLE: Final = 1e-9
"""How far a control point may be from where it is idle, as a share of the size: a tenth of what
edges may be off their faces."""


def without_idle_knots(brep: Brep) -> Brep:
    """Return a brep of the same shape whose surfaces and edges have corners only where they bend.

    Rational ones stay as they are.
    """
    edges = tuple(map(_smooth_curve, brep.edges))
    faces = tuple(replace(face, surface=_smooth_surface(face.surface)) for face in brep.faces)
    before = (*brep.edges, *(face.surface for face in brep.faces))
    after = (*edges, *(face.surface for face in faces))
    if all(one is other for one, other in zip(before, after, strict=True)):
        return brep
    try:
        return replace(brep, edges=edges, faces=faces)
    except GapError:  # edges that were as far off their faces as they may be
        return brep


def _smooth_surface(surface: BSplineSurface) -> BSplineSurface:
    if surface.weights is not None:
        return surface
    slack = IDLE * surface.size
    u, net = _without(surface.degrees[0], surface.knots_u, surface.control_points, slack)
    v, across = _without(surface.degrees[1], surface.knots_v, np.swapaxes(net, 0, 1), slack)
    if len(u) == len(surface.knots_u) and len(v) == len(surface.knots_v):
        return surface
    return BSplineSurface(surface.degrees, u, v, np.swapaxes(across, 0, 1))


def _smooth_curve(curve: Curve) -> Curve:
    if curve.weights is not None:
        return curve
    size = float(np.linalg.norm(np.ptp(curve.control_points, axis=0)))
    knots, points = _without(curve.degree, curve.knots, curve.control_points, IDLE * size)
    if len(knots) == len(curve.knots):
        return curve
    return replace(curve, knots=knots, control_points=points)


def _without(degree: int, knots: Array, points: Array, slack: float) -> tuple[Array, Array]:
    """Return knots and control points, (n, …), without those that are idle."""
    inner, first, count = np.unique(knots, return_index=True, return_counts=True)
    at = first[(count == degree) & (inner > knots[0]) & (inner < knots[-1])]
    if degree < 2 or not len(at):
        return knots, points
    on = at - 1  # the control point on the knot
    before = knots[at] - knots[at - 1]
    after = knots[at + degree] - knots[at]
    share = (before / (before + after)).reshape(-1, *[1] * (points.ndim - 1))
    idle = (1.0 - share) * points[on - 1] + share * points[on + 1]
    off = np.abs(points[on] - idle).reshape(len(on), -1).max(axis=1)
    gone = off <= slack
    return np.delete(knots, at[gone]), np.delete(points, on[gone], axis=0)
