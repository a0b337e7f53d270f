"""The ground: a faint grid that says where down is and how large things are."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from bozzetto.scene.display_list import Layer, Lines

if TYPE_CHECKING:
    from bozzetto.view.camera import Camera

GROUND = "ground"
"""Name of the layer that holds the grid."""

STEP_PIXELS = 36.0
"""Least distance between two lines at the depth of the target, px."""

REACH = 30
"""Lines on each side of the middle."""

PIECES = 12
"""Pieces of a line between the middle and its end, over which it fades."""

FINE_WIDTH, COARSE_WIDTH, AXIS_WIDTH = 0.9, 1.3, 1.7
"""Widths of lines, of every fifth, and of the axes, px. Below one pixel, thinner is
fainter: that is how the grid fades out."""

FIFTH = 5

AXIS_OPACITY = 0.45


def grid_step(camera: Camera) -> float:
    """Return the distance between lines that suits a view: 1, 2 or 5 times a power of ten, mm."""
    least = STEP_PIXELS / camera.pixels_per_mm
    decade = 10.0 ** np.floor(np.log10(least))
    for step in (decade, 2.0 * decade, 5.0 * decade):
        if step >= least:
            return float(step)
    return float(10.0 * decade)


def ground_height(bounds: NDArray[np.float64]) -> float:
    """Return z of a ground on which everything stands: 0, or the lowest point if that is lower.

    Parameters
    ----------
    bounds : (2, 3) float
        Corners of the box around the scene, mm; NaN for an empty one.
    """
    lowest = float(bounds[0, 2])
    return min(0.0, lowest) if np.isfinite(lowest) else 0.0


def ground_grid(camera: Camera, height: float = 0.0) -> Layer:
    """Return the ground plane's grid around the place the camera looks at.

    Parameters
    ----------
    camera : Camera
        The view.
    height : float
        z of the ground, mm.

    Returns
    -------
    Layer
        Three `Lines`: the grid, the x axis in the accent colour and the y axis in the
        second, where they pass through the grid. They fade towards the rim.
    """
    step = grid_step(camera)
    middle = np.round(np.asarray(camera.target[:2]) / step)
    radius = REACH * step
    aside = np.arange(-REACH, REACH + 1)
    points, widths = [], []
    for axis in (0, 1):
        number = middle[axis] + aside
        grid = number != 0  # that one is an axis
        points.append(_lines(axis, number[grid] * step, middle * step, radius, height))
        width = np.where(number % FIFTH == 0, COARSE_WIDTH, FINE_WIDTH)
        widths.append((width[:, None] * _fading(aside / REACH))[grid])
    count = sum(len(lines) for lines in points)
    items = [
        Lines(
            np.concatenate(points).reshape(-1, 3).astype(np.float32),
            np.arange(count, dtype=np.int32) * (2 * PIECES + 1),
            "grid",
            np.concatenate(widths).ravel().astype(np.float32),
            hidden="hide",
        )
    ]
    # The x axis runs where y is 0, and the other way round.
    for axis, color in ((1, "accent"), (0, "second")):
        if abs(middle[axis]) <= REACH:
            (line,) = _lines(axis, np.zeros(1), middle * step, radius, height)
            items.append(
                Lines(
                    line.astype(np.float32),
                    color=color,
                    width=(AXIS_WIDTH * _fading(middle[axis] / REACH)[0]).astype(np.float32),
                    opacity=AXIS_OPACITY,
                    hidden="hide",
                )
            )
    return Layer(GROUND, tuple(items))


def _lines(
    axis: int,
    places: NDArray[np.float64],
    middle: NDArray[np.float64],
    radius: float,
    height: float,
) -> NDArray[np.float64]:
    """Return points of the lines on which the coordinate `axis` has one value each, (n, p, 3)."""
    along = radius * np.linspace(-1.0, 1.0, 2 * PIECES + 1)
    points = np.full((len(places), len(along), 3), height)
    points[..., axis] = places[:, None]
    points[..., 1 - axis] = middle[1 - axis] + along
    return points


def _fading(aside: float | NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the share of a line's full width at its points, (n, p): lines fade outwards."""
    along = np.linspace(-1.0, 1.0, 2 * PIECES + 1)
    share: NDArray[np.float64] = 1.0 - (along**2 + np.atleast_1d(aside)[:, None] ** 2)
    return np.clip(share, 0.0, 1.0)
