"""Handles and tunnels that are too narrow to be meant are taken out of a closed mesh."""

from __future__ import annotations

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto_silhouette.numerics.grouping import connected_pieces
from bozzetto_silhouette.numerics.handle_loops import shortest_loop
from bozzetto_silhouette.numerics.isotropic_remeshing import border_edges

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
    if _with_handles(faces, len(vertices)) is None:
        return faces, parents
    # Mostly the whole loop lies where it may be cut: there it is sought first.
    left, mended = np.ones(len(faces), dtype=bool), []
    for place in _narrow_places(faces, longest > 0.0):
        some, copied = _taken_out_at(faces[place], vertices, longest, len(parents))
        left &= ~place
        mended.append(some)
        parents = np.concatenate([parents, copied])
    return _taken_out(vertices, np.concatenate([faces[left], *mended]), parents, longest)


def _with_handles(faces: Index, count: int) -> Index | None:
    """Return a vertex of each piece of a closed mesh; None where it has no handles."""
    a, b = faces[:, :2].ravel(), faces[:, 1:].ravel()
    pieces, number = connected_pieces(a, b, count)
    # Euler's formula: of a closed mesh each face owns one and a half edges.
    if count - len(faces) // 2 >= 2 * pieces:
        return None
    return np.unique(number, return_index=True)[1]


def _taken_out(
    vertices: Array, faces: Index, parents: Index, longest: Array
) -> tuple[Index, Index]:
    """Cut along one short loop after the other, as `without_narrow_handles` does."""
    for _ in range(MOST):
        roots = _with_handles(faces, len(parents))
        if roots is None:
            break
        loop = shortest_loop(vertices[parents], faces, roots, longest[parents])
        cut = None if loop is None else _cut(faces, loop, len(parents))
        if loop is None or cut is None:
            break
        faces, parents = cut, np.concatenate([parents, parents[loop]])
    return faces, parents


def _narrow_places(faces: Index, narrow: Flags) -> list[Flags]:
    """Return the faces (f,) of each connected place around narrow vertices that has handles.

    Handles are those that it has when every loop of its border is closed by a fan. Places whose
    border touches itself are left out.
    """
    count = len(narrow)
    inside = narrow[faces].any(axis=1)
    some = faces[inside]
    _, place = connected_pieces(some[:, :2].ravel(), some[:, 1:].ravel(), count)
    ends = border_edges(some, count)
    places = int(place.max(initial=-1)) + 1
    corners = np.bincount(place[np.unique(some)], minlength=places)
    number = np.bincount(place[some[:, 0]], minlength=places)
    edges = (3 * number + np.bincount(place[ends[:, 0]], minlength=places)) // 2
    _, loop = connected_pieces(ends[:, 0], ends[:, 1], count)
    first = ends[np.unique(loop[ends[:, 0]], return_index=True)[1], 0]
    handles = corners - edges + number + np.bincount(place[first], minlength=places) < 2
    handles[number == 0] = False
    leaving = np.bincount(ends[:, 0], minlength=count)
    handles[place[leaving > 1]] = False
    return [inside & (place[faces[:, 0]] == k) for k in np.flatnonzero(handles)]


def _taken_out_at(
    faces: Index, vertices: Array, longest: Array, copies: int
) -> tuple[Index, Index]:
    """Cut faces (f, 3) at one place of a mesh along short loops, by themselves.

    Their border is closed by fans: a loop that does not divide them then does not divide the whole.

    Returns
    -------
    faces : (g, 3) int array
        With the same border; copies of vertices are counted from `copies` on.
    parents : (w,) int array
        The vertex that each copy stands for.
    """
    numbers, inner = np.unique(faces, return_inverse=True)
    inner = inner.reshape(-1, 3)
    count = len(numbers)
    ends = border_edges(inner, count)
    _, loop = connected_pieces(ends[:, 0], ends[:, 1], count)
    loops, own = np.unique(loop[ends[:, 0]], return_inverse=True)
    middles = [vertices[numbers[ends[own == k, 0]]].mean(axis=0) for k in range(len(loops))]
    places = np.vstack([vertices[numbers], *middles])
    closed = np.concatenate([inner, np.column_stack([ends[:, ::-1], count + own])])
    most = np.concatenate([longest[numbers], np.zeros(len(loops))])
    cut, parents = _taken_out(places, closed, np.arange(len(places)), most)
    new = parents[len(places) :]
    of_fan = (cut >= count) & (cut < len(places))
    after = np.concatenate([numbers, np.zeros(len(loops), np.intp), copies + np.arange(len(new))])
    return after[cut[~of_fan.any(axis=1)]], numbers[new]


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
