"""From a picture of a drawing on paper to strokes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.ink.curves.resample import arc_length, distinct, resample
from bozzetto.ink.curves.smooth import smooth
from bozzetto.ink.trace.corners import split_at_corners
from bozzetto.ink.trace.gaps import TOUCHING, bridged, is_closed
from bozzetto.ink.trace.junctions import joined_lines
from bozzetto.ink.trace.photographed_page import find_page, straightened
from bozzetto.ink.trace.skeleton import Skeleton, length, skeleton_of
from bozzetto.ink.trace.threshold import InkMask, darkness_of, gray_of, ink_mask

SMOOTHING: Final = 0.6
"""Standard deviation of the smoothing along a line, in widths: what thinning shakes it."""

SPACING: Final = 0.6
"""Distance between two samples of a stroke, in widths; two pixels at least."""

LONGEST_GAP: Final = 0.012
"""Longest gap that is bridged, in longest sides of the picture."""

SHORTEST: Final = 0.006
"""Shortest line that is no speck, in longest sides; and two widths at least."""

ATTACHED: Final = 1.5
"""Shortest line that hangs on a longer one, in widths."""

PAGE_RIM: Final = 0.012
"""Rim of a straightened page on which its border may show, in longest sides."""

MOST_STROKES: Final = 20_000
"""Strokes of one picture; what has more is texture and no drawing."""

MOST_INK: Final = 0.35
"""Share of a picture that is ink, at most."""

HEAVY: Final = 90.0
"""Percentile of the lines' weight that gets `HEAVY_PRESSURE`."""

HEAVY_PRESSURE: Final = 0.8

LIGHTEST: Final = 0.05
"""Least pressure of what was seen at all."""

Checkpoint = Callable[[float, str], None]


def _pass(fraction: float, step: str) -> None:
    """Ignore progress that no one watches."""


