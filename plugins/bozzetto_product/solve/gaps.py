"""Gaps that were left open: ends of curves that nearly meet something."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bozzetto.plugin import remembered
from bozzetto.view import triple
from bozzetto_product.model.curves import Curve
from bozzetto_product.model.state import ProductState
from bozzetto_product.operations.free_ends import ASKED
from bozzetto_product.operations.meetings import meeting_place, splines_of
from bozzetto_product.operations.proposals import proposals_of
from bozzetto_product.projection.planes import in_plane

NEARLY: Final = 0.05
"""Widest gap that is told, as share of the network's diagonal."""


@dataclass(frozen=True)
class Gap:
    """An end of a curve that nearly meets something, but is not joined to it.

    Attributes
    ----------
    curve : str
        Name of the curve that ends there.
    other : str
        Name of the curve that it nearly meets; empty for the symmetry plane.
    width : float
        mm.
    ends : ((x, y, z), (x, y, z))
        Where the end is, and where it would meet the other, mm.
    """

    curve: str
    other: str
    width: float
    ends: tuple[tuple[float, float, float], tuple[float, float, float]]


def gaps_of(state: ProductState, curves: Sequence[Curve], size: float) -> tuple[Gap, ...]:
    """Return the gaps of a network, narrowest first.

    Parameters
    ----------
    state : ProductState
        Its joints and its symmetry.
    curves : sequence of Curve
        Where they are now.
    size : float
        Diagonal of the network, mm.
    """
    shapes = tuple((c.id, c.spline, c.mirrored) for c in curves if c.spline is not None)
    now = {curve.id: curve for curve in curves}
    nodes = tuple(now.get(node.id, node) for node in state.nodes)
    ends = _gaps(shapes, replace(state, nodes=nodes, selected=""), size)
    return tuple(replace(gap, curve=now[gap.curve].name, other=_name(now, gap)) for gap in ends)


def _name(curves: dict[str, Curve], gap: Gap) -> str:
    return curves[gap.other].name if gap.other else ""


def _key(shapes: tuple[object, ...], state: ProductState, size: float) -> tuple[object, ...]:
    return shapes, state.joints, state.symmetry, state.mirror, size


@remembered(limit=8, key=_key)
def _gaps(shapes: tuple[object, ...], state: ProductState, size: float) -> tuple[Gap, ...]:
    """Return the gaps, with the ids of curves in the place of their names."""
    splines = splines_of(state)
    made = []
    for one in proposals_of(state, NEARLY * size / ASKED):
        end = meeting_place(splines, one.meetings[0], state.symmetry)
        there, other = in_plane(end, state.symmetry), ""
        if len(one.meetings) > 1:
            there = meeting_place(splines, one.meetings[1], state.symmetry)
            other = one.meetings[1].curve
        width = float(np.linalg.norm(there - end))
        made.append(Gap(one.meetings[0].curve, other, width, (triple(end), triple(there))))
    return tuple(made)
