"""Drawings on paper as a camera or a scanner sees them, from lines that are known.

A pencil leaves more graphite on the grain than beside it; the paper has fibres and stains; the
light falls off, a hand throws a shadow with a soft border; the sensor is noisy and the file is a
JPEG.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw
from scipy import ndimage

from bozzetto.ink.trace.photographed_page import homography

Points = NDArray[np.float64]

FINER = 2
"""Pixels of the pencil's mask for one of the picture, along a side."""


@dataclass(frozen=True)
class Conditions:
    """How bad the picture is.

    Parameters
    ----------
    width : float
        Width of the line, in shares of the longer side.
    graphite : float
        Darkness of a line at full pressure.
    grain : float
        How much of it the paper's grain takes away.
    texture : float
        Standard deviation of the paper's brightness.
    shadow : float
        Darkness of the hand's shadow.
    falloff : float
        How much darker one side is than the other.
    noise : float
        Standard deviation of the sensor's noise.
    quality : int
        Of the JPEG.
    photograph : bool
        Whether the page lies on a table and is seen from the side.
    """

    width: float = 0.0045
    graphite: float = 0.62
    grain: float = 0.45
    texture: float = 0.012
    shadow: float = 0.30
    falloff: float = 0.25
    noise: float = 0.02
    quality: int = 72
    photograph: bool = False


SCAN = Conditions(texture=0.006, shadow=0.0, falloff=0.05, noise=0.008, quality=88)
PHONE = Conditions()
FAINT = Conditions(graphite=0.38, grain=0.6, noise=0.025, quality=60)
TABLE = Conditions(photograph=True)


def _noise(rng: np.random.Generator, size: tuple[int, int], sigma: float) -> Points:
    """Noise of standard deviation 1 whose features are about `sigma` pixels wide."""
    cells = max(1.0, sigma)
    small = (int(size[0] / cells) + 4, int(size[1] / cells) + 4)
    field = ndimage.gaussian_filter(rng.normal(size=small), 0.8)
    field = (field - field.mean()) / field.std()
    made = Image.fromarray(field.astype(np.float32)).resize(size[::-1], Image.Resampling.BICUBIC)
    return np.asarray(made, float)


def coverage(
    lines: Sequence[Points],
    size: tuple[int, int],
    width: float,
    pressures: Sequence[Points] | None = None,
) -> Points:
    """How much of each pixel (h, w) the pencil goes over, 0 … 1; darker where it is pressed."""
    image = Image.new("L", (FINER * size[0], FINER * size[1]))
    pen = ImageDraw.Draw(image)
    for number, line in enumerate(lines):
        pressure = np.full(len(line), 0.8) if pressures is None else pressures[number]
        for (a, b), p in zip(pairwise(line), pressure[1:], strict=True):
            wide = FINER * width * (0.55 + 0.55 * p)
            tone = round(255 * min(1.0, 0.45 + 0.7 * p))
            ends = [tuple(FINER * a), tuple(FINER * b)]
            pen.line(ends, fill=tone, width=max(1, round(wide)))
            for x, y in ends:
                pen.ellipse([x - wide / 2, y - wide / 2, x + wide / 2, y + wide / 2], fill=tone)
    return np.asarray(image.resize(size, Image.Resampling.BOX), float) / 255.0


