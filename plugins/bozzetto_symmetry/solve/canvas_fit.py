"""Curves drawn on a plane, or on the surface of another object: there one side says all.

Every line of sight meets the plane in one place (ILoveSketch: Bae, Balakrishnan & Singh 2008,
section "sketch surfaces"); on a surface the places were found when the curve was drawn.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags
from bozzetto.errors import UserError
from bozzetto.ink import arc_length, distances_to_polyline
from bozzetto_symmetry.fitting.bundle_adjustment import FEWEST, MORE, MOST, Sight, adjust_bundle
from bozzetto_symmetry.fitting.initial_guess import approximate, stations_of
from bozzetto_symmetry.fitting.normal_equations import NO_PLANES
from bozzetto_symmetry.fitting.space_curve import Reading, SpaceCurve
from bozzetto_symmetry.fitting.symmetric_basis import SymmetricBasis
from bozzetto_symmetry.ink.sides import Side
from bozzetto_symmetry.model.canvas import DrawingPlane, LaidInk
from bozzetto_symmetry.model.symmetry_plane import CentrePlane
from bozzetto_symmetry.solve.curve_fit import sampled
from bozzetto_symmetry.stereo.mirror_camera import MIRROR, Stereo
from bozzetto_symmetry.stereo.uncertainty import across_image, image_slopes

GRAZING: Final = float(np.sin(np.radians(3.0)))
"""Sine of the angle between a plane and the line of sight below which nothing is drawn on it."""

SAME: Final = 1e-6
"""Difference of unit normals, and share of a curve's size, within which planes are one."""

SYMMETRIC: Final = 0.02
"""Distance, as a share of a curve's size, within which it is its own mirror image: a hand that
draws a section over the centre plane errs by as much."""

FLAT: Final = 0.01
"""Standard deviation, as a share of the size, of places on a canvas: they are all known alike."""

ON_SURFACE: Final = 0.3
"""Distance (rms, px) from the places on a surface at which more control points are of no use."""


@dataclass(frozen=True, eq=False)
class CanvasFit:
    """A curve on its canvas.

    Attributes
    ----------
    curve : SpaceCurve
        In the frame of the centre plane.
    points : (k, 3) float
        Along it, mm.
    sigma : (k,) float
        How far each may be off across the curve for 1 px of the hand, mm.
    rms : float
        Distance of the ink from the image of the curve, px.
    """

    curve: SpaceCurve
    points: Array
    sigma: Array
    rms: float


def fitted_in_plane(
    stereo: Stereo, sides: Sequence[Side], plane: DrawingPlane, centre: CentrePlane
) -> CanvasFit:
    """Return the curve of a plane that is seen where the ink is.

    In the centre plane it is a curve in that. In a plane square to the centre plane, and drawn
    over both sides alike, it is a curve across. All others have a mirror image.

    Parameters
    ----------
    stereo : Stereo
        The camera of the view, in the frame of the centre plane.
    sides : sequence of Side
        One side.
    plane : DrawingPlane
        In the frame of the model.
    centre : CentrePlane
        The plane of symmetry.

    Raises
    ------
    UserError
        If the plane is seen edge-on, or lies behind the eye, or there is more than one line.
    """
    if len(sides) != 1:
        raise UserError("On a plane one line makes the curve. Draw it in one stroke.")
    (side,) = sides
    frame = centre.inverse
    normal, point = frame.directions(plane.normal)[0], frame.points(plane.point)[0]
    ink = side.pixels
    places = _met(stereo, ink, point, normal)
    size = float(np.linalg.norm(np.ptp(places, axis=0)))
    away = float(normal @ point)
    planes = np.append(normal, away)[None]
    spread = np.tile((FLAT * max(size, 1e-300)) ** 2 * np.eye(3), (len(places), 1, 1))
    reading: Reading
    near: tuple[Array, ...] = (ink,)
    far: tuple[Array, ...] = ()
    if abs(normal[1]) > 1.0 - SAME and np.abs(places[:, 1]).max() <= SAME * size:
        reading, planes = "plane", NO_PLANES
    elif (halves := _halves(ink, places, side.closed, normal, size)) is not None:
        reading = "self"
        near, far, places = halves
        spread = spread[: len(places)]
    else:
        reading = "pair"
    sight = Sight(stereo, near, far, side.noise)
    ring = reading == "self" and side.closed
    made = adjust_bundle(
        reading, places, spread, [sight], closed=side.closed, ring=ring, planes=planes
    )
    points = sampled(made.curve.spline)
    normals = np.tile(normal, (len(points), 1))
    return CanvasFit(made.curve, points, _sigmas(stereo, made.curve, points, normals), made.rms)


