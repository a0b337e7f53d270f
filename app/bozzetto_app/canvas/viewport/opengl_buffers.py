"""Vertex data for the GL viewport: one batch of a kind for each layer, as plain arrays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.scene.display_list import Image, Layer, Lines, Points, Shaded
from bozzetto.scene.renderer.highlights import SHEENS
from bozzetto.scene.renderer.normals import corner_normals, mean_curvature
from bozzetto.scene.renderer.shading import Shading, curvature_colors, draft_colors
from bozzetto.scene.renderer.surfaces import is_polished

if TYPE_CHECKING:
    from bozzetto.geometry.mesh import Mesh
    from bozzetto.geometry.texture import Texture
    from bozzetto.scene.palette import Palette

__all__ = [
    "HIDDEN_KINDS",
    "Batch",
    "dots",
    "glass_surfaces",
    "opaque_surfaces",
    "picture",
    "strips",
    "surface",
    "textured_surface",
]

Floats = NDArray[np.float32]
Indices = NDArray[np.uint32]

HIDDEN_KINDS: Final = ("hide", "faint", "dashed", "show")
"""How parts behind surfaces appear; lines of one kind share a batch."""


@dataclass(frozen=True, eq=False)
class Batch:
    """Vertices of one shader program.

    Attributes
    ----------
    vertices : (v, k) float32
        Interleaved columns of all attributes.
    widths : tuple of int
        How many columns each attribute has, in the program's order.
    indices : (i,) uint32
        Corners of triangles.
    """

    vertices: Floats
    widths: tuple[int, ...]
    indices: Indices


def _rgba(color: tuple[int, int, int], opacity: float) -> Floats:
    return np.array((*(part / 255.0 for part in color), opacity), np.float32)


def _finish(item: Shaded, shading: Shading) -> int:
    if is_polished(item, shading):
        return 1
    sheen = shading == "clay" and item.finish in SHEENS
    return 2 + list(SHEENS).index(item.finish) if sheen else 0


def surface(items: Sequence[Shaded], palette: Palette, shading: Shading = "clay") -> Batch:
    """Meshes: place 3, normal 3, matter 2, colour 4.

    Matter is whether a mesh has colours of its own, and its finish: 1 is polished, and finishes
    with a sheen follow in their order.

    Vertices are split only at creases.
    """
    vertices, indices, count = [], [], 0
    for item in items:
        mesh = item.mesh
        vertex, normal, corners = _split(mesh)
        colors = _vertex_colors(item, palette, shading)
        block = np.empty((len(vertex), 12), np.float32)
        block[:, :3] = mesh.vertices[vertex]
        block[:, 3:6] = normal
        block[:, 6] = colors is not None
        block[:, 7] = _finish(item, shading)
        if colors is not None:
            block[:, 8:] = colors[vertex].astype(np.float32) / np.float32(255.0)
            block[:, 11] *= item.opacity
        else:
            block[:, 8:] = _rgba(palette.color(item.color), item.opacity)
        vertices.append(block)
        indices.append(corners + np.uint32(count))
        count += len(vertex)
    return Batch(np.concatenate(vertices), (3, 3, 2, 4), np.concatenate(indices))


def textured_surface(item: Shaded, texture: Texture, palette: Palette, shading: Shading) -> Batch:
    """Return the buffer of a mesh with a texture: as `surface`, then place in the picture 2.

    A corner has a vertex of its own where another one has taken the vertex to another place.
    """
    bare = surface([item], palette, shading)
    places = texture.corners.reshape(-1, 2)
    common = np.zeros((len(bare.vertices), 2), np.float32)
    common[bare.indices] = places
    apart = np.flatnonzero((common[bare.indices] != places).any(axis=1))
    block = np.empty((len(common) + len(apart), 14), np.float32)
    block[: len(common), :12], block[: len(common), 12:] = bare.vertices, common
    block[len(common) :, :12] = bare.vertices[bare.indices[apart]]
    block[len(common) :, 12:] = places[apart]
    block[:, 6] = 1.0
    indices = bare.indices.copy()
    indices[apart] = len(common) + np.arange(len(apart), dtype=np.uint32)
    return Batch(block, (*bare.widths, 2), indices)


def _split(mesh: Mesh) -> tuple[NDArray[np.intp], Floats, Indices]:
    """Vertex and normal for each vertex on the card, and the corners of the triangles."""
    normals = corner_normals(mesh)
    if normals.corners is mesh.faces:
        return np.arange(len(mesh.vertices)), normals.vectors, mesh.faces.astype(np.uint32).ravel()
    # A corner is a pair (vertex, normal); equal pairs share one vertex on the card.
    pairs = mesh.faces.astype(np.int64) * len(normals.vectors) + normals.corners
    found, inverse = np.unique(pairs.ravel(), return_inverse=True)
    vertex, normal = np.divmod(found, len(normals.vectors))
    return vertex, normals.vectors[normal], inverse.astype(np.uint32).ravel()


def _vertex_colors(item: Shaded, palette: Palette, shading: Shading) -> NDArray[np.generic] | None:
    if shading == "curvature":
        return curvature_colors(mean_curvature(item.mesh), palette)
    if shading == "draft":
        return draft_colors(item.mesh.vertex_normals(), palette)
    return item.mesh.colors_over(palette.color(item.color))


def strips(items: Sequence[Lines], palette: Palette) -> Batch:
    """Polylines as ribbons: before 3, place 3, after 3, shape 3 (side, width, along), colour 4.

    Two vertices a point, pushed apart on the sheet by the shader.
    """
    vertices, indices, count = [], [], 0
    for item in items:
        color = _rgba(palette.color(item.color), item.opacity)
        width = np.broadcast_to(np.asarray(item.width, np.float32), (len(item.points),))
        for piece in item.pieces():
            points = item.points[piece]
            n = len(points)
            if n < 2:
                continue
            steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
            block = np.empty((n, 2, 16), np.float32)
            block[:, :, 0:3] = np.concatenate((points[:1], points[:-1]))[:, None]
            block[:, :, 3:6] = points[:, None]
            block[:, :, 6:9] = np.concatenate((points[1:], points[-1:]))[:, None]
            if np.array_equal(points[0], points[-1]) and n > 3:  # closed: no seam
                block[0, :, 0:3], block[-1, :, 6:9] = points[-2], points[1]
            block[:, :, 9] = (1.0, -1.0)
            block[:, :, 10] = width[piece][:, None]
            block[:, :, 11] = np.concatenate(((0.0,), np.cumsum(steps)))[:, None]
            block[:, :, 12:] = color
            vertices.append(block.reshape(-1, 16))
            first = count + 2 * np.arange(n - 1, dtype=np.uint32)[:, None]
            corners = np.array((0, 1, 2, 2, 1, 3), np.uint32)
            indices.append((first + corners).ravel())
            count += 2 * n
    if not vertices:
        return Batch(np.zeros((0, 16), np.float32), (3, 3, 3, 3, 4), np.zeros(0, np.uint32))
    return Batch(np.concatenate(vertices), (3, 3, 3, 3, 4), np.concatenate(indices))


def dots(items: Sequence[Points], palette: Palette) -> Batch:
    """Points as discs: place 3, shape 3 (corner x, y, diameter), colour 4."""
    corners = np.array(((-1, -1), (1, -1), (-1, 1), (1, 1)), np.float32)
    vertices = []
    for item in items:
        block = np.empty((len(item.points), 4, 10), np.float32)
        block[:, :, :3] = item.points[:, None]
        block[:, :, 3:5] = corners
        block[:, :, 5] = item.size
        block[:, :, 6:] = _rgba(palette.color(item.color), item.opacity)
        vertices.append(block.reshape(-1, 10))
    joined = np.concatenate(vertices)
    first = 4 * np.arange(len(joined) // 4, dtype=np.uint32)[:, None]
    indices = (first + np.array((0, 1, 2, 2, 1, 3), np.uint32)).ravel()
    return Batch(joined, (3, 3, 4), indices)


def picture(item: Image) -> Batch:
    """Return the buffer of a picture on a rectangle: position 3, texel 2."""
    corner, across, down = (
        np.asarray(v, np.float32) for v in (item.corner, item.across, item.down)
    )
    block = np.zeros((4, 5), np.float32)
    for row, (u, v) in enumerate(((0, 0), (1, 0), (0, 1), (1, 1))):
        block[row] = (*(corner + u * across + v * down), u, v)
    return Batch(block, (3, 2), np.array((0, 1, 2, 2, 1, 3), np.uint32))


def opaque_surfaces(layer: Layer) -> list[Shaded]:
    """Return the opaque meshes of a layer."""
    return [item for item in _surfaces(layer) if not _is_glass(item)]


def glass_surfaces(layer: Layer) -> list[Shaded]:
    """Return the meshes of a layer that let the inside show through."""
    return [item for item in _surfaces(layer) if _is_glass(item)]


def _surfaces(layer: Layer) -> list[Shaded]:
    return [
        i for i in layer.items if isinstance(i, Shaded) and len(i.mesh.faces) and i.opacity > 0.0
    ]


def _is_glass(item: Shaded) -> bool:
    colors = item.mesh.colors
    return item.opacity < 1.0 or (colors is not None and bool((colors[:, 3] < 255).any()))
