"""The constrained camera as numbers, many at once: how it sees points, and its derivatives.

A camera with square pixels and no skew has seven unknowns beside its principal point. They
are taken so that the orthographic camera is one of them and not a limit: with the points X
about their centroid, as Z = s R X,

    place = principal + ((Z_x, Z_y) + offset) / (1 + k Z_z),

where s is the scale of the image at the depth of the centroid and the *perspectivity*
k = 1/f the reciprocal of the focal length. k = 0 is the orthographic camera. Nothing grows
beyond bounds on the way there, as the focal length and the distance do in the usual form.

Lengths in the picture are shares of its diagonal from its middle, x right and y down; points
are in their root mean square radius. `normalization` leads to these units and back.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np

from bozzetto.arrays import Array, Flags, Index

PARAMETERS: Final = 9
"""Steps of a pose: a small turn (3), of the logarithm of the scale, of the offset (2), of the
perspectivity, and of the principal point (2)."""

SHORTEST_FOCUS: Final = 0.3
"""Least focal length, in diagonals of the picture: an angle of 118° from corner to corner, more
than sketches that exaggerate their perspective show."""

LONGEST_FOCUS: Final = 100.0
"""Greatest focal length of a perspective camera, in diagonals. Beyond, no hand could tell it
from an orthographic one, and the eye would leave the numbers of a scene."""

PERSPECTIVITIES: Final = (1.0 / LONGEST_FOCUS, 1.0 / SHORTEST_FOCUS)
"""Bounds of the perspectivity of a perspective camera, in reciprocal diagonals."""

SCALES: Final = (-3.0, 3.0)
"""Bounds of the logarithm of the scale: a twentieth to twenty diagonals for the root mean
square radius of the points. Marks without sense would shrink the points to a dot."""

OFF: Final = 100.0
"""Farthest image of the centroid from the middle of the picture, in diagonals."""

NEAREST: Final = 0.02
"""Least depth of a point before the eye, in depths of the centroid."""


class Seen(NamedTuple):
    """Projected points of several poses.

    Attributes
    ----------
    places : (b, n, 2) float
    depth : (b, n) float
        In depths of the centroid; 1 of an orthographic pose.
    scaled : (b, n, 3) float
        The points along right, down and forward, times the scale.
    """

    places: Array
    depth: Array
    scaled: Array


@dataclass(frozen=True, eq=False)
class Poses:
    """b constrained cameras; see the module for the formula.

    Attributes
    ----------
    turn : (b, 3, 3) float
        Rows right, down and forward: proper rotations.
    log_scale : (b,) float
    offset : (b, 2) float
    perspectivity : (b,) float
        Not negative.
    principal : (b, 2) float
    """

    turn: Array
    log_scale: Array
    offset: Array
    perspectivity: Array
    principal: Array

    def __len__(self) -> int:
        return len(self.log_scale)

    def __getitem__(self, rows: Index | Flags | list[int] | slice) -> Poses:
        """Return some of the poses."""
        return Poses(*(values[rows] for values in self._columns()))

    def where(self, chosen: Flags, others: Poses) -> Poses:
        """Return the chosen ones of these poses, and the others in the places of the rest."""
        pairs = zip(self._columns(), others._columns(), strict=True)
        return Poses(
            *(
                np.where(chosen.reshape((-1,) + (1,) * (mine.ndim - 1)), mine, theirs)
                for mine, theirs in pairs
            )
        )

    def _columns(self) -> tuple[Array, Array, Array, Array, Array]:
        return self.turn, self.log_scale, self.offset, self.perspectivity, self.principal

    def see(self, points: Array) -> Seen:
        """Project points (n, 3), in radii; a place at or behind the eye means nothing."""
        scaled = np.exp(self.log_scale)[:, None, None] * (points @ np.swapaxes(self.turn, 1, 2))
        depth = 1.0 + self.perspectivity[:, None] * scaled[:, :, 2]
        near = np.where(depth > NEAREST, depth, np.inf)[:, :, None]
        places = (scaled[:, :, :2] + self.offset[:, None]) / near + self.principal[:, None]
        return Seen(places, depth, scaled)

    def slopes(self, seen: Seen) -> Array:
        """Return derivatives of the projected points by the nine parameters, (b, 9, 2, n).

        Nought for points at or behind the eye.
        """
        x, y, z = (seen.scaled[:, :, axis] for axis in range(3))
        near = np.where(seen.depth > NEAREST, 1.0 / np.maximum(seen.depth, NEAREST), 0.0)
        u, v = (seen.places[:, :, axis] - self.principal[:, None, axis] for axis in range(2))
        u, v = u * near, v * near
        lean_u, lean_v = self.perspectivity[:, None] * u, self.perspectivity[:, None] * v
        x_near, y_near, z_near = x * near, y * near, z * near
        made = np.zeros((len(self), PARAMETERS, 2, x.shape[1]))
        # A turn by w moves Z by w × Z; what it moves in depth draws the place to the middle.
        made[:, 0, 0] = -lean_u * y
        made[:, 0, 1] = -z_near - lean_v * y
        made[:, 1, 0] = z_near + lean_u * x
        made[:, 1, 1] = lean_v * x
        made[:, 2, 0] = -y_near
        made[:, 2, 1] = x_near
        made[:, 3, 0] = x_near - lean_u * z
        made[:, 3, 1] = y_near - lean_v * z
        made[:, 4, 0] = made[:, 5, 1] = near
        made[:, 6, 0] = -u * z
        made[:, 6, 1] = -v * z
        made[:, 7, 0] = made[:, 8, 1] = near > 0.0
        return made

    def before_eye(self, points: Array) -> Flags:
        """Return which points (n, 3) lie before the eye of each pose, not too near it, (b, n)."""
        return np.asarray(self.see(points).depth > NEAREST)

    def moved(self, steps: Array) -> Poses:
        """Return the poses after steps (b, 9), within their bounds.

        A perspectivity of 0 stays 0: nothing steps from one kind of camera to the other.
        """
        perspective = self.perspectivity > 0.0
        bounded = np.clip(self.perspectivity + steps[:, 6], *PERSPECTIVITIES)
        return Poses(
            rotations(steps[:, :3]) @ self.turn,
            np.clip(self.log_scale + steps[:, 3], *SCALES),
            np.clip(self.offset + steps[:, 4:6], -OFF, OFF),
            np.where(perspective, bounded, 0.0),
            self.principal + steps[:, 7:9],
        )


def rotations(vectors: Array) -> Array:
    """Return rotations about vectors (b, 3) by their lengths in radians, (b, 3, 3).

    Rodrigues' formula; a vector of no length gives the identity.
    """
    angle = np.linalg.norm(vectors, axis=1)
    axis = vectors / np.where(angle > 0.0, angle, 1.0)[:, None]
    cross = np.zeros((len(vectors), 3, 3))
    cross[:, 0, 1], cross[:, 0, 2], cross[:, 1, 2] = -axis[:, 2], axis[:, 1], -axis[:, 0]
    cross[:, 1, 0], cross[:, 2, 0], cross[:, 2, 1] = axis[:, 2], -axis[:, 1], axis[:, 0]
    sine, versine = np.sin(angle)[:, None, None], (1.0 - np.cos(angle))[:, None, None]
    return np.asarray(np.eye(3) + sine * cross + versine * (cross @ cross))
