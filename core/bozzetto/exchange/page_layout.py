"""The sheet of drawings that know no camera: their unit is a millimetre on the front view."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.ink.drawing import Drawing
from bozzetto.ink.stroke import Stroke, Strokes
from bozzetto.view.camera import Camera

Color = tuple[int, int, int]

DISTANCE: Final = 500.0
"""Distance of the camera from the sheet, mm; without effect on a parallel view."""

FAR: Final = 64.0
"""Distance of the sheet's corner from a drawing, in sizes of the drawing, beyond which the
drawing gets a sheet of its own: float32 pixels stay right to 1e-5 of the size then."""

LEAST: Final = 1e-3
"""Least side of a sheet, mm."""

LEVEL: Final = 1e-9
"""Largest departure of a front view's axes from the world's."""


@dataclass(frozen=True)
class Sheet:
    """A rectangle of user units: the unit is a millimetre, y points down.

    The point (x, y) is the world point (x, 0, -y).
    """

    x: float
    y: float
    width: float
    height: float

    @classmethod
    def around(cls, lines: Sequence[Array], margin: float = 0.0) -> Sheet:
        """Return the smallest sheet that holds all points, with a share of its size around it."""
        points = np.concatenate(lines)
        low, high = points.min(0), points.max(0)
        rim = max(margin * float((high - low).max()), LEAST)
        x, y = low - rim
        width, height = high - low + 2 * rim
        return cls(float(x), float(y), float(width), float(height))

    @classmethod
    def of_front_view(cls, camera: Camera) -> Sheet | None:
        """Return the sheet that a parallel front view shows; None for any other camera."""
        front = np.array([[1.0, 0, 0], [0, 0, 1], [0, 1, 0]])
        if camera.kind != "orthographic" or np.abs(camera.axes - front).max() > LEVEL:
            return None
        width = camera.height * camera.viewport[0] / camera.viewport[1]
        x, z = camera.eye[0] - width / 2, camera.eye[2] + camera.height / 2
        return cls(x, -z, width, camera.height)

    def scaled(self, scale: float) -> Sheet:
        """Return the sheet made larger, from the origin."""
        return Sheet(scale * self.x, scale * self.y, scale * self.width, scale * self.height)

    def camera(self) -> Camera:
        """Return the front view on which one pixel is one unit."""
        x, z = self.x + self.width / 2, -(self.y + self.height / 2)
        return Camera(
            kind="orthographic",
            eye=(x, -DISTANCE, z),
            target=(x, 0.0, z),
            height=self.height,
            viewport=(self.width, self.height),
        )

    def to_units(self, pixels: Array, camera: Camera) -> Array:
        """Convert canvas pixels to user units, for the camera that shows this sheet."""
        return np.asarray(pixels * (self.height / camera.viewport[1]) + (self.x, self.y))


def sheet_drawing(
    lines: Sequence[Array],
    sheet: Sheet | None,
    name: str,
    *,
    colors: Sequence[Color | None],
) -> Drawing:
    """Make strokes of imported lines.

    Parameters
    ----------
    lines : sequence of (n, 2) arrays
        In user units; at least one.
    sheet : Sheet, optional
        The canvas; left out, or where the lines lie far off it, the bounds of the lines.
    name : str
        Name of the drawing.
    colors : sequence
        One for each line.
    """
    tight = Sheet.around(lines)
    if sheet is None or _far(sheet, tight):
        sheet = tight
    camera = sheet.camera()
    corner = np.array([sheet.x, sheet.y])
    strokes = []
    for line, color in zip(lines, colors, strict=True):
        x, y = (line - corner).T
        strokes.append(Stroke(x, y, camera, tool="imported", color=color))
    return Drawing(Strokes(strokes), camera, name)


def _far(sheet: Sheet, tight: Sheet) -> bool:
    """Whether float32 pixels from the sheet's corner would be too coarse for the lines."""
    reach = max(
        abs(tight.x - sheet.x), abs(tight.x + tight.width - sheet.x),
        abs(tight.y - sheet.y), abs(tight.y + tight.height - sheet.y),
    )  # fmt: skip
    return reach > FAR * max(tight.width, tight.height)
