"""Two bodies become one: sharp by manifold3d, or with a blend around the crease."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from bozzetto.arrays import Array, Faces, Flags, Index
from bozzetto.errors import UserError
from bozzetto_silhouette.implicit.composite import Composite
from bozzetto_silhouette.inflation.manifold_check import as_manifold
from bozzetto_silhouette.inflation.sewing import vertex_normals
from bozzetto_silhouette.inflation.solidify import Checkpoint, ignore
from bozzetto_silhouette.model.state import Operation
from bozzetto_silhouette.numerics.isotropic_remeshing import unit
from bozzetto_silhouette.solids.body import Body
from bozzetto_silhouette.solids.fillet import Fillet, filleted
from bozzetto_silhouette.solids.variational_csg import variational_combined

if TYPE_CHECKING:
    from manifold3d import Manifold


_DIFFERENCE = 0.04
"""Width of the difference quotients for normals, as a share of the reach."""

_TETRAHEDRON = np.array([[1, -1, -1], [-1, -1, 1], [-1, 1, -1], [1, 1, 1.0]]) / np.sqrt(3.0)
_KEY = np.array([0.7548776662466927, 0.5698402909980532, 0.3247179572447460])


def combined(
    first: Body,
    second: Body,
    operation: Operation,
    blend: float,
    checkpoint: Checkpoint = ignore,
) -> Body | None:
    """Combine two bodies into one.

    Parameters
    ----------
    first, second : Body
        In the same frame.
    operation : {"add", "merge", "carve", "intersect"}
        What the second does to the first.
    blend : float
        Radius of the blend as a share of the smaller `radius` of the two; 0 is a sharp crease.
    checkpoint : callable
        Called with (fraction, step) between steps; may raise `Cancelled`.

    Returns
    -------
    Body or None
        None where nothing is left.
    """
    reach = blend * min(first.radius, second.radius)
    if not _near(first, second):
        return _apart(first, second, operation)
    checkpoint(0.0, "combine")
    if reach > 0.0 and first.constraints is not None and second.constraints is not None:
        if operation in ("merge", "carve"):
            with suppress(UserError):  # no sound surface through them: blended like all others
                return variational_combined(first, second, operation, blend, checkpoint)
    whole = _boolean(first, second, operation)
    if whole.is_empty() or not whole.volume() > 0.0:
        return None
    sharp = _sharp(first, second, operation, whole)
    if reach <= 0.0 or len(sharp.creases) == 0:
        return sharp
    checkpoint(0.4, "blend")
    solid = Composite(first.implicit, second.implicit, operation, blend, reach)
    fillet = filleted(sharp.vertices, sharp.faces.astype(np.intp), solid, sharp.step, checkpoint)
    known = as_manifold(fillet.vertices, fillet.faces.astype(np.int32))
    if known.is_empty() or not known.volume() > 0.0:
        return sharp
    return _blended(sharp, fillet, known)


def _near(first: Body, second: Body) -> bool:
    (low, high), (other_low, other_high) = first.bounds, second.bounds
    return bool((low <= other_high).all() and (other_low <= high).all())


def _boolean(first: Body, second: Body, operation: Operation) -> Manifold:
    if operation == "carve":
        return first.manifold - second.manifold
    if operation == "intersect":
        return first.manifold ^ second.manifold
    return first.manifold + second.manifold


def _apart(first: Body, second: Body, operation: Operation) -> Body | None:
    """Combine two bodies whose boxes do not touch."""
    if operation == "carve":
        return first
    if operation == "intersect":
        return None
    count = len(first.vertices)
    return Body(
        np.vstack([first.vertices, second.vertices]),
        np.concatenate([first.faces, second.faces + np.int32(count)]),
        np.vstack([first.normals, second.normals]),
        np.append(first.origins, second.origins + np.int32(len(first.sources))),
        first.sources + second.sources,
        Composite(first.implicit, second.implicit, operation, 0.0, 0.0),
        max(first.radius, second.radius),
        min(first.step, second.step),
        np.append(first.creases, second.creases + count),
    )


def _sharp(first: Body, second: Body, operation: Operation, whole: Manifold) -> Body:
    """Make a body of a boolean's mesh; normals and origins come from the vertices before it."""
    mesh = whole.to_mesh64()
    vertices = np.array(mesh.vert_properties, np.float64)[:, :3]
    faces = np.array(mesh.tri_verts).astype(np.int32)
    before = np.vstack([first.vertices, second.vertices])
    parents = _found(vertices, before)
    side = -1.0 if operation == "carve" else 1.0
    normals = np.vstack([first.normals, side * second.normals])[parents]
    origins = np.append(first.origins, second.origins + np.int32(len(first.sources)))[parents]
    sharp_before = np.zeros(len(before), dtype=bool)
    sharp_before[first.creases] = sharp_before[len(first.vertices) + second.creases] = True
    new = parents < 0
    on_crease = np.flatnonzero(new | sharp_before[parents])
    normals[on_crease] = _crease_normals(vertices, faces, on_crease)
    return Body(
        vertices,
        faces,
        normals,
        _spread(origins, new, faces),
        first.sources + second.sources,
        Composite(first.implicit, second.implicit, operation, 0.0, 0.0),
        max(first.radius, second.radius),
        min(first.step, second.step),
        on_crease,
        known=whole,
    )


def _blended(sharp: Body, fillet: Fillet, known: Manifold) -> Body:
    normals = sharp.normals[fillet.parents]
    normals[fillet.moved] = _normals_of(fillet.solid, fillet.vertices[fillet.moved])
    sharp_before = np.zeros(len(sharp.vertices), dtype=bool)
    sharp_before[sharp.creases] = True
    return replace(
        sharp,
        vertices=fillet.vertices,
        faces=fillet.faces.astype(np.int32),
        normals=normals,
        origins=sharp.origins[fillet.parents],
        implicit=fillet.solid,
        creases=np.flatnonzero(sharp_before[fillet.parents] & ~fillet.moved),
        known=known,
    )


def _found(vertices: Array, before: Array) -> Index:
    """Find the index of each vertex among those before, -1 for new ones."""
    keys = before @ _KEY
    order = np.argsort(keys, kind="stable")
    at = np.minimum(np.searchsorted(keys[order], vertices @ _KEY), len(before) - 1)
    index = order[at]
    return np.where((before[index] == vertices).all(axis=1), index, -1)


def _spread(origins: Faces, new: Flags, faces: Faces) -> Faces:
    """Take the origins of new vertices from neighbours, as far as there are any."""
    origins = np.where(new, np.int32(-1), origins)
    a, b = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    while True:
        open_ends = np.flatnonzero((origins[a] < 0) & (origins[b] >= 0))
        if not len(open_ends):
            return np.maximum(origins, np.int32(0))
        origins[a[open_ends]] = origins[b[open_ends]]


def _crease_normals(vertices: Array, faces: Faces, on_crease: Index) -> Array:
    """Return the mean normals of the faces around some vertices."""
    chosen = np.zeros(len(vertices), dtype=bool)
    chosen[on_crease] = True
    return vertex_normals(vertices, faces[chosen[faces].any(axis=1)])[on_crease]


def _normals_of(solid: Composite, points: Array) -> Array:
    """Return unit normals, outwards, by differences of the value at a tetrahedron's corners."""
    width = _DIFFERENCE * solid.sides(points).reach[:, None, None]
    corners = (points[:, None, :] + width * _TETRAHEDRON).reshape(-1, 3)
    values = solid.value(corners).reshape(-1, 4)
    return unit(-values @ _TETRAHEDRON)
