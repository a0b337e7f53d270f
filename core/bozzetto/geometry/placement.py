"""Placement of a model: a rigid motion with one scale."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bozzetto.errors import UserError

UNIT_TOLERANCE: float = 1e-6
"""Largest departure from orthonormality accepted in a rotation."""

_UNTURNED = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)


@dataclass(frozen=True)
class Placement:
    """Rotation, then uniform scale, then translation: ``p -> scale * R p + offset``.

    Parameters
    ----------
    rotation : tuple of 9 floats
        Rows of R; may include a mirror (determinant −1).
    scale : float
        Positive.
    offset : (x, y, z)
        mm.
    """

    rotation: tuple[float, ...] = _UNTURNED
    scale: float = 1.0
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        if len(self.rotation) != 9 or len(self.offset) != 3:
            raise UserError("A placement needs nine numbers of rotation and three of offset.")
        if not np.isfinite((*self.rotation, self.scale, *self.offset)).all() or self.scale <= 0:
            raise UserError("A placement needs finite numbers and a scale above zero.")
        rows = np.reshape(self.rotation, (3, 3))
        with np.errstate(over="ignore", invalid="ignore"):  # numbers from a file may be huge
            departure = np.abs(rows @ rows.T - np.eye(3)).max()
        if not departure <= UNIT_TOLERANCE:  # NaN, where infinities cancelled, is no rotation
            raise UserError("A placement's rotation must be orthonormal.")

    @property
    def is_identity(self) -> bool:
        """Whether nothing moves."""
        return (self.rotation, self.scale, self.offset) == (_UNTURNED, 1.0, (0.0, 0.0, 0.0))

    @property
    def mirrors(self) -> bool:
        """Whether left and right are exchanged (triangles must be turned over)."""
        return float(np.linalg.det(np.reshape(self.rotation, (3, 3)))) < 0

    @property
    def heading(self) -> float:
        """The angle by which it turns about z, degrees, above −180 to 180; see `headed`."""
        rows = np.reshape(self.rotation, (3, 3))
        x, y = rows[0, 0], rows[1, 0]
        if np.hypot(x, y) < UNIT_TOLERANCE:  # its own x stands upright: where does its y point?
            x, y = rows[1, 1], -rows[0, 1]
        angle = float(np.degrees(np.arctan2(y, x)))
        return 180.0 if angle == -180.0 else angle + 0.0

    def headed(self, heading: float) -> Placement:
        """Return it turned about z, in its place, to another heading in degrees.

        Raises
        ------
        UserError
            If the heading is not finite.
        """
        if not np.isfinite(heading):
            raise UserError("A placement needs a finite angle.")
        by = (heading - self.heading) % 360.0
        if by == 0.0:
            return self
        # Quarter turns are exact: what stood along an axis stands along one again.
        quarters = {90.0: (0.0, 1.0), 180.0: (-1.0, 0.0), 270.0: (0.0, -1.0)}
        c, s = quarters.get(by, (np.cos(np.radians(by)), np.sin(np.radians(by))))
        turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        rows = turn @ np.reshape(self.rotation, (3, 3))
        # Many small turns, one after the other, must not add up to what is no rotation.
        left, _, right = np.linalg.svd(rows)
        exact = rows if by in quarters else left @ right
        return Placement(tuple(float(v) + 0.0 for v in exact.ravel()), self.scale, self.offset)

    def points(self, points: ArrayLike) -> NDArray[np.float64]:
        """Move points, shape (n, 3), mm."""
        rows = np.reshape(self.rotation, (3, 3))
        moved = np.reshape(np.asarray(points, float), (-1, 3)) @ rows.T
        return np.asarray(self.scale * moved + self.offset, np.float64)

    def directions(self, vectors: ArrayLike) -> NDArray[np.float64]:
        """Turn directions, shape (n, 3); lengths are kept."""
        rows = np.reshape(self.rotation, (3, 3))
        return np.asarray(np.reshape(np.asarray(vectors, float), (-1, 3)) @ rows.T, np.float64)

    def after(self, first: Placement) -> Placement:
        """Return the placement that does `first`, then this one."""
        rows = np.reshape(self.rotation, (3, 3)) @ np.reshape(first.rotation, (3, 3))
        x, y, z = (float(v) for v in self.points(first.offset)[0])
        turn = tuple(float(v) for v in rows.ravel())
        return Placement(turn, self.scale * first.scale, (x, y, z))

    def inverse(self) -> Placement:
        """Return the placement that undoes this one."""
        rows = np.reshape(self.rotation, (3, 3))
        back = -(rows.T @ np.asarray(self.offset)) / self.scale
        return Placement(
            tuple(float(v) for v in rows.T.ravel()),
            1.0 / self.scale,
            (float(back[0]), float(back[1]), float(back[2])),
        )
