"""The line in space that a stroke beside a body stands for, along which copies are put."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.ink import distances_to_polyline
from bozzetto.view import Camera
from bozzetto_polyhedron.drawing_on.body_hits import met_by
from bozzetto_polyhedron.drawing_on.stroke_ends import direction_on_sheet
from bozzetto_polyhedron.solid.planar_body import PlanarBody

STRAIGHT: Final = 0.04
"""Distance of a straight stroke's points from its chord, as share of the chord."""

EDGE_ON: Final = 0.15
"""Cosine between the line of sight and the normal of a plane below which nothing is drawn in it."""


def path_of(body: PlanarBody, stroke: ArrayLike, camera: Camera, reach: float) -> Array:
    """Return the line in space of a stroke that begins on a body.

    A straight stroke along an axis of the body is that axis; any other lies in the level plane
    through where it begins, or upright, facing the eye, where that plane is seen edge-on.

    Parameters
    ----------
    body : PlanarBody
        What is drawn on.
    stroke : (n, 2) array_like
        Canvas px; one of its ends is on the body.
    camera : Camera
        Through which it was drawn.
    reach : float
        Distance within which an end meets a corner or an edge, px.

    Returns
    -------
    (n, 3) float64
        mm, beginning on the body.

    Raises
    ------
    UserError
        If neither end is on the body, or the stroke is too short.
    """
    pixels = np.asarray(stroke, float).reshape(-1, 2)
    if len(pixels) < 2 or np.linalg.norm(np.ptp(pixels, axis=0)) <= reach:
        raise UserError("Copies need a line to stand along. Draw one from the body outward.")
    met = met_by(body, camera, pixels[0], reach)
    if met is None:
        pixels = pixels[::-1]
        met = met_by(body, camera, pixels[0], reach)
    if met is None:
        raise UserError("The line begins on no body. Draw it from the body outward.")
    start = met.point
    chord = float(np.linalg.norm(pixels[-1] - pixels[0]))
    bent = float(distances_to_polyline(pixels, pixels[[0, -1]]).max())
    if bent < STRAIGHT * chord:
        axis = direction_on_sheet(body, camera, pixels[[0, -1]], start)
        if axis is not None:
            return np.stack((start, _nearest_on(camera, pixels[-1], start, axis)))
    normal = _plane_normal(camera)
    path = camera.on_plane(pixels, start, normal)
    if not np.isfinite(path).all():
        raise UserError("The line leaves the plane that it lies in. Turn the view and draw again.")
    return np.asarray(path - path[0] + start)


def _plane_normal(camera: Camera) -> Array:
    """Return the normal of the level plane, or of the upright one that faces the eye."""
    up = np.array((0.0, 0.0, 1.0))
    sight = camera.axes[2]
    if abs(float(up @ sight)) > EDGE_ON:
        return up
    level = sight - (sight @ up) * up
    return np.asarray(level / np.linalg.norm(level))


def _nearest_on(camera: Camera, pixel: Array, start: Array, axis: Array) -> Array:
    """Return the point of a line in space that is seen nearest to a place."""
    rays = camera.rays(pixel[None])
    origin, sight = rays.origins[0], rays.directions[0]
    across = np.cross(axis, sight)
    normal = np.cross(sight, across)
    return np.asarray(start + axis * float((origin - start) @ normal) / float(axis @ normal))
