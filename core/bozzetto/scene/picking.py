"""Ray casting on the CPU, for every backend alike."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array, Flags, Index
from bozzetto.geometry.bvh import first_hits, tree_of
from bozzetto.geometry.mesh_places import closest_on_triangles
from bozzetto.scene.display_list import Lines, Scene, Shaded
from bozzetto.scene.surface_places import SurfacePlaces, topology_of

if TYPE_CHECKING:
    from bozzetto.view.camera import Camera, Rays


class SceneSurface(NamedTuple):
    """A surface of a scene that rays can meet.

    Attributes
    ----------
    model : str
        Id of the model that shows it.
    layer : str
        Name of its layer.
    number : int
        Which item of that layer it is.
    item : Shaded
        The item itself.
    """

    model: str
    layer: str
    number: int
    item: Shaded


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
    faces : (n,) int
        Which face of its mesh; -1 where nothing was hit.
    weights : (n, 3) float
        Barycentric coordinates within that face; NaN where nothing was hit.
    on : (n,) int
        Which of `surfaces` was hit; -1 where none was.
    surfaces : tuple of SceneSurface
        All surfaces of the scene that could have been hit.
    """

    points: Array
    normals: Array
    distance: Array
    faces: Index
    weights: Array
    on: Index
    surfaces: tuple[SceneSurface, ...]

    @property
    def hit(self) -> Flags:
        """Rays that met a surface, as flags (n,)."""
        return np.isfinite(self.distance)

    @property
    def owners(self) -> tuple[str, ...]:
        """Id of the model that each ray met; "" where none."""
        return tuple(self.surfaces[k].model if k >= 0 else "" for k in self.on.tolist())

    @property
    def items(self) -> tuple[Shaded | None, ...]:
        """Item that each ray met; None where nothing was."""
        return tuple(self.surfaces[k].item if k >= 0 else None for k in self.on.tolist())

    def taken(self, which: ArrayLike) -> Hits:
        """Return some of the rays, by numbers or flags."""
        rows = np.asarray(which)
        return Hits(
            self.points[rows],
            self.normals[rows],
            self.distance[rows],
            self.faces[rows],
            self.weights[rows],
            self.on[rows],
            self.surfaces,
        )

    def joined(self, other: Hits) -> Hits:
        """Return these rays followed by others that were cast into the same scene."""
        return Hits(
            np.concatenate((self.points, other.points)),
            np.concatenate((self.normals, other.normals)),
            np.concatenate((self.distance, other.distance)),
            np.concatenate((self.faces, other.faces)),
            np.concatenate((self.weights, other.weights)),
            np.concatenate((self.on, other.on)),
            self.surfaces,
        )

    def places(self, which: ArrayLike) -> SurfacePlaces:
        """Return what some rays met as places that a document keeps (see `SurfacePlaces`).

        Parameters
        ----------
        which : array_like of int or bool
            Rays that met one and the same surface, by numbers or flags.

        Raises
        ------
        ValueError
            If there is none, one met nothing, or they met several surfaces.
        """
        rows = np.asarray(which)
        on = np.unique(self.on[rows])
        if len(on) != 1 or on[0] < 0:
            raise ValueError("places are wanted of rays that do not meet one surface")
        model, layer, number, item = self.surfaces[on[0]]
        mesh = topology_of(item.mesh)
        return SurfacePlaces(model, layer, number, mesh, self.faces[rows], self.weights[rows])


def surfaces_of(scene: Scene) -> tuple[SceneSurface, ...]:
    """Return the surfaces of a scene that ink can be laid on, in the order of its layers."""
    return tuple(
        SceneSurface(layer.owner, layer.name, number, item)
        for layer in scene.layers
        for number, item in enumerate(layer.items)
        if isinstance(item, Shaded) and item.pickable and item.opacity > 0
    )


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

    count, surfaces = len(origins), surfaces_of(scene)
    points, normals, weights = (np.full((count, 3), np.nan) for _ in range(3))
    distance = np.full(count, np.inf)
    faces, on = np.full(count, -1, np.intp), np.full(count, -1, np.intp)
    nearest = np.full(len(usable), np.inf)
    for number, surface in enumerate(surfaces):
        mesh = surface.item.mesh
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
        weights[where] = closest_on_triangles(points[where], corners)
        on[where] = number
    return Hits(points, normals, distance, faces, weights, on, surfaces)


def place_on_lines(
    scene: Scene, camera: Camera, pixel: tuple[float, float], reach: float
) -> Array | None:
    """Return the place on a line of a scene that is seen nearest to a pixel.

    Parameters
    ----------
    scene : Scene
        Its `Lines` count, unless they are fully transparent.
    camera : Camera
        The view.
    pixel : (x, y)
        A place on the canvas.
    reach : float
        Largest distance, px.

    Returns
    -------
    (3,) float or None
        mm; None where no line is within reach.
    """
    items = [
        item
        for layer in scene.layers
        for item in layer.items
        if isinstance(item, Lines) and item.opacity > 0
    ]
    begins = [item.points[each.start : each.stop - 1] for item in items for each in item.pieces()]
    ends = [item.points[each.start + 1 : each.stop] for item in items for each in item.pieces()]
    none = np.zeros((0, 3), np.float32)
    both = np.stack((np.concatenate((none, *begins)), np.concatenate((none, *ends)))).astype(float)
    seen, depth = (
        rows.reshape(2, -1, *rows.shape[1:]) for rows in camera.project(both.reshape(-1, 3))
    )
    ahead = np.isfinite(seen).all(axis=(0, 2))
    if not ahead.any():
        return None
    (first, second), (near, far), both = seen[:, ahead], depth[:, ahead], both[:, ahead]
    along = second - first
    length = np.einsum("ij,ij->i", along, along)
    share = np.einsum("ij,ij->i", np.asarray(pixel) - first, along)
    share = np.clip(share / np.where(length > 0.0, length, 1.0), 0.0, 1.0)
    away = np.linalg.norm(first + share[:, None] * along - pixel, axis=1)
    best = int(np.argmin(away))
    if away[best] > reach:
        return None
    part = share[best]
    if camera.kind == "perspective":  # equal steps on the sheet are not equal in space
        part = part * near[best] / (part * near[best] + (1.0 - part) * far[best])
    return np.asarray((1.0 - part) * both[0, best] + part * both[1, best])
