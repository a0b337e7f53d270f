"""A fill as exact faces between the pieces of its edges and its spokes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bozzetto.arrays import Array
from bozzetto.geometry import Brep, BSplineSurface, Curve, Face, ParameterCurve, Trim
from bozzetto_product.fill.half_sides import HalfSide, Side


def brep_of(
    sides: Sequence[Side], patches: Sequence[BSplineSurface], spokes: Sequence[Curve], name: str
) -> Brep:
    """Return patches as faces that share their edges.

    The edges are first the pieces of the loop's edges, each in the sense of its edge, then the
    spokes, from the sides to the centre.
    """
    edges, numbers = _edges_of(sides)
    count = len(sides)
    faces = []
    for k, patch in enumerate(patches):
        before = len(edges) + (k - 1) % count
        along_u = _trims(sides[k].halves[0], 0, numbers)
        along_v = _trims(sides[k - 1].halves[1], 1, numbers)[::-1]
        out = Trim(len(edges) + k, True, ParameterCurve.line((1, 0), (1, 1), (0.0, 1.0)))
        back = Trim(before, False, ParameterCurve.line((0, 1), (1, 1), (0.0, 1.0)))
        faces.append(Face(patch, ((*along_u, out, back, *along_v),)))
    return Brep((*edges, *spokes), tuple(faces), name)


def plane_brep_of(outlines: Sequence[Sequence[Side]], plane: BSplineSurface, name: str) -> Brep:
    """Return a plane as one face within the edges of a loop, and outside of those of its holes.

    The trims are the edges' own control points, in u and v: exact, for a plane is affine.

    Parameters
    ----------
    outlines : sequence of sequence of Side
        Counter-clockwise in u and v, those of holes clockwise.
    plane : BSplineSurface
        A rectangle.
    name : str
        What the shape is called.
    """
    edges, numbers = _edges_of([side for sides in outlines for side in sides])
    loops = []
    for sides in outlines:
        trims = []
        for side in sides:
            first, second = side.halves
            for piece in (*first.pieces, *reversed(second.pieces)):
                curve = piece.piece.curve
                flat = plane_parameters(plane, curve.control_points)
                path = ParameterCurve(curve.degree, curve.knots, flat)
                trims.append(Trim(numbers[id(piece.piece)], piece.forward, path))
        loops.append(tuple(trims))
    return Brep(tuple(edges), (Face(plane, tuple(loops)),), name)


def plane_parameters(plane: BSplineSurface, points: Array) -> Array:
    """Return u and v, (n, 2), of the feet of points, (n, 3), on a rectangle of its plane."""
    net = plane.control_points
    sides = np.stack((net[1, 0] - net[0, 0], net[0, 1] - net[0, 0]))
    return np.asarray((points - net[0, 0]) @ (sides / (sides**2).sum(axis=1)[:, None]).T)


def _edges_of(sides: Sequence[Side]) -> tuple[list[Curve], dict[int, int]]:
    """Return the pieces of a loop's edges, and the number of each by its identity."""
    edges: list[Curve] = []
    numbers: dict[int, int] = {}
    for side in sides:
        for half in side.halves:
            for piece in half.pieces:
                numbers[id(piece.piece)] = len(edges)
                edges.append(piece.piece.curve)
    return edges, numbers


def _trims(half: HalfSide, axis: int, numbers: dict[int, int]) -> list[Trim]:
    """Return the pieces of a half on the side of a patch along one of its axes."""
    made = []
    for number, piece in enumerate(half.pieces):
        ends = np.zeros((2, 2))
        ends[:, axis] = half.breaks[number : number + 2]
        if piece.forward != half.onward:
            ends = ends[::-1]
        path = ParameterCurve.line(ends[0], ends[1], piece.piece.curve.range)
        made.append(Trim(numbers[id(piece.piece)], piece.forward, path))
    return made
