"""The picture of a cubic: through a camera it is a rational cubic in the plane.

The four Bézier points times the camera's matrix are the homogeneous points of the picture, so
places and derivatives there cost a few products, however often a search asks for them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.plugin import cached_property
from bozzetto.view import Camera

POWERS: Final = np.array([[1, 0, 0, 0], [-3, 3, 0, 0], [3, -6, 3, 0], [-1, 3, -3, 1]], float)
"""Coefficients of 1, t, t², t³ from Bézier points."""

DEGREES: Final = np.array([[1.0], [2.0], [3.0]])
"""Factors of the coefficients of t, t², t³ in the derivative."""

REMEMBERED: Final = 64
"""Number of cameras whose matrices are remembered: a body has many edits through few cameras."""

AT_EYE: Final = 1e-6
"""Depth, mm, at which a place counts as in the eye."""


@lru_cache(REMEMBERED)
def camera_matrix(camera: Camera) -> Array:
    """Return M (3, 4) with (u w, v w, w) = M (x, y, z, 1): px from mm, w > 0 before the eye."""
    right, up, forward = camera.axes
    eye = np.asarray(camera.eye)
    width, height = camera.viewport
    if camera.kind == "orthographic":
        last, scale = np.array([0.0, 0.0, 0.0, 1.0]), height / camera.height
    else:
        last = np.append(forward, -forward @ eye)
        scale = 0.5 * height / np.tan(np.radians(0.5 * camera.fov_y))
    across = scale * np.append(right, -right @ eye) + 0.5 * width * last
    down = 0.5 * height * last - scale * np.append(up, -up @ eye)
    matrix = np.stack((across, down, last))
    matrix.flags.writeable = False
    return matrix


def places_of(seen: Array) -> Array:
    """Return places (…, 2), px, from (u w, v w, w); infinite at or behind the eye."""
    places = np.full((*seen.shape[:-1], 2), np.inf)
    np.divide(seen[..., :2], seen[..., 2:], out=places, where=seen[..., 2:] > AT_EYE)
    return places


def slopes_at(matrix: Array, point: Array) -> Array:
    """Return the derivative (2, 3), px/mm, of the picture of a point (3,) before the eye."""
    u, v, w = matrix[:, :3] @ point + matrix[:, 3]
    w = max(float(w), AT_EYE)
    return np.asarray((matrix[:2, :3] - np.outer((u / w, v / w), matrix[2, :3])) / w)


def largest_scale(slopes: Array) -> float:
    """Return the greatest length, px, of the picture of a step of a millimetre.

    Parameters
    ----------
    slopes : (2, 3) float
        As `slopes_at` gives them; this is their greatest singular value.
    """
    (a, b), (_, c) = (slopes @ slopes.T).tolist()
    return math.sqrt(0.5 * (a + c) + math.hypot(0.5 * (a - c), b))


@lru_cache(REMEMBERED)
def _powers(pieces: int) -> Array:
    """Return 1, t, t², t³ at equal steps of t, (pieces + 1, 4)."""
    powers = np.linspace(0.0, 1.0, pieces + 1)[:, None] ** np.arange(4)
    powers.flags.writeable = False
    return powers


@dataclass(frozen=True, eq=False)
class Pass:
    """The picture of a cubic at some parameters, one number for each.

    Attributes
    ----------
    t : (n,) float
    x, y : (n,) float
        Places, px.
    speed_x, speed_y : (n,) float
        Derivatives of the places by t.
    w : (n,) float
        Homogeneous coordinate, clipped above 0.
    """

    t: Array
    x: Array
    y: Array
    speed_x: Array
    speed_y: Array
    w: Array

    @cached_property
    def _inverse_speed(self) -> Array:
        return 1.0 / np.maximum(np.hypot(self.speed_x, self.speed_y), np.finfo(float).tiny)

    @cached_property
    def normal_x(self) -> Array:
        """First coordinate of the unit vectors across the picture, (n,)."""
        return -self.speed_y * self._inverse_speed

    @cached_property
    def normal_y(self) -> Array:
        """Second coordinate of the unit vectors across the picture, (n,)."""
        return self.speed_x * self._inverse_speed

    @property
    def handles(self) -> Array:
        """How far places in space go with the inner Bézier points, (2, n)."""
        s = 1.0 - self.t
        middle = 3.0 * self.t * s
        found = np.empty((2, len(s)))
        np.multiply(middle, s, out=found[0])
        np.multiply(middle, self.t, out=found[1])
        return found

    @property
    def across(self) -> Array:
        """How fast places go across the picture with (u w, v w, w), (3, n) px."""
        found = np.empty((3, len(self.t)))
        np.divide(self.normal_x, self.w, out=found[0])
        np.divide(self.normal_y, self.w, out=found[1])
        np.negative(found[0] * self.x + found[1] * self.y, out=found[2])
        return found


@dataclass(frozen=True, eq=False)
class Pictured:
    """The picture of a cubic.

    Attributes
    ----------
    coefficients : (4, 3) float
        Coefficients of 1, t, t², t³ in (u w, v w, w).
    """

    coefficients: Array

    @classmethod
    def of(cls, matrix: Array, control_points: Array) -> Pictured:
        """Return the picture of Bézier points (4, 3), mm, through a camera's matrix (3, 4)."""
        seen = control_points @ matrix[:, :3].T + matrix[:, 3]
        return cls(POWERS @ seen)

    @cached_property
    def _with_slopes(self) -> Array:
        """Coefficients of (u w, v w, w) and of their derivatives, (6, 4)."""
        slopes = np.zeros((4, 3))
        slopes[:3] = self.coefficients[1:] * DEGREES
        return np.ascontiguousarray(np.hstack((self.coefficients, slopes)).T)

    def laid_out(self, pieces: int) -> Array:
        """Return places (pieces + 1, 2), px, at equal steps of t; infinite at or behind the eye."""
        return places_of(_powers(pieces) @ self.coefficients)

    def passed(self, t: Array) -> Pass:
        """Return places and derivatives at parameters (n,)."""
        powers = np.empty((4, len(t)))
        powers[0] = 1.0
        powers[1] = t
        np.multiply(t, t, out=powers[2])
        np.multiply(powers[2], t, out=powers[3])
        x, y, w, slope_x, slope_y, slope_w = self._with_slopes @ powers
        w = np.maximum(w, AT_EYE)
        x, y = x / w, y / w
        return Pass(t, x, y, (slope_x - slope_w * x) / w, (slope_y - slope_w * y) / w, w)
