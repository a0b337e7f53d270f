"""Seams: where fillets were united with bodies, triangles are made even and put on the blend."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto.plugin import remembered
from bozzetto_silhouette.implicit.composite import localized, signature
from bozzetto_silhouette.implicit.implicit_solid import Implicit, Sample, sample_each
from bozzetto_silhouette.numerics.grouping import connected_pieces
from bozzetto_silhouette.numerics.isotropic_remeshing import (
    Patch,
    border_edges,
    collapsed,
    dot,
    flipped_edges,
    relaxed,
    unit,
)
from bozzetto_silhouette.solids.batched_answers import each

SLIVER = 0.5
"""Edges shorter than this share of the spacing are collapsed."""

COLLAPSES = 3
"""Rounds of collapsing edges at first."""

EVENINGS = 3
"""Rounds of evening out after that."""

FLIPS = 2
"""Rounds of flipping edges before every relaxation."""

NEWTON = 2
"""Steps of Newton's method where two seams meet."""

MENDED = 2
"""Rings of vertices around such faces that are moved."""

ROUNDS = 6
"""Rounds of mending faces that were turned over, at most."""

STRIDE = 0.4
"""Longest of these steps, as a share of the spacing."""

STILL = 1e-3
"""Length of a step, as a share of the spacing, after which the next would not be felt: steps
become as short as their squares."""

FLATTEST = 0.2
"""Gradients are taken for no shorter than this: between sides that face each other they vanish."""

RINGS = 2
"""Rings of vertices around fillets that may be moved, too."""

MEETING = 2
"""Rings of vertices around those where two seams meet that are made even after both."""

SPREAD = 60
"""Rings at most of those that are not on the blended surface."""

OFF = 0.03
"""Value from which on a vertex is not on it, as a share of its spacing."""

ROOM = 3.0
"""Margin around a seam within which solids matter, in spacings."""

DIFFERENCE = 0.1
"""Width of the difference quotients for normals, as a share of the spacing."""

OVERTURNED = -0.2
"""Cosine between a face and the gradient below which it counts as turned over."""

_TETRAHEDRON = np.array([[1, -1, -1], [-1, -1, 1], [-1, 1, -1], [1, 1, 1.0]]) / np.sqrt(3.0)


class Sewn(NamedTuple):
    """A mesh whose seams were made even.

    Attributes
    ----------
    vertices, normals : (v, 3) float array
    faces : (f, 3) int array
    parents : (v,) int array
        The vertex before that each stands for.
    moved : (v,) bool array
        Those in seams: only they have normals; the others are as they were.
    """

    vertices: Array
    faces: Index
    parents: Index
    moved: Flags
    normals: Array


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
    for zone in _by_number(mesh.faces, of_face):
        mine, inner = _in_order(mesh.vertices, zone)
        local = _around(solid, mesh.vertices[mine], spacing[mine])
        numbers.append(mine)
        zones.append(_Zone(
            mesh.vertices[mine], inner, number[mine] >= 0, spacing[mine], local, evenings
        ))  # fmt: skip
    rest = mesh._replace(faces=mesh.faces[of_face < 0])
    found = each(_even, _evened, zones)
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


def _by_number(rows: Index, number: Index) -> list[Index]:
    """Return the rows of each number in turn, without those below 0."""
    order = np.argsort(number, kind="stable")
    starts = np.searchsorted(number[order], np.unique(number[number >= 0]))
    return np.split(rows[order], starts)[1:]


def _around(solid: Implicit, places: Array, spacing: Array) -> Implicit:
    """Reduce a solid to what matters around places (n, 3): that is faster to evaluate."""
    room = ROOM * float(spacing.max())
    box = np.stack([places.min(axis=0) - room, places.max(axis=0) + room])
    return localized(solid, box, room)


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
    for mine in _by_number(np.arange(len(vertices)), seam):
        place = vertices[mine]
        room = ROOM * float(spacing[mine].max())
        low, high = place.min(axis=0) - room, place.max(axis=0) + room
        near = free[np.searchsorted(x, low[0], "left") : np.searchsorted(x, high[0], "right")]
        near = near[((vertices[near] >= low) & (vertices[near] <= high)).all(axis=1)]
        if len(near):
            near = near[np.lexsort(vertices[near].T)]
            rows.append(near)
            local = _around(solid, vertices[near], spacing[near])
            asked.append(_Places(vertices[near], spacing[near], np.zeros(len(near), bool), local))
    for near, found in zip(rows, each(_is_off, _all_off, asked), strict=True):
        off[near] = found
    return off


class _Places(NamedTuple):
    """Places (n, 3) near a surface, how long edges are there (n,), and where normals are asked."""

    points: Array
    spacing: Array
    facing: Flags
    solid: Implicit


def _asked_at(some: _Places) -> Hashable:
    *arrays, solid = some
    return *(array.tobytes() for array in arrays), signature(solid)


@remembered(limit=512, key=_asked_at)
def _is_off(some: _Places) -> Flags:
    return _all_off([some])[0]


