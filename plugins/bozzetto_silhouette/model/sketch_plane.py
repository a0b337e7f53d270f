"""The sheet: the plane on which an outline was drawn.

A part's *object frame* is (x, y, z) with x to the right and y up on the sheet and z towards
the person who drew it, all in mm.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array
from bozzetto.geometry import Placement
from bozzetto.ink import Stroke
from bozzetto.plugin import Context
from bozzetto.view import Camera

Point = tuple[float, float, float]

FRONT_TOLERANCE = 1e-6
"""How far (sine of the angle) a view may turn from the front and still count as the front."""


@dataclass(frozen=True)
class Sheet:
    """A plane with two axes.

    Parameters
    ----------
    origin : (x, y, z)
        World place of (0, 0), mm.
    right, up : (x, y, z)
        Unit vectors; ``right × up`` points towards the person who drew.
    """

    origin: Point = (0.0, 0.0, 0.0)
    right: Point = (1.0, 0.0, 0.0)
    up: Point = (0.0, 0.0, 1.0)

    @property
    def normal(self) -> Array:
        """Unit vector towards the person who drew."""
        return np.cross(self.right, self.up)

    @property
    def placement(self) -> Placement:
        """The placement from the object frame to the world."""
        columns = np.column_stack((self.right, self.up, self.normal))
        return Placement(tuple(float(v) for v in columns.ravel()), 1.0, self.origin)

    def from_pixels(self, pixels: ArrayLike, camera: Camera) -> Array:
        """Project canvas positions, seen through a camera, onto the sheet; shape (n, 2), mm.

        NaN where the line of sight misses the sheet.
        """
        away = camera.on_plane(pixels, self.origin, self.normal) - self.origin
        return np.column_stack((away @ self.right, away @ self.up))

    def to_world(self, points: ArrayLike) -> Array:
        """Carry object-frame points, (n, 2) or (n, 3), into the world; shape (n, 3), mm."""
        given = np.asarray(points, float)
        frame = np.vstack((self.right, self.up, self.normal))[: given.shape[1]]
        return np.asarray(given @ frame + self.origin, np.float64)

    def turn(self, vectors: ArrayLike) -> Array:
        """Carry object-frame directions into the world, shape (n, 3)."""
        frame = np.vstack((self.right, self.up, self.normal))
        return np.asarray(np.asarray(vectors, float) @ frame, np.float64)

    def at(self, height: float) -> Sheet:
        """Return the plane parallel to this one at a height over it, mm."""
        return replace(self, origin=_point(self.origin + height * self.normal))

    def faces_as(self, other: Sheet) -> bool:
        """Whether both sheets are parallel and face the same way."""
        return bool(np.dot(self.normal, other.normal) > 1.0 - FRONT_TOLERANCE)


def sheet_under(stroke: Stroke, context: Context) -> Sheet:
    """Return the plane on which a stroke lies.

    From the front it is the plane of symmetry, y = 0. From anywhere else it is the plane
    parallel to the screen through what is under the stroke's first point; where nothing is,
    through the point about which the view turns.
    """
    if _is_front(stroke.camera):
        return Sheet()  # whatever is under it: nobody needs to solve for that
    return sheet_at(float(stroke.x[0]), float(stroke.y[0]), stroke.camera, context)[0]


def sheet_at(x: float, y: float, camera: Camera, context: Context) -> tuple[Sheet, bool]:
    """Return the plane of what begins at a place of the canvas, and whether that is on a shape."""
    right, up, forward = camera.axes
    hits = context.surface_hit(camera.rays([(x, y)]))
    landed = bool(hits.hit[0])
    if _is_front(camera):
        return Sheet(), landed
    through = hits.points[0] if landed else np.asarray(camera.target)
    depth = float((through - camera.eye) @ forward)
    origin = np.asarray(camera.eye) + depth * forward
    return Sheet(_point(origin), _point(right), _point(up)), landed


def _is_front(camera: Camera) -> bool:
    """Whether a view is that from the front, upright."""
    _, up, forward = camera.axes
    return bool(abs(forward[1] - 1.0) < FRONT_TOLERANCE and abs(up[2] - 1.0) < FRONT_TOLERANCE)


def _point(values: Array) -> Point:
    x, y, z = (float(v) for v in values)
    return x, y, z
