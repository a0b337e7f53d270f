"""Triangles that are collapsed, split and flipped one by one; their topology stays."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from bozzetto.geometry.quads.surface import edges_of

if TYPE_CHECKING:
    from collections.abc import Iterable

    from bozzetto.arrays import Array, Flags, Index


class TriangleGraph:
    """A mesh of triangles under change.

    Parameters
    ----------
    points : (n, 3) float
    faces : (f, 3) int
        No edge has more than two of them, unless it is a feature: such edges stay.
    kind : (f,) int
        Group of each triangle.
    features : (k, 2) int
        Edges that stay edges: they are neither flipped nor left.
    corner : (n,) bool
        Vertices that stay where they are.
    """

    def __init__(
        self, points: Array, faces: Index, kind: Index, features: Index, corner: Flags
    ) -> None:
        self.places: list[tuple[float, ...]] = [tuple(row) for row in points.tolist()]
        self.faces: dict[int, tuple[int, int, int]] = {
            number: (a, b, c) for number, (a, b, c) in enumerate(faces.tolist())
        }
        self.kind: list[int] = kind.tolist()
        self.around: list[set[int]] = [set() for _ in self.places]
        self.near: list[set[int]] = [set() for _ in self.places]
        for number, (a, b, c) in self.faces.items():
            for vertex, one, other in ((a, b, c), (b, c, a), (c, a, b)):
                self.around[vertex].add(number)
                self.near[vertex].add(one)
                self.near[vertex].add(other)
        self.features: list[set[int]] = [set() for _ in self.places]
        for a, b in features.tolist():
            self.features[a].add(b)
            self.features[b].add(a)
        self.corner: list[bool] = corner.tolist()
        sides = edges_of(faces)
        self.border: list[bool] = [False] * len(self.places)
        for vertex in sides.ends[sides.faces[:, 1] < 0].ravel().tolist():
            self.border[vertex] = True

    def rows(self) -> tuple[Index, Index]:
        """Return all triangles, (f, 3), and their groups, (f,)."""
        kind = np.array([self.kind[number] for number in self.faces], np.intp)
        return np.array(list(self.faces.values()), np.intp).reshape(-1, 3), kind

    def ring(self, face: int, a: int, b: int) -> int:
        """Return the third vertex of a face."""
        p, q, r = self.faces[face]
        return p + q + r - a - b

    def may_collapse(self, gone: int, kept: int) -> bool:
        """Whether a vertex may go onto its neighbour so that topology and features stay.

        Both have as many neighbours in common as the edge has triangles (link condition; Dey,
        Edelsbrunner, Guha, Nekhayev 1999), and no two triangles remain alone.
        """
        if self.corner[gone]:
            return False
        if self.features[gone] and kept not in self.features[gone]:
            return False
        shared = self.around[gone] & self.around[kept]
        if len(shared) > 2:
            return False
        if len(self.near[gone] & self.near[kept]) != len(shared):
            return False
        if self.features[gone] and (self.features[gone] & self.features[kept]):
            return False  # the last triangle within a ring of features
        for face in shared:
            third = self.ring(face, gone, kept)
            if len(self.around[third]) <= (1 if self.border[third] else 3):
                return False
        left = len(self.around[gone]) + len(self.around[kept]) - 2 * len(shared)
        return left >= (1 if self.border[kept] else 3)

    def collapse(self, gone: int, kept: int) -> None:
        """Move a vertex onto its neighbour."""
        for face in self.around[gone] & self.around[kept]:
            for vertex in self.faces.pop(face):
                self.around[vertex].discard(face)
        for face in self.around[gone]:
            a, b, c = self.faces[face]
            self.faces[face] = (
                kept if a == gone else a,
                kept if b == gone else b,
                kept if c == gone else c,
            )
            self.around[kept].add(face)
        self.around[gone] = set()
        for other in self.near[gone]:
            self.near[other].discard(gone)
            if other != kept:
                self.near[other].add(kept)
                self.near[kept].add(other)
        self.near[gone] = set()
        for other in self.features[gone]:
            self.features[other].discard(gone)
            if other != kept:
                self.features[other].add(kept)
                self.features[kept].add(other)
        self.features[gone] = set()

    def may_flip(self, a: int, b: int) -> tuple[int, int, int, int] | None:
        """Return both triangles of an edge and their third vertices, if it may be flipped."""
        if b in self.features[a]:
            return None
        shared = self.around[a] & self.around[b]
        if len(shared) != 2:
            return None
        one, other = sorted(shared)
        c, d = self.ring(one, a, b), self.ring(other, a, b)
        if c == d or d in self.near[c]:
            return None
        if self.kind[one] != self.kind[other]:
            return None
        if any(len(self.around[v]) <= (1 if self.border[v] else 3) for v in (a, b)):
            return None
        return one, other, c, d

    def flip(self, a: int, b: int, found: tuple[int, int, int, int]) -> None:
        """Flip an edge, as `may_flip` has found it."""
        one, other, c, d = found
        row = self.faces[one]
        if row[(row.index(a) + 1) % 3] != b:
            a, b = b, a  # one runs from a to b
        self.faces[one], self.faces[other] = (a, d, c), (d, b, c)
        self.around[b].discard(one)
        self.around[d].add(one)
        self.around[a].discard(other)
        self.around[c].add(other)
        self.near[a].discard(b)
        self.near[b].discard(a)
        self.near[c].add(d)
        self.near[d].add(c)

    def split(self, a: int, b: int, place: Iterable[float]) -> int:
        """Put a new vertex into an edge; return it."""
        new = len(self.places)
        self.places.append(tuple(place))
        self.around.append(set())
        self.near.append({a, b})
        self.features.append(set())
        self.corner.append(False)
        self.border.append(len(self.around[a] & self.around[b]) == 1)
        for one, other in ((a, b), (b, a)):
            self.near[one].discard(other)
            self.near[one].add(new)
        for face in list(self.around[a] & self.around[b]):
            row = self.faces[face]
            number = len(self.kind)
            self.kind.append(self.kind[face])
            self.faces[face] = tuple(new if v == b else v for v in row)  # type: ignore[assignment]
            self.faces[number] = tuple(new if v == a else v for v in row)  # type: ignore[assignment]
            third = self.ring(face, a, new)
            self.around[b].discard(face)
            self.around[b].add(number)
            self.around[new].update((face, number))
            self.around[third].add(number)
            self.near[third].add(new)
            self.near[new].add(third)
        if b in self.features[a]:
            self.features[a].discard(b)
            self.features[b].discard(a)
            for end in (a, b):
                self.features[end].add(new)
                self.features[new].add(end)
        return new

    def as_arrays(self) -> tuple[Array, Index, Index, Index, Index]:
        """Return points, faces, their groups, feature edges, and the old number of each point."""
        rows, kind = self.rows()
        used, corners = np.unique(rows, return_inverse=True)
        points = np.array(self.places, float)[used]
        place = np.full(len(self.places), -1)
        place[used] = np.arange(len(used))
        pairs = [(a, b) for a, near in enumerate(self.features) for b in near if a < b]
        lines = place[np.array(pairs, np.intp).reshape(-1, 2)]
        return points, corners.reshape(-1, 3).astype(np.intp), kind, lines, used
