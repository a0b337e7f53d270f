"""A picture projected on a surface along its own normal.

Both sides get the same place of the picture: the back sees it mirrored, so that it lies right
on the silhouette (as in *Monster Mash*, Dvorožňák et al., 2020). Where the surface turns away
from the picture a plain projection would draw pixels out to streaks, and catch what lies
beyond the drawn line. There the place moves inwards, against the normal, and the picture goes
over into a softened one: the sides continue what is seen just inside their edge.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Array
from bozzetto.plugin import remembered
from bozzetto_silhouette.appearance.vertex_colors import Coat
from bozzetto_silhouette.model.state import Picture

Pixels = NDArray[np.float32]

INSET = 0.06
"""How far the place in the picture moves inwards on the steepest sides, as a share of the
largest inscribed radius: more than a traced line lies beside the drawn one."""

STEEP = 0.35
"""Component of the normal along the projection below which the sides begin: there a pixel is
drawn out to three times its length."""

SOFTENING = 0.5
"""Standard deviation by which the picture is softened for the sides, as a share of the inset:
from there little of what lies beyond the edge is seen."""

SOFT_SIDE = 256
"""Longest side of the softened picture, pixels: it is smooth, so few tell all."""


class Level(NamedTuple):
    """A picture at one fineness.

    Attributes
    ----------
    pixels : (h, w, 4) float32
        sRGB 0 to 255 multiplied by the alpha, alpha 0 to 1; with a border of one pixel that
        repeats the outermost.
    extent : (2,) float array
        Width and height without the border, which need not be whole.
    """

    pixels: Pixels
    extent: Array


@dataclass(frozen=True, eq=False)
class Projection:
    """A picture ready to be projected on points.

    Attributes
    ----------
    picture : Picture
    sharp, soft : Level
    inset : float
        mm.
    """

    picture: Picture
    sharp: Level
    soft: Level
    inset: float

    def coat(self, points: Array, normals: Array) -> Coat:
        """Return the colours of surface points (n, 3) with unit normals (n, 3)."""
        picture = self.picture
        edges = np.column_stack([picture.across, picture.down]).astype(np.float64)
        facing = normals @ axes_of(picture)[2]
        # What points at the viewer has no part in the plane of the picture, so the normal
        # itself leads inwards there.
        in_plane = np.linalg.pinv(edges).T
        uv = points @ in_plane - self.inset * (normals @ in_plane) - picture.corner @ in_plane
        steep = 1.0 - _smooth_step(np.abs(facing) / STEEP)
        values = _sampled(self.sharp, uv)
        sides = np.flatnonzero(steep > 0.0)
        softened = _sampled(self.soft, uv[sides])
        values[sides] += steep[sides, None].astype(np.float32) * (softened - values[sides])
        return Coat(values[:, :3].astype(np.float64), values[:, 3].astype(np.float64))


def projection_of(picture: Picture, radius: float, detail: float) -> Projection:
    """Prepare a picture for a surface.

    Parameters
    ----------
    picture : Picture
        The picture and its rectangle.
    radius : float
        The largest inscribed radius of the solid, mm.
    detail : float
        Distance between the points at which it will be asked, mm: pixels that are smaller
        are averaged.
    """
    inset, texel = INSET * radius, texel_of(picture)
    longest = max(picture.pixels.shape[:2])
    few = 1 << max(0, (longest - 1) // SOFT_SIDE).bit_length()
    soft = _softened(_level(picture, few), SOFTENING * inset / (texel * few))
    finest = 1
    while 2 * finest <= min(detail / texel, longest):
        finest *= 2
    return Projection(picture, _level(picture, finest), soft, inset)


def texel_of(picture: Picture) -> float:
    """Return the size of a pixel of the picture, mm."""
    height, width = picture.pixels.shape[:2]
    across, down = (float(np.linalg.norm(edge)) for edge in (picture.across, picture.down))
    return float(max(min(across / width, down / height), 1e-300))


def axes_of(picture: Picture) -> Array:
    """Return orthonormal rows (3, 3): the picture's right, its down, and towards its viewer."""
    edges = np.column_stack([picture.across, picture.down]).astype(np.float64)
    square = np.linalg.qr(edges, mode="complete")[0].T
    along = np.sign((square[:2] * edges.T).sum(axis=1))
    square[:2] *= np.where(along == 0.0, 1.0, along)[:, None]
    square[2] = np.cross(square[1], square[0])
    return np.asarray(square, np.float64)


@remembered(limit=4)  # few, because the finest one of a large picture takes 64 megabytes
def _level(picture: Picture, factor: int) -> Level:
    """Average `factor` times `factor` pixels of a picture into one."""
    pixels = picture.pixels
    height, width = pixels.shape[:2]
    short = (-height % factor, -width % factor)
    whole = np.pad(pixels, ((0, short[0]), (0, short[1]), (0, 0)), "edge").astype(np.float32)
    whole[..., 3] *= np.float32(1.0 / 255.0)
    whole[..., :3] *= whole[..., 3:]
    rows, columns = whole.shape[0] // factor, whole.shape[1] // factor
    squares = whole.reshape(rows, factor, columns, factor, 4).mean(axis=(1, 3))
    bordered = np.pad(squares, ((1, 1), (1, 1), (0, 0)), "edge")
    return Level(bordered, np.array([width, height], np.float64) / factor)


def _softened(level: Level, sigma: float) -> Level:
    from scipy.ndimage import gaussian_filter

    sigma = min(sigma, float(max(level.extent)))
    softened = gaussian_filter(level.pixels, (sigma, sigma, 0), mode="nearest")
    return Level(np.asarray(softened, np.float32), level.extent)


def _sampled(level: Level, uv: Array) -> Pixels:
    """Sample a picture (n, 4) at places (n, 2), 0 to 1 from edge to edge; clear outside."""
    width = level.pixels.shape[1]
    places = np.clip(uv, 0.0, 1.0) * level.extent + 0.5
    corner = places.astype(np.intp)
    fx, fy = (places - corner).astype(np.float32).T[..., None]
    first = corner[:, 1] * width + corner[:, 0]
    flat = level.pixels.reshape(-1, 4)
    upper, lower = (
        flat.take(row, 0) * (1 - fx) + flat.take(row + 1, 0) * fx for row in (first, first + width)
    )
    values: Pixels = upper * (1 - fy) + lower * fy
    values[((uv < 0.0) | (uv > 1.0)).any(axis=1)] = 0.0
    return values


def _smooth_step(t: Array) -> Array:
    t = np.clip(t, 0.0, 1.0)
    return np.asarray(t * t * (3.0 - 2.0 * t), np.float64)
