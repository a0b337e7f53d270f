"""Merging and carving of variational bodies by what they interpolate.

Kukelova and Durikovic, "SketchCo", 2007: for a merge the constraints of either body that lie
inside the other are dropped; for carving those of the second outside the first are dropped and
the rest is reversed. Then one surface is made through what is left: there is no crease where
they meet, for nothing holds it there.

Two things are added. Around the crease constraints are dropped in a band as well, which makes
the transition as soft as the blend radius asks for. And each constraint that stays takes the
value that the sharp operation has there, the larger or the smaller of the two: a normal
constraint just outside of one body may touch the other.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from bozzetto.arrays import Array, Faces, Flags, Index
from bozzetto.errors import UserError
from bozzetto_silhouette.implicit.interpolation_constraints import Constraints
from bozzetto_silhouette.implicit.variational import (
    SPACING,
    VariationalSurface,
    apart,
    interpolated,
)
from bozzetto_silhouette.inflation.manifold_check import as_manifold
from bozzetto_silhouette.inflation.solidify import Checkpoint, ignore
from bozzetto_silhouette.numerics.grouping import connected_pieces
from bozzetto_silhouette.solids.body import Body
from bozzetto_silhouette.solids.polygonize import Surface, extract

BAND = 0.3
"""Half width of the band around the crease, in blend radii: the widest blend, two radii, still
leaves something of a ball that touches a wall."""

NARROWEST = 0.002
"""The same without a blend, as a share of the smaller size: of two constraints that contradict
each other within a fifth of the normal offset neither is to be trusted."""

FEWEST = 12
"""A body that is not wholly inside the other keeps at least so many constraints; else the band
is narrowed."""

ROOM = 0.08
"""Margin of the surface beyond the box of the bodies, as a share of its diagonal."""

COARSER = 1.4
"""Cells of the extraction in steps of the finer body: Newton's method and normals from the
function make up for it."""

FINEST = 1 / 160
"""Smallest cell, as a share of the longest side of the result's box."""

HELD = 4.0
"""A component holds a constraint that lies within so many cells of it."""

BLOB_ROUNDS = 3
"""Rounds in which blobs that hold no constraint are removed."""


def variational_combined(
    first: Body,
    second: Body,
    operation: Literal["merge", "carve"],
    blend: float,
    checkpoint: Checkpoint = ignore,
) -> Body | None:
    """Combine two variational bodies into one.

    Parameters
    ----------
    first, second : Body
        In the same frame, both with `Constraints`.
    operation : {"merge", "carve"}
        What the second does to the first.
    blend : float
        Radius of the blend as a share of the smaller `radius` of the two.
    checkpoint : callable
        Called with (fraction, step) between steps; may raise `Cancelled`.

    Returns
    -------
    Body or None
        None where nothing is left.

    Raises
    ------
    UserError
        If no sound surface passes through the constraints.
    """
    one, other = first.constraints, second.constraints
    if not isinstance(one, Constraints) or not isinstance(other, Constraints):
        raise TypeError("both bodies need constraints")
    checkpoint(0.0, "constraints")
    depth = second.implicit.value(one.points)
    other_depth = first.implicit.value(other.points)
    size = min(one.size, other.size)
    band = max(NARROWEST * size, BAND * blend * min(first.radius, second.radius))
    mine, theirs = _kept(operation, one, other, depth, other_depth, band)
    if operation == "merge" and not (mine.all() and theirs.all()):
        if not mine.any():
            return second
        if not theirs.any():
            return first
    if operation == "carve" and not mine.any():
        return None
    if operation == "carve" and not theirs.any():
        return first
    points, value, part = _joined(operation, one, other, depth, other_depth, mine, theirs)
    bounds = _bounds((first,) if operation == "carve" else (first, second))
    step = max(COARSER * min(first.step, second.step), FINEST * float(np.ptp(bounds, axis=0).max()))
    held, mesh = _surface(points, value, bounds, step, checkpoint)
    if not len(mesh.faces):
        return None
    whole = as_manifold(mesh.vertices, mesh.faces)
    if whole.is_empty() or not whole.volume() > 0.0:
        raise UserError(
            "These two variational parts do not join into one sound surface. Move them a little, "
            "make the blend radius smaller, or choose the round surface for one of them."
        )
    from scipy.spatial import cKDTree

    _, nearest = cKDTree(points).query(mesh.vertices)
    origins = _origins(first, second, points[nearest], part[nearest], mesh.vertices)
    return Body(
        mesh.vertices,
        mesh.faces,
        mesh.normals,
        origins,
        first.sources + second.sources,
        held,
        max(first.radius, second.radius) if operation == "merge" else first.radius,
        step,
        constraints=Constraints(points, value, max(one.size, other.size)),
        known=whole,
    )


