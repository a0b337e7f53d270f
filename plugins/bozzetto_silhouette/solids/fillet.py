"""The fillet: around the crease of a sharp mesh the surface of the blended solid.

The sharp mesh has the topology and all detail. Only where the blend matters are its triangles
remeshed, fine enough for the fillet, and moved onto the zero set of the blended solid. Where
that fails the blend is held back, in the function as in the mesh, and tried again.
"""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto.plugin import remembered
from bozzetto_silhouette.implicit.composite import Composite, Sides, signature
from bozzetto_silhouette.inflation.solidify import Checkpoint, ignore
from bozzetto_silhouette.numerics.grouping import connected_pieces
from bozzetto_silhouette.numerics.isotropic_remeshing import (
    Patch,
    collapsed,
    dot,
    flipped_edges,
    relaxed,
    split,
    unit,
)

_ATTEMPTS = 5
"""How often a crease is tried, each time with less of the blend where the last one failed."""

_RETREAT = 0.4
"""Share of the blend that is left at a place that failed, each time."""

_LEAST = 0.1
"""Shares of the blend below this are not tried: there the crease stays sharp."""

_NONE = 1e-3
"""The share of the blend that is left there: none would divide by zero."""

_AROUND = 2.5
"""How far around a place that failed less is blended, in reaches."""

_FINENESS = 0.35
"""Longest edge in the fillet as a share of the reach: a quarter circle gets about five, with a
sag of 1.5 % of its radius."""

_FINEST = 0.6
"""The same as a share of the mesh's spacing, at least: smaller fillets are not seen."""

_SLIVER = 0.55
"""Edges shorter than this share of the shorter of the longest edge and the mesh's own spacing
are collapsed. Half of the longest would undo what was just split."""

_STAGES = (0.4, 0.75, 1.0)
"""The reach grows by stages, so that no vertex has far to go at once."""

_SMOOTHINGS = 2
"""Rounds of relaxation after every stage."""

_COLLAPSES = 2
"""Rounds of collapsing edges before every relaxation."""

_FLIPS = 1
"""Rounds of flipping edges before every relaxation."""

_NOTICEABLE = 1e-3
"""Least amount that the blend adds, as a share of the reach, where vertices are set free."""

_NEWTON = 3
"""Steps of Newton's method at the end of the last stage; the others need not be exact."""

_STRIDE = 0.15
"""Longest of these steps, as a share of the reach."""

_FLATTEST = 0.2
"""Gradients are taken for no shorter than this: between sides that face each other they vanish."""

_BEYOND = 2.0
"""Values that a fillet meets, in reaches: those beyond are not blended."""

_RINGS = 2
"""Rings of vertices around those that the blend tells on which may be moved, too."""

_HOPELESS = 0.05
"""Share of faces turned over from which on nothing more is tried."""

_REPAIRS = 3
"""Rounds of mending faces that were turned over."""

_COMBINGS = 6
"""Relaxations of what is around such faces in every round."""

_LEFT = 0.02
"""Largest blended value that may be left at a vertex, as a share of the reach."""

_OVERTURNED = -0.2
"""Cosine between a face and the gradient below which it counts as turned over."""


class Fillet(NamedTuple):
    """A mesh with its fillets.

    Attributes
    ----------
    vertices : (v, 3) float array
    faces : (f, 3) int array
    parents : (v,) int array
        The vertex of the sharp mesh that each stands for or came from.
    moved : (v,) bool array
        Those that lie in fillets; the others are as they were.
    solid : Composite
        The blended solid that the mesh is the surface of, with its blend held back where the
        whole of it found no place.
    """

    vertices: Array
    faces: Index
    parents: Index
    moved: Flags
    solid: Composite


