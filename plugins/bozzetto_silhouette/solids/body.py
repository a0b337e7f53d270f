"""A body: a closed mesh, the function of space that it is the zero set of, and its origins."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from bozzetto.arrays import Array, Faces, Index
from bozzetto.geometry import Placement
from bozzetto.plugin import cached_property, override
from bozzetto_silhouette.implicit.implicit_solid import Implicit, Placed
from bozzetto_silhouette.inflation.manifold_check import as_manifold, volume_of
from bozzetto_silhouette.numerics.isotropic_remeshing import unit

if TYPE_CHECKING:
    from manifold3d import Manifold

    from bozzetto_silhouette.implicit.interpolation_constraints import Constraints
    from bozzetto_silhouette.inflation.solidify import SilhouetteSolid


INTO = 0.3
"""Where the normal of a face at a crease is looked up: the way from the crease to its middle."""

VERTEX = 320
"""Bytes that a vertex takes in manifold3d's own copy of the mesh."""


@dataclass(frozen=True, eq=False)
class Body:
    """A closed solid: a part, a group, or all of them combined.

    Attributes
    ----------
    vertices : (v, 3) float64 array
    faces : (f, 3) int32 array
        Oriented outwards, watertight.
    normals : (v, 3) float64 array
        Unit, outwards.
    origins : (v,) int32 array
        For every vertex the index in `sources` of the part that it came from.
    sources : tuple of str
        Ids of the parts.
    implicit : Implicit
        Its zero set is the mesh, but for the mesh's own coarseness.
    radius : float
        The largest inscribed radius: what blend radii are a share of.
    step : float
        Spacing of the mesh in the thick places.
    creases : (c,) int array
        Vertices that lie on sharp edges, where one normal cannot be right for all faces.
    constraints : Constraints, optional
        What a variational surface interpolates; such surfaces blend by what they interpolate.
    known : Manifold, optional
        The same mesh as manifold3d sees it, where it is at hand.
    solid : SilhouetteSolid, optional
        For a part by itself: its solid, in the part's object frame.
    resampled : bool
        Whether meshes could not be put together, so that it was made anew from its function.
    """

    vertices: Array
    faces: Faces
    normals: Array
    origins: Faces
    sources: tuple[str, ...]
    implicit: Implicit
    radius: float
    step: float
    creases: Index = field(default_factory=lambda: np.zeros(0, np.intp))
    constraints: Constraints | None = None
    known: Manifold | None = None
    solid: SilhouetteSolid | None = None
    resampled: bool = False

    @cached_property
    def mark(self) -> object:
        """Token that stands for it where answers are remembered that do not need it any more."""
        return object()

    @cached_property
    def manifold(self) -> Manifold:
        """The mesh as manifold3d sees it."""
        return as_manifold(self.vertices, self.faces) if self.known is None else self.known

    @cached_property
    def volume(self) -> float:
        """Volume that the mesh encloses, mm³."""
        return volume_of(self.vertices, self.faces)

    @cached_property
    def bounds(self) -> Array:
        """Corners of the box around the mesh, (2, 3)."""
        return np.stack([self.vertices.min(axis=0), self.vertices.max(axis=0)])

    @override
    def __sizeof__(self) -> int:
        """Return the bytes besides its arrays: mostly the copy of the mesh in manifold3d."""
        return object.__sizeof__(self) + VERTEX * len(self.vertices)

    def split_at_creases(self) -> tuple[Array, Faces, Array]:
        """Return vertices (v, 3), faces and normals with a vertex for every face at the creases.

        There every face has the normal of its own side.
        """
        on_crease = np.zeros(len(self.vertices), dtype=bool)
        on_crease[self.creases] = True
        face, corner = np.nonzero(on_crease[self.faces])
        copied = self.faces[face, corner]
        middle = self.vertices[self.faces[face]].mean(axis=1)
        at = self.vertices[copied] + INTO * (middle - self.vertices[copied])
        inwards = self.implicit.sample(at).gradient if len(at) else np.zeros((0, 3))
        faces = self.faces.copy()
        faces[face, corner] = len(self.vertices) + np.arange(len(copied))
        return (
            np.vstack([self.vertices, self.vertices[copied]]),
            faces,
            np.vstack([self.normals, -unit(inwards)]),
        )

    def placed(self, placement: Placement) -> Body:
        """Return the body moved, turned, scaled or mirrored."""
        if placement.is_identity:
            return self
        return replace(
            self,
            vertices=placement.points(self.vertices),
            faces=self.faces[:, ::-1] if placement.mirrors else self.faces,
            normals=placement.directions(self.normals),
            implicit=Placed(self.implicit, placement),
            radius=self.radius * placement.scale,
            step=self.step * placement.scale,
            constraints=None if self.constraints is None else self.constraints.placed(placement),
            known=None,
        )


def meet(box: Array, other: Array) -> bool:
    """Whether two boxes (2, 3) meet."""
    return bool((box[0] <= other[1]).all() and (other[0] <= box[1]).all())


def places_in(bodies: Iterable[Body], box: Array) -> Array:
    """Return the vertices (n, 3) of some bodies in a box (2, 3)."""
    found = [np.zeros((0, 3))]
    for body in bodies:
        if meet(body.bounds, box):
            inside = (body.vertices >= box[0]) & (body.vertices <= box[1])
            found.append(body.vertices[inside.all(axis=1)])
    return np.concatenate(found)
