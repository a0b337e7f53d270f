"""SVG writer: strokes and projected curves become paths."""

from __future__ import annotations

from typing import Final
from xml.sax.saxutils import quoteattr

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.exchange.cad.cad_curves import RESOLUTION, checked_curves
from bozzetto.exchange.page_layout import Sheet
from bozzetto.exchange.safe_xml import writable
from bozzetto.exchange.svg.curves import FRONT, PLAN, camera_matrix, picture
from bozzetto.exchange.svg.outlined_elements import SPACE
from bozzetto.exchange.svg.page_clip import clip_path
from bozzetto.exchange.svg.path_data import Subpath, flatten
from bozzetto.exchange.svg.style import Color
from bozzetto.geometry.shapes import Curve, Shapes
from bozzetto.ink.drawing import Drawing
from bozzetto.view.camera import Camera

INK_WIDTH: Final = 1 / 600
"""Width of the lines written, as a share of the sheet's height."""

INK: Final = "#22211f"

STRAY: Final = (1e-3, 1e-6)
"""Farthest that lines are written from the curves seen, where they are not exact: in user
units, and as a share of the picture's size, whichever is less."""

MARGIN: Final = 0.05
"""Paper left around curves that are written without a camera, as a share of their size."""

LEVEL: Final = 1e-9
"""Difference in height, as a share of the size, up to which curves lie in one level plane."""

BOUNDS: Final = 1e-3
"""Accuracy of their size, as a share of it: a small part of the margin."""


def write_drawing(drawing: Drawing) -> bytes:
    """Write the strokes as paths of straight lines.

    A drawing on the front view is written in millimetres of the world, so that it comes
    back to its place; every other one in pixels of its canvas.
    """
    sheet = Sheet.of_front_view(drawing.camera)
    fronts = [Sheet.of_front_view(stroke.camera) for stroke in drawing.strokes]
    lines: list[str] = []
    to_world = sheet is not None and all(front is not None for front in fronts)
    for stroke, front in zip(drawing.strokes, fronts, strict=True):
        points = stroke.points
        if to_world and front is not None:
            points = front.to_units(points, stroke.camera)
        lines.append(_path(_corners(points), stroke.color, stroke.group))
    if sheet is None or not to_world:
        sheet = Sheet(0.0, 0.0, *drawing.camera.viewport)
    return _document(sheet, lines, "mm" if to_world else "px")


def write_view(shapes: Shapes, camera: Camera | None) -> bytes:
    """Write the curves of shapes as a camera sees them; on the front view without one.

    What lies flat, all in one level plane, is a plan: without a camera it is seen from above.

    Parallel views of polylines and of curves up to degree three without weights are exact, and
    so are polylines in perspective. All else is right within `STRAY`. Front views and plans
    are in millimetres, others in pixels. What lies beyond the page is cut off.

    Raises
    ------
    UserError
        As `checked_curves`, or if no curve lies on the page.
    """
    curves = checked_curves(shapes)
    sheet = None if camera is None else Sheet.of_front_view(camera)
    if camera is None or sheet is not None:
        places = np.concatenate([curve.control_points for curve in curves])
        matrix, unit = (PLAN if camera is None and is_plan(places) else FRONT), "mm"
        size = max(float(np.ptp(places, axis=0).max()), RESOLUTION)
    else:
        matrix, unit = camera_matrix(camera), "px"
        sheet, size = Sheet(0.0, 0.0, *camera.viewport), max(camera.viewport)
    tolerance = min(STRAY[0], STRAY[1] * size)
    seen = [(curve, path) for curve in curves for path in picture(curve, matrix, tolerance)]
    if not seen:
        raise UserError("All curves lie behind the eye. Turn the view to them, then export.")
    if sheet is None:
        chord = BOUNDS * size
        sheet = Sheet.around([flatten(path, chord) for _, path in seen], MARGIN)
    else:
        low = np.array((sheet.x, sheet.y))
        high = np.add(low, (sheet.width, sheet.height))
        seen = [(curve, part) for curve, path in seen for part in clip_path(path, low, high)]
        if not seen:
            raise UserError("No curve lies on the page. Turn the view to them, then export.")
    lines = [_path(_pen(path, curve), curve.color, curve.name) for curve, path in seen]
    return _document(sheet, lines, unit)


def is_plan(points: Array) -> bool:
    """Whether points (n, 3) lie in one level plane, so that a front view shows them edge-on."""
    extent = np.ptp(points, axis=0) if len(points) else np.zeros(3)
    return bool(extent[2] <= LEVEL * extent[:2].max() and extent[1] > 0.0)


def _pen(path: Subpath, curve: Curve) -> str:
    """Write path data with all digits: lines of a polyline, cubics of any other curve."""
    start = path.cubics[0, 0].tolist()
    rows = path.cubics[:, 3:] if curve.degree == 1 else path.cubics[:, 1:]
    letter = "L" if curve.degree == 1 else "C"
    pieces = (letter + " ".join(f"{x!r},{y!r}" for x, y in row) for row in rows.tolist())
    return f"M{start[0]!r},{start[1]!r}{''.join(pieces)}{'Z' * path.closed}"


def _corners(points: Array) -> str:
    """Write path data of straight lines, as fine as ink is."""
    closed = len(points) > 3 and bool((points[0] == points[-1]).all())
    rows = points[:-1] if closed else points
    return "M" + "L".join(f"{x:.9g},{y:.9g}" for x, y in rows.tolist()) + ("Z" if closed else "")


def _path(data: str, color: Color | None, name: str) -> str:
    stroke = "" if color is None else f' stroke="#{color[0]:02x}{color[1]:02x}{color[2]:02x}"'
    label = f" data-curve={quoteattr(writable(name))}" if name else ""
    return f'<path d="{data}"{stroke}{label}/>'


def _document(sheet: Sheet, lines: list[str], unit: str) -> bytes:
    box = " ".join(f"{v:.12g}" for v in (sheet.x, sheet.y, sheet.width, sheet.height))
    return (
        f'<svg xmlns="{SPACE}" viewBox="{box}" '
        f'width="{sheet.width:.9g}{unit}" height="{sheet.height:.9g}{unit}">\n'
        f'<g fill="none" stroke="{INK}" stroke-width="{sheet.height * INK_WIDTH:.4g}" '
        'stroke-linecap="round" stroke-linejoin="round">\n' + "\n".join(lines) + "\n</g>\n</svg>\n"
    ).encode()
