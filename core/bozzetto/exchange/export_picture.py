"""A small picture of what a file would hold: the shapes as they are handed over, or a drawing."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from bozzetto.exchange.cad.curves_drawing import line_of
from bozzetto.geometry.shapes import Shapes
from bozzetto.scene.display_list import Layer, Lines, Scene
from bozzetto.scene.part_display import shaded_part
from bozzetto.scene.snapshot import picture

if TYPE_CHECKING:
    from bozzetto.exchange.line_drawing.page import Page
    from bozzetto.scene.palette import Palette


def picture_of_shapes(
    shapes: Shapes, palette: Palette, size: tuple[int, int], scale: float = 1.0
) -> NDArray[np.uint8]:
    """Render meshes and curves in the three-quarter view.

    Parameters
    ----------
    shapes : Shapes
        Without exact surfaces; see `bozzetto.geometry.meshed`.
    palette : Palette
        Colours of the theme.
    size : (width, height)
        Pixels; `scale` multiplies them.
    scale : float
        Picture pixels per pixel of the window.

    Returns
    -------
    (h, w, 4) uint8
        RGBA, sRGB, straight alpha, nothing behind it.
    """
    items = [item for part in shapes.meshes() for item in shaded_part(part)]
    lines = [
        Lines(line_of(curve).astype(np.float32), color=curve.color or "ink")
        for curve in shapes.curves
    ]
    scene = Scene((Layer("shapes", (*items, *lines)),))
    return picture(scene, palette=palette, size=size, scale=scale, background=False)


def picture_of_page(
    page: Page, palette: Palette, size: tuple[int, int], scale: float = 1.0
) -> NDArray[np.uint8]:
    """Render the lines of a page, without its words; parameters as in `picture_of_shapes`."""
    rows = [np.insert(line.points * (1.0, -1.0), 1, 0.0, axis=1) for line in page.lines]
    starts = np.cumsum([0, *(len(row) for row in rows[:-1])])
    lines = Lines(np.concatenate(rows).astype(np.float32), starts.astype(np.int32), width=1.0)
    scene = Scene((Layer("page", (lines,)),))
    return picture(scene, view="front", palette=palette, size=size, scale=scale, background=False)
