"""Translucent surfaces and pictures, laid over each other from far to near at each pixel."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Floats, Index


@dataclass(frozen=True, eq=False)
class Sheet:
    """A layer that lets what is behind it show through.

    Attributes
    ----------
    pixel : (n,) int
        Each at most once.
    nearness : (n,) float32
    color : (n, 3) float32
        0 … 255, not multiplied by the opacity.
    opacity : (n,) float32
        0 … 1.
    """

    pixel: Index
    nearness: Floats
    color: Floats
    opacity: Floats

    def before(self, surface: Floats) -> Sheet:
        """Return the part that no opaque surface (nearness at every pixel) hides."""
        keep = self.nearness >= surface[self.pixel]
        return Sheet(self.pixel[keep], self.nearness[keep], self.color[keep], self.opacity[keep])


def blend_sheets(pixels: Floats, sheets: Sequence[Sheet]) -> None:
    """Blend sheets over a picture, the farthest first: result = a·colour + (1 − a)·behind.

    Parameters
    ----------
    pixels : (h · w, 4) float32
        Written to: colour multiplied by opacity, opacity.
    sheets : sequence of Sheet
        Where two lie at exactly the same depth, the later one lies on top.
    """
    if len(sheets) == 1:
        _blend(pixels, sheets[0], slice(None))
        return
    if not sheets:
        return
    if len(sheets) == 2:
        _blend_two(pixels, *sheets)
        return
    every = Sheet(
        np.concatenate([s.pixel for s in sheets]),
        np.concatenate([s.nearness for s in sheets]),
        np.concatenate([s.color for s in sheets]),
        np.concatenate([s.opacity for s in sheets]),
    )
    order = np.argsort(_keys(every), kind="stable")
    pixel = every.pixel[order]
    index = np.arange(len(pixel))
    first = np.ones(len(pixel), bool)
    first[1:] = pixel[1:] != pixel[:-1]
    rank = index - np.maximum.accumulate(np.where(first, index, 0))
    by_rank = np.argsort(rank, kind="stable")
    ends = np.cumsum(np.bincount(rank))
    begin = 0
    for end in ends.tolist():
        _blend(pixels, every, order[by_rank[begin:end]])
        begin = end


def nearest_sheet(sheets: Sequence[Sheet], count: int) -> tuple[Floats, Floats]:
    """Return nearness (−inf for none) and opacity of the nearest sheet at each pixel."""
    nearness = np.full(count, -np.inf, np.float32)
    opacity = np.zeros(count, np.float32)
    for sheet in sheets:
        nearer = sheet.nearness > nearness[sheet.pixel]
        pixel = sheet.pixel[nearer]
        nearness[pixel] = sheet.nearness[nearer]
        opacity[pixel] = sheet.opacity[nearer]
    return nearness, opacity


def _keys(every: Sheet) -> NDArray[np.uint64]:
    """Return integers that sort by pixel, then by nearness."""
    bits = every.nearness.view(np.uint32)
    negative = bits >> np.uint32(31) == 1
    rising = np.where(negative, ~bits, bits | np.uint32(0x80000000))
    return (every.pixel.astype(np.uint64) << np.uint64(32)) | rising.astype(np.uint64)


def _blend_two(pixels: Floats, one: Sheet, other: Sheet) -> None:
    """Blend two sheets, such as the back and the front of a mesh: they need not be sorted."""
    nearness = np.full(len(pixels), -np.inf, np.float32)
    nearness[one.pixel] = one.nearness
    beneath = other.nearness < nearness[other.pixel]
    if not beneath.any():
        _blend(pixels, one, slice(None))
        _blend(pixels, other, slice(None))
        return
    _blend(pixels, other, np.flatnonzero(beneath))
    _blend(pixels, one, slice(None))
    _blend(pixels, other, np.flatnonzero(~beneath))


def _blend(pixels: Floats, sheet: Sheet, part: Index | slice) -> None:
    pixel = sheet.pixel[part]
    whole = pixels.view(np.complex128)[:, 0]  # four floats are moved as one value
    mixed = whole.take(pixel).view(np.float32)
    # Opacity mixes as a colour does that is 1 everywhere: all four are mixed in one row.
    colors = np.ones((len(pixel), 4), np.float32)
    colors[:, :3] = sheet.color[part]
    step: Floats = colors.ravel()
    step -= mixed
    step *= np.repeat(sheet.opacity[part], 4)
    mixed += step
    whole[pixel] = mixed.view(np.complex128)
