"""Baking: the colours of a surface, painted into a picture that is wrapped around it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Array, Faces, Flags, Index
from bozzetto.geometry import Texture
from bozzetto_silhouette.appearance.uv_charts import Layout, laid_out
from bozzetto_silhouette.appearance.vertex_colors import Coat

Paint = Callable[[Index, Array, float], Coat]
"""Colours of points on a surface from their faces (n,), their barycentric weights (n, 3), and
the distance between them, mm."""

LEAST = 1024
"""Longest side of a picture at least, texels: where one is looked at closely smaller ones show
their texels."""

AT_ONCE = 1 << 17
"""Texels coloured in one sweep: their arrays stay in the processor's cache."""


def baked(vertices: Array, faces: Faces, axes: Array, density: float, paint: Paint) -> Texture:
    """Lay a closed mesh out and colour every texel.

    Parameters
    ----------
    vertices : (v, 3) float array
        Corners of the mesh, mm.
    faces : (f, 3) int array
        Oriented outwards.
    axes : (3, 3) float array
        Rows: orthonormal; along them the surface is projected.
    density : float
        Texels per mm that are wanted; more where the picture would be smaller than `LEAST`.
    paint : callable
        Gives the colours of points on the surface.
    """
    layout = laid_out(vertices, faces, axes, max(density, _least_density(vertices, faces, axes)))
    texel, face, weights = _texels(layout)
    width, height = layout.size
    pixels = np.zeros((width * height, 4), np.uint8)
    for first in range(0, len(texel), AT_ONCE):
        part = slice(first, first + AT_ONCE)
        rgba, cover = paint(face[part], weights[part], 1.0 / layout.density).bytes()
        rgba[:, 3] = cover
        pixels[texel[part]] = rgba
    known = np.zeros(width * height, bool)
    known[texel] = True
    _spread(pixels.reshape(height, width, 4), known.reshape(height, width))
    corners = (layout.places / layout.size).astype(np.float32)
    return Texture(pixels.reshape(height, width, 4), corners)


def _least_density(vertices: Array, faces: Faces, axes: Array) -> float:
    """Return the texels per mm from which a surface fills more than half of a least picture.

    Faces are counted as large as they are seen along the axis that shows them best.
    """
    corners = vertices[faces] @ axes.T
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = 0.5 * float(np.abs(across).max(axis=1).sum())
    return float(LEAST * np.sqrt(0.5 / max(area, 1e-300)))


def _texels(layout: Layout) -> tuple[Index, Index, Array]:
    """Return the texels of the atlas, the face that each shows, and the place on it.

    A face too thin to cover the middle of a texel shows at those that its corners are in, if
    nothing else does.
    """
    width = layout.size[0]
    owner = layout.texels.triangle
    texel = np.flatnonzero(owner >= 0)
    face = owner[texel].astype(np.int64)
    middle = np.column_stack([texel % width, texel // width]).astype(np.float64) + 0.5
    weights = _barycentric(layout.places[face], middle)
    spots = np.floor(layout.places).astype(np.int64).reshape(-1, 2)
    spot = spots[:, 1] * width + spots[:, 0]
    free = np.flatnonzero(owner[spot] < 0)
    chosen, first = np.unique(spot[free], return_index=True)
    corner = free[first]
    return (
        np.concatenate([texel, chosen]),
        np.concatenate([face, corner // 3]),
        np.concatenate([weights, np.eye(3)[corner % 3]]),
    )


def _barycentric(corners: Array, points: Array) -> Array:
    """Return the weights (n, 3) of the corners (n, 3, 2) at points (n, 2)."""
    (ax, ay), (bx, by) = (corners[:, k].T - corners[:, 0].T for k in (1, 2))
    px, py = points.T - corners[:, 0].T
    area = ax * by - ay * bx
    area = np.where(area == 0.0, 1.0, area)
    second, third = (px * by - py * bx) / area, (ax * py - ay * px) / area
    return np.column_stack([1.0 - second - third, second, third])


def _spread(pixels: NDArray[np.uint8], known: Flags) -> None:
    """Fill every unknown texel with the colour of the nearest known one, in place.

    So neither the seams of charts nor smaller copies of the picture show what is between.
    """
    from scipy.ndimage import distance_transform_edt

    nearest = distance_transform_edt(~known, return_distances=False, return_indices=True)
    pixels[:] = pixels[tuple(nearest)]
