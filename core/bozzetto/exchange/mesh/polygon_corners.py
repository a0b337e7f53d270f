"""Faces of files that hold polygons: triangles, and quads of two triangles."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from bozzetto.arrays import Floats, Index
from bozzetto.geometry.shapes import Solid, Surface


def corner_runs(
    part: Solid | Surface, begin: int, end: int, laid: Floats | None = None
) -> Iterator[Index]:
    """Yield faces of a part as corners of its triangles, in their order.

    Parameters
    ----------
    part : Solid or Surface
        Its faces are asked for.
    begin, end : int
        Its triangles from the first up to the second, which begins a face.
    laid : (f, 3, 2) float32 array, optional
        Places in a picture: a quad that lies in two pieces there is two triangles.

    Yields
    ------
    (k, m) int
        Faces of m corners: 3 × the number of the triangle + the number of the corner.
    """
    if part.polygons is None:
        yield np.arange(3 * begin, 3 * end).reshape(-1, 3)
        return
    many = part.polygons.astype(np.intp)
    first = np.cumsum(many) - many
    inside = (first >= begin) & (first < end)
    first, quad = first[inside], many[inside] == 2
    faces = part.mesh.faces
    one, other = faces[first], faces[np.where(quad, first + 1, first)]
    lone = (~(other[:, :, None] == one[:, None, :]).any(axis=2)).argmax(axis=1)
    fourth = 3 * (first + 1) + lone
    if laid is not None:
        flat = laid.reshape(-1, 2)
        whole = quad.copy()
        for place, after in ((0, 1), (2, 2)):  # where both triangles have the same vertex
            there = np.where(quad, 3 * (first + 1) + (lone + after) % 3, 0)
            whole &= (flat[there] == flat[3 * first + place]).all(axis=1)
        times = np.where(quad & ~whole, 2, 1)
        later = np.arange(int(times.sum())) - np.repeat(np.cumsum(times) - times, times)
        first, fourth, quad = (np.repeat(row, times) for row in (first, fourth, whole))
        first = first + later
    changes = np.flatnonzero(np.diff(quad.astype(int))) + 1
    for rows in np.split(np.arange(len(first)), changes):
        if len(rows):
            corners = 3 * first[rows, None] + np.arange(3)
            yield np.column_stack((corners, fourth[rows])) if quad[rows[0]] else corners
