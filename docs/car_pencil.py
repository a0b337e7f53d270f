"""A sheet of paper, a marker and a pencil that trembles: what the drawn cars are drawn with.

All is arithmetic on arrays of the size of the sheet: ink and tones are shares of light taken away.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray
from PIL import Image
from scipy.ndimage import gaussian_filter

Array = NDArray[np.float64]
Color = tuple[int, int, int]

PAPER: Color = (247, 243, 233)
GRAPHITE: Color = (38, 40, 50)
"""Colours, sRGB."""

STEP = 0.6
"""Way between two touches of the pencil, px."""

TOUCH = 3
"""Half the side of the square of pixels that a touch may darken, px."""

BROAD = 17.0
"""Width of the marker, px."""

COLORS, RARE = 64, 24
"""Colours of a finished picture, frequent and rare ones: 300 kB must do."""

COARSE = (0.30, 0.68)
"""Tooth of the paper below and above which it catches the light, and loses it."""


class Sheet:
    """A drawing in the making.

    Parameters
    ----------
    width, height : int
        px.
    rng : Generator
        Of the hand and of the paper.
    """

    def __init__(self, width: int, height: int, rng: np.random.Generator) -> None:
        self.width, self.height, self.rng = width, height, rng
        self.light = np.ones((height, width, 3)) * np.array(PAPER) / 255.0
        fine = gaussian_filter(rng.normal(size=(height, width)), 0.8)
        self.tooth = (fine - fine.min()) / np.ptp(fine)
        rows, columns = np.mgrid[0:height, 0:width]
        self.places = np.stack((columns, rows), axis=-1).astype(float)

    # -- marker --

    def fill(self, cover: Array, color: Color, strength: float, slant: float = 62.0) -> None:
        """Marker over a mask.

        Parameters
        ----------
        cover : (height, width) float
            Share of the tone, 0 … 1.
        color : (r, g, b)
        strength : float
            How much of the paper the marker covers where it was drawn once, 0 … 1.
        slant : float
            Direction of the marker's strokes, degrees.
        """
        band, inside = self.bands(slant)
        shade = self.rng.normal(1.0, 0.07, band.max() + 1)[band]
        shade = shade + 0.14 * np.clip(1.0 - inside * 7.0, 0.0, 1.0)  # strokes overlap
        self._take(np.clip(cover * strength * shade, 0.0, 1.0), color)

    def bands(self, slant: float) -> tuple[NDArray[np.intp], Array]:
        """Which stroke of the marker each pixel is in, and where across it, 0 … 1."""
        turn = np.radians(slant)
        along = self.places @ np.array([np.cos(turn), np.sin(turn)])
        across = self.places @ np.array([-np.sin(turn), np.cos(turn)]) / BROAD
        across += 0.15 * np.sin(along / 90.0)
        band = np.floor(across).astype(np.intp)
        return band - band.min(), across - band

    def _take(self, share: Array, color: Color) -> None:
        kept = 1.0 - np.array(color) / 255.0
        self.light *= 1.0 - share[..., None] * kept

    # -- pencil --

    def line(
        self,
        path: ArrayLike,
        width: float = 1.5,
        dark: float = 0.8,
        *,
        tremor: float = 0.7,
        overshoot: float = 8.0,
        color: Color = GRAPHITE,
        white: bool = False,
    ) -> None:
        """One stroke along a path (k, 2), px.

        Parameters
        ----------
        path : (k, 2) array_like
        width : float
            px, where the pencil is pressed most.
        dark : float
            0 … 1.
        tremor : float
            Standard deviation of the slowest wave of the hand, px.
        overshoot : float
            How far the stroke goes on beyond its ends, px, on the average.
        color : (r, g, b)
        white : bool
            Whether it covers what is below, like white gouache.
        """
        rng = self.rng
        way = extended(np.asarray(path, float), overshoot * rng.uniform(0.4, 1.6, 2))
        way, along = evenly(way, STEP)
        length = along[-1]
        if length < 2.0:
            return
        share = along[:, None] / length
        waves = np.arange(1, max(4, int(length / 60.0)))
        sway = rng.normal(0.0, 1.0, (2, len(waves))) / waves**0.9
        phase = rng.uniform(0.0, 2.0 * np.pi, (2, len(waves)))
        for axis in (0, 1):
            way[:, axis] += tremor * np.sin(np.pi * share * waves + phase[axis]) @ sway[axis]
        ends = np.minimum(along, length - along) / (0.10 * length + 6.0)
        press = 0.25 + 0.75 * np.sqrt(np.clip(ends, 0.0, 1.0))
        slow = np.sin(2.0 * np.pi * (share * length / rng.uniform(160, 420) + rng.uniform()))
        press = press * (0.88 + 0.12 * slow[:, 0])
        self._touch(
            way, width * (0.55 + 0.45 * press), np.clip(1.15 * dark * press, 0.0, 1.0), color, white
        )

    def _touch(self, way: Array, width: Array, dark: Array, color: Color, white: bool) -> None:
        low = np.floor(way.min(axis=0)).astype(int) - TOUCH
        high = np.ceil(way.max(axis=0)).astype(int) + TOUCH + 1
        low = np.maximum(low, 0)
        high = np.minimum(high, (self.width, self.height))
        if (high <= low).any():
            return
        cover = np.zeros((high[1] - low[1], high[0] - low[0]))
        nearest = np.round(way).astype(int)
        for dy in range(-TOUCH, TOUCH + 1):
            for dx in range(-TOUCH, TOUCH + 1):
                at = nearest + np.array([dx, dy])
                inside = ((at >= low) & (at < high)).all(axis=1)
                off = np.hypot(*(at[inside] - way[inside]).T)
                share = dark[inside] * np.clip(0.5 * width[inside] + 0.5 - off, 0.0, 1.0)
                np.maximum.at(cover, (at[inside, 1] - low[1], at[inside, 0] - low[0]), share)
        here = np.s_[low[1] : high[1], low[0] : high[0]]
        # The tooth of the paper keeps light strokes from covering it.
        cover = np.clip(cover * (1.25 - 0.9 * self.tooth[here] * (1.0 - 0.6 * cover)), 0.0, 1.0)
        if white:
            self.light[here] += cover[..., None] * (1.0 - self.light[here])
        else:
            self.light[here] *= 1.0 - cover[..., None] * (1.0 - np.array(color) / 255.0)

    # -- the picture --

    def save(self, path: Path) -> None:
        """Write the sheet with its grain, in few colours."""
        grain = np.select([self.tooth > COARSE[1], self.tooth < COARSE[0]], [-0.030, 0.014], 0.0)
        pixels = np.clip((self.light + grain[..., None]) * 255.0, 0, 255).astype(np.uint8)
        image = Image.fromarray(pixels)
        # The second rule finds colours that are rare and far from all others, such as a lamp's.
        frequent = image.quantize(COLORS, Image.Quantize.MEDIANCUT).getpalette() or []
        covering = image.quantize(RARE, Image.Quantize.MAXCOVERAGE).getpalette() or []
        both = Image.new("P", (1, 1))
        both.putpalette(frequent[: 3 * COLORS] + covering[: 3 * RARE])
        image.quantize(palette=both, dither=Image.Dither.NONE).save(path, optimize=True)

    def clear(self, cover: Array) -> None:
        """Bare paper again, over a mask (height, width) of shares."""
        self.light += cover[..., None] * (np.array(PAPER) / 255.0 - self.light)


def extended(path: Array, by: ArrayLike) -> Array:
    """A path that goes on straight beyond its start and its end, px."""
    before, after = np.asarray(by, float)
    reach = min(6, len(path) - 1)
    first, last = path[0] - path[reach], path[-1] - path[-1 - reach]
    ways = [way / max(float(np.linalg.norm(way)), 1e-9) for way in (first, last)]
    return np.vstack((path[0] + before * ways[0], path, path[-1] + after * ways[1]))


def evenly(path: Array, step: float) -> tuple[Array, Array]:
    """A path resampled at even steps, and the way along it, px."""
    pieces = np.linalg.norm(np.diff(path, axis=0), axis=1)
    kept = np.concatenate(([True], pieces > 1e-6))
    path = path[kept]
    along = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))))
    even = np.linspace(0.0, along[-1], max(2, int(along[-1] / step)))
    return np.column_stack([np.interp(even, along, path[:, axis]) for axis in (0, 1)]), even
