"""Intersections of rays with patches, exact and over the whole surface."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.geometry.patches.patch import Places, points_at, split

if TYPE_CHECKING:
    from bozzetto.arrays import Array, Flags, Index

LEVELS: Final = 5
"""Times that patches are cut in quarters before Newton's method takes over."""

NEWTON_STEPS: Final = 12
"""Steps from the middle of a piece to a hit."""

HIT_TOLERANCE: Final = 1e-9
"""Distance of a hit from its ray, per unit of the patches' largest coordinate and the ray's
origin, and how far beyond its border a patch is still hit, in u and v: no ray slips through
between two patches."""


def ray_hits(nets: ArrayLike, origins: ArrayLike, directions: ArrayLike) -> tuple[Places, Array]:
    """Return the first places in which rays meet patches.

    Seen along a ray a patch is flat, and the ray a point. Pieces whose control points leave the
    point outside their box are dropped, the others cut in quarters (Nishita, Sederberg & Kakimoto
    1990, simplified), and Newton's method goes to the hits from what is left. So none is missed,
    however thin the sliver that a surface shows to the ray, unless the surface turns away and
    back within a 32nd of a patch.

    Parameters
    ----------
    nets : (k, 4, 4, 3) array_like
        mm.
    origins, directions : (n, 3) array_like
        Directions of any length above 0.

    Returns
    -------
    places : Places
        Patch −1 where a ray meets none.
    distances : (n,) float
        From the origin, in lengths of the direction, not below 0; inf where there is none.
    """
    nets = np.asarray(nets, float)
    origins = np.asarray(origins, float).reshape(-1, 3)
    directions = np.asarray(directions, float).reshape(-1, 3)
    places = Places(np.full(len(origins), -1), np.zeros((len(origins), 2)))
    distances = np.full(len(origins), np.inf)
    if not len(nets) or not len(origins):
        return places, distances
    frames = _across(directions)
    rays, patches, starts = _candidates(nets, origins, frames)
    if not len(rays):
        return places, distances
    size = np.abs(nets).max() + np.abs(origins[rays]).max(axis=1)
    hits, sound = _refined(nets, origins[rays], frames[rays], Places(patches, starts), size)
    rays, hits = rays[sound], hits[sound]
    along = ((points_at(nets, hits) - origins[rays]) * directions[rays]).sum(axis=1)
    along = along / (directions[rays] ** 2).sum(axis=1)
    ahead = np.flatnonzero(along >= 0.0)
    order = ahead[np.lexsort((along[ahead], rays[ahead]))]
    hit, first = np.unique(rays[order], return_index=True)
    chosen = order[first]
    places.patches[hit] = hits.patches[chosen]
    places.parameters[hit] = hits.parameters[chosen]
    distances[hit] = along[chosen]
    return places, distances


def _across(directions: Array) -> Array:
    """Return two unit vectors across each direction, (n, 2, 3)."""
    unit = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    least = np.eye(3)[np.abs(unit).argmin(axis=1)]
    first = np.cross(unit, least)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack((first, np.cross(unit, first)), axis=1)


def _candidates(nets: Array, origins: Array, frames: Array) -> tuple[Index, Index, Array]:
    """Return pieces of patches that rays may meet: rays, patches, and the pieces' middles."""
    seen = np.einsum("kijx,nax->nkija", nets, frames)
    seen -= np.einsum("nx,nax->na", origins, frames)[:, None, None, None]
    size = np.abs(nets).max() + np.abs(origins).max()
    slack = HIT_TOLERANCE * size
    rays, patches = np.nonzero(_boxed(seen, slack))
    pieces = seen[rays, patches]
    corner = np.zeros((len(rays), 2))
    width = 1.0
    for _ in range(LEVELS):
        width *= 0.5
        parts, steps = [], []
        for i, half in enumerate(split(pieces, 0.5, 0)):
            for j, part in enumerate(split(half, 0.5, 1)):
                parts.append(part)
                steps.append(corner + width * np.array([i, j]))
        pieces, corner = np.concatenate(parts), np.concatenate(steps)
        rays, patches = np.tile(rays, 4), np.tile(patches, 4)
        kept = _boxed(pieces, slack)
        pieces, corner, rays, patches = pieces[kept], corner[kept], rays[kept], patches[kept]
    return rays, patches, corner + 0.5 * width


def _boxed(pieces: Array, slack: float) -> Flags:
    """Whether the box of flat control nets (…, 4, 4, 2) holds the point that a ray is."""
    low, high = pieces.min(axis=(-3, -2)), pieces.max(axis=(-3, -2))
    return np.asarray(((low <= slack) & (high >= -slack)).all(axis=-1))


def _refined(
    nets: Array, origins: Array, frames: Array, start: Places, size: Array
) -> tuple[Places, Flags]:
    """Refine hits by Newton's method on the distance across the ray; return which are hits, too."""
    at = start.parameters
    for step in range(NEWTON_STEPS + 1):
        here = Places(start.patches, at)
        missed = np.einsum("nax,nx->na", frames, points_at(nets, here) - origins)
        if step == NEWTON_STEPS:
            break
        xu = np.einsum("nax,nx->na", frames, points_at(nets, here, du=1))
        xv = np.einsum("nax,nx->na", frames, points_at(nets, here, dv=1))
        area = xu[:, 0] * xv[:, 1] - xu[:, 1] * xv[:, 0]
        turned = np.stack(
            (
                missed[:, 1] * xv[:, 0] - missed[:, 0] * xv[:, 1],
                missed[:, 0] * xu[:, 1] - missed[:, 1] * xu[:, 0],
            ),
            axis=1,
        )
        move = np.zeros_like(at)
        np.divide(turned, area[:, None], out=move, where=area[:, None] != 0.0)
        # No further than a piece is wide: beyond, the patch is no longer nearly flat.
        at = np.clip(at + np.clip(move, -(0.5**LEVELS), 0.5**LEVELS), -0.01, 1.01)
    near = np.abs(missed).max(axis=1) <= HIT_TOLERANCE * size
    inside = (np.abs(at - 0.5) <= 0.5 + HIT_TOLERANCE).all(axis=1)
    return Places(start.patches, np.clip(at, 0.0, 1.0)), near & inside