def filleted(
    vertices: Array,
    faces: Index,
    solid: Composite,
    step: float,
    checkpoint: Checkpoint = ignore,
) -> Fillet:
    """Bring the mesh of the sharp operation onto the blended solid.

    Every crease is done by itself. Where its fillet finds no place, as where it would be larger
    than what it joins, it is tried with less around there, and at last stays sharp there.

    Parameters
    ----------
    vertices, faces : (v, 3) float array, (f, 3) int array
        Of the sharp operation.
    solid : Composite
        With a blend above 0.
    step : float
        Spacing of the finer of the two meshes.
    checkpoint : callable
        Called with (fraction, step) between steps; may raise `Cancelled`.
    """
    near = _in_place(solid, vertices)
    crease = _creases(near, vertices, faces)
    of_face = crease[faces].max(axis=1, initial=-1)
    parts = []
    for number in np.unique(of_face[of_face >= 0]):
        zone = faces[of_face == number]
        local = _in_place(near, vertices[np.unique(zone)])
        numbers, inner = _in_order(vertices, zone)
        parts.append((numbers, _made(vertices[numbers], inner, local, step, checkpoint)))
    return _set_in(vertices, faces[of_face < 0], parts, solid)


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
    first = inner.argmin(axis=1) if len(inner) else np.zeros(0, np.intp)
    inner = np.take_along_axis(inner, (first[:, None] + np.arange(3)) % 3, axis=1)
    return numbers, inner[np.lexsort(inner.T)]


def _set_in(
    vertices: Array, rest: Index, parts: list[tuple[Index, Fillet]], solid: Composite
) -> Fillet:
    """Put fillets, each of some vertices (by number) of a mesh, into the rest of that mesh."""
    count = len(vertices)
    rows: list[Index] = [rest]
    points: list[Array] = [vertices]
    parents: list[Index] = [np.arange(count)]
    limiter = solid.limiter
    for numbers, part in parts:
        number = numbers[part.parents]
        number[part.moved] = count + np.arange(part.moved.sum())
        count += int(part.moved.sum())
        rows.append(number[part.faces])
        points.append(part.vertices[part.moved])
        parents.append(numbers[part.parents[part.moved]])
        limiter = limiter.joined(part.solid.limiter)
    every, parent = np.concatenate(rows), np.concatenate(parents)
    place: Array = np.concatenate(points)
    used = np.zeros(count, dtype=bool)
    used[every] = True
    rank = np.cumsum(used) - 1
    moved = np.arange(count) >= len(vertices)
    return Fillet(
        place[used], rank[every], parent[used], moved[used], replace(solid, limiter=limiter)
    )


def _depends_on(
    vertices: Array, faces: Index, solid: Composite, step: float, checkpoint: Checkpoint
) -> Hashable:
    """Return what a fillet depends on: its crease, and what is blended there.

    Where nothing changed, it is the same, whatever was done to the rest of the tree.
    """
    return signature(solid), step, vertices.tobytes(), faces.tobytes()


@remembered(limit=512, key=_depends_on)
def _made(
    vertices: Array, faces: Index, solid: Composite, step: float, checkpoint: Checkpoint
) -> Fillet:
    """Make the fillet of a mesh that is only the surroundings of one crease."""
    may = _creases(solid, vertices, faces) >= 0
    for attempt in range(_ATTEMPTS):
        checkpoint(0.4 + 0.5 * attempt / _ATTEMPTS, "blend")
        patch = _rounded(_patch(vertices, faces), may, solid, step)
        bad = _bad(solid, patch)
        if not bad.any():
            return Fillet(patch.vertices, patch.faces, patch.parents, patch.free, solid)
        solid = _held_back(solid, patch.vertices[bad], step, _RETREAT)
    solid = _held_back(solid, vertices[may], step, 0.0)
    unmoved = np.zeros(len(vertices), dtype=bool)
    return Fillet(vertices, faces, np.arange(len(vertices)), unmoved, solid)


def _in_place(solid: Composite, vertices: Array) -> Composite:
    """Reduce the solid to what matters where it is blended: that is faster to evaluate."""
    felt = vertices[solid.felt(vertices)]
    if not len(felt):
        return solid
    box = np.stack([felt.min(axis=0) - solid.reach, felt.max(axis=0) + solid.reach])
    return solid.within(box, _BEYOND * solid.reach)


def _creases(solid: Composite, vertices: Array, faces: Index) -> Index:
    """Return for every vertex that the blend may move the number of its crease, else -1."""
    felt = np.flatnonzero(solid.felt(vertices))
    may = np.zeros(len(vertices), dtype=bool)
    may[felt] = _blend_matters(solid, solid.sides(vertices[felt]))
    for _ in range(_RINGS):
        may[faces[may[faces].any(axis=1)]] = True
    a, b = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    inner = may[a] & may[b]
    _, number = connected_pieces(a[inner], b[inner], len(vertices))
    return np.where(may, number, -1)