def paper_picture(
    lines: Sequence[Points],
    size: tuple[int, int],
    conditions: Conditions,
    seed: int,
    pressures: Sequence[Points] | None = None,
) -> tuple[NDArray[np.uint8], Points]:
    """Draw lines on paper and take a picture of it.

    Parameters
    ----------
    lines : sequence of (n, 2) arrays
        Pixels of the page.
    size : (width, height)
        Of the page, pixels.
    conditions : Conditions
    seed : int
    pressures : sequence of (n,) arrays, optional
        0 … 1; 0.8 without.

    Returns
    -------
    pixels : (h, w, 4) uint8
    corners : (4, 2) float
        The page's corners in the picture.
    """
    rng = np.random.default_rng((23, seed))
    shape = size[::-1]
    longest = max(size)
    covered = coverage(lines, size, conditions.width * longest, pressures)
    covered = ndimage.gaussian_filter(covered, 0.0004 * longest)
    tooth = np.clip(0.5 + 0.5 * _noise(rng, shape, 0.0010 * longest), 0.0, 1.0)
    graphite = conditions.graphite * covered * (1.0 - conditions.grain * tooth)
    fibres = 0.6 * _noise(rng, shape, 0.0015 * longest) + 0.8 * _noise(rng, shape, 0.01 * longest)
    page = (0.93 + conditions.texture * fibres) * (1.0 - graphite)
    corners = np.array([(0, 0), (size[0], 0), size, (0, size[1])], float)
    picture = page[..., None] * np.array([1.0, 0.985, 0.95])
    if conditions.photograph:
        picture, corners = _on_table(picture, rng)
    lit = _light(picture.shape[:2], conditions, rng)
    seen = picture * lit[..., None]
    seen = seen + rng.normal(0.0, conditions.noise, seen.shape)
    pixels = np.clip(255.0 * seen, 0, 255).astype(np.uint8)
    stream = io.BytesIO()
    Image.fromarray(pixels).save(stream, "JPEG", quality=conditions.quality)
    return np.asarray(Image.open(stream).convert("RGBA")), corners


def _on_table(page: Points, rng: np.random.Generator) -> tuple[Points, Points]:
    """Lay a page on a wooden table and look at it from the side."""
    height, width = page.shape[:2]
    size = (round(1.25 * width), round(1.25 * height))
    low = 0.1 * np.array([width, height])
    corners = low + np.array([(0, 0), (width, 0), (width, height), (0, height)], float)
    corners += rng.uniform(-0.055, 0.055, (4, 2)) * (width, height)
    rings = np.linspace(0, 40, size[1])[:, None] + 2.0 * _noise(rng, size[::-1], 60.0)
    wood = (0.38 + 0.06 * np.sin(rings))[..., None] * np.array([1.0, 0.78, 0.58])
    back = homography(corners, np.array([(0, 0), (width, 0), (width, height), (0, height)], float))
    values = (back / back[2, 2]).ravel()[:8].tolist()

    def seen(channel: Points) -> Points:
        image = Image.fromarray(channel.astype(np.float32))
        made = image.transform(size, Image.Transform.PERSPECTIVE, values, Image.Resampling.BICUBIC)
        return np.asarray(made, float)

    inside = seen(np.ones((height, width)))
    inside = np.clip(inside, 0.0, 1.0)[..., None]
    laid = np.stack([seen(page[..., k]) for k in range(3)], axis=-1)
    return laid * inside + wood * (1.0 - inside), corners


def _light(shape: tuple[int, int], conditions: Conditions, rng: np.random.Generator) -> Points:
    """Brightness of the light on each pixel."""
    height, width = shape
    y, x = np.mgrid[0:height, 0:width] / max(shape)
    angle = rng.uniform(0, 2 * np.pi)
    slope = np.cos(angle) * (x - 0.5) + np.sin(angle) * (y - 0.4)
    light = (
        1.0
        - conditions.falloff * (slope + 0.5)
        - 0.3 * conditions.falloff * ((x - 0.5) ** 2 + (y - 0.4) ** 2)
    )
    if conditions.shadow:
        # The border of a hand's shadow: sharp where it touches the paper, soft farther off.
        turn = rng.uniform(0, 2 * np.pi)
        across = np.cos(turn) * (x - 0.5) + np.sin(turn) * (y - 0.4)
        across = across + 0.05 * _noise(rng, shape, 0.2 * max(shape)) - rng.uniform(-0.1, 0.2)
        soft = rng.uniform(0.006, 0.04)
        light = light * (1.0 - conditions.shadow / (1.0 + np.exp(-across / soft)))
    return light