def fitted_on_surface(stereo: Stereo, laid: LaidInk, centre: CentrePlane) -> CanvasFit:
    """Return the curve through the places of a surface that ink lies on; it has a mirror image.

    Parameters
    ----------
    stereo : Stereo
        The camera of the view, in the frame of the centre plane.
    laid : LaidInk
        In the frame of the model.
    centre : CentrePlane
        The plane of symmetry.
    """
    frame = centre.inverse
    places, normals = frame.points(laid.points), frame.directions(laid.normals)
    size = float(np.linalg.norm(np.ptp(places, axis=0)))
    if not size > 0.0:
        raise UserError("The curve comes out as a dot. Draw it larger.")
    spread = np.tile((FLAT * size) ** 2 * np.eye(3), (len(places), 1, 1))
    reading: Reading = "plane" if np.abs(places[:, 1]).max() <= SAME * size else "pair"
    seen = stereo.project(places)
    for count in range(FEWEST, MOST + 1, MORE):
        basis = SymmetricBasis(reading, count, False, False)
        stations = stations_of(places, spread, basis)
        curve = basis.curve(approximate(basis, places, spread, stations))
        points = sampled(curve.spline)
        off = distances_to_polyline(seen, stereo.project(points))
        rms = float(np.sqrt(np.mean(off**2)))
        if rms <= ON_SURFACE:
            break
    along = arc_length(points) / max(float(arc_length(points)[-1]), 1e-300)
    theirs = arc_length(places) / max(float(arc_length(places)[-1]), 1e-300)
    there = np.column_stack([np.interp(along, theirs, column) for column in normals.T])
    return CanvasFit(curve, points, _sigmas(stereo, curve, points, there), rms)


def _met(stereo: Stereo, pixels: Array, point: Array, normal: Array) -> Array:
    """Return where lines of sight meet a plane, (n, 3) mm."""
    rays = stereo.rays(pixels)
    slope = rays.directions @ normal
    if not (np.abs(slope) > GRAZING).all():
        raise UserError("The plane is seen edge-on from here. Turn the view, then draw the curve.")
    reach = ((point - rays.origins) @ normal) / slope
    if not stereo.parallel and not (reach > 0.0).all():
        raise UserError("The plane lies behind the eye there. Turn the view, then draw the curve.")
    return np.asarray(rays.origins + reach[:, None] * rays.directions)


def _halves(
    ink: Array, places: Array, closed: bool, normal: Array, size: float
) -> tuple[tuple[Array, ...], tuple[Array, ...], Array] | None:
    """Return the ink of both halves of a curve across the plane, from that on, and one half.

    None where the curve is not its own mirror image.
    """
    if abs(normal[1]) > SAME:
        return None
    line = np.vstack((places, places[:1])) if closed else places
    if float(np.median(distances_to_polyline(places * MIRROR, line))) > SYMMETRIC * size:
        return None
    above: Flags = places[:, 1] > 0.0
    changes = np.flatnonzero(above != np.roll(above, -1)) if closed else np.flatnonzero(
        np.diff(above)
    )  # fmt: skip
    if len(changes) != (2 if closed else 1):
        return None
    if closed:
        ink, places = (np.roll(each, -int(changes[0]) - 1, axis=0) for each in (ink, places))
        middle = int(changes[1] - changes[0])
        return (ink[:middle],), (ink[: middle - 1 : -1],), places[:middle]
    middle = int(changes[0]) + 1
    return (ink[middle - 1 :: -1],), (ink[middle:],), places[middle - 1 :: -1]


def _sigmas(stereo: Stereo, curve: SpaceCurve, points: Array, normals: Array) -> Array:
    """Return how far places of a curve on a canvas may be off across it, (n,) mm for 1 px.

    A place moves within the canvas, across the curve, as its image moves across itself.
    """
    tangents = curve.spline.derivative(np.linspace(*curve.spline.range, len(points)))
    length = np.linalg.norm(tangents, axis=1, keepdims=True)
    along = np.divide(tangents, length, out=np.zeros_like(tangents), where=length > 0)
    aside = np.cross(normals, along)
    known = np.zeros(len(points))
    for factors in (np.ones(3), MIRROR) if curve.reading == "self" else (np.ones(3),):
        rows = across_image(image_slopes(stereo, points * factors) * factors, along)
        known += np.einsum("ni,ni->n", rows, aside) ** 2
    sigma = 1.0 / np.sqrt(np.maximum(known, 1e-12))
    apart = np.linalg.norm(points[:, None] - points, axis=2)
    return np.asarray((sigma + apart).min(axis=1, initial=np.inf))