def _patch(vertices: Array, faces: Index) -> Patch:
    """Return a mesh as a patch with no vertex free yet."""
    count = len(vertices)
    return Patch(
        vertices,
        faces,
        np.zeros(count, dtype=bool),
        np.arange(count),
        np.zeros((count, 3)),
        np.zeros(count),
    )


def _rounded(patch: Patch, may: Flags, solid: Composite, step: float) -> Patch:
    """Move the patch onto the blended solid, by stages.

    `may` tells of every vertex of the mesh whether it can be set free.
    """
    for share in _STAGES:
        stage = solid.scaled(share)
        sides = stage.sides(patch.vertices)
        held = solid.limiter.share(patch.vertices) < _LEAST
        patch = replace(
            patch,
            free=patch.free | (_blend_matters(stage, sides) & may[patch.parents] & ~held),
            spacing=np.maximum(_FINENESS / share * sides.reach, _FINEST * step),
        )
        patch = split(patch)
        for _ in range(_SMOOTHINGS):
            patch = _improved(stage, patch, step)
        for _ in range(_NEWTON if share == _STAGES[-1] else 1):
            patch = _projected(stage, patch)
        if np.mean(patch.facing() < _OVERTURNED) > _HOPELESS:
            return patch
    for _ in range(_REPAIRS):
        if patch.facing().min(initial=1.0) > 0.0:
            break
        patch = _improved(solid, patch, step)
        for _ in range(_COMBINGS):
            patch = relaxed(patch, _near_folds(patch))
        patch = _projected(solid, patch)
    return patch


def _near_folds(patch: Patch) -> Flags:
    """Mark the vertices of faces turned over, and those around them."""
    near = np.zeros(len(patch.vertices), dtype=bool)
    near[patch.faces[patch.facing() < 0.0]] = True
    for _ in range(_RINGS):
        near[patch.faces[near[patch.faces].any(axis=1)]] = True
    return near


def _improved(solid: Composite, patch: Patch, step: float) -> Patch:
    """Project the patch, collapse its slivers, and relax it."""
    patch = collapsed(_projected(solid, patch), _SLIVER, _SLIVER * step, _COLLAPSES)
    return relaxed(flipped_edges(patch, _FLIPS))


def _blend_matters(solid: Composite, sides: Sides) -> Flags:
    """Return where the blend makes a difference, (n,)."""
    added = np.abs(solid.blended(sides).value - solid.sharp(sides))
    matters: Flags = added > _NOTICEABLE * sides.reach
    return matters


def _projected(solid: Composite, patch: Patch) -> Patch:
    """Move free vertices by a damped Newton step; normals come from the gradient."""
    sides = solid.sides(patch.vertices)
    value, gradient, _ = solid.blended(sides)
    square = np.maximum(dot(gradient, gradient), _FLATTEST**2)
    way = np.where(patch.free, value / square, 0.0)
    far = np.abs(way) * np.sqrt(square)
    way *= np.minimum(1.0, _STRIDE * sides.reach / np.maximum(far, 1e-300))
    return replace(
        patch, vertices=patch.vertices - way[:, None] * gradient, normals=-unit(gradient)
    )


def _bad(solid: Composite, patch: Patch) -> Flags:
    """Mark vertices that did not arrive, or belong to faces turned over."""
    sides = solid.sides(patch.vertices)
    reach = np.maximum(sides.reach, _LEFT * solid.reach)
    bad = patch.free & ~(np.abs(solid.blended(sides).value) <= _LEFT * reach)
    inner = patch.faces[patch.free[patch.faces].all(axis=1)]
    bad[inner[~(patch.facing(inner) >= _OVERTURNED)]] = True
    return bad


def _held_back(solid: Composite, places: Array, step: float, retreat: float) -> Composite:
    """Return the solid with only a share of its blend around places (n, 3)."""
    left = solid.limiter.share(places)
    whole = solid.sides(places).reach / np.maximum(left, 1e-300)
    share = retreat * left
    share[share < _LEAST] = _NONE
    radii = np.maximum(_AROUND * whole, 2.0 * step)
    return replace(solid, limiter=solid.limiter.also(places, radii, share))
