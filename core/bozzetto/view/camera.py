"""One camera for perspective and orthographic views, in plain numpy.

World: right-handed, Z up, millimetres. Canvas: pixels, origin at the top left corner,
x right, y down; the canvas is the camera's `viewport`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.cached_properties import cached_property
from bozzetto.errors import UserError

if TYPE_CHECKING:
    from bozzetto.arrays import Array
    from bozzetto.geometry.placement import Placement

Point = tuple[float, float, float]

PARALLEL: float = 1e-9
"""Sine of the angle below which `up` counts as parallel to the line of sight."""

AT_EYE: float = 1e-100
"""Depth, mm, below which a point is at the eye: its picture would be beyond all numbers."""


class Rays(NamedTuple):
    """Half-lines into the world.

    Attributes
    ----------
    origins : (n, 3) float
        Start points, mm.
    directions : (n, 3) float
        Unit vectors away from the eye.
    """

    origins: Array
    directions: Array


@dataclass(frozen=True)
class Camera:
    """A pinhole or parallel camera with the canvas it fills.

    Parameters
    ----------
    kind : {"perspective", "orthographic"}
    eye, target, up : (x, y, z)
        World positions and the upward direction, mm. `target` is the point about which
        the view turns, and whose depth is the depth of the sheet.
    fov_y : float
        Full vertical opening angle in degrees (perspective).
    height : float
        World height that fills the canvas, mm (orthographic).
    viewport : (width, height)
        Canvas size in pixels.

    Raises
    ------
    UserError
        If a number is not finite, the eye sits on the target, or a size is not positive.
    """

    kind: Literal["perspective", "orthographic"] = "perspective"
    eye: Point = (0.0, -500.0, 0.0)
    target: Point = (0.0, 0.0, 0.0)
    up: Point = (0.0, 0.0, 1.0)
    fov_y: float = 35.0
    height: float = 200.0
    viewport: tuple[float, float] = (1200.0, 900.0)

    def __post_init__(self) -> None:
        for name, size in (("eye", 3), ("target", 3), ("up", 3), ("viewport", 2)):
            values = tuple(float(v) for v in getattr(self, name))
            if len(values) != size:
                raise UserError(f"A camera's {name} needs {size} numbers.")
            object.__setattr__(self, name, values)
        numbers = (*self.eye, *self.target, *self.up, *self.viewport, self.fov_y, self.height)
        if not np.isfinite(numbers).all():
            raise UserError("A camera holds a number that is not finite.")
        if self.kind not in ("perspective", "orthographic"):
            raise UserError(f"A camera is perspective or orthographic, not {self.kind!r}.")
        if min(self.viewport) <= 0 or self.height <= 0 or not 0 < self.fov_y < 180:
            raise UserError("A camera needs a canvas, a height and an opening angle above zero.")
        if not 0 < self.distance < np.inf:
            raise UserError("A camera's eye must not sit on its target, nor beyond all bounds.")

    # -- frame --

    @cached_property
    def distance(self) -> float:
        """Distance from eye to target, mm."""
        with np.errstate(over="ignore"):
            return float(np.linalg.norm(np.subtract(self.target, self.eye)))

    @cached_property
    def axes(self) -> Array:
        """Rows: right, up and forward unit vectors of the view, shape (3, 3).

        Where `up` is parallel to the line of sight, another world axis stands in for it.
        """
        forward = np.subtract(self.target, self.eye) / self.distance
        for candidate in (self.up, (0.0, 1.0, 0.0), (1.0, 0.0, 0.0)):
            vector = np.asarray(candidate, float)
            largest = float(np.abs(vector).max())
            if largest == 0.0:
                continue
            vector = vector / largest  # first, so that no square overflows or vanishes
            right = np.cross(forward, vector / np.linalg.norm(vector))
            if np.linalg.norm(right) > PARALLEL:
                break
        right /= np.linalg.norm(right)
        frame = np.vstack((right, np.cross(right, forward), forward))
        frame.flags.writeable = False
        return frame

    @property
    def pixels_per_mm(self) -> float:
        """Scale at the depth of the target, pixels per mm."""
        return self.viewport[1] / self.visible_height

    @property
    def visible_height(self) -> float:
        """World height that fills the canvas at the depth of the target, mm."""
        if self.kind == "orthographic":
            return self.height
        return float(2.0 * self.distance * np.tan(np.radians(self.fov_y) / 2.0))

    # -- between world and canvas --

    def view_space(self, points: ArrayLike) -> Array:
        """Return world points in the camera's own frame: right, up, depth; shape (n, 3), mm."""
        return (np.reshape(np.asarray(points, float), (-1, 3)) - self.eye) @ self.axes.T

    def project(self, points: ArrayLike) -> tuple[Array, Array]:
        """Project world points onto the canvas.

        Parameters
        ----------
        points : (n, 3) array_like
            World points, mm.

        Returns
        -------
        pixels : (n, 2) float
            Canvas positions; NaN for points at or behind the eye of a perspective camera.
        depth : (n,) float
            Distance along the line of sight from the eye, mm (may be negative).
        """
        seen = self.view_space(points)
        depth = seen[:, 2]
        width, height = self.viewport
        if self.kind == "orthographic":
            scale: Array | float = height / self.height
        else:
            focal = 0.5 * height / np.tan(np.radians(self.fov_y) / 2.0)
            scale = np.full_like(depth, np.nan)
            np.divide(focal, depth, out=scale, where=depth > AT_EYE)
        pixels = np.column_stack(
            (0.5 * width + seen[:, 0] * scale, 0.5 * height - seen[:, 1] * scale)
        )
        return pixels, depth

    def rays(self, pixels: ArrayLike) -> Rays:
        """Return rays through canvas positions.

        Parameters
        ----------
        pixels : (n, 2) array_like
            Canvas positions.

        Returns
        -------
        Rays
            From the eye (perspective), or from the plane of the eye (orthographic).
        """
        place = np.reshape(np.asarray(pixels, float), (-1, 2))
        width, height = self.viewport
        right, up, forward = self.axes
        across = place[:, 0] - 0.5 * width
        above = 0.5 * height - place[:, 1]
        if self.kind == "orthographic":
            scale = self.height / height
            origins = self.eye + scale * (across[:, None] * right + above[:, None] * up)
            return Rays(origins, np.broadcast_to(forward, origins.shape).copy())
        focal = 0.5 * height / np.tan(np.radians(self.fov_y) / 2.0)
        toward = across[:, None] * right + above[:, None] * up + focal * forward
        toward /= np.linalg.norm(toward, axis=1, keepdims=True)
        return Rays(np.broadcast_to(np.asarray(self.eye), toward.shape).copy(), toward)

    def on_plane(self, pixels: ArrayLike, point: ArrayLike, normal: ArrayLike) -> Array:
        """Return world points where the rays through canvas positions meet a plane.

        Parameters
        ----------
        pixels : (n, 2) array_like
            Canvas positions.
        point, normal : (3,) array_like
            The plane; the normal need not be of unit length.

        Returns
        -------
        (n, 3) float
            NaN where a ray is parallel to the plane or meets it behind the eye.
        """
        origins, directions = self.rays(pixels)
        towards = np.asarray(normal, float)
        towards = towards / np.linalg.norm(towards)
        slope = directions @ towards
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            along = ((np.asarray(point, float) - origins) @ towards) / slope
            along = np.where(np.abs(slope) > PARALLEL, along, np.nan)
        if self.kind == "perspective":
            along = np.where(along > 0, along, np.nan)
        return origins + along[:, None] * directions

    def with_viewport(self, width: float, height: float) -> Camera:
        """Return the same view on a canvas of another size."""
        return replace(self, viewport=(width, height))

    def moved(self, placement: Placement) -> Camera:
        """Return the camera carried along with the world that it looks at.

        What it sees of a moved thing is what it saw of the thing before. A placement that
        mirrors exchanges left and right: (x, y) becomes (width − x, y), see `Stroke.moved`.

        Raises
        ------
        UserError
            If it would stand beyond all bounds.
        """
        with np.errstate(over="ignore", invalid="ignore"):
            places = placement.points((self.eye, self.target)).tolist()
        eye, target, up = map(tuple, (*places, *placement.directions(self.axes[1]).tolist()))
        height = self.height * placement.scale
        return replace(self, eye=eye, target=target, up=up, height=height)
