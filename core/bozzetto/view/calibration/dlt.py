"""The direct linear transform: a camera of eleven parameters from marks, in one step.

Kara & Shimada (CAD 2008 slides; book chapter, section 13.3) find the camera of a sketch in
this way, and take it apart after Forsyth & Ponce, *Computer Vision: A Modern Approach*, 2003,
section 3.2. It is exact where the marks are, and needs no start. But it has four parameters
too many: skew, aspect and principal point follow the noise of the marks, and of an
orthographic sketch the parts mean nothing. So it is here to be shown and to start from.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array
from bozzetto.cached_properties import cached_property
from bozzetto.errors import UserError

FEWEST: Final = 6
"""Marks that eleven unknowns need, with two equations each."""

DEGENERATE: Final = 1e-3
"""Ratio of the second smallest to the largest singular value of the equations below which the
camera is not determined. It is 0.09 in a usual view of a car, 0.02 in one from the side, and
1e-17 where all points lie in one plane."""


@dataclass(frozen=True, eq=False)
class Parts:
    """A projection matrix taken apart.

    The matrix is, up to a factor, ``K (R | t)`` with the intrinsic matrix
    ``K = ((alpha, -alpha cot(theta), u0), (0, beta / sin(theta), v0), (0, 0, 1))``.

    Attributes
    ----------
    turn : (3, 3) float
        R: rows right, down and forward. A proper rotation.
    shift : (3,) float
        t: the world's origin as the camera has it, mm. Its depth t_z is positive where the
        origin lies before the eye.
    focal : (alpha, beta)
        Focal lengths, px, across and down.
    skew : float
        theta, the angle between the axes of the picture, radians; π/2 without skew.
    principal : (u0, v0)
        px.
    eye : (3,) float
        World position, mm.
    """

    turn: Array
    shift: Array
    focal: tuple[float, float]
    skew: float
    principal: tuple[float, float]
    eye: Array


@dataclass(frozen=True, eq=False)
class DirectCamera:
    """A projection matrix and how well the marks determine it.

    Attributes
    ----------
    matrix : (3, 4) float
        World, mm, to picture, px, in homogeneous coordinates. Its third row gives depths in
        mm, positive for the marks.
    determined : float
        Second smallest over largest singular value of the equations.
    """

    matrix: Array
    determined: float

    def project(self, points: ArrayLike) -> Array:
        """Project world points (n, 3), mm, to places (n, 2), px; NaN at or behind the eye."""
        places = np.reshape(np.asarray(points, float), (-1, 3))
        seen = places @ self.matrix[:, :3].T + self.matrix[:, 3]
        out = np.full((len(places), 2), np.nan)
        return np.asarray(np.divide(seen[:, :2], seen[:, 2:], out=out, where=seen[:, 2:] > 0.0))

    @cached_property
    def parts(self) -> Parts:
        """The decomposition of Forsyth & Ponce, equations (3.12) to (3.17).

        The sign of the matrix, which the equations leave open, is that for which the centroid
        of the marks lies before the eye. The slides ask for the world's origin before the
        eye, by the sign of t_z; the two agree unless the eye stands between car and origin.
        """
        first, second, third = self.matrix[:, :3]
        scale = 1.0 / float(np.linalg.norm(third))
        forward = scale * third
        u0, v0 = (scale**2 * float(row @ third) for row in (first, second))
        across, below = np.cross(first, third), np.cross(second, third)
        sizes = float(np.linalg.norm(across)), float(np.linalg.norm(below))
        cosine = float(np.clip(-(across @ below) / (sizes[0] * sizes[1]), -1.0, 1.0))
        sine = float(np.sqrt(1.0 - cosine**2))
        alpha, beta = (float(scale**2 * size * sine) for size in sizes)
        right = below / sizes[1]
        turn = np.stack((right, np.cross(forward, right), forward))
        eye = np.asarray(-np.linalg.solve(self.matrix[:, :3], self.matrix[:, 3]), np.float64)
        return Parts(
            turn, np.asarray(-turn @ eye), (alpha, beta), float(np.arccos(cosine)), (u0, v0), eye
        )


def direct_linear_transform(points: ArrayLike, marks: ArrayLike) -> DirectCamera:
    """Fit the camera of eleven parameters with the least algebraic error.

    Both sides are normalised first (Hartley, "In defence of the eight-point algorithm", 1997).

    Parameters
    ----------
    points : (n, 3) array_like
        World points, mm.
    marks : (n, 2) array_like
        Their places in the picture, px.

    Raises
    ------
    UserError
        If there are fewer than six marks, a number is not finite, or the points lie in or
        near one plane (or on another of the surfaces that leave the camera open).
    """
    world = np.reshape(np.asarray(points, float), (-1, 3))
    picture = np.reshape(np.asarray(marks, float), (-1, 2))
    if len(world) != len(picture):
        raise UserError("Every point needs one mark. Give as many marks as points.")
    if len(world) < FEWEST:
        raise UserError(f"There are {len(world)} marks. Set at least {FEWEST}.")
    if not (np.isfinite(world).all() and np.isfinite(picture).all()):
        raise UserError("A mark or its point is not a finite number. Set that mark again.")
    to_world, to_picture = _normalising(world), _normalising(picture)
    ones = np.ones((len(world), 1))
    known = np.hstack((world, ones)) @ to_world.T
    seen = np.hstack((picture, ones)) @ to_picture.T
    equations = np.zeros((2 * len(world), 12))
    equations[0::2, :4] = equations[1::2, 4:8] = known
    equations[0::2, 8:] = -seen[:, :1] * known
    equations[1::2, 8:] = -seen[:, 1:2] * known
    _, sizes, rows = np.linalg.svd(equations)
    determined = float(sizes[-2] / sizes[0])
    matrix = np.linalg.solve(to_picture, rows[-1].reshape(3, 4)) @ to_world
    size = float(np.linalg.norm(matrix[2, :3]))
    if determined < DEGENERATE or not size > 0.0 or np.linalg.cond(matrix[:, :3]) > 1e15:
        raise UserError(
            "The marks do not say where the camera is, for their points lie close to one plane. "
            "Mark a point well off that plane too."
        )
    matrix /= size
    if float(matrix[2] @ np.append(world.mean(axis=0), 1.0)) < 0.0:
        matrix = -matrix
    return DirectCamera(matrix, determined)


def _normalising(places: Array) -> Array:
    """Return the similarity, in homogeneous coordinates, that makes the mean distance √d."""
    size = places.shape[1]
    middle = places.mean(axis=0)
    mean = float(np.mean(np.linalg.norm(places - middle, axis=1)))
    scale = np.sqrt(size) / mean if mean > 0.0 else 1.0
    made = np.diag(np.append(np.full(size, scale), 1.0))
    made[:size, size] = -scale * middle
    return made
