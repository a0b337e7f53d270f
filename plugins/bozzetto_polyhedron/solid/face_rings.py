"""Rings of faces: areas, edges, sides, and whether they are sound."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto_polyhedron.graph.planar_embedding import Ring
from bozzetto_polyhedron.reconstruction.answer import Rings

TOUCHING: Final = 1e-9
"""Distance, as share of the size of a face, below which its rings touch."""


def area_vector(points: Array) -> Array:
    """Return the area of a ring times its unit normal, (3,), by Newell's formula.

    Parameters
    ----------
    points : (n, 3) float
        Corners once round, counter-clockwise seen from where the normal points.
    """
    spokes = points[1:] - points[0]
    (x, y, z), (p, q, r) = spokes[:-1].T, spokes[1:].T
    return 0.5 * np.array((y @ r - z @ q, z @ p - x @ r, x @ q - y @ p))


def cross(one: Array, two: Array) -> Array:
    """Return the cross product of two vectors: that of numpy takes longer for so few numbers."""
    x, y, z = one.tolist()
    p, q, r = two.tolist()
    return np.array((y * r - z * q, z * p - x * r, x * q - y * p))


def area_vectors(vertices: Array, faces: Sequence[Rings]) -> Array:
    """Return the areas of faces, holes taken off, times their unit normals, (f, 3)."""
    sums = [sum(area_vector(vertices[list(ring)]) for ring in face) for face in faces]
    return np.array(sums, float).reshape(-1, 3)


def corners_of(face: Rings) -> list[int]:
    """Return the numbers of the vertices of a face, each once, in the order of its rings."""
    return list(dict.fromkeys(vertex for ring in face for vertex in ring))


def sides_of(ring: Ring) -> list[tuple[int, int]]:
    """Return the sides of a ring as pairs of vertices, in its direction."""
    return list(zip(ring, (*ring[1:], ring[0]), strict=True))


def edges_of(faces: Sequence[Rings]) -> Index:
    """Return all edges of faces, each once with the smaller number first, in order, (m, 2)."""
    pairs = {(min(side), max(side)) for face in faces for ring in face for side in sides_of(ring)}
    return np.array(sorted(pairs), np.intp).reshape(-1, 2)


def bounds_volume(faces: Sequence[Rings]) -> bool:
    """Whether every side is run once in each direction, so that faces bound a volume."""
    uses = Counter(side for face in faces for ring in face for side in sides_of(ring))
    return bool(uses) and all(count == 1 and uses[side[::-1]] == 1 for side, count in uses.items())


def signed_volume(vertices: Array, faces: Sequence[Rings]) -> float:
    """Return the volume that closed faces bound, mm³: positive where rings look outward."""
    middle = vertices.mean(axis=0)
    heights = np.array([(vertices[face[0][0]] - middle) for face in faces])
    return float(np.einsum("fk,fk->", area_vectors(vertices - middle, faces), heights) / 3.0)


def turned_over(faces: Sequence[Rings]) -> tuple[Rings, ...]:
    """Return faces that look to the other side."""
    return tuple(tuple(ring[::-1] for ring in face) for face in faces)


def tangents(normal: Array) -> Array:
    """Return two unit vectors that make a right-handed frame with a unit normal, (2, 3)."""
    start = np.eye(3)[int(np.abs(normal).argmin())]
    first = start - (start @ normal) * normal
    first /= np.linalg.norm(first)
    return np.stack((first, cross(normal, first)))


def parted(ring: Ring) -> list[Ring]:
    """Return a ring that runs through some corners twice as rings that touch there."""
    found: list[Ring] = []
    open_ring: list[int] = []
    for vertex in ring:
        if vertex in open_ring:
            begin = open_ring.index(vertex)
            found.append(tuple(open_ring[begin:]))
            del open_ring[begin:]
        open_ring.append(vertex)
    return [*found, tuple(open_ring)]


def hanging_rings(face: Rings) -> int:
    """Return how many rings of a face hang together by no corner."""
    groups: list[set[int]] = []
    for ring in face:
        met = [group for group in groups if not group.isdisjoint(ring)]
        groups = [group for group in groups if group.isdisjoint(ring)]
        groups.append(set(ring).union(*met))
    return len(groups)


def flat_rings(vertices: Array, face: Rings, normal: Array) -> list[Array]:
    """Return the rings of a face in coordinates of its own plane, each (n, 2), mm."""
    axes = tangents(normal)
    origin = vertices[face[0][0]]
    return [(vertices[list(ring)] - origin) @ axes.T for ring in face]


def inside(ring: Array, points: Array) -> Flags:
    """Whether points (n, 2) lie inside a ring (m, 2), by the parity of crossings."""
    start, end = ring, np.roll(ring, -1, axis=0)
    x, y = points[:, :1], points[:, 1:]
    straddles = (start[:, 1] > y) != (end[:, 1] > y)
    rise = np.where(end[:, 1] == start[:, 1], 1.0, end[:, 1] - start[:, 1])
    at = start[:, 0] + (end[:, 0] - start[:, 0]) * (y - start[:, 1]) / rise
    return np.asarray((straddles & (x < at)).sum(axis=1) % 2 == 1)


def inside_face(rings: Sequence[Array], points: Array) -> Flags:
    """Whether points (n, 2) lie within the outer ring of a face and in none of its holes."""
    parity = np.zeros(len(points), bool)
    for ring in rings:
        parity ^= inside(ring, points)
    return parity


def are_simple(rings: Sequence[Array]) -> bool:
    """Whether plane rings do not cross, and holes lie inside the first one.

    Rings may touch in corners that they share to the last digit, and nowhere else.

    Parameters
    ----------
    rings : sequence of (n, 2) float
        The outer ring, then the holes.
    """
    starts = np.concatenate(rings)
    ends = np.concatenate([np.roll(ring, -1, axis=0) for ring in rings])
    size = float(np.ptp(starts, axis=0).max())
    if not size > 0 or not _segments_apart(starts, ends, TOUCHING * size):
        return False
    outer, *holes = rings
    for number, hole in enumerate(holes):
        others = [other for k, other in enumerate(holes) if k != number]
        middles = 0.5 * (hole[:1] + hole[1:2])
        if not inside(outer, middles)[0] or any(inside(o, middles)[0] for o in others):
            return False
    return True


def _segments_apart(starts: Array, ends: Array, least: float) -> bool:
    """Whether segments meet nowhere but at ends that they share by following one another."""
    along = ends - starts
    lengths = np.linalg.norm(along, axis=1)
    if (lengths <= least).any():
        return False
    offset = starts[None] - starts[:, None]
    cross = along[:, None, 0] * along[None, :, 1] - along[:, None, 1] * along[None, :, 0]
    safe = np.where(cross == 0.0, 1.0, cross)
    first = (offset[..., 0] * along[None, :, 1] - offset[..., 1] * along[None, :, 0]) / safe
    second = (offset[..., 0] * along[:, None, 1] - offset[..., 1] * along[:, None, 0]) / safe
    proper = (first > 0) & (first < 1) & (second > 0) & (second < 1)
    same = np.arange(len(starts))
    follows = (ends[:, None] == starts[None]).all(axis=-1)
    near = follows | follows.T
    near[same, same] = True
    if ((cross != 0.0) & proper & ~near).any():
        return False
    distance = _distance_to_segments(starts, starts, ends)
    at_end = (ends[None] == starts[:, None]).all(axis=-1)
    own = near | at_end | (starts[None] == starts[:, None]).all(axis=-1)
    own[same, same] = True
    return bool((distance[~own] > least).all()) and not _folds_back(along, lengths, follows)


def _folds_back(along: Array, lengths: Array, follows: Flags) -> bool:
    """Whether a side runs back along the one before it."""
    first, second = np.nonzero(follows)
    unit = along / lengths[:, None]
    turn = unit[first, 0] * unit[second, 1] - unit[first, 1] * unit[second, 0]
    return bool(((np.abs(turn) < TOUCHING) & ((unit[first] * unit[second]).sum(1) < 0)).any())


def _distance_to_segments(points: Array, starts: Array, ends: Array) -> Array:
    """Return the distance of every point from every segment, (n, m)."""
    along = ends - starts
    offset = points[:, None] - starts[None]
    share = np.einsum("nmk,mk->nm", offset, along) / np.einsum("mk,mk->m", along, along)
    foot = starts + np.clip(share, 0.0, 1.0)[..., None] * along
    return np.asarray(np.linalg.norm(points[:, None] - foot, axis=-1))
