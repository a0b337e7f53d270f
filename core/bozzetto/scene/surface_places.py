"""Places on a surface that follow it: by model, item, face and barycentric coordinates.

A point of a surface that another model shows cannot be kept as three numbers, for the surface is
moved, bent and solved again. It is kept as a place on a triangle. As long as the triangles are
the same ones, wherever their corners are, the place goes along exactly. Where the surface comes
back with other triangles, it goes to the closest point that faces the same way.
"""

from __future__ import annotations

import weakref
from dataclasses import dataclass, replace
from hashlib import blake2b
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bozzetto.arrays import Array, Flags, frozen
from bozzetto.geometry.mesh_places import alike, closest_on_mesh, face_normals, mesh_points
from bozzetto.scene.display_list import Scene, Shaded

if TYPE_CHECKING:
    from bozzetto.geometry.mesh import Mesh

ROUNDING: Final = 1e-6
"""How far from one the sum of barycentric coordinates may be in a file."""

DIGEST_BYTES: Final = 8
"""Length of the digest of a mesh's faces: two meshes are taken for one another once in 10¹⁹."""


@dataclass(frozen=True, eq=False)
class SurfacePlaces:
    """Places on one surface; a value that a document can keep.

    Parameters
    ----------
    model : str
        Id of the model that shows the surface.
    layer : str
        Name of its layer.
    item : int
        Which item of that layer it is.
    topology : str
        Of the mesh that `faces` counts in (`topology_of`).
    faces : (n,) int32
        Face that each place lies on.
    weights : (n, 3) float64
        Barycentric coordinates within it: not negative, of sum one.

    Raises
    ------
    ValueError
        If the numbers are no places.
    """

    model: str
    layer: str
    item: int
    topology: str
    faces: NDArray[np.int32]
    weights: NDArray[np.float64]

    def __post_init__(self) -> None:
        object.__setattr__(self, "faces", frozen(self.faces, np.int32))
        object.__setattr__(self, "weights", frozen(self.weights, np.float64, 3))
        if self.faces.shape != (len(self.weights),):
            raise ValueError("every place needs one face and three weights")
        if self.item < 0 or (len(self) and self.faces.min() < 0):
            raise ValueError("items and faces of surfaces are counted from 0")
        total = self.weights.sum(axis=1)
        if (self.weights < 0).any() or (np.abs(total - 1.0) > ROUNDING).any():
            raise ValueError("the weights of a place are not negative and have the sum one")

    def __len__(self) -> int:
        return len(self.faces)

    def taken(self, which: ArrayLike | slice) -> SurfacePlaces:
        """Return some of the places, by numbers or flags."""
        rows = which if isinstance(which, slice) else np.asarray(which)
        return replace(self, faces=self.faces[rows], weights=self.weights[rows])

    def fit(self, mesh: Mesh) -> bool:
        """Whether a mesh has the triangles that the places lie on, wherever their corners are."""
        known = not len(self) or int(self.faces.max()) < len(mesh.faces)  # a file may say anything
        return known and self.topology in _topologies(mesh)


@dataclass(frozen=True, eq=False)
class FollowedPlaces:
    """Where places are on a surface as it is now.

    Attributes
    ----------
    places : SurfacePlaces
        On the triangles of now: what a document should keep from here on.
    points : (n, 3) float
        mm.
    normals : (n, 3) float
        Of their faces; 0 on a face without area.
    distance : (n,) float
        mm from where the place was to the closest point that it was carried to. 0 where the
        triangles are the same ones: then it moved with its surface.
    alike : (n,) bool
        Whether the face still looks the same way; else the place is on another side of the
        surface, for the side that it was on is gone.
    """

    places: SurfacePlaces
    points: Array
    normals: Array
    distance: Array
    alike: Flags


def topology_of(mesh: Mesh) -> str:
    """Return a digest of a mesh's faces: equal for the same triangles over the same vertices."""
    return _topologies(mesh)[0]


def follow(places: SurfacePlaces, before: Mesh, after: Mesh) -> FollowedPlaces:
    """Carry places from a surface as it was to the surface as it is now.

    With the same triangles, moved or bent, they go along exactly; on other triangles they go to
    the closest points on faces that look the same way.

    Parameters
    ----------
    places : SurfacePlaces
        Places on `before`.
    before, after : Mesh
        The surface, in one frame.

    Raises
    ------
    ValueError
        If the places are not on `before`, or `after` has no face.
    """
    if places.fit(after):
        return _exact(places, after)
    here = _exact(places, before)
    if not len(after.faces):
        raise ValueError("the surface of these places is gone")
    found = closest_on_mesh(after, here.points, here.normals)
    there = replace(
        places,
        topology=topology_of(after),
        faces=found.faces.astype(np.int32),
        weights=found.weights,
    )
    normals = face_normals(after, found.faces)
    same_way = alike(here.normals, normals)
    return FollowedPlaces(there, found.points(after), normals, found.distances, same_way)


def located(
    places: SurfacePlaces, scene: Scene, before: Mesh | None = None
) -> FollowedPlaces | None:
    """Return where places are in a scene, on their surface as it is shown now.

    Parameters
    ----------
    places : SurfacePlaces
        As they were kept.
    scene : Scene
        What is visible, such as `Context.scene`.
    before : Mesh, optional
        The surface that they were on, in the frame of the scene: with it they are carried to
        other triangles, see `follow`.

    Returns
    -------
    FollowedPlaces or None
        None if the surface is not there, or has other triangles and `before` is not given.
    """
    mesh = surface_mesh(places, scene)
    if mesh is None or not (places.fit(mesh) or (before is not None and len(mesh.faces))):
        return None
    return follow(places, mesh if before is None else before, mesh)


def surface_mesh(places: SurfacePlaces, scene: Scene) -> Mesh | None:
    """Return the mesh of the surface that places are on, as a scene shows it; None if it does not.

    Of several layers with one name the one with the triangles of the places counts.
    """
    meshes = [
        item.mesh
        for layer in scene.layers
        if (layer.owner, layer.name) == (places.model, places.layer)
        for item in layer.items[places.item : places.item + 1]
        if isinstance(item, Shaded)
    ]
    return next((mesh for mesh in meshes if places.fit(mesh)), meshes[0] if meshes else None)


def _exact(places: SurfacePlaces, mesh: Mesh) -> FollowedPlaces:
    """Return places on a mesh with their triangles."""
    if not places.fit(mesh):
        raise ValueError("these places are on another mesh")
    turned = places.topology != topology_of(mesh)
    weights = places.weights[:, ::-1] if turned else places.weights
    count = len(places)
    return FollowedPlaces(
        places,
        mesh_points(mesh, places.faces, weights),
        face_normals(mesh, places.faces),
        np.zeros(count),
        np.ones(count, bool),
    )


_known: weakref.WeakKeyDictionary[Mesh, tuple[str, str]] = weakref.WeakKeyDictionary()


def _topologies(mesh: Mesh) -> tuple[str, str]:
    """Return digests of a mesh's faces: as they are, and turned over as a mirror leaves them."""
    if mesh not in _known:
        _known[mesh] = (_digest(mesh, mesh.faces), _digest(mesh, mesh.faces[:, ::-1]))
    return _known[mesh]


def _digest(mesh: Mesh, faces: NDArray[np.int32]) -> str:
    size = len(mesh.vertices).to_bytes(8, "little")
    return blake2b(size + faces.tobytes(), digest_size=DIGEST_BYTES).hexdigest()
