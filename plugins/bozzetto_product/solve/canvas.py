"""Canvases of curves: rough shapes, and the surfaces of other models."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final, TypeAlias

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto.geometry import Mesh, Shapes, closest_on_mesh, face_normals, meshed
from bozzetto.plugin import remembered
from bozzetto_product.model.rough_shapes import FollowedShape, RoughShape
from bozzetto_product.model.state import ProductState
from bozzetto_product.rough_shapes.shapes import rough_mesh

Sources: TypeAlias = Mapping[str, Shapes]
"""What a product follows, by id; see `bozzetto.plugin.Job.sources`."""

NOTHING: Final[Sources] = MappingProxyType({})
"""What a product follows that follows nothing."""

LYING: Final = 0.02
"""Distance, as share of the size of what was drawn, within which it lies on a canvas."""

LOOKS: Final = 24
"""Points of it that are looked at."""


@dataclass(frozen=True, eq=False)
class Canvas:
    """A surface to draw on.

    Parameters
    ----------
    part : RoughShape or FollowedShape
        Hidden parts have one, too, for curves follow them.
    mesh : Mesh
        In the frame of the model, mm; without faces where there is nothing.
    """

    part: RoughShape | FollowedShape
    mesh: Mesh


def canvases_of(state: ProductState, sources: Sources) -> tuple[Canvas, ...]:
    """Return what the curves of a product are drawn on, in the order of its parts.

    Parameters
    ----------
    state : ProductState
        The recipe.
    sources : Sources
        What other models hand over.
    """
    made = []
    for part in state.nodes:
        if isinstance(part, RoughShape):
            made.append(Canvas(part, mesh_of_rough_shape(part)))
        elif isinstance(part, FollowedShape) and part.source in sources:
            made.append(Canvas(part, mesh_of_shapes(sources[part.source])))
    return tuple(made)


def outward_at(canvases: Sequence[Canvas], points: Array) -> Array:
    """Return the way outward (3,) of the canvases on which points (n, 3) lie; 0 if they do not."""
    few = points[:: max(1, len(points) // LOOKS)]
    reach = LYING * float(np.linalg.norm(np.ptp(points, axis=0)))
    found = np.zeros(3)
    for canvas in canvases:
        if len(canvas.mesh.faces):
            places = closest_on_mesh(canvas.mesh, few)
            found += face_normals(canvas.mesh, places.faces)[places.distances <= reach].sum(axis=0)
    return found


@remembered(
    limit=64, key=lambda part: (part.kind, part.centre, part.length, part.width, part.height)
)
def mesh_of_rough_shape(part: RoughShape) -> Mesh:
    """Return the triangles of a rough shape where it stands."""
    return rough_mesh(part)


def mesh_of_shapes(shapes: Shapes) -> Mesh:
    """Return all surfaces of some shapes as one mesh; empty where there are curves only."""
    return _joined(tuple(_meshes(shapes)))


def _meshes(shapes: Shapes) -> Iterator[Mesh]:
    for part in meshed(shapes).meshes():
        yield part.mesh


@remembered(limit=16)
def _joined(meshes: tuple[Mesh, ...]) -> Mesh:
    """Return meshes as one; remembered, so that its tree of boxes is made once."""
    vertices: list[Array] = [np.zeros((0, 3))]
    faces: list[Index] = [np.zeros((0, 3), int)]
    normals: list[Array] = [np.zeros((0, 3))]
    first = 0
    for mesh in meshes:
        vertices.append(mesh.vertices.astype(float))
        faces.append(mesh.faces.astype(int) + first)
        normals.append(mesh.vertex_normals().astype(float))
        first += len(mesh.vertices)
    return Mesh(
        np.concatenate(vertices).astype(np.float32),
        np.concatenate(faces).astype(np.int32),
        np.concatenate(normals).astype(np.float32),
    )
