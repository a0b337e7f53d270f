"""SVG: drawings to strokes, strokes and projected curves to paths.

One user unit is one millimetre, and the point (x, y) of the file is the world point
(x, 0, -y): drawings from other programs stand upright on the front view.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace
from typing import Final
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from bozzetto.errors import FormatError
from bozzetto.exchange.limits import (
    MAX_COORDINATE,
    MAX_SAMPLES,
    MAX_STROKES,
    at_most,
)
from bozzetto.exchange.sheet import Sheet, sheet_drawing
from bozzetto.exchange.svg_path import Subpath, ellipse, flattened, parse_path, polyline
from bozzetto.exchange.xml_tree import Element, parsed, writable
from bozzetto.geometry.shapes import Curve, Shapes
from bozzetto.ink.drawing import Drawing
from bozzetto.view.camera import Camera

__all__ = ["read_drawing", "write_drawing", "write_view"]

Array = NDArray[np.float64]
Color = tuple[int, int, int]

SPACE: Final = "http://www.w3.org/2000/svg"

FLATTENING: Final = 2e-4
"""How far a chord may stray from its curve, as a share of the drawing's diagonal."""

PIXELS: Final = {
    "": 1.0, "px": 1.0, "mm": 96 / 25.4, "cm": 96 / 2.54, "in": 96.0, "pt": 96 / 72, "pc": 16.0,
}  # fmt: skip
"""User units in a unit of length (CSS: 96 to the inch)."""

GROUPS: Final = {"svg", "g", "a", "switch"}
"""Elements that merely hold others."""

NUMBER: Final = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")
LENGTH: Final = re.compile(rf"\s*({NUMBER.pattern})\s*(px|mm|cm|in|pt|pc)?\s*")
TRANSFORM: Final = re.compile(r"[\s,]*([A-Za-z]+)\s*\(([^()]*)\)[\s,]*")


# -- reading -------------------------------------------------------------------------------


@dataclass(frozen=True)
class _State:
    """What an element inherits."""

    matrix: Array
    color: Color | None = None


def read_drawing(data: bytes, name: str) -> Drawing:
    """Read the lines of an SVG file: one stroke for every stretch of the pen.

    Paths and basic shapes under nested transforms are read; a closed one repeats its first
    point at the end. Fill, text, images and everything under ``defs`` is passed over.

    Parameters
    ----------
    data : bytes
    name : str
        Of the drawing.

    Raises
    ------
    FormatError
        If it is no SVG, is damaged or too large, has a document type, clones elements
        (``use``), or holds no line.
    """
    root = parsed(data)
    if root.tag != "svg" or root.space not in ("", SPACE):
        raise FormatError("This is not an SVG file.")
    found: list[tuple[Subpath, Color | None]] = []
    outer = replace(root, attributes={**root.attributes, "x": "0", "y": "0"})
    _collect(outer, _State(np.eye(3)), found, outermost=True)
    if not found:
        raise FormatError("There are no lines in this drawing.")
    at_most(len(found), MAX_STROKES, "strokes")
    corners = np.concatenate([path.cubics.reshape(-1, 2) for path, _ in found])
    if not (np.abs(corners) <= MAX_COORDINATE).all():
        raise FormatError("A point lies further away than a drawing can reach.")
    size = float(np.linalg.norm(np.ptp(corners, axis=0)))
    at_most(len(corners), MAX_SAMPLES, "points")
    lines = [flattened(path, max(FLATTENING * size, 1e-300)) for path, _ in found]
    return sheet_drawing(lines, _canvas(root), name, colors=[color for _, color in found])


def _canvas(root: Element) -> Sheet | None:
    """The view box, else width and height, else None."""
    box = NUMBER.findall(root.attributes.get("viewBox", ""))
    if len(box) == 4:
        x, y, width, height = map(float, box)
    else:
        x = y = 0.0
        width, height = (_length(root, side, math.nan) for side in ("width", "height"))
    sane = max(abs(x), abs(y)) <= MAX_COORDINATE
    if sane and 0 < width <= MAX_COORDINATE and 0 < height <= MAX_COORDINATE:
        return Sheet(x, y, width, height)
    return None


def _collect(
    element: Element,
    state: _State,
    found: list[tuple[Subpath, Color | None]],
    *,
    outermost: bool = False,
) -> None:
    """Put the subpaths of an element and all below it into `found`, transformed."""
    if element.space not in ("", SPACE) or _style(element, "display") == "none":
        return
    if element.tag == "use":
        raise FormatError(
            "It repeats elements by reference (<use>). In the program that made it, unlink "
            "the clones or convert objects to paths, and save again."
        )
    with np.errstate(all="ignore"):
        matrix = state.matrix @ _transform(element.attributes.get("transform", ""))
    state = _State(matrix, _color(element, state.color))
    if element.tag in GROUPS:
        if element.tag == "svg" and not outermost:
            state = replace(state, matrix=matrix @ _nested_viewport(element))
        for child in element.children:
            _collect(child, state, found)
        return
    for path in _outline(element):
        with np.errstate(all="ignore"):
            cubics = path.cubics @ state.matrix[:2, :2].T + state.matrix[:2, 2]
        found.append((Subpath(cubics, path.closed), state.color))


