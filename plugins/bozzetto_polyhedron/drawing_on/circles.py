"""Ellipses on the sheet that are circles in space: on a face, or in a plane of the frame.

A stroke is laid into each plane that it may lie in; the plane in which it is rounder than in all
others names its axis. Radial errors are weighed by their length on the sheet.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, cos, pi
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.ink import resample
from bozzetto.view import Camera
from bozzetto_polyhedron.drawing_on.body_hits import face_under
from bozzetto_polyhedron.solid.face_rings import tangents
from bozzetto_polyhedron.solid.planar_body import PlanarBody

SAMPLES: Final = 60
"""Points of a stroke that a circle is fitted to."""

SIDES: Final = 48
"""Sides of the polygon that a circle is pushed as."""

TURN: Final = 2.0 * pi
"""Radians."""

ROUNDING: Final = 1e-9
"""Share of a side that does not make one more."""

ROUND: Final = 0.06
"""Largest deviation from a circle, root mean square over the radius, both on the sheet: a hand
wobbles by 2 % of the drawing, and a square is off by 10 %."""

OVAL: Final = 1.4
"""Largest ratio of the axes of what is drawn for a circle: people mistake how a face is turned, and
who means an ellipse draws it longer."""

ALL_ROUND: Final = 0.8 * TURN
"""Angle by which ink must go round a circle: what leaves more open is not closed yet."""

EDGE_ON: Final = 0.05
"""Cosine of the angle between line of sight and axis below which a plane shows no circle."""

ROUNDS: Final = 8
"""Steps of Gauss and Newton; three are usual."""


@dataclass(frozen=True, eq=False)
class Circle:
    """A circle in space, or the arc that rounds an edge.

    Parameters
    ----------
    center : (3,) float64
        mm.
    axis : (3,) float64
        Unit normal of its plane; on a face that of the face.
    radius : float
        mm.
    face : int
        The face that it lies on, −1 for none.
    deviation : float
        Root mean square distance of the ink, over the radius, on the sheet; on a face from the
        ellipse that was drawn for the circle, where that is nearer and no more than `OVAL`.
    sweep : float
        Angle of an arc, radians, at most half a turn; a whole turn for a circle.
    """

    center: Array
    axis: Array
    radius: float
    face: int
    deviation: float
    sweep: float = TURN

    @property
    def is_arc(self) -> bool:
        """Whether it rounds an edge."""
        return self.sweep < TURN

    @property
    def sides(self) -> int:
        """Number of flat sides that stand for it."""
        return max(3, ceil(SIDES * self.sweep / TURN - ROUNDING)) if self.is_arc else SIDES

    @property
    def apothem(self) -> float:
        """Distance of the flat sides from the axis, mm.

        The sides of a circle have its area. Those of an arc have their corners on it, so that the
        faces beside it end where it begins.
        """
        corners = self.radius if self.is_arc else area_radius(self.radius)
        return corners * cos(0.5 * self.sweep / self.sides)


def circle_on_face(body: PlanarBody, stroke: ArrayLike, camera: Camera) -> Circle | None:
    """Return the circle that a closed stroke draws on a face; None if it is no circle there.

    Parameters
    ----------
    body : PlanarBody
        What is drawn on.
    stroke : (n, 2) array_like
        Canvas px.
    camera : Camera
        Through which it was drawn.
    """
    pixels = _samples(stroke)
    hit = face_under(body, camera, pixels.mean(axis=0))
    if hit is None:
        return None
    normal = body.normals[hit[1]]
    found = _fitted(pixels, camera, normal, float(body.offsets[hit[1]]), hit[1], oval=True)
    if found is None or found.deviation >= ROUND or _turned(found, pixels, camera) < ALL_ROUND:
        return None
    return found


def circle_in_plane(
    points: ArrayLike, camera: Camera, normal: Array, offset: float, face: int
) -> Circle | None:
    """Return the circle in the plane of a face that is seen as points; None where it is none.

    Parameters
    ----------
    points : (n, 2) array_like
        Canvas px, in their order.
    camera : Camera
        Through which they are seen.
    normal : (3,) float64
        Of the plane.
    offset : float
        Of the plane, mm.
    face : int
        Number of the face, which the circle gets.
    """
    return _fitted(_samples(points), camera, normal, offset, face, oval=True)


def _turned(circle: Circle, pixels: Array, camera: Camera) -> float:
    """Return the angle by which ink goes round a circle: a straight line is part of a wide one."""
    points = camera.on_plane(pixels, circle.center, circle.axis)
    x, y = ((points - circle.center) @ tangents(circle.axis).T).T
    angles = np.unwrap(np.arctan2(y, x))
    return float(abs(angles[-1] - angles[0]))


def area_radius(radius: float) -> float:
    """Return the radius of the corners of a polygon of `SIDES` sides with a circle's area."""
    turn = 2.0 * np.pi / SIDES
    return radius * float(np.sqrt(turn / np.sin(turn)))


