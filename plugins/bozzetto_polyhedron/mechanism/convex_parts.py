"""Convex polytopes, and what is not convex cut into some of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from manifold3d import Manifold
from manifold3d import Mesh as ManifoldMesh
from scipy.spatial import ConvexHull, QhullError

from bozzetto.arrays import Array, Index
from bozzetto.geometry import Mesh
from bozzetto.plugin import cached_property

MOST_CORNERS: Final = 64
"""Corners of a part: one with more is a little smaller than what it stands for."""

MOST_PARTS: Final = 16
"""Parts that one body is cut into; hollows that are left then are full."""

MOST_CUTS: Final = 10
"""Planes that are tried for each cut."""

HOLLOW: Final = 2e-3
"""Share of the volume of a body by which hulls may be larger than what they stand for."""

MOST_TRIANGLES: Final = 2000
"""Triangles of a body that is cut: one with more is made plainer first."""

FINEST: Final = 1e-3
"""Distance, by size, by which a body with more triangles is made plainer at first."""

KERF: Final = 1e-5
"""Width of a cut, by size: what only touches along the plane of a cut comes apart."""

SLIVER: Final = 1e-5
"""Share of a body below which a piece is the rounding of a cut."""

FLAT: Final = 1e-6
"""Cosine from 1, and distance by size, within which triangles of a hull are one face."""


@dataclass(frozen=True, eq=False)
class Polytope:
    """A convex polytope.

    Parameters
    ----------
    corners : (n, 3) float64
    normals : (f, 3) float64
        Of its faces, outwards.
    offsets : (f,) float64
        The faces lie where normal · place = offset.
    rings : tuple of tuple of int
        Corners of each face, counter-clockwise from outside.
    """

    corners: Array
    normals: Array
    offsets: Array
    rings: tuple[tuple[int, ...], ...]

    @cached_property
    def edges(self) -> Index:
        """Each edge once, (m, 2)."""
        pairs = {
            (min(pair), max(pair))
            for ring in self.rings
            for pair in zip(ring, (*ring[1:], *ring[:1]), strict=True)
        }
        return np.array(sorted(pairs), np.intp)

    @cached_property
    def directions(self) -> tuple[Array, Index]:
        """Directions of edges without repetition, (d, 3), and which each edge has, (m,)."""
        along = self.corners[self.edges[:, 1]] - self.corners[self.edges[:, 0]]
        along /= np.linalg.norm(along, axis=1, keepdims=True)
        leading = along[np.arange(len(along)), np.abs(along).argmax(axis=1)]
        along *= np.sign(leading)[:, None]
        _, chosen, which = np.unique(along.round(6), axis=0, return_index=True, return_inverse=True)
        return along[chosen], np.asarray(which.ravel(), np.intp)

    def scaled(self, scale: float, offset: Array) -> Polytope:
        """Return the same, its places (3,) moved by an offset and then made larger."""
        corners = (self.corners + offset) * scale
        offsets = (self.offsets + self.normals @ offset) * scale
        return Polytope(corners, self.normals, offsets, self.rings)


def polytope_of(points: Array) -> Polytope | None:
    """Return the convex hull of points (n, 3); None where they lie in a plane."""
    points = _fewer(points)
    try:
        hull = ConvexHull(points)
    except (QhullError, ValueError):
        return None
    size = float(np.ptp(points, axis=0).max())
    groups: list[list[int]] = []
    for number, plane in enumerate(hull.equations):
        for group in groups:
            known = hull.equations[group[0]]
            same = plane[:3] @ known[:3] > 1.0 - FLAT
            if same and abs(plane[3] - known[3]) < 10.0 * FLAT * size:
                group.append(number)
                break
        else:
            groups.append([number])
    kept = np.unique(hull.vertices)
    numbers = np.full(len(points), -1)
    numbers[kept] = np.arange(len(kept))
    normals = hull.equations[[group[0] for group in groups], :3]
    rings = tuple(
        _ring(points, np.unique(hull.simplices[group]), normal, numbers)
        for group, normal in zip(groups, normals, strict=True)
    )
    corners = points[kept]
    return Polytope(corners, normals, (corners @ normals.T).max(axis=0), rings)


def convex_parts(mesh: Mesh) -> tuple[Polytope, ...]:
    """Return polytopes that fill a body, cut along the faces at its hollow edges.

    What bounds no volume is its convex hull.
    """
    body = Manifold(
        ManifoldMesh(np.array(mesh.vertices, np.float32), np.array(mesh.faces, np.uint32))
    )
    if body.is_empty() or body.volume() <= 0.0:
        whole = polytope_of(np.asarray(mesh.vertices, float))
        return () if whole is None else (whole,)
    body = _plain(body)
    allowed = HOLLOW * float(body.volume())
    waiting = [body]
    done: list[Manifold] = []
    while waiting:
        waiting.sort(key=_hollow)
        piece = waiting.pop()
        halves = ()
        if _hollow(piece) > allowed and len(waiting) + len(done) + 2 <= MOST_PARTS:
            halves = _halves(piece)
        if halves:
            waiting.extend(halves)
        else:
            done.append(piece)
    parts = [polytope_of(np.asarray(piece.hull().to_mesh().vert_properties)) for piece in done]
    return tuple(part for part in parts if part is not None)


def _plain(body: Manifold) -> Manifold:
    """Return a body with a bounded number of triangles: within hundredths of its size the same."""
    tolerance = FINEST * float(np.ptp(np.reshape(body.bounding_box(), (2, 3)), 0).max())
    while body.num_tri() > MOST_TRIANGLES and tolerance > 0.0:
        body, tolerance = body.simplify(tolerance), 2.0 * tolerance
    return body


def _hollow(piece: Manifold) -> float:
    """Return by how much the hull of a piece is larger, mm³."""
    return float(piece.hull().volume() - piece.volume())


def _halves(piece: Manifold) -> tuple[Manifold, ...]:
    """Return both sides of the best plane through a face at a hollow edge; () without any."""
    best: tuple[Manifold, ...] = ()
    least, kerf = np.inf, KERF * float(np.ptp(np.reshape(piece.bounding_box(), (2, 3)), 0).max())
    for normal, offset in _planes_at_hollow_edges(piece):
        outside = piece.trim_by_plane(normal, offset + kerf)
        inside = piece.trim_by_plane([-x for x in normal], -offset)
        halves = tuple(
            each
            for half in (outside, inside)
            for each in half.decompose()
            if each.volume() > SLIVER * piece.volume()
        )
        left = sum(_hollow(half) for half in halves)
        if len(halves) > 1 and left < least:
            best, least = halves, left
    return best


def _planes_at_hollow_edges(piece: Manifold) -> list[tuple[list[float], float]]:
    """Return the planes of faces at hollow edges, those of the largest faces, each once."""
    mesh = piece.to_mesh()
    places, faces = np.asarray(mesh.vert_properties, float)[:, :3], np.asarray(mesh.tri_verts)
    corners = places[faces]
    areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    sizes = np.linalg.norm(areas, axis=1)
    normals = areas / np.maximum(sizes, 1e-300)[:, None]
    offsets = np.einsum("ij,ij->i", normals, corners[:, 0])
    extent = float(np.ptp(places, axis=0).max())
    sides = np.concatenate((faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]))
    owner = np.tile(np.arange(len(faces)), 3)
    there = {(int(a), int(b)): int(k) for (a, b), k in zip(sides, owner, strict=True)}
    planes: dict[tuple[float, ...], int] = {}
    areas_of: dict[tuple[float, ...], float] = {}
    for (a, b), number in there.items():
        other = there.get((b, a))
        if other is None or sizes[number] == 0.0:
            continue
        above = corners[other] @ normals[number] - offsets[number]
        if above.max() > 1e-4 * extent:
            key = (*normals[number].round(4), round(float(offsets[number]) / extent, 4))
            planes.setdefault(key, number)
            areas_of[key] = areas_of.get(key, 0.0) + float(sizes[number])
    best = sorted(planes, key=lambda key: -areas_of[key])[:MOST_CUTS]
    chosen = [planes[key] for key in best]
    return [(normals[number].tolist(), float(offsets[number])) for number in chosen]


def _fewer(points: Array) -> Array:
    """Return at most `MOST_CORNERS` corners of the hull of points: the farthest to many sides."""
    if len(points) <= MOST_CORNERS:
        return points
    number = np.arange(MOST_CORNERS) + 0.5
    height, turn = 1.0 - 2.0 * number / MOST_CORNERS, np.pi * (1.0 + np.sqrt(5.0)) * number
    flat = np.sqrt(1.0 - height**2)
    ways = np.column_stack((flat * np.cos(turn), flat * np.sin(turn), height))
    return np.asarray(points[np.unique((points @ ways.T).argmax(axis=0))])


def _ring(points: Array, face: Index, normal: Array, numbers: Index) -> tuple[int, ...]:
    """Return the corners of a face in their order, as numbers among those that are kept."""
    away = points[face] - points[face].mean(axis=0)
    across = away[0] / max(float(np.linalg.norm(away[0])), 1e-300)
    turns = np.arctan2(away @ np.cross(normal, across), away @ across)
    return tuple(int(numbers[k]) for k in face[np.argsort(turns)] if numbers[k] >= 0)
