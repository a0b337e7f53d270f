"""The view cube without a widget: its faces as they are seen, and what lies under a place."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import msgspec
import numpy as np

from bozzetto.arrays import Array

if TYPE_CHECKING:
    from bozzetto.view.camera import Camera, Point

__all__ = ["EDGE", "FACES", "Face", "SeenFace", "direction_at", "patch", "seen_faces"]


EDGE: Final = 0.62
"""Where on a face (0 middle, 1 rim) the edges and corners of the cube begin."""

FACING: Final = 0.06
"""Cosine of the angle to the eye below which a face is too thin to be shown."""


class Face(NamedTuple):
    """One side of the cube: its outward direction, and its right and up when upright."""

    name: str
    outward: Point
    right: Point
    up: Point


FACES: Final = (
    Face("front", (0, -1, 0), (1, 0, 0), (0, 0, 1)),
    Face("back", (0, 1, 0), (-1, 0, 0), (0, 0, 1)),
    Face("left", (-1, 0, 0), (0, -1, 0), (0, 0, 1)),
    Face("right", (1, 0, 0), (0, 1, 0), (0, 0, 1)),
    Face("top", (0, 0, 1), (1, 0, 0), (0, 1, 0)),
    Face("bottom", (0, 0, -1), (1, 0, 0), (0, -1, 0)),
)


class SeenFace(msgspec.Struct, frozen=True, eq=False):
    """A face that is turned to the eye.

    Attributes
    ----------
    middle, across, above : (2,) float
        Its centre and half its edges on the sheet, in half edges of the cube, y down.
    facing : float
        Cosine of the angle between its outward direction and the eye.
    """

    face: Face
    middle: Array
    across: Array
    above: Array
    facing: float

    def place(self, u: float, v: float) -> Array:
        """Return the sheet position of face coordinates, −1 … 1 to the right and up."""
        return np.asarray(self.middle + u * self.across + v * self.above)


def seen_faces(camera: Camera) -> list[SeenFace]:
    """Return the faces turned to the eye of a camera, the most frontal one last."""
    right, up, forward = camera.axes
    sheet = np.vstack((right, -up))
    found = []
    for face in FACES:
        facing = -float(np.dot(forward, face.outward))
        if facing > FACING:
            found.append(
                SeenFace(
                    face,
                    sheet @ np.asarray(face.outward, float),
                    sheet @ np.asarray(face.right, float),
                    sheet @ np.asarray(face.up, float),
                    facing,
                )
            )
    return sorted(found, key=lambda seen: seen.facing)


def direction_at(camera: Camera, x: float, y: float) -> Point | None:
    """Return the outward direction of the face, edge or corner under a position.

    Parameters
    ----------
    camera : Camera
        The view of the sheet, which the cube follows.
    x, y : float
        From the middle of the cube, in half edges, y down.

    Returns
    -------
    (x, y, z) of −1, 0, 1, or None
        One of `bozzetto.view.standard_views.CUBE_DIRECTIONS`.
    """
    for seen in reversed(seen_faces(camera)):
        basis = np.column_stack((seen.across, seen.above))
        u, v = np.linalg.solve(basis, np.array((x, y)) - seen.middle)
        if max(abs(u), abs(v)) <= 1.0:
            outward = np.array(seen.face.outward, float)
            if abs(u) > EDGE:
                outward += np.sign(u) * np.asarray(seen.face.right)
            if abs(v) > EDGE:
                outward += np.sign(v) * np.asarray(seen.face.up)
            return float(outward[0]), float(outward[1]), float(outward[2])
    return None


def patch(seen: SeenFace, direction: Point) -> Array | None:
    """Return the part of a face that belongs to a face, edge or corner; (4, 2), or None."""
    if np.dot(direction, seen.face.outward) < 0.5:
        return None
    spans = []
    for axis in (seen.face.right, seen.face.up):
        side = float(np.dot(direction, axis))
        spans.append((EDGE, 1.0) if side > 0.5 else (-1.0, -EDGE) if side < -0.5 else (-EDGE, EDGE))
    (u0, u1), (v0, v1) = spans
    return np.array([seen.place(u, v) for u, v in ((u0, v0), (u1, v0), (u1, v1), (u0, v1))])
