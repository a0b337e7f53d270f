"""Which pixels of a picture are ink: illumination flattened, then a threshold with hysteresis."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Array, Flags

LONGEST_SIDE: Final = 2048
"""Longest side of what is traced, pixels: a pencil line on A4 is 3 to 5 wide then."""

SHORTEST_SIDE: Final = 1000
"""Pictures whose longer side is shorter are enlarged to twice their size: thin lines of one
pixel have no middle."""

PAPER_CELL: Final = 1 / 256
"""Cell in which the paper's brightness is estimated, in longest sides."""

WIDEST_LINE: Final = 0.03
"""Widest line that is taken for ink and not for the paper's own brightness, in longest sides."""

BLUR: Final = 0.0006
"""Standard deviation of the blur against grain, in longest sides: 1.2 pixels of 2048."""

GRAIN_LEVEL: Final = 7.5
"""Darkness that no grain of the paper has, in standard deviations of it."""

GRAIN_FLOOR: Final = 3.2
"""Darkness down to which a line is followed on, in standard deviations of the grain."""

LEAST_DARKNESS: Final = 0.045
"""Darkness below which nothing is ink, also where the paper has no grain; 1 is black."""

STRONG: Final = 0.40
"""Darkness where a line begins, as a share of the darkness of the picture's lines."""

WEAK: Final = 0.22
"""Darkness down to which it is followed, as a share of that."""

DARK_PAPER: Final = 0.7
"""Median brightness below which lines may be lighter than their ground: kraft paper, a blackboard.
Whether they are is seen in the lines, for white paper in bad light is as dark."""

LIGHT_LINES: Final = 0.5
"""Least skewness of the brightness about its mean nearby where lines are lighter than the ground:
it is above 1 for light lines, below -1 for dark ones, and about 0 without lines."""


@dataclass(frozen=True, eq=False)
class InkMask:
    """Ink found in a picture.

    Attributes
    ----------
    darkness : (h, w) float32
        0 for paper … 1 for black, without the illumination.
    mask : (h, w) bool
        Where ink is.
    """

    darkness: NDArray[np.float32]
    mask: Flags


def gray_of(pixels: NDArray[np.uint8], longest: int = LONGEST_SIDE) -> NDArray[np.float32]:
    """Return the brightness of a picture on white, in the size in which it is traced.

    Parameters
    ----------
    pixels : (h, w, 4) uint8
        RGBA, sRGB, straight alpha.
    longest : int
        Longest side of the answer, pixels; smaller pictures are enlarged to twice their size at
        most.

    Returns
    -------
    (h', w') float32
        0 … 1, in the picture's own gamma.
    """
    from PIL import Image

    image = Image.fromarray(np.ascontiguousarray(pixels), "RGBA")
    width, height = image.size
    scale = longest / max(width, height)
    if max(width, height) >= SHORTEST_SIDE:
        scale = min(scale, 1.0)
    scale = min(scale, 2.0)
    size = (max(1, round(scale * width)), max(1, round(scale * height)))
    if size != image.size:
        # A picture of ten thousand by one pixels stays one.
        kind = Image.Resampling.BOX if scale < 1.0 else Image.Resampling.BICUBIC
        image = image.resize(size, kind)
    if np.asarray(image.getchannel("A")).min() < 255:
        white = Image.new("RGBA", image.size, "white")
        image = Image.alpha_composite(white, image)
    return np.asarray(image.convert("L"), np.float32) / 255.0


