"""The surfaces that details lie on: places on them, kept and found again."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto.geometry import BSplineSurface
from bozzetto_product.fill.feet import NEAREST, foot_of, grid_parameters
from bozzetto_product.fill.fill import Fill
from bozzetto_product.fill.plane_fill import PlaneFill
from bozzetto_product.model.details import OutlinePlaces

SAME_PLACE: Final = 0.01
"""Distance, as share of the size of all surfaces, within which others are where one was."""

PLANE: Final = -1
"""Number of the piece of a surface that is a plane: the same loop, bent, has others."""


@dataclass(frozen=True, eq=False)
class Ground:
    """A surface to lay details on.

    Parameters
    ----------
    patch : str
        Id of its patch.
    mirrored : bool
        Whether it is the mirror image.
    fill : Fill
    """

    patch: str
    mirrored: bool
    fill: Fill


@dataclass(frozen=True, eq=False)
class Located:
    """Places on grounds.

    Parameters
    ----------
    grounds, pieces : (n,) int
        Number of the ground, and of the piece of its surface.
    parameters : (n, 2) float
        u and v.
    points, normals : (n, 3) float
        mm; unit normals outward.
    """

    grounds: Index
    pieces: Index
    parameters: Array
    points: Array
    normals: Array


def located(grounds: Sequence[Ground], points: Array) -> Located:
    """Return the places of grounds nearest to points, (n, 3).

    Raises
    ------
    ValueError
        If there is no ground.
    """
    from scipy.spatial import cKDTree

    if not grounds:
        raise ValueError("there is nothing to lie on")
    u, v = grid_parameters()
    surfaces = [
        (g, k, surface)
        for g, one in enumerate(grounds)
        for k, surface in enumerate(one.fill.patches)
    ]
    planes = {g: one.fill for g, one in enumerate(grounds) if isinstance(one.fill, PlaneFill)}
    seeds = np.concatenate([_seeds(grounds[g].fill, surface, u, v) for g, _, surface in surfaces])
    near = np.asarray(cKDTree(seeds).query(points, k=NEAREST)[1], int)
    best = np.full(len(points), np.inf)
    which, parameters = np.zeros(len(points), int), np.zeros((len(points), 2))
    found = np.zeros((len(points), 3))
    for column in near.T:
        owners = column // len(u)
        for number in np.unique(owners).tolist():
            rows = np.flatnonzero(owners == number)
            start = np.column_stack((u, v))[column[rows] % len(u)]
            ground, _, surface = surfaces[number]
            plane = planes.get(ground)
            if plane is None:
                foot = foot_of(surface, points[rows], start)
            else:
                foot = plane.nearest_within(points[rows])
            places = surface.value(*foot.T)
            gaps = np.linalg.norm(places - points[rows], axis=1)
            nearer = gaps < best[rows]
            best[rows[nearer]] = gaps[nearer]
            which[rows[nearer]], parameters[rows[nearer]] = number, foot[nearer]
            found[rows[nearer]] = places[nearer]
    normals = np.empty((len(points), 3))
    for number in np.unique(which).tolist():
        rows = which == number
        normals[rows] = surfaces[number][2].normals(*parameters[rows].T)
    return Located(
        np.array([surfaces[k][0] for k in which]),
        np.array([PLANE if surfaces[k][0] in planes else surfaces[k][1] for k in which]),
        parameters,
        found,
        normals,
    )


def _seeds(fill: Fill, surface: BSplineSurface, u: Array, v: Array) -> Array:
    """Return places of a piece from which the nearest is sought; of a plane, within its loop."""
    places = surface.value(u, v)
    return surface.value(*fill.nearest_within(places).T) if isinstance(fill, PlaneFill) else places


def kept_places(
    grounds: Sequence[Ground], points: Array, corners: Flags, starts: Sequence[int]
) -> OutlinePlaces:
    """Return places of grounds as a recipe keeps them; see `OutlinePlaces`."""
    found = located(grounds, points)
    fills = {grounds[k].patch: grounds[k].fill for k in found.grounds.tolist()}
    patches = tuple(fills)
    rows = [
        (patches.index(grounds[g].patch), int(grounds[g].mirrored), piece)
        for g, piece in zip(found.grounds.tolist(), found.pieces.tolist(), strict=True)
    ]
    return OutlinePlaces(
        patches,
        np.array(rows, np.int32),
        found.parameters,
        found.points,
        np.asarray(corners, np.uint8),
        np.asarray(starts, np.int32),
        tuple(0 if isinstance(one, PlaneFill) else len(one.patches) for one in fills.values()),
    )


@dataclass(frozen=True, eq=False)
class FollowedOutline:
    """Where kept places are now.

    Parameters
    ----------
    points, normals : (n, 3) float
        mm; unit normals outward.
    lost : tuple of str
        Ids of patches that are gone, if any: then points are those nearest on what is there.
    """

    points: Array
    normals: Array
    lost: tuple[str, ...] = ()


def followed_outline(grounds: Sequence[Ground], places: OutlinePlaces) -> FollowedOutline | None:
    """Return kept places on the surfaces as they are now; None where all of them are gone."""
    known = {(one.patch, one.mirrored): one for one in grounds}
    points, normals = np.full((len(places.rows), 3), np.nan), np.full((len(places.rows), 3), np.nan)
    counts = places.pieces or len(places.patches) * (0,)
    lost = tuple(p for p in places.patches if not any(one.patch == p for one in grounds))
    for row in np.unique(places.rows, axis=0).tolist():
        ground = known.get((places.patches[row[0]], bool(row[1])))
        surface = None if ground is None else _piece(ground.fill, row[2], counts[row[0]])
        if surface is None:
            continue
        chosen = (places.rows == row).all(axis=1)
        at = places.parameters[chosen]
        points[chosen], normals[chosen] = surface.value(*at.T), surface.normals(*at.T)
    gone = ~np.isfinite(points).all(axis=1)
    if gone.any():
        near = _beside(grounds, places, places.points[gone])
        if not near:
            return None
        found = located(near, places.points[gone])
        points[gone], normals[gone] = found.points, found.normals
    return FollowedOutline(points, normals, lost)


def _piece(fill: Fill, number: int, count: int) -> BSplineSurface | None:
    """Return a piece of a surface that had so many; of a plane also those that it has where bent.

    None where it has another number of pieces now: a corner that was rounded is a further side.
    """
    if isinstance(fill, PlaneFill):
        if number == PLANE:
            return fill.plane
        bent = fill.bent
        return None if bent is None else _piece(bent, number, count)
    if count and len(fill.patches) != count:
        return None
    return fill.patches[number] if 0 <= number < len(fill.patches) else None


def _beside(grounds: Sequence[Ground], places: OutlinePlaces, points: Array) -> Sequence[Ground]:
    """Return the grounds on which places go on whose own is gone: those that are where it was.

    A surface that a curve is drawn across comes back as two others in the same place.
    """
    if not grounds:
        return ()
    boxes = np.array([one.fill.mesh.bounds for one in grounds], float)
    size = float(np.linalg.norm(boxes[:, 1].max(axis=0) - boxes[:, 0].min(axis=0)))
    off = np.linalg.norm(located(grounds, points).points - points, axis=1)
    if float(off.max()) <= SAME_PLACE * size:
        return grounds
    return [one for one in grounds if one.patch in places.patches]
