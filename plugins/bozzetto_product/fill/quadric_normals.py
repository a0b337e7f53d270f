"""Normals that planes and quadrics through the curves of loops tell along their edges.

Two curves through a corner leave open how normals lean in the middle of edges; a surface of second
order, if one alone goes through all curves of a loop, tells it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, cross_product
from bozzetto.geometry import Spline
from bozzetto.plugin import remembered
from bozzetto_product.fill.edge_pieces import opened
from bozzetto_product.fill.even_torsion import even_parameters
from bozzetto_product.fill.normal_field import NormalField, unit_tangents
from bozzetto_product.fill.quadric import EXACT, Quadric, quadric_through
from bozzetto_product.network.flat_places import plane_through
from bozzetto_product.network.net import Loop, Net

MOST_APART: Final = 0.15
"""Angle at the ends of an edge between the normals of its corners and those of a quadric, radians,
up to which the quadric is meant there: a hook at the end of a curve leans its corner."""

SAME: Final = 0.05
"""Largest angle between the normals of two quadrics along an edge, radians, up to which they are
the same."""


LEAST_LEANING: Final = 0.01
"""The same of a plane: a ring in a plane may well be that of a dome, which leans there."""

CREASED: Final = float(np.sin(np.radians(3.0)))
"""Sine between the normals of two exact surfaces somewhere along an edge from which it is a crease:
two cylinders of one radius that cross are tangent at the ends of their edge, and nowhere else."""


def is_exact_crease(net: Net, edge: int, loops: Sequence[Loop]) -> bool:
    """Tell whether two loops lie in planes or on quadrics that meet at an angle along an edge.

    Parameters
    ----------
    net : Net
        The network.
    edge : int
        Of both loops.
    loops : sequence of Loop
        The two.
    """
    spline = opened(net.edges[edge].spline)
    places = spline.value(even_parameters(spline)[0])
    found = []
    for loop in loops:
        surface = _surface_of(tuple(net.edges[number].spline for number, _ in loop))
        if surface is None or not surface.is_exact:
            return False
        found.append(surface.normals(places))
    return bool(np.linalg.norm(cross_product(*found), axis=1).max() > CREASED)


def quadric_turns(
    net: Net,
    loops: Sequence[Loop],
    smooth: Mapping[int, Sequence[tuple[int, int, bool]]],
    fields: Mapping[int, NormalField],
) -> dict[int, Array]:
    """Return how far the normals of edges are from those of a quadric.

    Parameters
    ----------
    net : Net
        The network.
    loops : sequence of Loop
        Counter-clockwise seen from outside.
    smooth : mapping of int to sequence
        Of each smooth edge the loop, the place in it, and whether it runs in the edge's sense,
        once or twice.
    fields : mapping of int to NormalField
        Of edges, with the normals of corners at their ends.

    Returns
    -------
    dict of int to (17,) array
        Of each edge of a loop that lies on one quadric alone, or in a plane, and is smooth all
        round or lies there exactly; at the places of `even_parameters`, radians about the tangent.
    """
    told: dict[int, list[Array]] = {}
    for loop in loops:
        if not any(edge in fields for edge, _ in loop):
            continue
        surface = _surface_of(tuple(net.edges[edge].spline for edge, _ in loop))
        if surface is None:
            continue
        if not surface.is_exact and any(edge not in smooth for edge, _ in loop):
            continue
        for edge, _ in loop:
            if edge in fields:
                turn = _turn_to(surface, fields[edge])
                if max(abs(turn[0]), abs(turn[-1])) <= surface.most_apart:
                    told.setdefault(edge, []).append(turn)
    return {
        edge: np.mean(turns, axis=0)
        for edge, turns in told.items()
        if float(np.ptp(turns, axis=0).max()) <= SAME
    }


@dataclass(frozen=True, eq=False)
class _Plane:
    """A plane in which the curves of a loop lie.

    Parameters
    ----------
    normal : (3,) float
        Unit.
    """

    normal: Array
    is_exact: bool = True
    most_apart: float = LEAST_LEANING

    def normals(self, places: Array) -> Array:
        """Return its normal at places, (n, 3)."""
        return np.broadcast_to(self.normal, places.shape)


@dataclass(frozen=True, eq=False)
class _Curved:
    """A quadric on which the curves of a loop lie."""

    quadric: Quadric
    most_apart: float = MOST_APART

    @property
    def is_exact(self) -> bool:
        """See `Quadric.is_exact`."""
        return self.quadric.is_exact

    def normals(self, places: Array) -> Array:
        """Return unit normals at places, (n, 3)."""
        return self.quadric.normals(places)


@remembered(limit=2000)
def _surface_of(splines: tuple[Spline, ...]) -> _Plane | _Curved | None:
    """Return the plane or the one quadric that splines lie on, if they do."""
    plane = plane_through(np.concatenate([spline.control_points for spline in splines]), EXACT)
    if plane is not None:
        return _Plane(plane[1])
    places, weights = [], []
    for spline in splines:
        at, length = even_parameters(opened(spline))
        share = np.full(len(at), length / (len(at) - 1))
        share[[0, -1]] *= 0.5
        places.append(opened(spline).value(at))
        weights.append(share)
    quadric = quadric_through(np.concatenate(places), np.concatenate(weights))
    return None if quadric is None else _Curved(quadric)


@remembered(limit=4000)
def _turn_to(surface: _Plane | _Curved, field: NormalField) -> Array:
    """Return the angles about an edge from its normals to those of a surface, (17,), radians."""
    at, _ = even_parameters(field.spline)
    normals, tangents = field.value(at), unit_tangents(field.spline, at)
    wanted = surface.normals(field.spline.value(at))
    along = (normals * wanted).sum(axis=1)
    sine = (cross_product(normals, wanted) * tangents).sum(axis=1)
    sense = -1.0 if along[len(along) // 2] < 0.0 else 1.0
    return np.asarray(np.arctan2(sense * sine, sense * along))
