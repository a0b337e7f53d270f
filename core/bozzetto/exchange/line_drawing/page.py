"""A page with lines and words, and the drawing of shapes in a view as such a page."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.exchange.line_drawing.drawn_edges import Net, net_of
from bozzetto.exchange.line_drawing.hidden_lines import DrawnLine, drawn_lines
from bozzetto.geometry.meshed_shapes import meshed
from bozzetto.geometry.shapes import Shapes
from bozzetto.view.camera import Camera

LayerName = Literal["visible", "hidden", "dimensions", "frame"]

LAYERS: Final[tuple[LayerName, ...]] = ("frame", "hidden", "visible", "dimensions")
"""Layers of a page, in the order in which they are drawn."""

MARGIN: Final = 0.05
"""Paper left around a drawing, as a share of its size."""

LEAST: Final = 1e-3
"""Paper left around what is a point in its view, mm."""

POINT: Final = 1e-9
"""Extent of a line that is seen from its end, as a share of that of the drawing."""


@dataclass(frozen=True, eq=False)
class PageLine:
    """A line on a page.

    Attributes
    ----------
    points : (n, 2) float
        In the units of the page, y down.
    layer : {"visible", "hidden", "dimensions", "frame"}
    name : str
        Of what it shows.
    """

    points: Array
    layer: LayerName
    name: str = ""


@dataclass(frozen=True)
class PageText:
    """Words on a page.

    Attributes
    ----------
    words : str
    place : (x, y)
        The middle of their foot, or its beginning.
    height : float
        Of the letters.
    upwards : bool
        Whether they are read from the right, as beside upright dimensions.
    centered : bool
    """

    words: str
    place: tuple[float, float]
    height: float
    upwards: bool = False
    centered: bool = True


@dataclass(frozen=True, eq=False)
class Page:
    """Lines and words on paper.

    Attributes
    ----------
    corner : (x, y)
        The upper left one.
    width, height : float
    unit : {"mm", "px"}
    lines : tuple of PageLine
    texts : tuple of PageText
    """

    corner: tuple[float, float]
    width: float
    height: float
    unit: Literal["mm", "px"]
    lines: tuple[PageLine, ...]
    texts: tuple[PageText, ...] = ()


def net_to_draw(shapes: Shapes) -> Net:
    """Return the net of shapes.

    Raises
    ------
    UserError
        If there is nothing to draw.
    """
    net = net_of(meshed(shapes))
    if not len(net.faces) and not len(net.wires):
        raise UserError("There is nothing to draw yet. Draw something first.")
    return net


def outlines_page(shapes: Shapes, camera: Camera | None, *, hidden: bool) -> Page:
    """Return edges and outlines as a camera sees them; the front view without one.

    Parallel views are in millimetres, at the size of the things; others in pixels.

    Parameters
    ----------
    shapes : Shapes
        mm.
    camera : Camera, optional
        The view.
    hidden : bool
        Whether lines that are hidden are drawn, too.

    Raises
    ------
    UserError
        If there is nothing to draw, or all of it lies behind the eye.
    """
    net = net_to_draw(shapes)
    if camera is None:
        lines = parallel_lines(net, np.eye(3)[[0, 2, 1]])
    elif camera.kind == "orthographic":
        lines = parallel_lines(net, camera.axes)
    else:
        places, distance = camera.project(net.points)
        with np.errstate(all="ignore"):
            lines = drawn_lines(net, places, -1.0 / distance)
    drawn = tuple(page_lines(lines, hidden=hidden))
    if not drawn:
        raise UserError("All of it lies behind the eye. Turn the view to it, then export.")
    if camera is not None and camera.kind == "perspective":
        return Page((0.0, 0.0), *camera.viewport, "px", drawn)
    low, high = bounds_of(drawn)
    rim = MARGIN * float((high - low).max()) or LEAST
    x, y = (low - rim).tolist()
    width, height = (high - low + 2 * rim).tolist()
    return Page((x, y), width, height, "mm", drawn)


def page_lines(lines: Sequence[DrawnLine], *, hidden: bool) -> list[PageLine]:
    """Return the lines that a page shows; those seen from their ends only where nothing else is.

    Parameters
    ----------
    lines : sequence of DrawnLine
        Of one view.
    hidden : bool
        Whether lines that are hidden are shown, too.
    """
    shown = [
        PageLine(line.points, "visible" if line.visible else "hidden", line.name)
        for line in lines
        if line.visible or hidden
    ]
    extents = [float(np.ptp(line.points, axis=0).max()) for line in shown]
    least = POINT * float(np.ptp(bounds_of(shown), axis=0).max()) if shown else 0.0
    return [line for line, extent in zip(shown, extents, strict=True) if extent >= least]


def parallel_lines(net: Net, axes: Array) -> list[DrawnLine]:
    """Return the lines of a parallel view, mm.

    Parameters
    ----------
    net : Net
        What is drawn.
    axes : (3, 3) float
        Rows: to the right, up, and away from the eye.
    """
    right, up, away = (net.points @ np.asarray(axes, float).T).T
    return drawn_lines(net, np.column_stack((right, -up)), away)


def bounds_of(lines: Sequence[DrawnLine | PageLine]) -> tuple[Array, Array]:
    """Return the lower and upper corner of the box around lines."""
    points = np.concatenate([line.points for line in lines])
    return points.min(axis=0), points.max(axis=0)


def moved(line: PageLine, scale: float, offset: Array) -> PageLine:
    """Return a line made larger and then moved."""
    return replace(line, points=line.points * scale + offset)
