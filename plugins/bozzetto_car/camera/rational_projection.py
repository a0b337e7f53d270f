"""The picture of a cubic: through a camera it is a rational cubic in the plane.

The four Bézier points times the camera's matrix are the homogeneous points of the picture, so
places and derivatives there cost a few products, however often a search asks for them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto.view import Camera

POWERS: Final = np.array([[1, 0, 0, 0], [-3, 3, 0, 0], [3, -6, 3, 0], [-1, 3, -3, 1]], float)
"""Coefficients of 1, t, t², t³ from Bézier points."""

AND_SLOPES: Final = np.stack((POWERS.T, np.vstack((POWERS[1:], np.zeros(4))).T * (1, 2, 3, 0)))
"""Coefficients of 1, t, t², t³ in a cubic and in its derivative from Bézier points, (2, 4, 4)."""

LED_BY_HANDLES: Final = POWERS[:, 1:3].T.copy()
"""Coefficients of 1, t, t², t³ in how far a place goes with the inner Bézier points, (2, 4)."""

REMEMBERED: Final = 64
"""Number of cameras whose matrices are remembered: a body has many edits through few cameras."""

AT_EYE: Final = 1e-6
"""Depth, mm, at which a place counts as in the eye."""

TINY: Final = float(np.finfo(float).tiny)
"""Least speed of a picture that is divided by."""


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


def slopes_at(matrix: Array, points: Array) -> Array:
    """Return the derivatives (…, 2, 3), px/mm, of the pictures of points (…, 3) before the eye."""
    seen = points @ matrix[:, :3].T + matrix[:, 3]
    w = np.maximum(seen[..., 2], AT_EYE)[..., None, None]
    return np.asarray((matrix[:2, :3] - seen[..., :2, None] / w * matrix[2, :3]) / w)


def largest_scale(slopes: Array) -> Array:
    """Return the greatest lengths (…,), px, of the pictures of a step of a millimetre.

    Parameters
    ----------
    slopes : (…, 2, 3) float
        As `slopes_at` gives them; these are their greatest singular values.
    """
    across, down = slopes[..., 0, :], slopes[..., 1, :]
    a, c = (across**2).sum(axis=-1), (down**2).sum(axis=-1)
    b = (across * down).sum(axis=-1)
    return np.asarray(np.sqrt(0.5 * (a + c) + np.hypot(0.5 * (a - c), b)))


@lru_cache(REMEMBERED)
def _powers(pieces: int) -> Array:
    """Return 1, t, t², t³ at equal steps of t, (pieces + 1, 4)."""
    powers = np.linspace(0.0, 1.0, pieces + 1)[:, None] ** np.arange(4)
    powers.flags.writeable = False
    return powers


class Pass:
    """The picture of a cubic at some parameters, at which it can be looked at again.

    Parameters
    ----------
    coefficients : (8, 4) float
        Coefficients of 1, t, t², t³ in (u w, v w, w, w) and in its derivative.
    count : int
        Number n of parameters.
    before : bool
        Whether all of the cubic is known to be before the eye.

    Attributes
    ----------
    t : (n,) float
    places : (2 n,) float
        First all coordinates across, then all down, px.
    speeds : (2 n,) float
        Derivatives of the places by t.
    w : (2 n,) float
        Homogeneous coordinate, clipped above 0, twice.

    Notes
    -----
    A search for foot points asks some sixty times for a hundred places, and numpy's time goes into
    the calls: so both coordinates are in one row, and no call makes a new array or broadcasts.
    """

    __slots__ = ("_before", "_coefficients", "_cube", "_powers", "_rows", "_seen", "_slope_w",
                 "_slopes", "_square", "places", "speeds", "t", "w")  # fmt: skip

    def __init__(self, coefficients: Array, count: int, before: bool) -> None:
        self._coefficients, self._before = coefficients, before
        self._powers, self._rows = np.empty((4, count)), np.empty((8, count))
        self._powers[0] = 1.0
        _, self.t, self._square, self._cube = self._powers
        self._seen, self.w, self._slopes, self._slope_w = self._rows.reshape(4, -1)
        self.places, self.speeds = np.empty((2, 2 * count))

    def go(self, t: Array) -> None:
        """Look at parameters (n,) from now on."""
        self.t[:] = t
        np.multiply(t, t, out=self._square)
        np.multiply(self._square, t, out=self._cube)
        np.dot(self._coefficients, self._powers, out=self._rows)
        places, speeds, w = self.places, self.speeds, self.w
        if not self._before:
            np.maximum(w, AT_EYE, out=w)
        np.divide(self._seen, w, out=places)
        np.multiply(self._slope_w, places, out=speeds)
        np.subtract(self._slopes, speeds, out=speeds)
        np.divide(speeds, w, out=speeds)

    @property
    def normals(self) -> Array:
        """Unit vectors across the picture, (2 n,): first all coordinates across, then all down."""
        count = len(self.t)
        right, down = self.speeds[:count], self.speeds[count:]
        pace = np.maximum(np.hypot(right, down), TINY)
        return np.concatenate((-down / pace, right / pace))

    def across(self, normals: Array) -> Array:
        """Return how fast places go along vectors (2 n,) with (u w, v w, w), (3, n) px."""
        count = len(self.t)
        found = np.empty((3, count))
        ways = found[:2].reshape(-1)
        np.divide(normals, self.w, out=ways)
        along = ways * self.places
        np.add(along[:count], along[count:], out=found[2])
        np.negative(found[2], out=found[2])
        return found

    def led(self, handles: Index) -> Array:
        """Return how far places in space go with inner Bézier points, 0 or 1, (len(handles), n)."""
        return np.asarray(LED_BY_HANDLES[handles] @ self._powers)


@dataclass(frozen=True, eq=False)
class Pictured:
    """The picture of a cubic.

    Attributes
    ----------
    seen : (4, 4) float
        (u w, v w, w, w) of the Bézier points.
    """

    seen: Array

    @classmethod
    def of(cls, matrix: Array, control_points: Array) -> Pictured:
        """Return the picture of Bézier points (4, 3), mm, through a camera's matrix (3, 4)."""
        seen = np.empty((4, 4))
        seen[:3] = matrix[:, :3] @ control_points.T + matrix[:, 3:]
        seen[3] = seen[2]
        return cls(seen)

    def is_within(self, bound: float) -> bool:
        """Whether the Bézier points are before the eye and not farther off than a bound, px.

        Then all of the picture is, too: it lies in the convex hull of theirs.
        """
        across, down, depth, _ = self.seen.tolist()
        return all(
            w > AT_EYE and abs(u) <= bound * w and abs(v) <= bound * w
            for u, v, w in zip(across, down, depth, strict=True)
        )

    def laid_out(self, pieces: int) -> Array:
        """Return places (pieces + 1, 2), px, at equal steps of t; infinite at or behind the eye."""
        return places_of(_powers(pieces) @ (POWERS @ self.seen[:3].T))

    def passed(self, t: Array) -> Pass:
        """Return places and derivatives at parameters (n,)."""
        is_before = min(self.seen[2].tolist()) > AT_EYE
        found = Pass(np.matmul(self.seen, AND_SLOPES).reshape(8, 4), len(t), is_before)
        found.go(t)
        return found
