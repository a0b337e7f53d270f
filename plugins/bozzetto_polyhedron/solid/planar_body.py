"""A body whose faces lie exactly in planes."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from bozzetto.arrays import Array
from bozzetto_polyhedron.reconstruction.answer import Rings


@dataclass(frozen=True, eq=False)
class PlanarBody:
    """Vertices, planes and the faces in them.

    Parameters
    ----------
    vertices : (n, 3) float64
        mm.
    faces : tuple of Rings
        Outer rings counter-clockwise seen from outside.
    normals : (f, 3) float64
        Unit normals, outward.
    offsets : (f,) float64
        ``normals @ p == offsets`` for every point p of the face, mm.
    closed : bool
        Whether it bounds a volume; otherwise it is a sheet.
    frame : (3, 3) float64, optional
        Rows are the axes that right angles were made with.
    told : tuple of str
        What was made exact or had to be left, for a person.
    """

    vertices: Array
    faces: tuple[Rings, ...]
    normals: Array
    offsets: Array
    closed: bool
    frame: Array | None = None
    told: tuple[str, ...] = ()


def on_axis_planes(body: PlanarBody) -> PlanarBody:
    """Return a body whose corners have exactly the coordinates of its axis-aligned planes."""
    vertices = body.vertices.copy()
    for face, normal, offset in zip(body.faces, body.normals, body.offsets, strict=True):
        axis = int(np.abs(normal).argmax())
        if abs(normal[axis]) == 1.0:
            vertices[[v for ring in face for v in ring], axis] = offset * normal[axis]
    return replace(body, vertices=vertices)


def evened(vertices: Array, least: float) -> Array:
    """Return corners, (n, 3), with coordinates made equal that differ by less than a length.

    So edges along an axis of the world have directions of zeros and a one, in oblique planes too.
    """
    made = vertices.copy()
    for column in made.T:
        order = np.argsort(column, kind="stable")
        first = np.diff(column[order], prepend=-np.inf) > least
        column[order] = column[order][first][np.cumsum(first) - 1]
    return made
