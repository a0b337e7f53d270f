"""Closed slabs between surfaces and their offsets, and wedges that fill the gaps at creases.

Surfaces that meet in a crease are offset by themselves. On one side of the crease their slabs
overlap, on the other they gape; there an arc about the crease, all of it as far from it as the
slabs are thick, goes between them. At smooth edges both slabs share the corners of their offsets.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags, Index, cross_product
from bozzetto.geometry import Mesh

SMOOTH: Final = float(np.cos(np.radians(10.0)))
"""Cosine between the normals of two surfaces at a place from which on they share its offset."""

BACK: Final = 0.0
"""Cosine between a triangle and its offset below which that looks back."""

LEAN: Final = 0.3
"""Depth in the slab beside it, in thicknesses, to which the wall of a slab over a crease leads."""

KNIFE: Final = 0.05
"""Square of the sine between two surfaces below which they are a blade, and walls stay upright."""

WIDER: Final = 1.0 + 2e-4
"""Factor on the triangles of prisms, so that neighbours overlap and do not only touch."""

ARC_STEP: Final = float(np.radians(11.25))
"""Largest step along an arc about a crease: chords are within half a percent of the radius."""


@dataclass(frozen=True, eq=False)
class Slab:
    """Slab between a surface and its offset.

    Parameters
    ----------
    vertices : (2 n, 3) float
        Those of the surface, then those of the offset, mm.
    faces : (m, 3) int
        Outward; first all of the surface, but for those under prisms.
    kept : int
        How many faces are the surface itself.
    prisms : (k, 6, 3) float
        Corners of what lies over single triangles, where the slab is thicker than the surface's
        radius: it would run into itself.
    """

    vertices: Array
    faces: Index
    kept: int
    prisms: Array


def _prisms(vertices: Array, ways: Array, faces: Index) -> Array:
    """Return the corners of the slab over each triangle, (k, 6, 3)."""
    corners = np.stack((vertices[faces], (vertices + ways)[faces]), axis=1)
    middles = corners.mean(axis=2, keepdims=True)
    return np.asarray((middles + WIDER * (corners - middles)).reshape(-1, 6, 3))


def _near_turned(vertices: Array, ways: Array, faces: Index) -> Flags:
    """Return which triangles are within the thickness of one whose offset looks back, (m,) bool."""
    one, other = _across(vertices[faces]), _across((vertices + ways)[faces])
    lengths = np.linalg.norm(one, axis=1) * np.linalg.norm(other, axis=1)
    turned = np.asarray((one * other).sum(axis=1) < BACK * lengths)
    if not turned.any():
        return turned
    from scipy.spatial import cKDTree

    used = np.unique(faces[turned])
    thickness = float(np.linalg.norm(ways[used], axis=1).max())
    away = np.asarray(cKDTree(vertices[used]).query(vertices)[0])
    return np.asarray((away <= thickness)[faces].any(axis=1))


def _across(corners: Array) -> Array:
    return cross_product(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])


@dataclass(frozen=True, eq=False)
class Sheets:
    """Surfaces that hang together, by their meshes.

    Parameters
    ----------
    vertices : tuple of (n, 3) float
        Of each mesh, mm.
    normals : tuple of (n, 3) float
        Unit; the same numbers in all meshes at a smooth edge.
    faces : tuple of (m, 3) int
    places : tuple of (n,) int
        Number of the place of each vertex: the same for vertices at one place.
    """

    vertices: tuple[Array, ...]
    normals: tuple[Array, ...]
    faces: tuple[Index, ...]
    places: tuple[Index, ...]

    @classmethod
    def of(cls, meshes: Sequence[Mesh], turn: Array) -> Sheets:
        """Bring meshes with vertices at the very same places on common edges together.

        Parameters
        ----------
        meshes : sequence of Mesh
            Turned alike.
        turn : (3, 3) float
            Rotation by which they are turned.
        """
        starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
        vertices = np.concatenate([mesh.vertices for mesh in meshes])
        normals = np.concatenate([mesh.vertex_normals() for mesh in meshes]).astype(float)
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
        _, places = np.unique(vertices, axis=0, return_inverse=True)
        places = places.ravel()
        normals = _shared_normals(normals, places)
        split = starts[1:-1]
        return cls(
            tuple(np.split(vertices.astype(float) @ turn.T, split)),
            tuple(np.split(normals @ turn.T, split)),
            tuple(mesh.faces.astype(np.intp) for mesh in meshes),
            tuple(np.split(places, split)),
        )


def _shared_normals(normals: Array, places: Index) -> Array:
    """Return normals, those at one place that are nearly the same made equal."""
    made = normals.copy()
    order = np.argsort(places, kind="stable")
    counts = np.bincount(places)
    starts = np.concatenate(([0], np.cumsum(counts)))
    for place in np.flatnonzero(counts > 1):
        waiting = order[starts[place] : starts[place + 1]].tolist()
        while waiting:
            group = [waiting.pop()]
            for one in group:
                near = [other for other in waiting if normals[one] @ normals[other] >= SMOOTH]
                group += near
                waiting = [other for other in waiting if other not in near]
            mean = normals[group].sum(axis=0)
            made[group] = mean / max(float(np.linalg.norm(mean)), 1e-300)
    return made


def slabs_of(sheets: Sheets, offset: float, *, lean: bool) -> list[Slab]:
    """Return the slab of each surface.

    Parameters
    ----------
    sheets : Sheets
        The surfaces.
    offset : float
        mm; positive to the side of the normals.
    lean : bool
        Whether walls over creases lean into one another, so that none stands out. A body that the
        slabs are taken from needs none of that.
    """
    ways = [offset * normals for normals in sheets.normals]
    for one, two in _creases(sheets) if lean else ():
        if _gapes(sheets, one, two, offset):
            continue
        for own, other in ((one, two), (two, one)):
            _lean(sheets, ways, own, other, offset)
    rows = zip(sheets.vertices, ways, sheets.faces, sheets.places, strict=True)
    return [_slab(*row, offset < 0.0) for row in rows]


Use = tuple[int, int, int]
"""A side of a triangle at the border of a mesh: the number of the mesh, and two vertices."""


def _creases(sheets: Sheets) -> list[tuple[Use, Use]]:
    """Return sides at which two surfaces meet whose normals differ, from the same end each."""
    ends: dict[tuple[int, int], list[Use]] = {}
    for number, (faces, places) in enumerate(zip(sheets.faces, sheets.places, strict=True)):
        for start, end in border_sides(faces).tolist():
            a, b = int(places[start]), int(places[end])
            ends.setdefault((min(a, b), max(a, b)), []).append((number, start, end))
    found = []
    for uses in ends.values():
        for one, (second, c, d) in itertools.pairwise(uses):
            if sheets.places[one[0]][one[1]] != sheets.places[second][c]:
                c, d = d, c
            here, there = sheets.normals[one[0]][[*one[1:]]], sheets.normals[second][[c, d]]
            if (here != there).any():
                found.append((one, (second, c, d)))
    return found


def _gapes(sheets: Sheets, one: Use, two: Use, offset: float) -> bool:
    """Whether slabs leave a gap between them; else they overlap."""
    ends = sheets.vertices[one[0]][[*one[1:]]]
    here, there = (sheets.normals[use[0]][[*use[1:]]].sum(axis=0) for use in (one, two))
    return bool(offset * float(cross_product(here, ends[1] - ends[0]) @ there) < 0.0)


def _lean(sheets: Sheets, ways: list[Array], own: Use, other: Use, offset: float) -> None:
    """Have the wall of a slab over a crease lean into the other slab, so that none stands out.

    The offset keeps its distance from its own surface.
    """
    sense = float(np.sign(offset))
    for vertex, near in zip(own[1:], other[1:], strict=True):
        normal, beside = sheets.normals[own[0]][vertex], sheets.normals[other[0]][near]
        missing = LEAN * abs(offset) - sense * float(ways[own[0]][vertex] @ beside)
        along = beside - float(beside @ normal) * normal
        square = float(along @ along)
        if missing > 0.0 and square > KNIFE:
            ways[own[0]][vertex] += sense * missing / square * along


def _slab(vertices: Array, ways: Array, faces: Index, places: Index, inward: bool) -> Slab:
    """Return a slab; surfaces on both sides of an edge cut the wall over it along one diagonal."""
    near = _near_turned(vertices, ways, faces)
    prisms = _prisms(vertices, ways, faces[near])
    faces = faces[~near]
    count = len(vertices)
    start, end = border_sides(faces).T
    swap = places[start] > places[end]
    low, high = np.where(swap, end, start), np.where(swap, start, end)
    walls = np.stack(
        (
            np.column_stack((high, low, low + count)),
            np.column_stack((high, low + count, high + count)),
        )
    )
    walls[:, swap] = walls[:, swap, ::-1]
    walls = walls.reshape(-1, 3)
    every = np.concatenate((faces, faces[:, ::-1] + count, walls))
    every = every if inward else every[:, ::-1]
    return Slab(np.concatenate((vertices, vertices + ways)), every, len(faces), prisms)


def border_sides(faces: Index) -> Index:
    """Return the sides of triangles that no other triangle runs the other way, (k, 2)."""
    sides = np.concatenate([faces[:, [k, (k + 1) % 3]] for k in range(3)])
    count = int(faces.max(initial=0)) + 1
    there = sides[:, 0] * count + sides[:, 1]
    back = sides[:, 1] * count + sides[:, 0]
    return np.asarray(sides[~np.isin(there, back)])


def wedges_of(sheets: Sheets, offset: float) -> list[Array]:
    """Return the corners of convex wedges in the gaps between slabs, each (n, 3) mm."""
    made: list[Array] = []
    nodes: dict[int, Array] = {}
    for one, two in _creases(sheets):
        if _gapes(sheets, one, two, offset):
            made.append(_wedge(sheets, one, two, offset))
            for vertex in one[1:]:
                nodes[int(sheets.places[one[0]][vertex])] = sheets.vertices[one[0]][vertex]
    return made + _corners(sheets, nodes, offset)


def _wedge(sheets: Sheets, one: Use, two: Use, offset: float) -> Array:
    """Return the wedge between two slabs along a side of their meshes."""
    ends = sheets.vertices[one[0]][[*one[1:]]]
    here, there = sheets.normals[one[0]][[*one[1:]]], sheets.normals[two[0]][[*two[1:]]]
    inward = _unit(cross_product(here[0] + here[1], ends[1] - ends[0]))
    beside = _unit(cross_product(there[0] + there[1], ends[0] - ends[1]))
    away = -_unit(inward + beside)
    sense = float(np.sign(offset))
    rows = [ends]
    for end, m, n in zip(ends, sense * here, sense * there, strict=True):
        rows.append(end + abs(offset) * _arc(m, n, away))
    return np.concatenate(rows)


def _arc(first: Array, second: Array, middle: Array) -> Array:
    """Return unit vectors from one to another, over a third where they are nearly opposite."""
    cosine = float(np.clip(first @ second, -1.0, 1.0))
    if cosine < -0.99:
        return np.concatenate((_arc(first, middle, first), _arc(middle, second, second)))
    angle = float(np.arccos(cosine))
    if angle < 1e-6:
        return np.array([first, second])
    share = np.linspace(0.0, 1.0, int(np.ceil(angle / ARC_STEP)) + 1)[:, None]
    return np.asarray(
        (np.sin((1.0 - share) * angle) * first + np.sin(share * angle) * second) / np.sin(angle)
    )


def _corners(sheets: Sheets, nodes: dict[int, Array], offset: float) -> list[Array]:
    """Return wedges at places where more than two normals meet and a gap ends."""
    normals: dict[int, set[tuple[float, ...]]] = {}
    for places, own in zip(sheets.places, sheets.normals, strict=True):
        for vertex in np.flatnonzero(np.isin(places, list(nodes))):
            normals.setdefault(int(places[vertex]), set()).add(tuple(own[vertex].tolist()))
    made = []
    for place, found in sorted(normals.items()):
        ways = np.sign(offset) * np.array(sorted(found))
        if len(ways) < 3:
            continue
        arcs = [_arc(m, n, m) for k, m in enumerate(ways) for n in ways[:k] if m @ n > -0.9]
        round_it = np.concatenate([ways, *arcs])
        made.append(np.concatenate((nodes[place][None], nodes[place] + abs(offset) * round_it)))
    return made


def _unit(vector: Array) -> Array:
    return np.asarray(vector / max(float(np.linalg.norm(vector)), 1e-300))
