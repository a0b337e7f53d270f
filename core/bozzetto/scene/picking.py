"""Ray casting on the CPU, for every backend alike."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto.geometry.bvh import first_hits, tree_of
from bozzetto.scene.display_list import Scene, Shaded
from bozzetto.view.camera import Rays


@dataclass(frozen=True, eq=False)
class Hits:
    """The front-most surface under each ray.

    Attributes
    ----------
    points : (n, 3) float
        mm; NaN where nothing was hit.
    normals : (n, 3) float
        Unit face normals turned towards the eye; NaN where nothing was hit.
    distance : (n,) float
        Along the ray, mm; inf where nothing was hit.
    owners : tuple of str
        Id of the model hit; "" where none.
    items : tuple of Shaded or None
        What was hit; None where nothing was.
    faces : (n,) int
        Which face of its mesh; -1 where nothing was hit.
    """

    points: Array
    normals: Array
    distance: Array
    owners: tuple[str, ...]
    items: tuple[Shaded | None, ...]
    faces: Index

    @property
    def hit(self) -> Flags:
        """Rays that met a surface, as flags (n,)."""
        return np.isfinite(self.distance)


def cast_rays(scene: Scene, rays: Rays) -> Hits:
    """Find where rays first meet a pickable surface of the scene, from either side.

    Parameters
    ----------
    scene : Scene
        Its `Shaded` items count, unless they are not pickable or fully transparent.
    rays : Rays
        Half-lines; a direction need not be of unit length, and a ray that is not finite
        or has no direction hits nothing.

    Returns
    -------
    Hits

    Notes
    -----
    Each mesh keeps a tree of boxes from its first use on (see `bvh`), so a mesh
    that is shared between scenes is sorted once.
    """
    origins = np.reshape(np.asarray(rays.origins, float), (-1, 3))
    directions = np.reshape(np.asarray(rays.directions, float), (-1, 3))
    length = np.linalg.norm(directions, axis=1)
    usable = np.flatnonzero(np.isfinite(origins).all(1) & np.isfinite(length) & (length > 0))
    starts = origins[usable]
    towards = directions[usable] / length[usable, None]

    count = len(origins)
    points, normals = np.full((count, 3), np.nan), np.full((count, 3), np.nan)
    distance, owners = np.full(count, np.inf), [""] * count
    items: list[Shaded | None] = [None] * count
    faces = np.full(count, -1, np.intp)
    nearest = np.full(len(usable), np.inf)
    for layer, item in scene.items():
        if not isinstance(item, Shaded) or not item.pickable or item.opacity <= 0:
            continue
        mesh = item.mesh
        along, face = first_hits(tree_of(mesh), starts, towards)
        nearer = np.flatnonzero(along < nearest)
        if not len(nearer):
            continue
        nearest[nearer] = along[nearer]
        corners = mesh.vertices[mesh.faces[face[nearer]]].astype(np.float64)
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        away = np.einsum("ij,ij->i", normal, towards[nearer]) > 0
        normal[away] *= -1.0
        where = usable[nearer]
        points[where] = starts[nearer] + along[nearer, None] * towards[nearer]
        normals[where] = normal
        distance[where] = along[nearer]
        faces[where] = face[nearer]
        for ray in where.tolist():
            owners[ray], items[ray] = layer.owner, item
    return Hits(points, normals, distance, tuple(owners), tuple(items), faces)