@dataclass(frozen=True, eq=False)
class Sheet:
    """A picture as it is traced.

    Attributes
    ----------
    pixels : (h, w, 4) uint8
        The page, straightened where one was found.
    darkness : (h', w') float32
        Darkness beside the paper, 0 … 1, in the size in which it is traced.
    corners : (4, 2) float or None
        The page's corners in the picture that was given, pixels; None where there was none.
    """

    pixels: NDArray[np.uint8]
    darkness: NDArray[np.float32]
    corners: Array | None = None

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the page, pixels of `pixels`."""
        return self.pixels.shape[1], self.pixels.shape[0]


@dataclass(frozen=True, eq=False)
class TracedLine:
    """A line found on paper.

    Attributes
    ----------
    points : (n, 2) float
        x and y, y down, in pixels of `Sheet.pixels`. A closed line begins and ends in one place.
    pressure : (n,) float
        0 … 1: width times darkness of the line, 0.8 for the heavier lines of the picture.
    """

    points: Array
    pressure: Array

    @property
    def is_closed(self) -> bool:
        """Whether it is an outline."""
        return is_closed(self.points)


def sheet_of(
    pixels: NDArray[np.uint8], *, page: bool = True, checkpoint: Checkpoint = _pass
) -> Sheet:
    """Prepare a picture: find and straighten its page, and take the illumination away.

    Parameters
    ----------
    pixels : (h, w, 4) uint8
        RGBA, sRGB, straight alpha.
    page : bool
        Whether a page is looked for; otherwise the whole picture is paper.
    checkpoint : callable
        Called with the share done and the step's name; what it raises passes.

    Raises
    ------
    ValueError
        If the array is not a picture.
    """
    if pixels.ndim != 3 or pixels.shape[2] != 4 or pixels.dtype != np.uint8 or not pixels.size:
        raise ValueError("a picture needs the shape (height, width, 4), bytes, and pixels")
    checkpoint(0.0, "Looking for the page")
    gray = gray_of(pixels)
    corners = find_page(gray) if page else None
    if corners is not None:
        corners = corners * (pixels.shape[1] / gray.shape[1])
        pixels = straightened(pixels, corners)
        gray = gray_of(pixels)
    checkpoint(0.15, "Flattening the light")
    return Sheet(pixels, darkness_of(gray), corners)


def ink_of(sheet: Sheet, sensitivity: float = 0.5) -> InkMask:
    """Return what is ink on a sheet; see `ink_mask`. The rim of a straightened page is none."""
    return ink_mask(sheet.darkness, sensitivity, 0.0 if sheet.corners is None else PAGE_RIM)


def trace(
    sheet: Sheet, sensitivity: float = 0.5, *, checkpoint: Checkpoint = _pass
) -> tuple[TracedLine, ...]:
    """Trace the lines on a sheet.

    Parameters
    ----------
    sheet : Sheet
        See `sheet_of`.
    sensitivity : float
        0 … 1: how faint a line may be.
    checkpoint : callable
        As in `sheet_of`.

    Returns
    -------
    tuple of TracedLine
        The longest first.

    Raises
    ------
    UserError
        If there is no line, or so much ink that it is no line drawing.
    """
    checkpoint(0.3, "Finding the ink")
    found = ink_of(sheet, sensitivity)
    share = float(found.mask.mean())
    if share == 0.0:
        raise UserError(
            "There is no line in this picture. Raise the sensitivity, or take a sharper picture."
        )
    if share > MOST_INK:
        raise UserError(
            "Most of this picture is dark, so it is no line drawing. Lower the sensitivity, "
            "or crop the picture to the drawing."
        )
    checkpoint(0.45, "Thinning the lines")
    skeleton = skeleton_of(found.mask)
    checkpoint(0.65, "Following the lines")
    lines = joined_lines(skeleton)
    if len(lines) > MOST_STROKES:
        raise UserError(
            "This picture has more grain than lines. Lower the sensitivity, or take it in "
            "better light."
        )
    width = _usual_width(lines, skeleton)
    longest = max(found.mask.shape)
    checkpoint(0.8, "Bridging gaps")
    whole = bridged(lines, max(3.0 * width, LONGEST_GAP * longest), width)
    kept = _without_specks(whole, max(2.0 * width, SHORTEST * longest), width)
    if not kept:
        raise UserError(
            "There are only specks in this picture. Raise the sensitivity, or take a sharper "
            "picture."
        )
    checkpoint(0.9, "Weighing the lines")
    placed = _strokes([_even(line, width) for line in kept], width)
    placed.sort(key=length, reverse=True)
    scale = sheet.size[0] / found.mask.shape[1]
    pressures = _pressures(placed, skeleton, found)
    return tuple(
        TracedLine(scale * points, pressure)
        for points, pressure in zip(placed, pressures, strict=True)
    )


def _strokes(lines: list[Array], width: float) -> list[Array]:
    """Return closed lines whole, and open ones from corner to corner."""
    is_open = [line for line in lines if not is_closed(line)]
    ends = np.array([line[[0, -1]] for line in is_open]).reshape(-1, 2, 2)
    strokes = [line for line in lines if is_closed(line)]
    for number, line in enumerate(is_open):
        others = np.delete(ends, number, axis=0).reshape(-1, 2)
        strokes += split_at_corners(line, width, others)
    return strokes


def _without_specks(lines: list[Array], shortest: float, width: float) -> list[Array]:
    """Leave out short lines, but for those that hang on a longer one: dashes that cross it."""
    from scipy.spatial import cKDTree

    kept = [line for line in lines if length(line) >= shortest]
    if not kept:
        return []
    tree = cKDTree(np.vstack(kept))
    for line in lines:
        if ATTACHED * width <= length(line) < shortest:
            apart, _ = tree.query(line[[0, -1]], distance_upper_bound=TOUCHING * width)
            if np.isfinite(apart).any():
                kept.append(line)
    return kept


def _usual_width(lines: list[Array], skeleton: Skeleton) -> float:
    return max(1.0, float(np.median(skeleton.width_at(np.vstack(lines)))))


def _even(line: Array, width: float) -> Array:
    """Smooth a line from pixel to pixel, and sample it evenly."""
    closed = is_closed(line)
    line = line[distinct(line)]
    plain = smooth(line, SMOOTHING * width, closed=closed)
    count = max(2, round(float(arc_length(plain)[-1]) / max(2.0, SPACING * width)) + 1)
    even = resample(plain, count=max(count, 8 if closed else 2))
    if closed:
        even[-1] = even[0]
    return even


def _pressures(lines: list[Array], skeleton: Skeleton, ink: InkMask) -> list[Array]:
    """Return the pressure along each line, from width times darkness."""
    weights = []
    for line in lines:
        rows = np.clip(line[:, 1].astype(int), 0, ink.mask.shape[0] - 1)
        columns = np.clip(line[:, 0].astype(int), 0, ink.mask.shape[1] - 1)
        weight = skeleton.width_at(line) * np.maximum(ink.darkness[rows, columns], 0.0)
        weights.append(_running_median(weight))
    heavy = max(float(np.percentile(np.concatenate(weights), HEAVY)), 1e-6)
    return [np.clip(HEAVY_PRESSURE / heavy * weight, LIGHTEST, 1.0) for weight in weights]


def _running_median(values: Array) -> Array:
    """Smooth without spreading junctions, where lines are wide, and gaps, where they are not."""
    from scipy import ndimage

    return np.asarray(ndimage.median_filter(values, size=min(9, len(values)), mode="nearest"))
