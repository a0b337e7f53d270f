"""Rims and arcs of a drawing where they are seen: on its sheet, and on the solid that it became."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto_polyhedron.drawing_on.circles import TURN, area_radius
from bozzetto_polyhedron.model.same_view import camera_of, on_sheet
from bozzetto_polyhedron.model.state import Body
from bozzetto_polyhedron.rounds.round_curves import RoundCurve, curves_of
from bozzetto_polyhedron.rounds.round_things import PlacedRound
from bozzetto_polyhedron.rounds.straightened import straightened
from bozzetto_polyhedron.solid.face_rings import tangents
from bozzetto_polyhedron.solid.planar_body import PlanarBody
from bozzetto_polyhedron.solve.pipeline import Solved

ON_WALL: Final = 1e-6
"""Distance of a vertex from a cylinder, in radii, within which it lies on it."""


@dataclass(frozen=True, eq=False)
class RoundLine:
    """A rim, or an arc.

    Parameters
    ----------
    curve : RoundCurve
        As it was drawn.
    points : (m, 3) float64
        Where it is now, mm in the frame of the model; empty where nothing came of it.
    """

    curve: RoundCurve
    points: Array


def round_lines(body: Body, found: Solved) -> list[RoundLine]:
    """Return what of a drawing was understood as round."""
    reading = straightened(body.strokes, body.evidence).reading
    if reading is None:
        return []
    curves = curves_of(reading)
    if body.choice is None or found.body is None:
        return [RoundLine(curve, on_sheet(body, curve.drawn)) for curve in curves]
    return [
        RoundLine(curve, _places(body, found.body, found.rounds[curve.number], curve, curves))
        if curve.number in found.rounds
        else RoundLine(curve, np.zeros((0, 3)))
        for curve in curves
    ]


def is_column(body: Body) -> bool:
    """Whether a drawing has nothing but cylinders: its lines are the box about the largest one."""
    return straightened(body.strokes, body.evidence).column is not None


def _places(
    body: Body,
    solid: PlanarBody,
    placed: PlacedRound,
    curve: RoundCurve,
    curves: Sequence[RoundCurve],
) -> Array:
    """Return the vertices at that end of a cylinder which a curve draws, in order about its axis.

    They are found by the cylinder and not by the ink, which lies elsewhere once a size was typed.
    """
    circle = placed.circle
    spokes = body.placement.inverse().points(solid.vertices) - circle.center
    heights = spokes @ circle.axis
    flat = spokes @ tangents(circle.axis).T
    corners = circle.radius if circle.is_arc else area_radius(circle.radius)
    on_wall = np.abs(np.linalg.norm(flat, axis=1) - corners) < ON_WALL * corners
    if not on_wall.any():
        return np.zeros((0, 3))
    low, high = heights[on_wall].min(), heights[on_wall].max()
    is_high = heights > 0.5 * (low + high)
    camera = camera_of(body)
    begin, end = camera.project(circle.center + np.outer((low, high), circle.axis))[0]
    own = curve.drawn.mean(axis=0)
    other = [
        each.drawn.mean(axis=0)
        for each in curves
        if each.number == curve.number and each is not curve
    ]
    if other:
        meant = bool((own - other[0]) @ (end - begin) > 0.0)
    else:
        meant = bool(np.linalg.norm(own - end) < np.linalg.norm(own - begin))
    chosen = np.flatnonzero(on_wall & (is_high == meant))
    angles = np.arctan2(flat[chosen, 1], flat[chosen, 0])
    order = np.argsort(angles, kind="stable")
    gaps = np.diff(angles[order], append=angles[order[:1]] + TURN)
    order = np.roll(order, -1 - int(gaps.argmax()))
    return np.asarray(solid.vertices[chosen[[*order, *([] if circle.is_arc else order[:1])]]])
