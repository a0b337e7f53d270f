"""Handles and tunnels that are too narrow to be meant are taken out of a closed mesh."""

from __future__ import annotations

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto_silhouette.numerics.grouping import connected_pieces
from bozzetto_silhouette.numerics.handle_loops import shortest_loop

MOST = 16
"""Handles that are taken out of one mesh, at most."""


def without_narrow_handles(vertices: Array, faces: Index, longest: Array) -> tuple[Index, Index]:
    """Cut a mesh open along short loops that do not divide it, and close both sides of each cut.

    A tunnel is closed by two walls in one place, a handle is cut through in one place: for whoever
    moves the vertices onto a surface afterwards.

    Parameters
    ----------
    vertices, faces : (v, 3) float array, (f, 3) int array
        A closed mesh in which every vertex has faces.
    longest : (v,) float array
        How long a loop is at most that passes a vertex; 0 where the mesh is to stay as it is.

    Returns
    -------
    faces : (g, 3) int array
        Of a closed mesh.
    parents : (w,) int array
        The vertex before that each stands for: the first v are those before.
    """
    parents = np.arange(len(vertices))
    for _ in range(MOST):
        a, b = faces[:, :2].ravel(), faces[:, 1:].ravel()
        pieces, number = connected_pieces(a, b, len(parents))
        # Euler's formula: of a closed mesh each face owns one and a half edges.
        if len(parents) - len(faces) // 2 >= 2 * pieces:
            break
        roots = np.unique(number, return_index=True)[1]
        loop = shortest_loop(vertices[parents], faces, roots, longest[parents])
        cut = None if loop is None else _cut(faces, loop, len(parents))
        if loop is None or cut is None:
            break
        faces, parents = cut, np.concatenate([parents, parents[loop]])
    return faces, parents


def _cut(faces: Index, loop: Index, count: int) -> Index | None:
    """Cut faces along a loop, whose vertices get copies from a count on, and close both sides.

    None where an edge of the new faces is there already.
    """
    on_loop = np.isin(faces, loop)
    rows = np.flatnonzero(on_loop.any(axis=1))
    after = {
        (int(t[k]), int(t[(k + 1) % 3])): (int(row), int(t[(k + 2) % 3]))
        for row, t in zip(rows, faces[rows], strict=True)
        for k in range(3)
    }
    inner = range(2, len(loop) - 1)
    if any((int(loop[0]), int(loop[k])) in after for k in inner):
        return None
    result = faces.copy()
    for k, vertex in enumerate(loop.tolist()):
        # The faces on the left, in turn around the vertex, from the edge on to the edge before.
        corner, last = int(loop[(k + 1) % len(loop)]), int(loop[k - 1])
        while corner != last:
            row, corner = after[vertex, corner]
            result[row, faces[row] == vertex] = count + k
    copies = count + np.arange(len(loop))
    steps = np.arange(1, len(loop) - 1)
    start = np.zeros(len(steps), np.intp)
    caps = [
        np.stack([copies[start], copies[steps + 1], copies[steps]], axis=1),
        np.stack([loop[start], loop[steps], loop[steps + 1]], axis=1),
    ]
    return np.concatenate([result, *caps])
