"""What lies under the pen: ray casting on the CPU, for every backend alike."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto.scene.bvh import first_hits, tree_of
from bozzetto.scene.display_list import Handle, Item, Layer, Lines, Points, Scene, Shaded
from bozzetto.view.camera import Camera, Rays

HANDLE_TARGET = 22.0
"""Radius around a handle that belongs to it, px: a touch target of 44 px."""

COVERED_SLACK = 3.0
"""How far (px, at its own depth) behind a surface a thing still counts as lying on it."""


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
        """Which rays met a surface."""
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


@dataclass(frozen=True, eq=False)
class Near:
    """The handle, point or line that lies nearest to a place on the sheet.

    Attributes
    ----------
    layer : Layer
    item : Handle, Points or Lines
    index : int
        Which point of `Points`, or the first point of the segment of `Lines`; 0 for a
        handle.
    point : (3,) float
        The nearest place on it, mm.
    pixels : float
        Its distance from the pen, px.
    """

    layer: Layer
    item: Handle | Points | Lines
    index: int
    point: Array
    pixels: float


def nearest_item(
    scene: Scene, camera: Camera, x: float, y: float, radius: float = 8.0
) -> Near | None:
    """Find the handle, point or line under the pen.

    Parameters
    ----------
    scene : Scene
    camera : Camera
        `x` and `y` are pixels of its canvas.
    radius : float
        How far away (px) points and lines may be. Handles are found within their touch
        target of `HANDLE_TARGET`, or within `radius` where that is larger.

    Returns
    -------
    Near or None
        Handles win over points, points over lines; among equals what is not covered by a
        surface wins, then what is nearest.
    """
    pen = np.array([x, y], float)
    best: Near | None = None
    best_rank: tuple[int, bool, float] | None = None
    for layer, item in scene.items():
        for near in _candidates(layer, item, camera, pen, radius):
            rank = (
                0 if isinstance(near.item, Handle) else 1 if isinstance(near.item, Points) else 2,
                not isinstance(near.item, Handle) and _covered(scene, camera, near.point),
                near.pixels,
            )
            if best_rank is None or rank < best_rank:
                best, best_rank = near, rank
    return best


def _candidates(
    layer: Layer, item: Item, camera: Camera, pen: Array, radius: float
) -> Iterator[Near]:
    """The nearest place of one item, and the nearest that is in front of the rest."""
    if isinstance(item, Handle):
        pixels, _ = camera.project(item.point)
        gap = float(np.hypot(*(pixels[0] - pen)))
        if gap <= max(radius, HANDLE_TARGET):
            yield Near(layer, item, 0, np.array(item.point, float), gap)
    elif isinstance(item, Points) and len(item.points) and item.opacity > 0:
        places = np.asarray(item.points, np.float64)
        pixels, depth = camera.project(places)
        gaps = np.hypot(*(pixels - pen).T)
        reach = radius + 0.5 * item.size
        yield from _nearest_and_foremost(layer, item, places, gaps, depth, reach)
    elif isinstance(item, Lines) and len(item.points) > 1 and item.opacity > 0:
        first = np.concatenate([np.arange(p.start, p.stop - 1) for p in item.pieces()])
        if len(first):
            ends = np.asarray(item.points, np.float64)
            pixels, depth = camera.project(ends)
            begin, end = pixels[first], pixels[first + 1]
            at = _foot(begin, end, pen)
            gaps = np.hypot(*(begin + at[:, None] * (end - begin) - pen).T)
            along = _in_space(camera, at, depth[first], depth[first + 1])
            places = ends[first] + along[:, None] * (ends[first + 1] - ends[first])
            depths = depth[first] + along * (depth[first + 1] - depth[first])
            yield from _nearest_and_foremost(layer, item, places, gaps, depths, radius, first)


def _nearest_and_foremost(
    layer: Layer,
    item: Points | Lines,
    places: Array,
    gaps: Array,
    depth: Array,
    reach: float,
    names: Index | None = None,
) -> Iterator[Near]:
    within = np.flatnonzero(gaps <= reach)  # NaN (behind the eye) is never within
    if not len(within):
        return
    chosen = {int(within[np.argmin(gaps[within])]), int(within[np.argmin(depth[within])])}
    for index in sorted(chosen):
        name = index if names is None else int(names[index])
        yield Near(layer, item, name, places[index], float(gaps[index]))


def _foot(begin: Array, end: Array, pen: Array) -> Array:
    """Parameter 0 … 1 of the place on each segment that is nearest to the pen."""
    along = end - begin
    square = np.einsum("ij,ij->i", along, along)
    with np.errstate(divide="ignore", invalid="ignore"):
        at = np.einsum("ij,ij->i", pen - begin, along) / square
    return np.clip(np.where(square > 0, at, 0.0), 0.0, 1.0)


def _in_space(camera: Camera, at: Array, near: Array, far: Array) -> Array:
    """The parameter on a segment in space that is seen at a parameter on the sheet."""
    if camera.kind == "orthographic":
        return at
    with np.errstate(divide="ignore", invalid="ignore"):
        return at * near / (far + at * (near - far))


def _covered(scene: Scene, camera: Camera, point: Array) -> bool:
    """Whether a surface lies in front of a place."""
    pixels, depth = camera.project(point)
    rays = camera.rays(pixels)
    distance = float(cast_rays(scene, rays).distance[0])
    own = float(np.linalg.norm(point - rays.origins[0]))
    shrink = 1.0 if camera.kind == "orthographic" else max(float(depth[0]), 0.0) / camera.distance
    return distance < own - COVERED_SLACK * shrink / camera.pixels_per_mm
