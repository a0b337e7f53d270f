"""Seams: where fillets were united with bodies, triangles are made even and put on the blend."""

from __future__ import annotations

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto_silhouette.implicit.implicit_solid import Implicit
from bozzetto_silhouette.numerics.grouping import connected_pieces
from bozzetto_silhouette.solids.batched_answers import each
from bozzetto_silhouette.solids.evening import Sewn, Zone, even, evened
from bozzetto_silhouette.solids.on_surface import (
    ROOM,
    Places,
    all_off,
    around,
    is_off,
    rows_by_number,
    settled,
)

EVENINGS = 3
"""Rounds of evening out after that."""

RINGS = 2
"""Rings of vertices around fillets that may be moved, too."""

MEETING = 2
"""Rings of vertices around those where two seams meet that are made even after both."""

SPREAD = 60
"""Rings at most of those that are not on the blended surface."""


def sewn(
    vertices: Array, faces: Index, seam: Index, held: Flags, spacing: Array, solid: Implicit
) -> Sewn:
    """Even out the triangles of a mesh at its seams, and bring them onto a solid's surface.

    Every seam is done by itself, so that it can be remembered: where two meet, vertices are only
    brought onto the surface at first, and the triangles around these are made even after that.

    Parameters
    ----------
    vertices, faces : (v, 3) float array, (f, 3) int array
        A closed mesh.
    seam : (v,) int array
        The number of the seam that a vertex of a fillet, or where one meets a body, belongs to;
        -1 for others.
    held : (v,) bool array
        Those that must stay where they are: on sharp edges.
    spacing : (v,) float array
        How long edges are there, about.
    solid : Implicit
        Whose surface the mesh is.
    """
    seam = _grown(vertices, faces, np.where(held, -1, seam), held, spacing, solid)
    a, b = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    between = np.zeros(len(vertices), dtype=bool)
    between[a[(seam[a] >= 0) & (seam[a] < seam[b])]] = True
    vertices, normals = settled(vertices, np.where(between, seam, -1), spacing, between, solid)
    moved = Sewn(vertices, faces, np.arange(len(vertices)), between, normals)
    first = with_even(moved, np.where(between, -1, seam), spacing, solid)
    if not between.any():
        return first
    places = _around_vertices(first, between[first.parents])
    return with_even(first, places, spacing[first.parents], solid)


def with_even(
    mesh: Sewn, number: Index, spacing: Array, solid: Implicit, evenings: int = EVENINGS
) -> Sewn:
    """Return a mesh with even triangles around the vertices of each number (v,), -1 for none.

    Vertices of two numbers must not be neighbours.
    """
    of_face = number[mesh.faces].max(axis=1)
    numbers, zones = [], []
    for zone in rows_by_number(mesh.faces, of_face):
        mine, inner = _in_order(mesh.vertices, zone)
        local = around(solid, mesh.vertices[mine], spacing[mine])
        numbers.append(mine)
        zones.append(Zone(
            mesh.vertices[mine], inner, number[mine] >= 0, spacing[mine], local, evenings
        ))  # fmt: skip
    rest = mesh._replace(faces=mesh.faces[of_face < 0])
    found = each(even, evened, zones)
    return _set_in(rest, list(zip(numbers, found, strict=True)))


def _around_vertices(mesh: Sewn, chosen: Flags) -> Index:
    """Return the number (v,) of the place around some vertices, of moved ones; elsewhere -1."""
    a, b = mesh.faces.ravel(), np.roll(mesh.faces, -1, axis=1).ravel()
    for _ in range(MEETING):
        chosen = chosen.copy()
        chosen[b[chosen[a]]] = True
        chosen &= mesh.moved
    inner = chosen[a] & chosen[b]
    _, number = connected_pieces(a[inner], b[inner], len(chosen))
    return np.where(chosen, number, -1)


def _grown(
    vertices: Array, faces: Index, seam: Index, held: Flags, spacing: Array, solid: Implicit
) -> Index:
    """Add some rings of vertices to seams, and more as far as the blend is felt."""
    a, b = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    loose = np.zeros(len(seam), dtype=bool)
    for ring in range(SPREAD):
        new = (seam[a] >= 0) & (seam[b] < 0) & ~held[b]
        if ring >= RINGS:
            if ring == RINGS:
                loose = _off_surface(vertices, seam, spacing, solid)
            new &= loose[b]
        if not new.any():
            break
        reached = np.full(len(seam), -1)
        np.maximum.at(reached, b[new], seam[a[new]])
        seam = np.where(reached >= 0, reached, seam)
    return seam


def _off_surface(vertices: Array, seam: Index, spacing: Array, solid: Implicit) -> Flags:
    """Mark the vertices in the boxes of seams, without these, that are not on the surface."""
    off = np.zeros(len(vertices), dtype=bool)
    free = np.flatnonzero(seam < 0)
    free = free[np.argsort(vertices[free, 0])]  # only few have an x as in a seam's box
    x = vertices[free, 0]
    rows, asked = [], []
    for mine in rows_by_number(np.arange(len(vertices)), seam):
        place = vertices[mine]
        room = ROOM * float(spacing[mine].max())
        low, high = place.min(axis=0) - room, place.max(axis=0) + room
        near = free[np.searchsorted(x, low[0], "left") : np.searchsorted(x, high[0], "right")]
        near = near[((vertices[near] >= low) & (vertices[near] <= high)).all(axis=1)]
        if len(near):
            near = near[np.lexsort(vertices[near].T)]
            rows.append(near)
            local = around(solid, vertices[near], spacing[near])
            asked.append(Places(vertices[near], spacing[near], np.zeros(len(near), bool), local))
    for near, found in zip(rows, each(is_off, all_off, asked), strict=True):
        off[near] = found
    return off


def _in_order(vertices: Array, faces: Index) -> tuple[Index, Index]:
    """Return some faces by themselves, in an order that depends on their places alone.

    Returns
    -------
    numbers : (k,) int array
        Of their vertices.
    faces : (f, 3) int array
        As indices into these.
    """
    numbers = np.unique(faces)
    numbers = numbers[np.lexsort(vertices[numbers].T)]
    rank = np.zeros(len(vertices), np.intp)
    rank[numbers] = np.arange(len(numbers))
    inner = rank[faces]
    first = inner.argmin(axis=1)
    inner = np.take_along_axis(inner, (first[:, None] + np.arange(3)) % 3, axis=1)
    return numbers, inner[np.lexsort(inner.T)]


def _set_in(rest: Sewn, parts: list[tuple[Index, Sewn]]) -> Sewn:
    """Put seams, each of some vertices (by number) of a mesh, into the rest of that mesh."""
    count = len(rest.vertices)
    rows, points, moved = [rest.faces], [rest.vertices], [rest.moved]
    parents, normals = [rest.parents], [rest.normals]
    for numbers, part in parts:
        number = numbers[part.parents]
        new = int(part.moved.sum())
        number[part.moved] = count + np.arange(new)
        count += new
        rows.append(number[part.faces])
        points.append(part.vertices[part.moved])
        normals.append(part.normals[part.moved])
        moved.append(np.ones(new, dtype=bool))
        parents.append(rest.parents[numbers[part.parents[part.moved]]])
    every = np.concatenate(rows)
    used = np.zeros(count, dtype=bool)
    used[every] = True
    rank = np.cumsum(used) - 1
    place, normal = np.concatenate(points)[used], np.concatenate(normals)[used]
    return Sewn(
        place, rank[every], np.concatenate(parents)[used], np.concatenate(moved)[used], normal
    )
