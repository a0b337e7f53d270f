"""Where a surface is cut into pieces: along creases, between front and back, and across limbs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from bozzetto.geometry.atlas.chart_flattening import Piece

if TYPE_CHECKING:
    from bozzetto.arrays import Array, Flags, Index

CREASE: Final = float(np.cos(np.radians(50.0)))
"""Cosine of the angle between two faces from which their edge is a crease."""

LEAST: Final = 0.004
"""Share of the surface from which a part within creases counts."""

MOST_CRUMBS: Final = 0.1
"""Share of the surface in smaller parts above which its creases are no borders."""

TILT: Final = 0.08
"""How far the border between front and back may be off where the surface turns, in components of
the normal. Farther would be shorter, but what reaches around the rim covers itself laid flat."""

FIRM: Final = 0.25
"""The same from which a part is of its side however small it is."""

ISLAND: Final = 0.03
"""Share of what is cut below which a part of one side joins the other."""

CRUMB: Final = 0.1
"""Share of that below which it does so however firm it is."""

FRONT: Final = np.array([0.0, 1.0, 0.0])
"""What is drawn from the front has its sides along this axis."""

NEARLY: Final = 0.95
"""Share of the best axis from which the front's is as good."""

DIGITS: Final = 8
"""Decimals of a piece's size that count where it is cut."""

BAND: Final = 0.04
"""How far the border may be off the straight cut, as a share of the piece's size."""


class Surface:
    """A mesh with what cutting it needs.

    Parameters
    ----------
    vertices : (v, 3) float array
    faces : (f, 3) int array

    Attributes
    ----------
    normals : (f, 3) float array
        Of the length one, or zero.
    areas : (f,) float array
    beyond : (f, 3) int array
        The face beyond each edge; -1 where there is none or more than one.
    lengths : (f, 3) float array
        Of the edges.
    """

    def __init__(self, vertices: Array, faces: Index) -> None:
        self.vertices, self.faces = vertices, faces
        corners = vertices[faces]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        size = np.linalg.norm(normals, axis=1)
        self.areas: Array = 0.5 * size
        self.normals: Array = normals / np.maximum(size, 1e-300)[:, None]
        self.lengths: Array = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
        self.beyond = _beyond(faces)

    def piece(self, face: Index) -> Piece:
        """Return some faces with vertices of their own: one for each fan of faces around it."""
        count = len(self.faces)
        place = np.full(count + 1, -1)
        place[face] = np.arange(len(face))
        beyond = place[self.beyond[face]]
        own, side = np.nonzero(beyond >= 0)
        other = beyond[own, side]
        triangles = self.faces[face]
        corner = np.arange(3 * len(face)).reshape(-1, 3)
        # The edge runs the other way in the face beyond it.
        there = np.argmax(triangles[other] == triangles[own, side][:, None], axis=1)
        after = np.argmax(triangles[other] == triangles[own, (side + 1) % 3][:, None], axis=1)
        ends = np.concatenate([corner[own, side], corner[own, (side + 1) % 3]])
        starts = np.concatenate([corner[other, there], corner[other, after]])
        label = _pieces(ends, starts, corner.size)
        _, first, number = np.unique(label, return_index=True, return_inverse=True)
        points = self.vertices[triangles.ravel()[first]]
        return Piece(face, points, number.reshape(-1, 3).astype(np.intp))

    def parts(self, face: Index, label: Index) -> list[Index]:
        """Return the connected parts of some faces, of one label (f,) each."""
        place = np.full(len(self.faces) + 1, -1)
        place[face] = np.arange(len(face))
        beyond = place[self.beyond[face]]
        own, side = np.nonzero(beyond >= 0)
        other = beyond[own, side]
        alike = label[own] == label[other]
        number = _pieces(own[alike], other[alike], len(face))
        return [face[part] for part in _grouped(number)]

    def regions(self) -> list[Index]:
        """Return the parts of the surface within its creases; crumbs join a part beside them."""
        every = np.arange(len(self.faces))
        own, side = np.nonzero(self.beyond >= 0)
        other = self.beyond[own, side]
        joined = _pieces(own, other, len(every))
        smooth = np.einsum("fd,fd->f", self.normals[own], self.normals[other]) > CREASE
        number = _pieces(own[smooth], other[smooth], len(every))
        size = np.bincount(number, self.areas)
        small = size < LEAST * self.areas.sum()
        if size[small].sum() > MOST_CRUMBS * self.areas.sum():
            return _grouped(joined)
        return _grouped(self._without_crumbs(number, LEAST * float(self.areas.sum())))

    def _without_crumbs(self, number: Index, least: float) -> Index:
        """Join each part smaller than this to the one along most of its border, if there is."""
        own, side = np.nonzero(self.beyond >= 0)
        other, length = self.beyond[own, side], self.lengths[own, side]
        for _ in range(8):
            size = np.bincount(number, self.areas)
            cut = number[own] != number[other]
            pairs = number[own[cut]] * np.int64(len(size)) + number[other[cut]]
            keys, place = np.unique(pairs, return_inverse=True)
            share = np.bincount(place, length[cut])
            one, two = keys // len(size), keys % len(size)
            order = np.lexsort((two, -share, one))
            first = order[np.unique(one[order], return_index=True)[1]]
            joins = np.arange(len(size))
            small = (size[one[first]] < least) & (
                (size[two[first]] > size[one[first]])
                | ((size[two[first]] == size[one[first]]) & (two[first] < one[first]))
            )
            if not small.any():
                break
            joins[one[first][small]] = two[first][small]
            number = joins[number]
            _, number = np.unique(number, return_inverse=True)
        return number

    def by_sides(self, face: Index) -> list[Index]:
        """Cut between what looks to one side and what looks to the other."""
        normals, areas = self.normals[face], self.areas[face]
        mean = (areas[:, None] * normals).sum(axis=0) / max(float(areas.sum()), 1e-300)
        spread = normals - mean
        matrix = (areas[:, None] * spread).T @ spread
        axis = np.linalg.eigh(matrix)[1][:, -1]
        if FRONT @ matrix @ FRONT >= NEARLY * float(axis @ matrix @ axis):
            axis = FRONT
        axis = axis * np.sign(axis[np.abs(axis).argmax()])
        ahead = spread @ axis
        parts = self._cut(face, ahead, TILT, FIRM)
        return parts if len(parts) > 1 else self.parts(face, (ahead > 0.0).astype(np.intp))

    def across(self, face: Index, ahead: Array) -> list[Index]:
        """Cut where `ahead` (f,) changes its sign, in shares of the piece's size.

        All stay together where one side is crumbs only.
        """
        return self._cut(face, np.round(ahead, DIGITS), BAND, np.inf)

    def _mean(self, values: Array, face: Index) -> float:
        """Return the mean of values (f,) over some faces, by their areas."""
        size = self.areas[face]
        return float(values @ size) / max(float(size.sum()), 1e-300)

    def _cut(self, face: Index, ahead: Array, band: float, firm: float) -> list[Index]:
        """Cut where `ahead` (f,) changes its sign, but for where a detour is shorter.

        Small parts whose mean is less than `firm` join the other side.
        """
        place = np.full(len(self.faces) + 1, -1)
        place[face] = np.arange(len(face))
        beyond = place[self.beyond[face]]
        side = ahead > 0.0
        near = np.abs(ahead) < band
        if side[~near].any() and not side[~near].all():
            own, edge = np.nonzero((beyond >= 0) & near[:, None])
            length = self.lengths[face][own, edge]
            if len(own):
                side = shortest_cut(own, beyond[own, edge], length, near, side)
        for _ in range(8):
            parts = self.parts(face, side.astype(np.intp))
            least = ISLAND * float(self.areas[face].sum())
            small = [
                part for part in parts
                if (size := float(self.areas[part].sum())) < least
                and (size < CRUMB * least or self._mean(np.abs(ahead[place[part]]), part) < firm)
            ]  # fmt: skip
            if not small or len(small) == len(parts):
                break
            for part in small:
                side[place[part]] = ~side[place[part]]
        return self.parts(face, side.astype(np.intp))


