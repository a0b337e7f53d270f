"""Patchworks as faces that share edges, so that one writer serves both."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from bozzetto.arrays import frozen
from bozzetto.geometry.brep.brep import Brep, Face, ParameterCurve, Trim
from bozzetto.geometry.brep.surface import BSplineSurface
from bozzetto.geometry.curve import Curve
from bozzetto.geometry.look import Look
from bozzetto.geometry.patches.coons import edge_numbers

if TYPE_CHECKING:
    from bozzetto.geometry.patches.patchwork import Patchwork

KNOTS: Final = frozen((0.0,) * 4 + (1.0,) * 4, np.float64)
"""Knots with which a cubic B-spline of four control points is a Bézier curve."""

CORNERS: Final = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.0, 0.0))
"""u and v where the sides of a patch meet, in their order."""


def brep_of_patchwork(patchwork: Patchwork) -> Brep:
    """Return each patch as a face, with the same control points and order; edges of none go."""
    used = np.unique(edge_numbers(patchwork.sides))
    number_of = {edge: number for number, edge in enumerate(used.tolist())}
    names = patchwork.patch_names or ("",) * len(patchwork.nets)
    looks = patchwork.patch_looks or (Look(),) * len(patchwork.nets)
    faces = []
    rows = zip(patchwork.nets, patchwork.sides.tolist(), names, looks, strict=True)
    for net, sides, name, look in rows:
        loop = []
        for number, side in enumerate(sides):
            ends = CORNERS[number : number + 2]
            start, end = ends if side >= 0 else ends[::-1]
            path = ParameterCurve.line(start, end, (0.0, 1.0))
            loop.append(Trim(number_of[max(side, ~side)], side >= 0, path))
        faces.append(Face(BSplineSurface((3, 3), KNOTS, KNOTS, net), (tuple(loop),), name, *look))
    edges = tuple(Curve(3, KNOTS, points) for points in patchwork.edges[used])
    return Brep(edges, tuple(faces), patchwork.name, patchwork.color)
