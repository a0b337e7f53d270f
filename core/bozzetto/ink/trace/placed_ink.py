"""Traced lines as strokes: on a sheet of their own, in a view, or along a picture in space."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.ink.drawing import Drawing
from bozzetto.ink.stroke import Stroke, Strokes
from bozzetto.view.camera import Camera

if TYPE_CHECKING:
    from bozzetto.arrays import Array
    from bozzetto.ink.trace.trace import TracedLine

PAGE_WIDTH: Final = 200.0
"""Width of a page in the world, mm; as wide as a picture that is laid under the sheet."""

DISTANCE: Final = 500.0
"""Distance of the camera from the page, mm; without effect on a parallel view."""

FILLED: Final = 0.9
"""Share of a view that the page fills."""

SLANT: Final = 0.03
"""Greatest departure from a square view, in shares of a pixel's side."""


def page_camera(size: tuple[int, int]) -> Camera:
    """Return the parallel front view of a page that stands on the ground, centred.

    Parameters
    ----------
    size : (width, height)
        Of the page, pixels; the canvas is as large.
    """
    width, height = size
    tall = PAGE_WIDTH * height / width
    return Camera(
        kind="orthographic",
        eye=(0.0, -DISTANCE, tall / 2),
        target=(0.0, 0.0, tall / 2),
        height=tall,
        viewport=(float(width), float(height)),
    )


def page_drawing(lines: Sequence[TracedLine], size: tuple[int, int], name: str) -> Drawing:
    """Return traced lines as a drawing in the front view.

    Parameters
    ----------
    lines : sequence of TracedLine
        See `trace`.
    size : (width, height)
        Of the page, pixels; see `Sheet.size`.
    name : str
        Name of the drawing.
    """
    camera = page_camera(size)
    strokes = [_stroke(line.points, line, camera) for line in lines]
    return Drawing(Strokes(strokes), camera, name)


def strokes_in_view(
    lines: Sequence[TracedLine], size: tuple[int, int], camera: Camera
) -> tuple[Stroke, ...]:
    """Return traced lines as if a hand had drawn them in a view, the page as large as it fits.

    Parameters
    ----------
    lines : sequence of TracedLine
        See `trace`.
    size : (width, height)
        Of the page, pixels.
    camera : Camera
        The view.
    """
    canvas, page = np.asarray(camera.viewport, float), np.asarray(size, float)
    scale = FILLED * float((canvas / page).min())
    corner = 0.5 * (canvas - scale * page)
    return tuple(_stroke(corner + scale * line.points, line, camera) for line in lines)


def strokes_on_picture(
    lines: Sequence[TracedLine],
    size: tuple[int, int],
    place: tuple[ArrayLike, ArrayLike, ArrayLike],
    camera: Camera,
) -> tuple[Stroke, ...]:
    """Return traced lines as a hand draws them along a picture that is seen in a view.

    Parameters
    ----------
    lines : sequence of TracedLine
        See `trace`.
    size : (width, height)
        Of the picture, pixels.
    place : (corner, across, down)
        Where the picture lies in the world, mm; see `bozzetto.scene.Image`.
    camera : Camera
        The view; the whole picture lies before its eye.
    """
    corner, across, down = (np.asarray(vector, float) for vector in place)
    made = []
    for line in lines:
        share = line.points / np.asarray(size, float)
        seen, _ = camera.project(corner + share @ np.stack((across, down)))
        made.append(_stroke(seen, line, camera))
    return tuple(made)


def is_seen_square(
    size: tuple[int, int], place: tuple[ArrayLike, ArrayLike, ArrayLike], camera: Camera
) -> bool:
    """Whether a picture is seen as it is: turned or larger at most, not slanted nor mirrored.

    Parameters
    ----------
    size, place, camera
        As in `strokes_on_picture`.
    """
    corner, across, down = (np.asarray(vector, float) for vector in place)
    seen, _ = camera.project(
        np.stack((corner, corner + across, corner + down, corner + across + down))
    )
    if not np.isfinite(seen).all():
        return False
    right, below = (seen[1] - seen[0]) / size[0], (seen[2] - seen[0]) / size[1]
    turned = np.array([-right[1], right[0]])
    far = np.abs(seen[3] - seen[1] - seen[2] + seen[0]).max() / max(size)
    least = float(np.linalg.norm(right))
    return bool(max(float(np.linalg.norm(below - turned)), float(far)) <= SLANT * least)


def _stroke(points: Array, line: TracedLine, camera: Camera) -> Stroke:
    return Stroke(points[:, 0], points[:, 1], camera, pressure=line.pressure, tool="imported")