def darkness_of(gray: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return how dark each pixel is beside the paper around it.

    The paper's brightness is a grey closing of the picture in coarse cells: what is darker than
    all around it and narrower than `WIDEST_LINE` is ink, and shadows with soft or hard borders are
    paper. Dividing by it takes illumination and vignetting away.

    Parameters
    ----------
    gray : (h, w) float32
        Brightness, 0 … 1.

    Returns
    -------
    (h, w) float32
        0 for paper … 1 for black; grain of the paper lies about 0.
    """
    from PIL import Image
    from scipy import ndimage

    gray = 1.0 - gray if _has_light_lines(gray) else gray
    coarse, across = _cells(gray)
    paper = ndimage.grey_closing(coarse, size=(across, across), mode="nearest")
    paper = ndimage.uniform_filter(paper, 3, mode="nearest")
    full = np.asarray(
        Image.fromarray(paper).resize((gray.shape[1], gray.shape[0]), Image.Resampling.BICUBIC)
    )
    darkness = 1.0 - gray / np.maximum(full, 1e-3)
    blur = max(0.6, BLUR * max(gray.shape))
    blurred = ndimage.gaussian_filter(darkness, blur, mode="nearest")
    # A closing lies above the mean of grainy paper.
    return np.asarray(blurred - np.median(blurred[::4, ::4]), np.float32)


def _cells(gray: NDArray[np.float32]) -> tuple[NDArray[np.float32], int]:
    """Return the mean brightness in coarse cells, and how many are wider than any line."""
    from PIL import Image

    longest = max(gray.shape)
    cell = max(1, round(PAPER_CELL * longest))
    size = (max(1, gray.shape[1] // cell), max(1, gray.shape[0] // cell))
    coarse = np.asarray(Image.fromarray(gray).resize(size, Image.Resampling.BOX))
    return coarse, 2 * round(0.5 * WIDEST_LINE * longest / cell) + 1


def _has_light_lines(gray: NDArray[np.float32]) -> bool:
    """Whether the lines on a dark ground are lighter than it.

    Lines cover less than the ground between them, so the skewness of the brightness about its mean
    nearby has their sign. Grain and the borders of shadows are as often light as dark.
    """
    from scipy import ndimage

    if float(np.median(gray[::4, ::4])) >= DARK_PAPER:
        return False
    coarse, across = _cells(gray)
    apart = coarse - ndimage.gaussian_filter(coarse, 0.5 * across, mode="nearest")
    spread = float((apart**2).mean())
    return bool(float((apart**3).mean()) > LIGHT_LINES * spread**1.5)


def ink_mask(darkness: NDArray[np.float32], sensitivity: float = 0.5, rim: float = 0.0) -> InkMask:
    """Return which pixels are ink.

    Parameters
    ----------
    darkness : (h, w) float32
        See `darkness_of`.
    sensitivity : float
        0 … 1: how faint a line may be. 0.5 takes the thresholds of this module; 0 and 1 take
        four times and a quarter of their share of the lines' darkness.
    rim : float
        Width of a rim that holds no ink, in longest sides.

    Returns
    -------
    InkMask
        The mask is empty where there is nothing but paper.
    """
    from scipy import ndimage

    margin = round(rim * max(darkness.shape))
    if margin:
        darkness = darkness.copy()
        for edge in (np.s_[:margin], np.s_[-margin:], np.s_[:, :margin], np.s_[:, -margin:]):
            darkness[edge] = 0.0
    grain = _grain(darkness)
    floor = max(GRAIN_LEVEL * grain, LEAST_DARKNESS)
    inky = darkness[darkness > floor]
    nothing = InkMask(darkness, np.zeros(darkness.shape, bool))
    if len(inky) < 8:
        return nothing
    lines = float(np.percentile(inky, 80))
    factor = 16.0 ** (0.5 - sensitivity)
    strong = max(min(STRONG * factor, 0.9) * lines, floor)
    weak = max(min(WEAK * factor, 0.6) * lines, GRAIN_FLOOR * grain, 0.6 * LEAST_DARKNESS)
    labels, count = ndimage.label(darkness > min(weak, strong), np.ones((3, 3), int))
    if not count:
        return nothing
    begun = np.zeros(count + 1, bool)
    begun[labels[darkness > strong]] = True
    begun[0] = False
    return InkMask(darkness, begun[labels] & ~_beyond_the_page(labels))


def _beyond_the_page(labels: NDArray[np.signedinteger]) -> Flags:
    """Return what lies along the border of a picture as no line does: a rim of the table.

    A line that leaves the picture meets its border no longer than it is wide. What meets it longer
    is cleared as far from there as a rim can be taken for ink; lines that go on from it stay.

    Parameters
    ----------
    labels : (h, w) int
        Numbers of what hangs together; 0 for paper.
    """
    depth = max(1, round(WIDEST_LINE * max(labels.shape)))
    beyond = np.zeros(labels.shape, bool)
    turned = ((labels, beyond), (labels.T, beyond.T), (labels[::-1], beyond[::-1]),
              (labels.T[::-1], beyond.T[::-1]))  # fmt: skip
    for rows, cleared in turned:
        edge = np.concatenate(([0], rows[0], [0]))
        starts = np.flatnonzero((edge[1:] != edge[:-1]) & (edge[1:] > 0))
        ends = np.flatnonzero((edge[1:] != edge[:-1]) & (edge[:-1] > 0))
        for start, end in zip(starts.tolist(), ends.tolist(), strict=True):
            if end - start > depth:
                strip = np.s_[:depth, max(start - depth, 0) : end + depth]
                cleared[strip] |= rows[strip] == edge[start + 1]
    return beyond


def _grain(darkness: NDArray[np.float32]) -> float:
    """Return the standard deviation of the paper, from the side on which there is no ink."""
    light: Array = -darkness[::2, ::2][darkness[::2, ::2] < 0.0].astype(float)
    return 1.4826 * float(np.median(light)) if len(light) else 0.0
