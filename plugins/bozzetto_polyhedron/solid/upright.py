"""Bodies stood up along their own axes, on the ground."""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.geometry import Placement
from bozzetto_polyhedron.solid.face_rings import area_vectors, edges_of
from bozzetto_polyhedron.solid.planar_body import PlanarBody, on_axis_planes

ROUNDED: Final = 1e-13
"""Numbers below this share of the size are rounding, and are left out where a body stands along
its axes."""


def upright(body: PlanarBody) -> tuple[PlanarBody, Placement]:
    """Return a body along the axes of its own frame, on the ground, and the way back.

    Parameters
    ----------
    body : PlanarBody
        Anywhere.

    Returns
    -------
    upright : PlanarBody
        Axis planes have normals of exactly 1 and two zeros; the lowest corner has z = 0, the
        middle of its box x = y = 0. A body without a frame stands on its largest face.
    placement : Placement
        Takes it back to where it was drawn.
    """
    frame = body.frame if body.frame is not None else _largest_face_frame(body)
    vertices = body.vertices @ frame.T
    used = vertices[edges_of(body.faces).ravel()]
    low, high = used.min(axis=0), used.max(axis=0)
    shift = np.array([(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, low[2]])
    normals = body.normals @ frame.T
    near = np.abs(normals) > 1.0 - 1e-12
    on_axis = near.any(axis=1)
    normals[on_axis] = np.where(near[on_axis], np.sign(normals[on_axis]), 0.0)
    offsets = body.offsets - normals @ shift
    size = float((high - low).max())
    normals[np.abs(normals) < ROUNDED] = 0.0
    offsets[np.abs(offsets) < ROUNDED * size] = 0.0
    standing = PlanarBody(
        _evened(vertices - shift, ROUNDED * size),
        body.faces,
        normals,
        offsets,
        body.closed,
        np.eye(3),
        body.told,
    )
    x, y, z = (float(v) for v in shift @ frame)
    turn = tuple(float(v) for v in frame.T.ravel())
    return on_axis_planes(standing), Placement(turn, 1.0, (x, y, z))


def _evened(vertices: Array, least: float) -> Array:
    """Return corners with coordinates made equal that differ by less than a length."""
    made = vertices.copy()
    for column in made.T:
        order = np.argsort(column, kind="stable")
        first = np.diff(column[order], prepend=-np.inf) > least
        column[order] = column[order][first][np.cumsum(first) - 1]
    return made


def _largest_face_frame(body: PlanarBody) -> Array:
    """Return a frame whose z points out of the side opposite to the largest face."""
    areas = area_vectors(body.vertices, body.faces)
    largest = int(np.linalg.norm(areas, axis=1).argmax())
    z = -body.normals[largest]
    ring = body.vertices[list(body.faces[largest][0])]
    steps = np.roll(ring, -1, axis=0) - ring
    x = steps[int((steps**2).sum(axis=1).argmax())]
    x = x - (x @ z) * z
    x /= np.linalg.norm(x)
    return np.stack((x, np.cross(z, x), z))
