"""Textures on visible surfaces: from places in a picture to colours.

A picture that is seen smaller than it is is sampled from a level of detail for each triangle
(Williams 1983, "Pyramidal parametrics"), bilinear.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from bozzetto.scene.renderer.mipmaps import bilinear, level
from bozzetto.scene.renderer.shading import Fragments, at_pixels

if TYPE_CHECKING:
    from bozzetto.arrays import Array, Bytes, Floats, Index
    from bozzetto.geometry.texture import Texture
    from bozzetto.scene.renderer.triangle_soup import Soup
    from bozzetto.scene.renderer.view_transform import ViewTransform

LEAST_SIDE: Final = 8
"""Shorter side of the smallest level of detail, texels; smaller ones mix what lies far apart."""


def with_textures(
    seen: Fragments,
    soup: Soup,
    textures: Sequence[Texture | None],
    sight: ViewTransform,
) -> Fragments:
    """Lay textures over the colours of visible surfaces.

    Parameters
    ----------
    seen : Fragments
        The visible surface, with the colours of its vertices.
    soup : Soup
        The triangles on the sheet, with their places in the textures.
    textures : sequence of Texture or None
        That of each mesh.
    sight : ViewTransform
        The transform of the window.
    """
    if soup.texels is None:
        return seen
    color = seen.color.copy()
    part = soup.part[seen.triangle]
    for k, texture in enumerate(textures):
        own = np.flatnonzero(part == k)
        if texture is None or not len(own):
            continue
        pixel, triangle = seen.pixel[own], seen.triangle[own]
        across, down = at_pixels(pixel, triangle, soup.texels, soup, sight)
        halved = _halvings(texture, soup, np.flatnonzero(soup.part == k))[triangle]
        for times in np.flatnonzero(np.bincount(halved)).tolist():
            there = np.flatnonzero(halved == times)
            smaller = level(texture.pixels, 1 << times, 1 << times)
            height, width = smaller.shape[:2]
            texels = bilinear(smaller, across[there] * width, down[there] * height)
            over = color.take(own[there], axis=0)
            over[:, :3] *= np.float32(1) - texels[:, 3:] * np.float32(1 / 255)
            over[:, :3] += texels[:, :3]
            color[own[there]] = over
    return replace(seen, color=color)


def _halvings(texture: Texture, soup: Soup, triangles: Index) -> Index:
    """Return how often to halve a texture for each triangle of a scene; 0 for those of others."""
    height, width = texture.pixels.shape[:2]
    assert soup.texels is not None
    in_picture = _doubled_areas(soup.texels[triangles] * np.array((width, height), np.float32))
    on_sheet = _doubled_areas(soup.places[:, :2][soup.faces[triangles]])
    ratio = np.divide(in_picture, on_sheet, out=np.ones(len(on_sheet)), where=on_sheet > 0)
    # Half of the logarithm of the ratio of areas is that of lengths.
    times = np.rint(0.5 * np.log2(np.maximum(ratio, 1.0)))
    halvings = np.zeros(len(soup.faces), np.intp)
    halvings[triangles] = np.minimum(times, smallest_level(texture.pixels))
    return halvings


def smallest_level(pixels: Bytes) -> int:
    """Return how often a picture (h, w, 4) is halved at most."""
    return max(0, int(np.log2(max(min(pixels.shape[:2]) / LEAST_SIDE, 1.0))))


def _doubled_areas(corners: Array | Floats) -> Array:
    """Return twice the areas of triangles (t, 3, 2)."""
    one, two = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    return np.asarray(np.abs(one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0]), np.float64)
