"""The thinnest walls of a solid, for printing.

From inside every facet a ray goes straight in, to the facet on the other side; where both are
about parallel its length is the thickness of a wall (the shape diameter of Shapira, Shamir and
Cohen-Or, 2008, with one ray). A tip is thin but no wall: a wall is as thin all around, within
twice its own thickness.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from bozzetto.geometry.mesh import Mesh
from bozzetto.scene.display_list import Layer, Scene, Shaded
from bozzetto.scene.picking import cast_rays
from bozzetto.view.camera import Rays

if TYPE_CHECKING:
    from bozzetto.arrays import Array, Faces, Index

RAYS = 2000
"""Facets that are looked at, and places beside: meshes are finest where they are thin."""

PARALLEL = 0.7
"""Cosine of the angle between two facets up to which they are sides of one wall."""

AROUND = 2.0
"""Times its thickness, how far around a wall is looked at."""

ALIKE = 1.25
"""Times its thickness, how thick a wall may be there."""

NEIGHBOURS = 12
"""Samples that must be looked at around a wall, however far they lie apart."""

MOST_TIPS = 200
"""Tips that are passed over; of what has more of them the next one is as thin as a wall."""

SHARE = 0.6
"""Share of the surface around that must be as thin."""

FINEST = 0.01
"""Share of the surface that may be thinner than the smallest detail: tips."""

INSIDE = 1e-4
"""Distance inside a facet from which its ray starts, as a share of the size."""


@dataclass(frozen=True)
class Walls:
    """Wall thickness of a solid.

    Attributes
    ----------
    thinnest : float
        Of all walls, in the unit of the mesh; of what is no wall nowhere, the size.
    place : (x, y, z)
        Where, in the middle of the wall.
    detail : float
        What all but `FINEST` of the surface is thicker than, tips included.
    """

    thinnest: float
    place: tuple[float, float, float]
    detail: float


def walls_of(vertices: Array, faces: Faces) -> Walls:
    """Measure a closed mesh (v, 3), (f, 3), oriented outwards."""
    low = vertices.min(axis=0)
    size = float((vertices.max(axis=0) - low).max())
    unit = (vertices - low) / size
    a, b, c = unit[faces].transpose(1, 0, 2)
    across = np.cross(b - a, c - a)
    area = 0.5 * np.linalg.norm(across, axis=1)
    # Half of the rays go to facets, which are many where it is thin, half to the surface
    # evenly; each stands for its share of the surface as the latter would have it.
    random = np.random.default_rng(0)
    whole = np.flatnonzero(area > 0.0)
    facets = random.choice(whole, min(RAYS, len(whole)), replace=False)
    spread = random.choice(len(faces), RAYS, p=area / area.sum())
    chosen = np.concatenate([facets, spread])
    u, v = random.random((2, RAYS))
    u, v = np.where(u + v > 1.0, (1.0 - u, 1.0 - v), (u, v))
    u = np.concatenate([np.full(len(facets), 1.0 / 3.0), u])[:, None]
    v = np.concatenate([np.full(len(facets), 1.0 / 3.0), v])[:, None]
    middle = a[chosen] + u * (b - a)[chosen] + v * (c - a)[chosen]
    inwards = -across[chosen] / (2.0 * area[chosen, None])
    even = area.sum() / RAYS
    area = 1.0 / (1.0 / even + np.where(len(whole) > RAYS, RAYS / len(whole), 1.0) / area[chosen])
    scene = Scene((Layer("solid", (Shaded(Mesh(unit.astype(np.float32), faces)),)),))
    hits = cast_rays(scene, Rays(middle + INSIDE * inwards, inwards))
    with np.errstate(invalid="ignore"):
        meets = np.abs((hits.normals * inwards).sum(axis=1)) >= PARALLEL
    seen = hits.hit & meets
    thickness = (hits.distance + INSIDE)[seen]
    middle, inwards, area = middle[seen], inwards[seen], area[seen]
    if not len(thickness):
        x, y, z = (float(v) for v in low + 0.5 * size)
        return Walls(size, (x, y, z), size)
    order = np.argsort(thickness)
    below = np.cumsum(area[order]) / area.sum()
    detail = float(thickness[order[np.searchsorted(below, FINEST)]])
    thinnest = _first_wall(middle, thickness, area, order)
    place = low + size * (middle[thinnest] + 0.5 * thickness[thinnest] * inwards[thinnest])
    x, y, z = (float(v) for v in place)
    return Walls(size * float(thickness[thinnest]), (x, y, z), size * detail)


def _first_wall(middle: Array, thickness: Array, area: Array, order: Index) -> int:
    """Return the thinnest sample that is not at a tip; the thickest where all are."""
    from scipy.spatial import cKDTree

    tree = cKDTree(middle)
    spacing = np.asarray(tree.query(middle, [min(NEIGHBOURS, len(middle))])[0])[:, 0]
    passed = np.zeros(len(middle), bool)
    looks = 0
    for k in order.tolist():
        if passed[k]:
            continue
        looks += 1
        if looks > MOST_TIPS:
            return int(k)
        reach = max(AROUND * thickness[k], float(spacing[k]))
        near = np.array(tree.query_ball_point(middle[k], reach))
        thin = thickness[near] < ALIKE * thickness[k]
        if area[near][thin].sum() >= SHARE * area[near].sum():
            return int(k)
        # The same tip need not be looked at from every sample on it.
        passed[tree.query_ball_point(middle[k], 0.5 * reach)] = True
    return int(order[-1])
