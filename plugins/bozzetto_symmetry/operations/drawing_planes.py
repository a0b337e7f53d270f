"""The plane that touches of known places mean."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.plugin import Context
from bozzetto.view import Camera, triple
from bozzetto_symmetry.model.axes import AXES
from bozzetto_symmetry.model.canvas import DrawingPlane
from bozzetto_symmetry.model.state import SymmetryState
from bozzetto_symmetry.model.symmetry_plane import Point
from bozzetto_symmetry.operations.drawn_snaps import known_places
from bozzetto_symmetry.operations.snap_targets import nearest_target

REACH: Final = 2.0
"""How near a touch must be to a known place, in tolerances of the pen: a finger is not exact."""

DETERMINED: Final = 1e-6
"""Sine of the angle between two directions below which they make no plane."""


@dataclass(frozen=True)
class Touched:
    """A place that was touched.

    Attributes
    ----------
    point : (x, y, z)
        In the frame of the model, mm.
    tangent : (x, y, z), optional
        Unit direction in which a curve or line ends there.
    """

    point: Point
    tangent: Point | None = None


def touched(
    state: SymmetryState, pixel: ArrayLike, camera: Camera, context: Context
) -> Touched | None:
    """Return the known place under the pen, else that of the surface there, if there is one."""
    known = known_places(state, context)
    place = nearest_target(pixel, camera, known, REACH * context.pen.tolerance)
    if place is None:
        hits = context.surface_hit(camera.rays(np.asarray(pixel, float)[None]))
        return Touched(triple(hits.points[0])) if bool(hits.hit[0]) else None
    away = np.linalg.norm(known.points - np.asarray(place.point), axis=1)
    number = int(np.argmin(away))
    way = known.tangents[number]
    if place.kind != "end" or not way.any():
        return Touched(place.point)
    return Touched(place.point, triple(way))


def plane_of_touches(places: Sequence[Touched], camera: Camera) -> DrawingPlane:
    """Return the plane through one, two or three places.

    Through one it is square to an axis of the box, or holds the tangent of the curve that ends
    there; through two it holds both. Of the planes that also hold an axis of the box it is the one
    that faces the eye most.

    Parameters
    ----------
    places : sequence of Touched
        One to three.
    camera : Camera
        In the frame of the model.

    Raises
    ------
    UserError
        If the places lie on a line, or two of them are one.
    """
    points = np.array([place.point for place in places])
    tangent = places[0].tangent if len(places) == 1 else None
    if len(places) == 3:
        normals = np.cross(_unit(points[1] - points[0]), _unit(points[2] - points[0]))[None]
    elif len(places) == 2:
        normals = np.cross(_unit(points[1] - points[0]), AXES)
    elif tangent is not None:
        normals = np.cross(np.asarray(tangent), AXES)
    else:
        normals = AXES
    length = np.linalg.norm(normals, axis=1)
    clear = length > DETERMINED
    if not clear.any():
        raise UserError("These places lie on a line. Touch one that lies beside it.")
    units = normals[clear] / length[clear, None]
    seen, _ = camera.project(points[-1])
    sight = camera.rays(seen).directions[0]
    facing = units[int(np.argmax(np.abs(units @ sight)))]
    return DrawingPlane(triple(points[-1]), triple(facing))


def _unit(way: Array) -> Array:
    length = float(np.linalg.norm(way))
    return way / length if length > 0.0 else way
