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

from bozzetto_silhouette.coloring import Coat
from bozzetto_silhouette.memory import Memory
from bozzetto_silhouette.state import Picture

__all__ = ["Projection", "projection_of"]

Array = NDArray[np.float64]
Pixels = NDArray[np.float32]

INSET = 0.06
"""How far the place in the picture moves inwards on the steepest sides, as a share of the
largest inscribed radius: more than a traced line lies beside the drawn one."""

STEEP = 0.35
"""Component of the normal along the projection below which the sides begin: there a pixel is
drawn out to three times its length."""

SOFT_SIDE = 256
"""Longest side of the softened picture, pixels: it is smooth, so few tell all."""

_projections: Memory[Projection] = Memory(limit=8)


class Level(NamedTuple):
    """A picture at one fineness.

    Attributes
    ----------
    pixels : (h, w, 4) float32
        sRGB 0 to 255 multiplied by the alpha, alpha 0 to 1.
    extent : (2,) float array
        Width and height in these pixels, which need not be whole.
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
        """Colours of surface points (n, 3) with unit normals (n, 3)."""
        picture = self.picture
        edges = np.column_stack([picture.across, picture.down])
        towards = np.cross(picture.down, picture.across)
        towards /= max(float(np.linalg.norm(towards)), 1e-300)
        facing = normals @ towards
        sideways = normals - facing[:, None] * towards
        places = points - self.inset * sideways - picture.corner
        uv = places @ np.linalg.pinv(edges).T
        steep = 1.0 - _smooth_step(np.abs(facing) / STEEP)
        values = _sampled(self.sharp, uv)
        sides = np.flatnonzero(steep > 0.0)
        softened = _sampled(self.soft, uv[sides])
        values[sides] += steep[sides, None] * (softened - values[sides])
        return Coat(values[:, :3], values[:, 3])


def projection_of(picture: Picture, radius: float, detail: float) -> Projection:
    """A picture ready for a surface.

    Parameters
    ----------
    radius : float
        The largest inscribed radius of the solid, mm.
    detail : float
        Distance between the points at which it will be asked, mm: pixels that are smaller
        are averaged.
    """
    inset = INSET * radius

    def work() -> Projection:
        height, width = picture.pixels.shape[:2]
        sizes = [np.linalg.norm(picture.across) / width, np.linalg.norm(picture.down) / height]
        texel = max(float(min(sizes)), 1e-300)
        alpha = picture.pixels[..., 3:].astype(np.float32) / np.float32(255)
        values = np.concatenate([picture.pixels[..., :3] * alpha, alpha], axis=2)
        whole = Level(values, np.array([width, height], np.float64))
        sharp = _reduced(whole, int(np.clip(round(detail / texel), 1, max(height, width))))
        factor = -(-max(height, width) // SOFT_SIDE)
        soft = _softened(_reduced(whole, factor), inset / (texel * factor))
        return Projection(picture, sharp, soft, inset)

    return _projections.recall((picture, radius, detail), work)


def _reduced(level: Level, factor: int) -> Level:
    """The picture with its pixels averaged in squares."""
    pixels = level.pixels
    if factor <= 1:
        return level
    rows, columns = (-(-size // factor) for size in pixels.shape[:2])
    shape = (rows * factor - pixels.shape[0], columns * factor - pixels.shape[1])
    padded = np.pad(pixels, ((0, shape[0]), (0, shape[1]), (0, 0)), "edge")
    squares = padded.reshape(rows, factor, columns, factor, 4)
    return Level(np.asarray(squares.mean(axis=(1, 3)), np.float32), level.extent / factor)


def _softened(level: Level, sigma: float) -> Level:
    from scipy.ndimage import gaussian_filter

    sigma = min(sigma, float(max(level.extent)))
    softened = gaussian_filter(level.pixels, (sigma, sigma, 0), mode="nearest")
    return Level(np.asarray(softened, np.float32), level.extent)


def _sampled(level: Level, uv: Array) -> Array:
    """Bilinear values (n, 4) at places (n, 2), 0 to 1 from edge to edge; clear outside."""
    pixels = level.pixels
    rows, columns = pixels.shape[:2]
    x, y = (np.clip(uv, -1.0, 2.0) * level.extent - 0.5).T
    left, top = np.floor(x), np.floor(y)
    fx, fy = (x - left)[:, None], (y - top)[:, None]
    inside = np.asarray((uv >= 0.0) & (uv <= 1.0)).all(axis=1)

    def at(down: int, right: int) -> Array:
        row = np.clip(top + down, 0, rows - 1).astype(np.intp)
        column = np.clip(left + right, 0, columns - 1).astype(np.intp)
        return np.asarray(pixels[row, column], np.float64)

    upper = at(0, 0) * (1.0 - fx) + at(0, 1) * fx
    lower = at(1, 0) * (1.0 - fx) + at(1, 1) * fx
    return np.where(np.reshape(inside, (-1, 1)), upper * (1.0 - fy) + lower * fy, 0.0)


def _smooth_step(t: Array) -> Array:
    t = np.clip(t, 0.0, 1.0)
    return np.asarray(t * t * (3.0 - 2.0 * t), np.float64)
