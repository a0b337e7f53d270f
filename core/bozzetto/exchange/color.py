"""Colours of parts and vertices, between sRGB and linear light."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bozzetto.geometry.shapes import Solid, Surface

WHITE: Final = (255, 255, 255)
"""The colour of what has none, in files that must have one."""

KNEE: Final = 0.04045
"""End of the straight part of the sRGB curve (IEC 61966-2-1)."""


def srgb_to_linear(values: ArrayLike) -> NDArray[np.float64]:
    """Convert sRGB values 0 … 255 to linear light 0 … 1."""
    v = np.asarray(values, float) / 255.0
    return np.where(v <= KNEE, v / 12.92, ((v + 0.055) / 1.055) ** 2.4)


def linear_to_srgb(values: ArrayLike) -> NDArray[np.uint8]:
    """Encode linear light 0 … 1 as sRGB values 0 … 255; what lies outside is clipped."""
    v = np.clip(np.nan_to_num(np.asarray(values, float)), 0.0, 1.0)
    coded = np.where(v <= KNEE / 12.92, 12.92 * v, 1.055 * v ** (1 / 2.4) - 0.055)
    return np.asarray(np.rint(255.0 * coded), np.uint8)


def vertex_colors(part: Solid | Surface) -> NDArray[np.uint8] | None:
    """Return RGBA of every vertex, (v, 4): the mesh's own, else the part's colour, else None.

    Where the mesh's own do not cover a part without a colour, it is white.
    """
    if part.mesh.colors is not None:
        return part.mesh.colors_over(part.color or WHITE)
    if part.color is None:
        return None
    return np.tile(np.array((*part.color, 255), np.uint8), (len(part.mesh.vertices), 1))