def _all_off(asked: list[_Places]) -> list[Flags]:
    """Mark the places that are not on their surface."""
    ends = np.cumsum([0, *(len(some.points) for some in asked)])
    points = np.concatenate([some.points for some in asked])
    values = sample_each([some.solid for some in asked], points, ends).value
    return [
        np.abs(value) > OFF * some.spacing
        for value, some in zip(np.split(values, ends[1:-1]), asked, strict=True)
    ]


def settled(
    vertices: Array, number: Index, spacing: Array, facing: Flags, solid: Implicit
) -> tuple[Array, Array]:
    """Bring numbered vertices (v,) onto the surface; return all vertices, and normals.

    Each number is worked out by itself, and remembered; -1 is left as it is. Normals are those of
    numbered vertices that are `facing` (v,), which take twice the time; others are 0.
    """
    normals = np.zeros_like(vertices)
    vertices = vertices.copy()
    rows = [
        mine[np.lexsort(vertices[mine].T)]
        for mine in _by_number(np.arange(len(vertices)), number)
    ]  # fmt: skip
    asked = [
        _Places(
            vertices[mine],
            spacing[mine],
            facing[mine],
            _around(solid, vertices[mine], spacing[mine]),
        )
        for mine in rows
    ]
    answers = each(_on_surface, _all_on_surface, asked)
    for mine, found in zip(rows, answers, strict=True):
        vertices[mine], normals[mine] = found
    return vertices, normals


def _all_on_surface(asked: list[_Places]) -> list[tuple[Array, Array]]:
    """Bring places onto surfaces; return them, and the normals that are asked."""
    ends = np.cumsum([0, *(len(some.points) for some in asked)])
    surfaces = _Surfaces([some.solid for some in asked], np.repeat(
        np.arange(len(asked)), np.diff(ends)
    ))  # fmt: skip
    count = int(ends[-1])
    patch = Patch(
        np.concatenate([some.points for some in asked]), np.zeros((0, 3), np.intp),
        np.ones(count, dtype=bool), np.arange(count), np.zeros((count, 3)),
        np.concatenate([some.spacing for some in asked]),
    )  # fmt: skip
    for _ in range(NEWTON):
        before = patch.vertices
        patch = _projected(surfaces, patch)
        step = patch.vertices - before
        patch = replace(patch, free=dot(step, step) > np.square(STILL * patch.spacing))
        if not patch.free.any():
            break
    normals = np.zeros((count, 3))
    facing = np.flatnonzero(np.concatenate([some.facing for some in asked]))
    if len(facing):
        normals[facing] = surfaces.normals(patch.vertices[facing], patch.spacing[facing], facing)
    at = ends[1:-1]
    return list(zip(np.split(patch.vertices, at), np.split(normals, at), strict=True))


@remembered(limit=512, key=_asked_at)
def _on_surface(some: _Places) -> tuple[Array, Array]:
    return _all_on_surface([some])[0]


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


class _Zone(NamedTuple):
    """The mesh around one seam, by itself.

    Attributes
    ----------
    vertices, faces : (v, 3) float array, (f, 3) int array
    free : (v,) bool array
        Those that may be moved.
    spacing : (v,) float array
    solid : Implicit
        Whose surface it is.
    evenings : int
        Rounds of evening it out.
    """

    vertices: Array
    faces: Index
    free: Flags
    spacing: Array
    solid: Implicit
    evenings: int


def _depends_on(zone: _Zone) -> Hashable:
    *arrays, solid, evenings = zone
    return *(array.tobytes() for array in arrays), signature(solid), evenings


@remembered(limit=512, key=_depends_on)
def _even(zone: _Zone) -> Sewn:
    return _evened([zone])[0]


class _Surfaces(NamedTuple):
    """The surfaces that the vertices of a patch belong on.

    Attributes
    ----------
    solids : list of Implicit
    owner : (n,) int array
        The number of its solid by the `parents` of a patch; it never falls.
    """

    solids: list[Implicit]
    owner: Index

    def sample(self, patch: Patch, at: Index) -> Sample:
        """Return values and gradients at some vertices of a patch, each of its own solid."""
        return sample_each(self.solids, patch.vertices[at], self._ends(patch.parents[at]))

    def normals(self, points: Array, spacing: Array, parents: Index) -> Array:
        """Return unit normals, outwards, by differences of the value at a tetrahedron's corners."""
        width = DIFFERENCE * spacing[:, None, None]
        corners = (points[:, None, :] + width * _TETRAHEDRON).reshape(-1, 3)
        values = sample_each(self.solids, corners, 4 * self._ends(parents)).value
        return unit(-values.reshape(-1, 4) @ _TETRAHEDRON)

    def _ends(self, parents: Index) -> Index:
        """Return where in a row of vertices those of each solid begin, and the end of the last."""
        return np.searchsorted(self.owner[parents], np.arange(len(self.solids) + 1))