def polygon_of(circle: Circle) -> Array:
    """Return a regular polygon of the same area, to push as a loop, (`SIDES`, 3), mm."""
    radius = area_radius(circle.radius)
    angles = 2.0 * np.pi / SIDES * np.arange(SIDES)
    across = tangents(circle.axis)
    return np.asarray(
        circle.center + radius * np.column_stack((np.cos(angles), np.sin(angles))) @ across
    )


def _samples(stroke: ArrayLike) -> Array:
    points = np.asarray(stroke, float).reshape(-1, 2)
    if len(points) < 5 or not np.isfinite(points).all():
        raise UserError("A circle needs a longer stroke. Draw it again.")
    if not np.linalg.norm(np.ptp(points, axis=0)) > 0:
        raise UserError("A circle needs a longer stroke. Draw it again.")
    return np.asarray(resample(points, count=SAMPLES))


def _fitted(
    pixels: Array, camera: Camera, axis: Array, offset: float, face: int, *, oval: bool = False
) -> Circle | None:
    """Fit a circle in a plane with residuals on the sheet; None where the plane is seen edge-on."""
    points = camera.on_plane(pixels, offset * axis, axis)
    if not np.isfinite(points).all():
        return None
    sight = points - np.asarray(camera.eye) if camera.kind == "perspective" else camera.axes[2:]
    sight = sight / np.linalg.norm(sight, axis=1, keepdims=True)
    if np.abs(sight @ axis).min() < EDGE_ON:
        return None
    across = tangents(axis)
    origin = points.mean(axis=0)
    flat = (points - origin) @ across.T
    matrix = np.column_stack((2.0 * flat, np.ones(len(flat))))
    a, b, c = np.linalg.lstsq(matrix, (flat**2).sum(axis=1), rcond=None)[0]
    center, radius = np.array((a, b)), float(np.sqrt(max(c + a * a + b * b, 1e-300)))
    for _ in range(ROUNDS):
        spokes = flat - center
        lengths = np.maximum(np.linalg.norm(spokes, axis=1), 1e-12 * radius)
        out = spokes / lengths[:, None]
        scale = _pixels_per_mm(camera, points, out @ across, 1e-3 * radius)
        weighted = np.column_stack((out, np.ones(len(out)))) * scale[:, None]
        step = np.linalg.lstsq(weighted, (lengths - radius) * scale, rcond=None)[0]
        center, radius = center + step[:2], radius + float(step[2])
        if not radius > 0:
            return None
    off = (np.linalg.norm(flat - center, axis=1) - radius) * scale
    place = origin + center @ across
    deviation = float(np.sqrt((off**2).mean()) / (radius * np.sqrt((scale**2).mean())))
    if oval:
        from_ellipse, ratio = _oval((flat - center) / radius)
        deviation = min(deviation, from_ellipse) if ratio <= OVAL else deviation
    return Circle(place, axis, radius, face, deviation)


def _oval(points: Array) -> tuple[float, float]:
    """Return how far points (n, 2) are from the ellipse through them, and its ratio of axes.

    The distance is of first order, root mean square; infinite where no ellipse goes through them.
    """
    x, y = points.T
    rows = np.column_stack((x * x, 2.0 * x * y, y * y, 2.0 * x, 2.0 * y))
    a, b, c, d, e = form = np.linalg.lstsq(rows, np.ones(len(rows)), rcond=None)[0]
    small, large = np.linalg.eigvalsh([[a, b], [b, c]])
    if not small > 0.0:
        return np.inf, np.inf
    slope = 2.0 * np.hypot(a * x + b * y + d, b * x + c * y + e)
    off = (rows @ form - 1.0) / np.maximum(slope, 1e-12)
    return float(np.sqrt((off**2).mean())), float(np.sqrt(large / small))


def _pixels_per_mm(camera: Camera, points: Array, along: Array, step: float) -> Array:
    """Return how long a millimetre along directions is on the sheet, px."""
    here, _ = camera.project(points)
    there, _ = camera.project(points + step * along)
    return np.asarray(np.linalg.norm(there - here, axis=1) / step)
