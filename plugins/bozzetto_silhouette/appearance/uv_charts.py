"""Charts: a surface cut into pieces that lie flat side by side in one picture.

Faces whose normals are nearest to the same of six directions form one chart and
are projected along that direction, so nothing is drawn out by more than the square root of
three. Where a chart would cover itself, what is behind becomes a chart of its own.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from bozzetto.arrays import Array, Faces, Index
from bozzetto.scene import DepthBuffer, blank_buffer, rasterize
from bozzetto_silhouette.numerics.grouping import connected_pieces, face_neighbours

MOST = 2048
"""Longest side of an atlas, texels: what every graphics card takes."""

PADDING = 2
"""Texels around every chart: mixing neighbours reaches one, rounding another."""

TURN = 0.25
"""Component of a face's normal along the direction of a neighbouring chart above which it may
join that one: charts get smoother borders, and are still drawn out by no more than four."""

ROUNDS = 3
"""How often faces between charts join the one that most of their neighbours are in."""

SHRINK = 0.9
"""Factor on the texels per mm until the atlas is no larger than allowed."""

PEELS = 8
"""How often what is hidden within a chart is taken out of it. The last peel takes the faces
one by one."""


class Layout(NamedTuple):
    """Places of all faces in the atlas.

    Attributes
    ----------
    places : (f, 3, 2) float array
        Of the corners, texels from the top left: right and down.
    size : (int, int)
        Width and height in texels, powers of two.
    density : float
        Texels per mm.
    texels : Buffer
        Which face owns each texel whose middle it covers.
    """

    places: Array
    size: tuple[int, int]
    density: float
    texels: DepthBuffer


def laid_out(vertices: Array, faces: Faces, axes: Array, density: float) -> Layout:
    """Lay a closed mesh out without overlaps.

    Parameters
    ----------
    vertices : (v, 3) float array
        Corners of the mesh, mm.
    faces : (f, 3) int array
        Oriented outwards.
    axes : (3, 3) float array
        Rows: orthonormal; charts are projected along them.
    density : float
        Texels per mm that are wanted; fewer where the atlas would be too large.
    """
    corners = vertices[faces] @ axes.T
    beside = face_neighbours(faces, int(faces.max(initial=0)) + 1)
    label = _labels(corners, beside)
    layer = np.zeros(len(faces), np.int64)
    for peel in range(PEELS + 1):
        chart = _components(beside, label * (PEELS + 2) + layer)
        layout = _packed(_flat(corners, label), chart, density)
        hidden = _hidden(layout, corners, label)
        if not len(hidden):
            break
        layer[hidden] = peel + 1
        if peel == PEELS - 1:
            beside = np.where(layer[:, None] == peel + 1, -1, beside)
    return layout


def _labels(corners: Array, beside: Index) -> Index:
    """Return the direction that each face looks to: 2 axis + (1 where it looks against that)."""
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    towards = np.stack([normal, -normal], axis=2).reshape(-1, 6)
    label: Index = towards.argmax(axis=1)
    rows = np.arange(len(label))
    for _ in range(ROUNDS):
        around = np.where(beside >= 0, label[beside], label[:, None])
        first, second, third = around.T
        most = np.where((first == second) | (first == third), first, second)
        agreed = (first == second) | (first == third) | (second == third)
        label = np.where(agreed & (towards[rows, most] > TURN), most, label)
    return label


def _components(beside: Index, kind: Index) -> Index:
    """Return for each face the number of the connected region of one kind that it is in."""
    face, side = np.nonzero((beside >= 0) & (kind[beside] == kind[:, None]))
    _, number = connected_pieces(face, beside[face, side], len(kind))
    return number.astype(np.int64)


def _flat(corners: Array, label: Index) -> Array:
    """Project corners along the direction of their chart, (f, 3, 2)."""
    axis = label // 2
    right, down = np.where(axis == 0, 2, 0), np.where(axis == 1, 2, 1)
    rows = np.arange(len(label))[:, None]
    sides = np.arange(3)[None]
    return np.stack([corners[rows, sides, right[:, None]], corners[rows, sides, down[:, None]]], 2)


def _packed(flat: Array, chart: Index, density: float) -> Layout:
    """Pack charts on shelves, the highest first, in the smallest atlas that holds them."""
    count = int(chart.max(initial=0)) + 1
    low = np.full((count, 2), np.inf)
    high = np.full((count, 2), -np.inf)
    np.minimum.at(low, chart, flat.min(axis=1))
    np.maximum.at(high, chart, flat.max(axis=1))
    reach, most = float((high - low).max(initial=0.0)), MOST
    density = min(density, most / max(reach, 1e-300))
    while (shelves := _shelved(_extents(high - low, density), most)) is None:
        if reach * density > 1.0:
            density *= SHRINK
        else:  # so many charts that a texel for each is too much
            most *= 2
    corner, size = shelves
    places = (flat - low[chart][:, None]) * density + (corner[chart] + PADDING + 0.5)[:, None]
    return Layout(places, size, density, blank_buffer(*size))


def _extents(spans: Array, density: float) -> Index:
    return np.asarray(np.ceil(spans * density), np.int64) + 2 * PADDING + 1


def _shelved(extents: Index, most: int) -> tuple[Index, tuple[int, int]] | None:
    """Place rectangles (n, 2): their top left corners and the atlas's size; None if too many."""
    order = np.argsort(-extents[:, 1], kind="stable")
    least = int(extents.prod(axis=1).sum())
    for width, height in _sizes(most):
        if width * height < least or width < int(extents[:, 0].max()):
            continue
        corner = np.zeros_like(extents)
        x = y = shelf = 0
        for index in order.tolist():
            across, down = extents[index].tolist()
            if x + across > width:
                x, y, shelf = 0, y + shelf, 0
            if y + down > height:
                break
            corner[index] = x, y
            x, shelf = x + across, max(shelf, down)
        else:
            return corner, (width, height)
    return None


def _sizes(most: int) -> list[tuple[int, int]]:
    """Return sizes of atlases, ascending: squares and those of half the height."""
    sizes, side = [], 64
    while side <= most:
        sizes += [(side, side // 2), (side, side)]
        side *= 2
    return sizes


def _hidden(layout: Layout, corners: Array, label: Index) -> Index:
    """Find faces that lie behind another one somewhere in the atlas, and fill `layout.texels`."""
    axis, against = label // 2, label % 2
    depth = corners[np.arange(len(label))[:, None], np.arange(3)[None], axis[:, None]]
    depth = np.where(against[:, None] == 1, -depth, depth)
    places = np.concatenate([layout.places, depth[..., None]], axis=2).reshape(-1, 3)
    faces = np.arange(len(places), dtype=np.int32).reshape(-1, 3)
    rasterize(layout.texels, places, faces)
    behind = blank_buffer(*layout.size)
    rasterize(behind, places * (1.0, 1.0, -1.0), faces)
    differs = behind.triangle != layout.texels.triangle
    return np.unique(behind.triangle[differs]).astype(np.int64)
