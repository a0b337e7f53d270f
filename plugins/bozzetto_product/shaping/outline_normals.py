"""Normals along an outline that nothing meets: from corner to corner."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.geometry import DEGREE, Spline
from bozzetto_product.fill.edge_pieces import opened
from bozzetto_product.fill.loop_sides import corner_kind
from bozzetto_product.fill.normal_field import NormalField, carried, frame_parameters
from bozzetto_product.fill.normals import LoopNormals
from bozzetto_product.network.net import Loop, Net

FEWEST: Final = 3
"""Corners of an outline from which on they tell how its surface leaves it."""


def with_open_fields(
    net: Net, ring: Loop, normals: LoopNormals, met: Collection[int]
) -> LoopNormals:
    """Return the normals of an outline with fields along its open edges.

    The planes of two corners that follow one another are carried along what runs between them, with
    as little turn as possible. Edges that others meet, and creases, stay as they are.

    Parameters
    ----------
    net : Net
        That it is in.
    ring : Loop
        The outline.
    normals : LoopNormals
        Of it.
    met : collection of int
        Edges that other surfaces have.
    """
    starts = [k for k, corner in enumerate(normals.corners) if corner_kind(corner)]
    if len(starts) < FEWEST:
        return normals
    fields = list(normals.fields)
    for first, last in zip(starts, [*starts[1:], starts[0] + len(ring)], strict=True):
        run = [k % len(ring) for k in range(first, last)]
        curves = [opened(net.edges[ring[k][0]].spline) for k in run]
        along = [one if ring[k][1] else one.reversed() for k, one in zip(run, curves, strict=True)]
        ends = normals.corners[run[0]].normal, normals.corners[last % len(ring)].normal
        whole = carried(rejoined(along), *ends)
        begin = whole.spline.range[0]
        for k, curve in zip(run, curves, strict=True):
            low, high = curve.range
            edge, forward = ring[k]
            if fields[k] is None and edge not in met and not net.edges[edge].crease >= 1.0:
                at = frame_parameters(curve)
                there = begin + (at - low if forward else high - at)
                fields[k] = NormalField(curve, at, whole.value(np.clip(there, *whole.spline.range)))
            begin += high - low
    return replace(normals, fields=tuple(fields))


def rejoined(pieces: Sequence[Spline]) -> Spline:
    """Return pieces that follow one another on a curve as one, with a knot of full count between.

    Parameters
    ----------
    pieces : sequence of Spline
        Clamped; each begins in the very place where the one before ends.
    """
    knots, points = [pieces[0].knots[:-1]], [pieces[0].control_points]
    for piece in pieces[1:]:
        begin = knots[-1][-1]
        knots.append(begin + piece.knots[DEGREE + 1 : -1] - piece.range[0])
        points.append(piece.control_points[1:])
    last = knots[-1][-1]
    return Spline(np.append(np.concatenate(knots), last), np.concatenate(points))