def _joined(
    operation: str,
    one: Constraints,
    other: Constraints,
    depth: Array,
    other_depth: Array,
    mine: Flags,
    theirs: Flags,
) -> tuple[Array, Array, Index]:
    """Return the constraints that stay: points, values, and whose (0 or 1) they were."""
    if operation == "merge":
        values = np.maximum(one.values, depth), np.maximum(other.values, other_depth)
    else:
        values = np.minimum(one.values, -depth), np.minimum(-other.values, other_depth)
    points = np.concatenate([one.points[mine], other.points[theirs]])
    value = np.concatenate([values[0][mine], values[1][theirs]])
    part = np.repeat([0, 1], [int(mine.sum()), int(theirs.sum())])
    # What lies on the surface goes first: of two that are too close the earlier one stays.
    order = np.argsort(np.abs(value), kind="stable")
    keep = order[apart(points[order], SPACING * min(one.size, other.size))]
    return points[keep], value[keep], part[keep]


def _bounds(bodies: tuple[Body, ...]) -> Array:
    """Return the box of some bodies with room for the surface to bulge, (2, 3)."""
    corners = np.concatenate([body.bounds for body in bodies])
    box = np.stack([corners.min(axis=0), corners.max(axis=0)])
    margin = ROOM * float(np.linalg.norm(box[1] - box[0]))
    return box + margin * np.array([[-1.0], [1.0]])


def _kept(
    operation: str,
    one: Constraints,
    other: Constraints,
    depth: Array,
    other_depth: Array,
    band: float,
) -> tuple[Flags, Flags]:
    """Mark the constraints that stay; the band is narrowed where it would hide a body."""
    narrowest = min(band, NARROWEST * min(one.size, other.size))
    side = -other_depth if operation == "carve" else other_depth
    while True:
        mine, theirs = depth < -band, side < -band
        swallowed = any(
            (kept & on).sum() < min(FEWEST, (free & on).sum())
            for kept, free, on in (
                (mine, depth < -narrowest, one.values == 0.0),
                (theirs, side < -narrowest, other.values == 0.0),
            )
        )
        if not swallowed or band <= narrowest:
            break
        band = max(0.5 * band, narrowest)
    # Normal constraints alone are no surface.
    if not (mine & (one.values == 0.0)).any():
        mine[:] = False
    if not (theirs & (other.values == 0.0)).any():
        theirs[:] = False
    return mine, theirs


def _surface(
    points: Array, value: Array, bounds: Array, step: float, checkpoint: Checkpoint
) -> tuple[VariationalSurface, Surface]:
    """Return the function through the constraints and its surface, without blobs far from them."""
    for turn in range(BLOB_ROUNDS):
        checkpoint(0.2, "solve")
        held = interpolated(points, value, bounds)
        mesh = extract(held, bounds, step, checkpoint)
        if not len(mesh.faces):
            return held, mesh
        mesh, blobs = _without_blobs(mesh, points[value == 0.0], HELD * step)
        if not len(blobs) or turn == BLOB_ROUNDS - 1:
            break
        # Where a blob was the function gets the sign of its surroundings.
        from scipy.spatial import cKDTree

        middles, signs = blobs[:, :3], blobs[:, 3]
        gap, _ = cKDTree(points).query(middles)
        points = np.concatenate([points, middles])
        value = np.concatenate([value, -signs * gap])
    return held, mesh


def _without_blobs(mesh: Surface, on: Array, reach: float) -> tuple[Surface, Array]:
    """Drop components without constraints; return the mesh, their middles and signs (k, 4)."""
    from scipy.spatial import cKDTree

    vertices, faces, normals = mesh
    a, b = faces[:, [0, 1, 1, 2]].reshape(-1, 2).T
    count, label = connected_pieces(a, b, len(vertices))
    gap, nearest = cKDTree(vertices).query(on, distance_upper_bound=reach)
    held = np.zeros(count, bool)
    held[label[np.asarray(nearest)[np.isfinite(gap)]]] = True
    if held.all():
        return mesh, np.zeros((0, 4))
    share = np.maximum(np.bincount(label, minlength=count), 1)
    middle = np.stack([np.bincount(label, vertices[:, k], count) / share for k in range(3)], axis=1)
    p, q, r = (vertices[faces] - vertices[:1]).transpose(1, 0, 2)
    volume = np.bincount(label[faces[:, 0]], np.einsum("ij,ij->i", p, np.cross(q, r)), count)
    blobs = np.column_stack([middle, np.where(volume > 0.0, 1.0, -1.0)])[~held]
    stays = held[label]
    number = np.cumsum(stays) - 1
    kept = number[faces[stays[faces[:, 0]]]].astype(np.int32)
    return Surface(vertices[stays], kept, normals[stays]), blobs


def _origins(first: Body, second: Body, points: Array, part: Index, vertices: Array) -> Faces:
    """Return for every vertex the source of the nearest vertex of its own body."""
    from scipy.spatial import cKDTree

    origins = np.empty(len(vertices), np.int32)
    for k, (body, shift) in enumerate(((first, 0), (second, len(first.sources)))):
        mine = part == k
        if mine.any():
            _, nearest = cKDTree(body.vertices).query(points[mine])
            origins[mine] = body.origins[np.asarray(nearest)] + shift
    return origins