def _outline(element: Element) -> list[Subpath]:
    """The subpaths of one shape; none for what is no shape."""

    def at(name: str) -> float:
        return _length(element, name, 0.0)

    match element.tag:
        case "path":
            return parse_path(element.attributes.get("d", ""))
        case "line":
            ends = np.array([[at("x1"), at("y1")], [at("x2"), at("y2")]])
            return [polyline(ends, closed=False)]
        case "polyline" | "polygon":
            numbers = NUMBER.findall(element.attributes.get("points", ""))
            points = np.array(numbers[: len(numbers) // 2 * 2], float).reshape(-1, 2)
            if len(points) < 2:
                return []
            if not (np.abs(points) <= MAX_COORDINATE).all():
                raise FormatError("A point lies further away than a drawing can reach.")
            return [polyline(points, closed=element.tag == "polygon")]
        case "circle" | "ellipse":
            rx, ry = (at("r"), at("r")) if element.tag == "circle" else (at("rx"), at("ry"))
            center = complex(at("cx"), at("cy"))
            return [ellipse(center, complex(rx, ry))] if min(rx, ry) > 0 else []
        case "rect":
            return _rectangle(element)
        case _:
            return []


def _rectangle(element: Element) -> list[Subpath]:
    x, y, width, height = (_length(element, k, 0.0) for k in ("x", "y", "width", "height"))
    if width <= 0 or height <= 0:
        return []
    rx, ry = _length(element, "rx", -1.0), _length(element, "ry", -1.0)
    rx, ry = (ry if rx < 0 else rx), (rx if ry < 0 else ry)
    rx, ry = min(max(rx, 0.0), width / 2), min(max(ry, 0.0), height / 2)
    if rx == 0 or ry == 0:
        corners = [[x, y], [x + width, y], [x + width, y + height], [x, y + height]]
        return [polyline(np.array(corners), closed=True)]
    a = f"a{rx!r} {ry!r} 0 0 1 "
    return parse_path(
        f"M{x + rx!r} {y!r}h{width - 2 * rx!r}{a}{rx!r} {ry!r}v{height - 2 * ry!r}{a}{-rx!r} {ry!r}"
        f"h{2 * rx - width!r}{a}{-rx!r} {-ry!r}v{2 * ry - height!r}{a}{rx!r} {-ry!r}z"
    )


def _length(element: Element, name: str, default: float) -> float:
    """A length in user units; the default where it is absent or relative."""
    match = LENGTH.fullmatch(element.attributes.get(name, ""))
    if match is None:
        return default
    value = float(match[1]) * PIXELS[match[2] or ""]
    if abs(value) > MAX_COORDINATE:
        raise FormatError(f"The length “{name}” is larger than a drawing can be.")
    return value


def _style(element: Element, name: str) -> str | None:
    """A presentation property: from the style attribute, else from one of its own."""
    for entry in element.attributes.get("style", "").split(";"):
        key, _, value = entry.partition(":")
        if key.strip() == name:
            return value.strip()
    return element.attributes.get(name)


def _color(element: Element, inherited: Color | None) -> Color | None:
    said = _style(element, "stroke")
    if said is None or said == "inherit":
        return inherited
    if said in ("none", "currentColor", "transparent") or said.startswith("url"):
        return None
    from PIL import ImageColor

    try:
        red, green, blue = ImageColor.getrgb(said)[:3]
    except ValueError:
        return None
    return min(max(red, 0), 255), min(max(green, 0), 255), min(max(blue, 0), 255)


def _nested_viewport(element: Element) -> Array:
    """Where an inner ``svg`` puts its own units."""
    matrix = _shift(_length(element, "x", 0.0), _length(element, "y", 0.0))
    inner = _canvas(element) if "viewBox" in element.attributes else None
    width, height = (_length(element, side, 0.0) for side in ("width", "height"))
    if inner is None or width <= 0 or height <= 0:
        return matrix
    scale = min(width / inner.width, height / inner.height)
    center = _shift(
        (width - scale * inner.width) / 2 - scale * inner.x,
        (height - scale * inner.height) / 2 - scale * inner.y,
    )
    return matrix @ center @ np.diag([scale, scale, 1.0])


def _shift(x: float, y: float) -> Array:
    return np.array([[1.0, 0.0, x], [0.0, 1.0, y], [0.0, 0.0, 1.0]])


def _transform(text: str) -> Array:
    """A transform list as one matrix (3, 3)."""
    matrix: Array = np.eye(3)
    at = 0
    while at < len(text):
        match = TRANSFORM.match(text, at)
        if match is None:
            if text[at:].strip():
                raise FormatError(f"A transform cannot be understood: “{text[at : at + 30]}”.")
            break
        numbers = [float(word) for word in NUMBER.findall(match[2])]
        with np.errstate(all="ignore"):
            matrix = matrix @ _single_transform(match[1], numbers)
        at = match.end()
    if not (np.abs(matrix) <= MAX_COORDINATE).all():
        raise FormatError("A transform moves its lines further than a drawing can reach.")
    return matrix


def _single_transform(kind: str, numbers: list[float]) -> Array:
    if not all(abs(number) <= MAX_COORDINATE for number in numbers):
        raise FormatError("A transform holds a number that is too large.")
    match kind, numbers:
        case "matrix", [a, b, c, d, e, f]:
            return np.array([[a, c, e], [b, d, f], [0.0, 0.0, 1.0]])
        case "translate", [x, *rest] if len(rest) < 2:
            return _shift(x, *rest or [0.0])
        case "scale", [x, *rest] if len(rest) < 2:
            return np.diag([x, *(rest or [x]), 1.0])
        case "rotate", [degrees, *center] if len(center) in (0, 2):
            x, y = center or (0.0, 0.0)
            c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
            turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
            return np.asarray(_shift(x, y) @ turn @ _shift(-x, -y))
        case "skewX", [degrees]:
            return np.array([[1, math.tan(math.radians(degrees)), 0], [0, 1, 0], [0, 0, 1.0]])
        case "skewY", [degrees]:
            return np.array([[1, 0, 0], [math.tan(math.radians(degrees)), 1, 0], [0, 0, 1.0]])
        case _:
            raise FormatError(f"A transform cannot be understood: “{kind[:20]}”.")


# -- writing -------------------------------------------------------------------------------

INK_WIDTH: Final = 1 / 600
"""Width of the lines written, as a share of the sheet's height."""

INK: Final = "#22211f"

STATIONS_PER_SPAN: Final = 24
"""Points on each knot span of a curve of degree two or more."""

MARGIN: Final = 0.05
"""Paper left around curves that are written without a camera, as a share of their size."""


def write_drawing(drawing: Drawing) -> bytes:
    """The strokes as paths of straight lines.

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
        lines.append(_path(points, stroke.color, stroke.group))
    if sheet is None or not to_world:
        sheet = Sheet(0.0, 0.0, *drawing.camera.viewport)
    return _document(sheet, lines, "mm" if to_world else "px")


def write_view(shapes: Shapes, camera: Camera | None) -> bytes:
    """The curves of shapes as a camera sees them; on the front view without one.

    Polylines are written exactly, other curves as close polylines.
    """
    points = [_stations(curve) for curve in shapes.curves]
    if camera is None:
        sheet = Sheet.around([p[:, [0, 2]] * (1, -1) for p in points], MARGIN)
        camera = sheet.camera()
    front = Sheet.of_front_view(camera)
    sheet = front or Sheet(0.0, 0.0, *camera.viewport)
    lines: list[str] = []
    for curve, p in zip(shapes.curves, points, strict=True):
        pixels, _ = camera.project(p)
        seen = pixels if front is None else front.to_units(pixels, camera)
        for piece in _visible(seen):
            lines.append(_path(piece, curve.color, curve.name))
    return _document(sheet, lines, "px" if front is None else "mm")


def _visible(points: Array) -> list[Array]:
    """The stretches of a line that lie before the eye."""
    seen = np.isfinite(points).all(axis=1)
    cuts = np.flatnonzero(np.diff(seen)) + 1
    return [part for part in np.split(points, cuts) if len(part) > 1 and np.isfinite(part).all()]


def _stations(curve: Curve) -> Array:
    """Points along a curve, shape (n, 3), mm."""
    if curve.degree == 1:
        return curve.control_points
    from scipy.interpolate import BSpline

    weights = np.ones(len(curve.control_points)) if curve.weights is None else curve.weights
    lifted = np.column_stack((curve.control_points * weights[:, None], weights))
    spline = BSpline(curve.knots, lifted, curve.degree)
    spans = np.unique(curve.knots[curve.degree : len(curve.control_points) + 1])
    share = np.arange(STATIONS_PER_SPAN) / STATIONS_PER_SPAN
    u = np.append((spans[:-1, None] + np.diff(spans)[:, None] * share).ravel(), spans[-1])
    values = np.asarray(spline(u))
    return np.asarray(values[:, :3] / values[:, 3:])


def _path(points: Array, color: Color | None, name: str) -> str:
    closed = len(points) > 3 and bool((points[0] == points[-1]).all())
    rows = points[:-1] if closed else points
    data = "M" + "L".join(f"{x:.9g},{y:.9g}" for x, y in rows.tolist()) + ("Z" if closed else "")
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
