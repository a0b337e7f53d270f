"""Meshes of shapes as quads with few triangles between, of about as many as a person wants."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Array, Index
from bozzetto.geometry.mesh import Mesh
from bozzetto.geometry.mesh_places import MeshPlaces, closest_on_mesh
from bozzetto.geometry.quads.remeshing import QuadMesh, places_on, quad_dominant
from bozzetto.geometry.quads.surface import across
from bozzetto.geometry.rig import Skin
from bozzetto.geometry.shapes import Shapes, Solid, Surface

LEAST: Final = 24
"""Quads that each part gets in any case."""

JOINTS: Final = 4
"""Joints that a vertex follows at most."""

STEP: Final = "Quads"


@dataclass(frozen=True)
class Quadrangulated:
    """Shapes of quads, and how that went.

    Attributes
    ----------
    shapes : Shapes
        Each two triangles that are a quad follow one another (`Solid.polygons`).
    quads, triangles : int
        Faces of both kinds.
    deviation : float
        The largest distance of the surfaces before from those after, mm.
    joined : tuple of str
        Names of parts on which triangles were joined in pairs, for want of a lattice.
    """

    shapes: Shapes
    quads: int
    triangles: int
    deviation: float
    joined: tuple[str, ...]


def within_quads(
    shapes: Shapes, count: int, checkpoint: Callable[[float, str], None]
) -> Quadrangulated:
    """Return shapes whose meshes are of quads, about as many as are wanted.

    Each part gets its share of them by its area. Colours, groups and bones are carried over; a
    picture is not, for its places belong to the triangles.

    Parameters
    ----------
    shapes : Shapes
        Without exact surfaces; see `bozzetto.geometry.meshed`.
    count : int
        Of all parts together.
    checkpoint : callable
        Called with the fraction done (0 … 1) and the step's name; may raise to stop.
    """
    parts = list(shapes.meshes())
    sizes = [_area(part.mesh) for part in parts]
    made: list[Solid | Surface] = []
    laid: list[QuadMesh] = []
    for number, (part, share) in enumerate(zip(parts, _shares(sizes, count), strict=True)):
        done = number / len(parts)
        quads = _laid(part, share, partial(checkpoint, done, STEP))
        laid.append(quads)
        made.append(_of_quads(part, quads))
    return Quadrangulated(
        replace(
            shapes,
            solids=tuple(part for part in made if isinstance(part, Solid)),
            surfaces=tuple(part for part in made if isinstance(part, Surface)),
        ),
        sum(len(one.quads) for one in laid),
        sum(len(one.triangles) for one in laid),
        max((one.deviation for one in laid), default=0.0),
        tuple(part.name for part, one in zip(parts, laid, strict=True) if not one.remeshed),
    )


def _area(mesh: Mesh) -> float:
    large = across(mesh.vertices.astype(np.float64), mesh.faces.astype(np.intp))
    return 0.5 * float(np.linalg.norm(large, axis=1).sum())


def _shares(sizes: Sequence[float], count: int) -> list[int]:
    """Return how many quads each part gets, (k,): `LEAST`, and of the rest its share by area."""
    area = np.array(sizes, float)
    spare = max(0, count - LEAST * len(area))
    share = area / area.sum() if area.sum() > 0.0 else np.zeros(len(area))
    return [int(one) for one in np.rint(LEAST + spare * share)]


def _base(part: Solid | Surface) -> Mesh:
    """Return the mesh that quads are laid over: that at rest."""
    return part.mesh if part.skin is None or part.skin.rest is None else part.skin.rest


def _groups(part: Solid | Surface) -> Index:
    if not part.groups:
        return np.zeros(len(part.mesh.faces), np.intp)
    return np.repeat(np.arange(len(part.groups)), [group.count for group in part.groups])


def _laid(part: Solid | Surface, count: int, checkpoint: Callable[[], None]) -> QuadMesh:
    return quad_dominant(_base(part), count, _groups(part), checkpoint)


def _of_quads(part: Solid | Surface, made: QuadMesh) -> Solid | Surface:
    """Return a part of quads: two triangles each, and then those that are none."""
    base = _base(part)
    if not len(base.faces):
        return part
    cut = made.quads[:, (0, 1, 2, 0, 2, 3)].reshape(-1, 3)
    faces = np.concatenate((cut, made.triangles)).astype(np.int32)
    polygons = np.repeat((2, 1), (len(made.quads), len(made.triangles)))
    first = np.cumsum(polygons) - polygons
    groups = part.groups
    if groups:
        owner = _owners(base, made.points, faces[first], _groups(part))
        order = np.argsort(owner, kind="stable")
        rows = np.concatenate([np.arange(first[k], first[k] + polygons[k]) for k in order])
        faces, polygons = faces[rows], polygons[order]
        counts = np.bincount(owner[order], polygons, len(groups)).astype(int)
        groups = tuple(replace(g, count=int(n)) for g, n in zip(groups, counts, strict=True))
    places = places_on(base, made)
    colors = _colors(base if part.skin is None else part.mesh, places)
    cover = None if part.mesh.cover is None else _mixed(
        part.mesh.cover[:, None], part.mesh, places
    )[:, 0]  # fmt: skip
    mesh = Mesh(made.points.astype(np.float32), faces, None, colors, cover)
    skin = part.skin
    if skin is not None:
        joints, weights = _followed(skin, base, places)
        rest = mesh if skin.rest is not None else None
        skin = Skin(skin.rig, joints, weights, rest, skin.clips)
        mesh = skin.posed(mesh)
    return replace(
        part, mesh=mesh, groups=groups, skin=skin, texture=None, exact=None, normals=None,
        polygons=polygons,
    )  # fmt: skip


def _owners(base: Mesh, points: Array, faces: NDArray[np.int32], groups: Index) -> Index:
    """Return the group of each face, (k,): of the triangle under the middle of it."""
    middles = points[faces].mean(axis=1)
    return groups[closest_on_mesh(base, middles, across(points, faces.astype(np.intp))).faces]


def _mixed(values: NDArray[np.uint8], mesh: Mesh, places: MeshPlaces) -> NDArray[np.uint8]:
    """Return values of vertices (v, k) at places."""
    corners = values[mesh.faces[places.faces]].astype(np.float64)
    mixed = np.rint(np.einsum("nc,nck->nk", places.weights, corners))
    return np.asarray(mixed, np.uint8)


def _colors(mesh: Mesh, places: MeshPlaces) -> NDArray[np.uint8] | None:
    return None if mesh.colors is None else _mixed(mesh.colors, mesh, places)


def _followed(
    skin: Skin, mesh: Mesh, places: MeshPlaces
) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
    """Return joints and weights (n, 4) at places: of the corners around, the strongest four."""
    corners = mesh.faces[places.faces]
    count = len(corners)
    joints = skin.joints[corners].reshape(count, -1).astype(np.int64)
    weights = (skin.weights[corners].astype(np.float64) * places.weights[:, :, None]).reshape(
        count, -1
    )
    # Weights of one joint are added up at the first place of it.
    order = np.argsort(joints, axis=1, kind="stable")
    joints = np.take_along_axis(joints, order, axis=1)
    weights = np.take_along_axis(weights, order, axis=1)
    run = np.cumsum(np.diff(joints, axis=1, prepend=-1) != 0, axis=1) - 1
    summed = np.zeros_like(weights)
    np.add.at(summed, (np.arange(count)[:, None], run), weights)
    named = np.zeros_like(joints)
    np.put_along_axis(named, run, joints, axis=1)
    top = np.argsort(-summed, axis=1, kind="stable")[:, :JOINTS]
    summed, named = np.take_along_axis(summed, top, 1), np.take_along_axis(named, top, 1)
    summed /= summed.sum(axis=1, keepdims=True)
    return np.where(summed > 0.0, named, 0).astype(np.int32), summed.astype(np.float32)
