"""Which spot the pen means: a corner, a place on a body, or a place in space."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.scene import Layer, Scene, Shaded, cast_rays
from bozzetto.view import Camera
from bozzetto_polyhedron.model.fittings import Spot
from bozzetto_polyhedron.model.followed import Followed
from bozzetto_polyhedron.model.state import Body, PolyhedronState
from bozzetto_polyhedron.solve.moving import Moving, corner_of
from bozzetto_polyhedron.solve.picking import REACH
from bozzetto_polyhedron.solve.pipeline import solved
from bozzetto_polyhedron.solve.spots import corner_places_at_rest, spot_at

SAME: Final = 1e-6
"""Distance, in extents of a body, within which a vertex is a corner of its drawing."""


@dataclass(frozen=True, eq=False)
class Aim:
    """A spot that the pen means.

    Parameters
    ----------
    spot : Spot
    place : (3,) float64
        Where it is now, mm.
    """

    spot: Spot
    place: Array


def aim_at(
    state: PolyhedronState, made: Moving, camera: Camera, pixel: Array, beside: Array | None = None
) -> Aim | None:
    """Return what is under the pen.

    Where that is nothing, the pen means the place that is as far from the eye as a place beside
    it, (3,) mm; without such a place it means nothing.
    """
    corner = _corner_at(state, made, camera, pixel)
    if corner is not None:
        return corner
    if state.moved is None:
        hit = _surface_at(state, made, camera, pixel)
        if hit is not None:
            return hit
    if beside is None:
        return None
    place = camera.on_plane(pixel[None], beside, camera.axes[2])[0]
    return Aim(spot_at(place, None), place) if np.isfinite(place).all() else None


def _corner_at(state: PolyhedronState, made: Moving, camera: Camera, pixel: Array) -> Aim | None:
    best, away = None, REACH
    motion = made.motion(state.moved)
    for body_id, number in made.numbers.items():
        if not isinstance(state.node(body_id), Body):
            continue  # what is round has no corners: its surface is meant
        places = made.machine.moved(number, motion)
        far = np.linalg.norm(camera.project(places)[0] - pixel, axis=1)
        far = np.where(np.isfinite(far), far, np.inf)
        nearest = int(np.argmin(far))
        if far[nearest] <= away:
            away = float(far[nearest])
            rest = made.machine.shapes[number].vertices[nearest]
            best = Aim(corner_spot(state, state.node(body_id), rest), places[nearest])
    return best


def corner_spot(state: PolyhedronState, body: Body | Followed, rest: Array) -> Spot:
    """Return the spot at a corner of a body that is at a place at rest, mm."""
    if isinstance(body, Followed):
        return spot_at(rest, body)
    found = solved(body, state)
    corner = corner_of(body, found, rest)
    drawn = corner_places_at_rest(body, found)
    if np.linalg.norm(drawn[corner] - rest) > SAME * float(np.ptp(drawn, axis=0).max()):
        return spot_at(rest, body)
    x, y = (float(value) for value in found.graph.places[corner])
    return spot_at(rest, body, (x, y))


def _surface_at(state: PolyhedronState, made: Moving, camera: Camera, pixel: Array) -> Aim | None:
    layers = [
        Layer(body_id, (Shaded(mesh),), owner=body_id) for body_id, mesh in made.meshes.items()
    ]
    if not layers:
        return None
    hits = cast_rays(Scene(tuple(layers)), camera.rays(pixel[None]))
    if not hits.hit[0]:
        return None
    place = np.asarray(hits.points[0], float)
    return Aim(spot_at(place, state.node(hits.owners[0])), place)
