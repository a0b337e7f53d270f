"""Pen strokes for tests: curves on a box, as a hand draws them in two views."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bozzetto.arrays import Array
from bozzetto.testing import Pen, Shell
from bozzetto.view import Camera

FRONT = Camera(eye=(160.0, -420.0, 260.0), target=(0.0, 0.0, 30.0))
"""Sees the front, the right side and the top of a box that stands in the middle."""

TOP_EDGES = (
    ((-50.0, -30.0, 60.0), (50.0, -30.0, 60.0)),
    ((50.0, -30.0, 60.0), (50.0, 30.0, 60.0)),
    ((50.0, 30.0, 60.0), (-50.0, 30.0, 60.0)),
    ((-50.0, 30.0, 60.0), (-50.0, -30.0, 60.0)),
)
"""A rectangle on the top of the box, 10 mm inside its edges."""


def straight(start: Sequence[float], end: Sequence[float], count: int = 30) -> Array:
    """Return points along a line, (count, 3)."""
    share = np.linspace(0.0, 1.0, count)[:, None]
    return (1.0 - share) * np.array(start) + share * np.array(end)


def draw_rectangle(shell: Shell, pen: Pen) -> None:
    """Draw a rectangle on the top of the box of 120 × 80 × 60 mm in four strokes."""
    shell.camera = FRONT
    for start, end in TOP_EDGES:
        draw_along(shell, pen, straight(start, end))


def draw_along(shell: Shell, pen: Pen, points: Array, tool: str = "draw") -> None:
    """Draw a stroke where points in space are seen."""
    aside = pen.but(camera=FRONT)
    shell.draw(aside.along(FRONT.project(points)[0]), tool=tool)
