"""Surface of a field on a lattice: narrow band, marching cubes, one Newton step.

The mesh of a single part comes from its plan (`bozzetto_silhouette.solid`), which cannot
lose thin walls. This module is for fields that are no height fields any more, such as
blends of several parts.

Its limits: what is thinner than two cells is lost. `ConvolutionField` is not faired, so that
the surface lies where the field does, some hundredths of the local radius from the mesh of
the same part, with the field's ripples. And its `gradient` takes six evaluations, because the
correction follows foot points on a sampled outline, which have no gradient worth the name.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bozzetto_silhouette.field import ConvolutionField

__all__ = ["Lattice", "extract", "narrow_band"]

Points = NDArray[np.float64]

MARGIN = 3
"""Cells outside the solid on every side: a surface that touches the border is no manifold."""

BAND = 2.0
"""Half width of the narrow band, in cells."""


@dataclass(frozen=True, eq=False)
class Lattice:
    """Values of a field on a regular lattice.

    Attributes
    ----------
    values : (nx, ny, nz) float array
        Positive inside.
    origin : (3,) float array
        Position of node (0, 0, 0).
    spacing : float
        Distance of neighbouring nodes.
    """

    values: Points
    origin: Points
    spacing: float

    @property
    def axes(self) -> tuple[Points, Points, Points]:
        """Coordinates of the nodes along x, y and z."""
        x, y, z = (
            o + self.spacing * np.arange(n)
            for o, n in zip(self.origin, self.values.shape, strict=True)
        )
        return x, y, z


def narrow_band(field: ConvolutionField, spacing: float) -> Lattice:
    """Sample a silhouette's field where its surface is; elsewhere only the sign is right.

    The heights over the plane tell where that is, so nothing needs to be searched. Only
    z >= 0 is evaluated and mirrored.

    Parameters
    ----------
    field : ConvolutionField
    spacing : float
        Cell size, in the object frame.

    Returns
    -------
    Lattice
        Symmetric in z, with a layer at z = 0.
    """
    from scipy.ndimage import maximum_filter, minimum_filter

    points = field.rim.points * field.scale + field.origin
    low, high = points.min(axis=0), points.max(axis=0)
    nx, ny = (np.ceil((high - low) / spacing).astype(np.intp) + 2 * MARGIN + 1).tolist()
    start = low - MARGIN * spacing
    x, y = start[0] + spacing * np.arange(nx), start[1] + spacing * np.arange(ny)
    xy = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    height = field.heights(xy).reshape(nx, ny)
    nz = int(np.ceil(height.max() / spacing)) + MARGIN + 1
    z = spacing * np.arange(nz)
    most, least = maximum_filter(height, size=3), minimum_filter(height, size=3)
    reach = BAND * spacing
    band = (z >= (least - reach)[..., None]) & (z <= (most + reach)[..., None])
    band &= (most > 0.0)[..., None]
    values = np.where(z < height[..., None], 1.0, -1.0)
    where = np.nonzero(band)
    values[where] = field.value(np.stack([x[where[0]], y[where[1]], z[where[2]]], axis=1))
    full = np.concatenate([values[:, :, :0:-1], values], axis=2)
    return Lattice(full, np.array([start[0], start[1], -z[-1]]), spacing)


def extract(
    lattice: Lattice,
    value: Callable[[Points], Points] | None = None,
    gradient: Callable[[Points], Points] | None = None,
) -> tuple[Points, NDArray[np.int32], Points]:
    """Closed surface where a field is zero.

    Parameters
    ----------
    lattice : Lattice
        Negative on the border.
    value, gradient : callable, optional
        The exact field at points (n, 3). With both, the vertices take one Newton step and
        the normals come from the gradient; else from the mesh.

    Returns
    -------
    vertices : (v, 3) float array
    faces : (f, 3) int32 array
        Oriented outwards.
    normals : (v, 3) float array

    Notes
    -----
    ``gradient_direction="ascent"`` is what an inside that is positive needs; the default
    gives a solid turned inside out, which nothing complains about.
    """
    from skimage.measure import marching_cubes

    from bozzetto_silhouette.shell import vertex_normals

    vertices, faces, _, _ = marching_cubes(
        lattice.values, 0.0, spacing=(lattice.spacing,) * 3, gradient_direction="ascent"
    )
    vertices = vertices.astype(np.float64) + lattice.origin
    faces = faces.astype(np.int32)
    if value is None or gradient is None:
        return vertices, faces, vertex_normals(vertices, faces)
    slope = gradient(vertices)
    steepness2 = np.maximum((slope**2).sum(axis=1), 1e-30)
    move = -(value(vertices) / steepness2)[:, None] * slope
    # Where the field is flat the step would overshoot: half a cell is the most it may be off.
    length = np.sqrt((move**2).sum(axis=1))
    move *= np.minimum(1.0, 0.5 * lattice.spacing / np.maximum(length, 1e-300))[:, None]
    normals = -slope / np.sqrt(steepness2)[:, None]
    return vertices + move, faces, normals
