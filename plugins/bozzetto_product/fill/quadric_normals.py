"""Normals that quadrics through the curves of loops tell along their edges.

Two curves through a corner leave open how normals lean in the middle of edges; a surface of second
order, if one alone goes through all curves of a loop, tells it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from bozzetto.arrays import Array, cross_product
from bozzetto.geometry import Spline
from bozzetto.plugin import remembered
from bozzetto_product.fill.edge_pieces import opened
from bozzetto_product.fill.even_torsion import even_parameters
from bozzetto_product.fill.normal_field import NormalField, unit_tangents
from bozzetto_product.fill.quadric import Quadric, quadric_through
from bozzetto_product.network.net import Loop, Net

MOST_APART: Final = 0.15
"""Angle at the ends of an edge between the normals of its corners and those of a quadric, radians,
up to which the quadric is meant there: a hook at the end of a curve leans its corner."""

SAME: Final = 0.05
"""Largest angle between the normals of two quadrics along an edge, radians, up to which they are
the same."""


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
        Of each edge of a loop that is smooth all round and lies on one quadric alone, at the
        places of `even_parameters`, radians about the tangent.
    """
    told: dict[int, list[Array]] = {}
    for loop in loops:
        if any(edge not in smooth for edge, _ in loop):
            continue
        quadric = _quadric_of(tuple(net.edges[edge].spline for edge, _ in loop))
        if quadric is None:
            continue
        for edge, _ in loop:
            if edge in fields:
                turn = _turn_to(quadric, fields[edge])
                if max(abs(turn[0]), abs(turn[-1])) <= MOST_APART:
                    told.setdefault(edge, []).append(turn)
    return {
        edge: np.mean(turns, axis=0)
        for edge, turns in told.items()
        if float(np.ptp(turns, axis=0).max()) <= SAME
    }


@remembered(limit=2000)
def _quadric_of(splines: tuple[Spline, ...]) -> Quadric | None:
    places, weights = [], []
    for spline in splines:
        at, length = even_parameters(opened(spline))
        share = np.full(len(at), length / (len(at) - 1))
        share[[0, -1]] *= 0.5
        places.append(opened(spline).value(at))
        weights.append(share)
    return quadric_through(np.concatenate(places), np.concatenate(weights))


@remembered(limit=4000)
def _turn_to(quadric: Quadric, field: NormalField) -> Array:
    """Return the angles about an edge from its normals to those of a quadric, (17,), radians."""
    at, _ = even_parameters(field.spline)
    normals, tangents = field.value(at), unit_tangents(field.spline, at)
    wanted = quadric.normals(field.spline.value(at))
    along = (normals * wanted).sum(axis=1)
    sine = (cross_product(normals, wanted) * tangents).sum(axis=1)
    sense = -1.0 if along[len(along) // 2] < 0.0 else 1.0
    return np.asarray(np.arctan2(sense * sine, sense * along))