def shortest_cut(own: Index, other: Index, length: Array, near: Flags, side: Flags) -> Flags:
    """Return the sides of faces, (f,), such that the border between them is the shortest.

    Parameters
    ----------
    own, other : (e,) int array
        Faces near the border, and what is beyond their edges.
    length : (e,) float array
        Of these edges.
    near : (f,) bool array
        Faces that may change sides.
    side : (f,) bool array
        On which side the others are.
    """
    from scipy.sparse import coo_array, csr_array
    from scipy.sparse.csgraph import breadth_first_order, maximum_flow

    place = np.full(len(near), -1)
    place[near] = np.arange(int(near.sum()))
    source, sink = int(near.sum()), int(near.sum()) + 1
    start = place[own]
    end = np.where(near[other], place[other], np.where(side[other], source, sink))
    room = np.maximum(1, np.rint(length / float(length.max()) * 1e4)).astype(np.int32)
    both = np.concatenate([start, end]), np.concatenate([end, start])
    inner = near[other]
    room = np.concatenate([room, np.where(inner, 0, room)])
    graph = csr_array(coo_array((room, both), shape=(sink + 1, sink + 1)))
    graph.sum_duplicates()
    left = graph - maximum_flow(graph, source, sink).flow
    left.eliminate_zeros()
    reached = np.zeros(sink + 1, bool)
    reached[breadth_first_order(left, source, return_predecessors=False)] = True
    found = side.copy()
    found[near] = reached[:source]
    return found


def _beyond(faces: Index) -> Index:
    begin, end = faces.astype(np.int64), np.roll(faces, -1, axis=1).astype(np.int64)
    count = np.int64(faces.max(initial=0)) + 1
    forth, back = (begin * count + end).ravel(), (end * count + begin).ravel()
    order = np.argsort(forth, kind="stable")
    ordered = forth[order]
    first = np.searchsorted(ordered, back)
    once = np.searchsorted(ordered, back, side="right") == first + 1
    alone = np.searchsorted(ordered, forth, side="right") == np.searchsorted(ordered, forth) + 1
    partner = order[np.minimum(first, len(order) - 1)]
    beyond: Index = np.where(once & alone, partner // 3, -1).reshape(-1, 3)
    own = np.arange(len(faces))[:, None]
    return np.where(beyond == own, -1, beyond)


def _pieces(one: Index, other: Index, count: int) -> Index:
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    graph = coo_array((np.ones(len(one), np.int8), (one, other)), shape=(count, count))
    return np.asarray(connected_components(graph, directed=False)[1], np.intp)


def _grouped(number: Index) -> list[Index]:
    order = np.argsort(number, kind="stable")
    return np.split(order, np.flatnonzero(np.diff(number[order])) + 1)
