"""A curve in space that follows strokes drawn over it in one view.

Kara & Shimada, section 13.2: the picture of the curve is an active contour that the strokes
pull, and its new course is lifted back into space with the least change. The control points of
the curve follow, so what was not drawn over stays.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.geometry import Spline
from bozzetto.ink import (
    DEFAULT_FORCES,
    SnakeForces,
    Stroke,
    contour_nodes,
    lift_curve,
    oversketch_curve,
)
from bozzetto_symmetry.editing.displacement import displace
from bozzetto_symmetry.fitting.space_curve import SpaceCurve
from bozzetto_symmetry.model.perspective import pixel_size
from bozzetto_symmetry.stereo.mirror_camera import MIRROR, Stereo

SPACING: Final = 2.5
"""Distance of the contour's nodes along the picture, px: about the finest detail of a hand."""

STEEPEST: Final = 20.0
"""How much farther a place may go in the plane than it seems to, before the view says too
little about it: the plane is seen within three degrees of its edge then."""


def oversketch(
    curve: SpaceCurve,
    stereo: Stereo,
    strokes: Sequence[Stroke],
    *,
    mirrored: bool = False,
    forces: SnakeForces = DEFAULT_FORCES,
) -> SpaceCurve:
    """Return the curve after strokes drawn over it.

    Only what was drawn over changes, and a short stretch beyond. A pair stays one, exactly;
    so does a curve across the plane, which crosses it at a right angle as before; and one in
    the plane stays there.

    Parameters
    ----------
    curve : SpaceCurve
        The curve in space, in the frame of the plane.
    stereo : Stereo
        Of the camera through which the strokes were drawn.
    strokes : sequence of Stroke
        What was drawn, in one view.
    mirrored : bool
        Of a pair: they were drawn over the mirror image.
    forces : SnakeForces
        What pulls and what resists.

    Returns
    -------
    SpaceCurve
        The same object where the strokes follow the curve as it is.

    Raises
    ------
    UserError
        If nothing of the curve is seen, or the plane that holds it is seen edge-on.
    """
    image = MIRROR if mirrored and curve.reading == "pair" else np.ones(3)
    at, points, whole = _nodes(curve.spline, stereo, image)
    pixels = stereo.project(points)
    bent = oversketch_curve(
        pixels,
        [(stroke.points, stroke.pressure) for stroke in strokes],
        closed=whole,
        forces=forces,
    )
    if not bent.moved.any():
        return curve
    if curve.reading == "plane":
        goal = _in_plane(stereo, bent.points, points, pixels)
    else:
        goal = lift_curve(points, stereo.camera, bent.points)
    shifts = np.where(bent.moved[:, None], (goal - points) * image, 0.0)
    unit = pixel_size(stereo.camera, points)
    spline = displace(curve.spline, at, shifts, unit, symmetric=curve.reading == "self")
    return curve if spline is curve.spline else SpaceCurve(curve.reading, spline)


def _nodes(spline: Spline, stereo: Stereo, image: Array) -> tuple[Array, Array, bool]:
    """Return places at equal steps along the picture: parameters, points, whether they close."""
    at, whole = contour_nodes(spline, lambda points: stereo.project(points * image), SPACING)
    return at, spline.value(at) * image, whole


def _in_plane(stereo: Stereo, pixels: Array, points: Array, before: Array) -> Array:
    """Return where the new places are seen in the centre plane, (n, 3) mm."""
    goal = stereo.on_plane(pixels)
    way = np.linalg.norm(goal - points, axis=1) / pixel_size(stereo.camera, points)
    if not (way <= STEEPEST * np.linalg.norm(pixels - before, axis=1) + 1.0).all():
        raise UserError(
            "Where the stroke leads, the centre plane is seen edge-on or not at all. Turn the "
            "view, then draw over the curve."
        )
    return goal