def _evened(zones: list[_Zone]) -> list[Sewn]:
    """Even out the meshes around some seams, all in as many rounds.

    Where that turns faces over one stays as it was.
    """
    counts = [len(zone.vertices) for zone in zones]
    starts = np.cumsum([0, *counts])
    surfaces = _Surfaces([zone.solid for zone in zones], np.repeat(np.arange(len(zones)), counts))
    free = np.concatenate([zone.free for zone in zones])
    before = Patch(
        np.concatenate([zone.vertices for zone in zones]),
        np.concatenate([zone.faces + start for zone, start in zip(zones, starts, strict=False)]),
        free,
        np.arange(starts[-1]),
        np.zeros((starts[-1], 3)),
        np.concatenate([zone.spacing for zone in zones]),
    )
    slope = surfaces.sample(before, before.parents).gradient
    before = replace(before, normals=-unit(slope))
    patch = _improved(surfaces, before, COLLAPSES)
    for _ in range(zones[0].evenings):
        patch = _improved(surfaces, patch, 1)
    for _ in range(ROUNDS):
        over = patch.faces[patch.facing() <= OVERTURNED]
        if not len(over):
            break
        patch = replace(patch, free=free[patch.parents] & _near(patch, over))
        among = surfaces._replace(owner=surfaces.owner[patch.parents])
        patch = patch.with_loosened(_improved(among, patch.loosened(), 1))
    patch = replace(patch, free=free[patch.parents])
    kept = [
        _better(*pair) for pair in zip(
            _apart(before, surfaces.owner), _apart(patch, surfaces.owner), strict=True
        )
    ]  # fmt: skip
    free = np.concatenate([one.free for one in kept])
    normals = np.zeros((len(free), 3))
    normals[free] = surfaces.normals(
        np.concatenate([one.vertices for one in kept])[free],
        np.concatenate([one.spacing for one in kept])[free],
        np.concatenate([one.parents + k for one, k in zip(kept, starts, strict=False)])[free],
    )
    own = np.split(normals, np.cumsum([len(one.vertices) for one in kept])[:-1])
    return [
        Sewn(one.vertices, one.faces, one.parents, one.free, normal)
        for one, normal in zip(kept, own, strict=True)
    ]


def _apart(patch: Patch, owner: Index) -> list[Patch]:
    """Take a patch apart by what its vertices belong to; parents count within each."""
    count = int(owner[-1]) + 1
    own = owner[patch.parents]
    ends = np.searchsorted(own, np.arange(count + 1))
    first = np.searchsorted(owner, np.arange(count))
    of_face = own[patch.faces[:, 0]]
    faces = np.split(
        patch.faces[np.argsort(of_face, kind="stable")],
        np.cumsum(np.bincount(of_face, minlength=count))[:-1],
    )
    return [
        Patch(
            patch.vertices[a:b], faces[k] - a, patch.free[a:b], patch.parents[a:b] - first[k],
            patch.normals[a:b], patch.spacing[a:b],
        )
        for k, (a, b) in enumerate(pairwise(ends.tolist()))
    ]  # fmt: skip


def _better(before: Patch, patch: Patch) -> Patch:
    """Return a seam that was made even; as it was, where that was worse."""
    worse = (patch.facing() <= OVERTURNED).sum() > (before.facing() <= OVERTURNED).sum()
    if worse or not _fits(before, patch) or not np.isfinite(patch.vertices).all():
        return before
    return patch


def _fits(before: Patch, patch: Patch) -> bool:
    """Whether a patch has the border that it had, so that the mesh around it stays closed."""
    before_ends, ends = (
        np.sort(_border_keys(some, len(before.parents))) for some in (before, patch)
    )
    return np.array_equal(before_ends, ends)


def _border_keys(patch: Patch, count: int) -> Index:
    a, b = border_edges(patch.faces, len(patch.vertices)).T
    keys: Index = patch.parents[a] * count + patch.parents[b]
    return keys


def _near(patch: Patch, faces: Index) -> Flags:
    """Mark the vertices of some faces, and those around them."""
    near = np.zeros(len(patch.vertices), dtype=bool)
    near[faces] = True
    for _ in range(MENDED):
        near[patch.faces[near[patch.faces].any(axis=1)]] = True
    return near


def _improved(surfaces: _Surfaces, patch: Patch, collapses: int) -> Patch:
    """Collapse slivers, flip and relax, and project."""
    patch = relaxed(flipped_edges(collapsed(patch, SLIVER, collapses), FLIPS))
    return _projected(surfaces, patch)


def _projected(surfaces: _Surfaces, patch: Patch) -> Patch:
    """Move free vertices by a damped Newton step; normals come from the gradient."""
    at = np.flatnonzero(patch.free)
    value, gradient, _ = surfaces.sample(patch, at)
    square = np.maximum(dot(gradient, gradient), FLATTEST**2)
    way = value / square
    far = np.abs(way) * np.sqrt(square)
    way *= np.minimum(1.0, STRIDE * patch.spacing[at] / np.maximum(far, 1e-300))
    vertices, normals = patch.vertices.copy(), patch.normals.copy()
    vertices[at] -= way[:, None] * gradient
    normals[at] = -unit(gradient)
    return replace(patch, vertices=vertices, normals=normals)


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
