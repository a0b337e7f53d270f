"""SVG reader: painted lines and areas become strokes.

One user unit is one millimetre where the file does not say how large its view box is; where it
does (``width="100mm"``), the drawing has that size. The point (x, y) of the file is the world point
(x, 0, -y), in millimetres: drawings from other programs stand upright on the front view.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.cached_properties import cached_property
from bozzetto.errors import FormatError
from bozzetto.exchange.limits import (
    MAX_COORDINATE,
    MAX_DEPTH,
    MAX_ELEMENTS,
    MAX_STROKES,
    at_most,
)
from bozzetto.exchange.page_layout import Sheet, sheet_drawing
from bozzetto.exchange.safe_xml import Element, parse_xml
from bozzetto.exchange.svg.clip_regions import MAX_EFFORT, Region, clipped
from bozzetto.exchange.svg.clips import Box, Clip, box_of, lies_apart, lies_within, named_clip
from bozzetto.exchange.svg.outlined_elements import (
    LONGEST_LENGTH,
    NUMBER,
    SPACE,
    is_sized_by_letters,
    length,
    origin,
    outline,
    paper_length,
    shift,
    transform,
)
from bozzetto.exchange.svg.overlaps import Area, TooManyPairs, without_overlaps
from bozzetto.exchange.svg.path_data import MAX_PIECES, Subpath, chord_counts, flatten
from bozzetto.exchange.svg.style import Look, Properties, Sheets
from bozzetto.exchange.svg.writer import write_drawing as write_drawing
from bozzetto.exchange.svg.writer import write_view as write_view
from bozzetto.ink.drawing import Drawing

XLINK_HREF: Final = "http://www.w3.org/1999/xlink href"

FLATTENING: Final = 2e-4
"""Greatest distance of a chord from its curve, as a share of the drawing's diagonal."""

GROUPS: Final = {"svg", "g", "a", "switch"}
"""Elements that merely hold others."""

EXTENDED: Final = "requiredExtensions"
"""Attribute of what only the program that wrote it shows, such as Adobe Illustrator's own data."""

UNREAD: Final = {"text": "text", "image": "picture", "foreignObject": "embedded page"}
"""Elements that show something other than lines, and what people call it."""

NEARLY_ROUND: Final = 0.1
"""Gap between the ends of a filled line that is closed, as a share of its length."""

FRAME: Final = ("x", "y", "width", "height", "viewBox", "preserveAspectRatio")
"""Attributes that say where a viewport is."""

SPILLING: Final = ("visible", "auto")
"""Values of ``overflow`` with which an inner viewport hides nothing."""

FITTED: Final = re.compile(
    r"\s*(?:none|x(Min|Mid|Max)Y(Min|Mid|Max))(?:\s+(meet|slice))?\s*", re.ASCII
)
"""How a view box lies in its viewport: scaled along each axis, or alike, within or around it."""

SHARES: Final = {"Min": 0.0, "Mid": 0.5, "Max": 1.0}
"""Where it lies, as a share of the room that is left."""

ROUNDED: Final = 1e-6
"""Departure of a scale from 1 that comes from rounded numbers."""

LEAST_SCALE: Final = 1e-6
"""A user unit that is smaller, mm, or as much larger, is a mistake."""

MAX_CLONES: Final = 50_000
"""Elements repeated by reference; a few lines of text can ask for billions."""

MAX_POINTS: Final = 4_000_000
"""Points of all lines, flattened: as strokes a quarter of a gigabyte."""


@dataclass(frozen=True)
class _Line:
    """A subpath in the units of the file."""

    path: Subpath
    look: Look
    element: int
    clips: tuple[Region, ...] = ()

    @cached_property
    def box(self) -> Box | None:
        return box_of(self.path)


class _Own:
    """Properties of one element, apart from where it stands.

    Attributes
    ----------
    properties : Properties
        Properties of its look.
    matrix : (3, 3) array or None
        Its transform, if it has one.
    paths : list of Subpath or None
        Its outline, once it was asked for.
    """

    __slots__ = ("matrix", "paths", "properties")

    def __init__(self, properties: Properties, matrix: Array | None) -> None:
        self.properties, self.matrix = properties, matrix
        self.paths: list[Subpath] | None = None


class _Reader:
    """Traversal of a document that collects lines."""

    def __init__(self, root: Element) -> None:
        self.sheets = Sheets(root)
        self.canvas = _canvas(root)
        self.page = None if self.canvas is None else (self.canvas.width, self.canvas.height)
        self.clips: dict[Element, Clip] = {}
        self.borders: dict[tuple[str, ...], Element] = {}
        self.regions: dict[tuple[Element, bytes], Region | None] = {}
        self.clip_corners = 0
        self.cut = 0
        self.moves: dict[str, Array | None] = {}
        self.unmoved = 0
        self.named: dict[str, Element] = {}
        self.found: list[_Line] = []
        self.pieces = 0
        self.visited = 0
        self.clones = 0
        self.repeating = 0
        self.known: dict[Element, _Own] = {}
        self.unread: Counter[str] = Counter()
        waiting = [root]
        while waiting:
            element = waiting.pop()
            waiting.extend(reversed(element.children))
            if "id" in element.attributes:
                self.named.setdefault(element.attributes["id"], element)
        self.scale = millimetres(root, self.canvas)
        self.collect(root, np.diag((self.scale, self.scale, 1.0)), Look(), outermost=True)

    def own(self, element: Element) -> _Own:
        """Return the properties of an element: read once, however often it is repeated."""
        if element in self.known:
            return self.known[element]
        properties = self.sheets.properties(element)
        made = _Own(properties, self._matrix(element, properties))
        if self.repeating:
            self.known[element] = made
        return made

    def _matrix(self, element: Element, properties: Properties) -> Array | None:
        """Return the transform of an element; None if it has none, or a style that nobody knows."""
        text = properties.get("transform", "")
        if text not in self.moves:
            try:
                self.moves[text] = transform(text, self.page)
            except FormatError:
                if text == element.attributes.get("transform"):
                    raise
                self.moves[text] = None
                self.unmoved += 1
        matrix = self.moves[text]
        if matrix is not None and "transform-origin" in properties:
            x, y = origin(properties["transform-origin"], self.page)
            matrix = shift(x, y) @ matrix @ shift(-x, -y)
        return matrix

    def collect(
        self,
        element: Element,
        matrix: Array,
        inherited: Look,
        *,
        frame: Element | None = None,
        outermost: bool = False,
        depth: int = 0,
    ) -> None:
        """Take the lines of an element and of all below it, transformed.

        What a ``use`` shows of a symbol has a `frame`, which takes the place of its own.
        """
        if element.space not in ("", SPACE):
            return
        self.visited += 1
        at_most(self.visited, MAX_ELEMENTS, "elements")
        at_most(depth, MAX_DEPTH, "levels of nesting")
        if self.repeating:
            self.clones += 1
            at_most(self.clones, MAX_CLONES, "repeated elements")
        own = self.own(element)
        if own.properties.get("display") == "none" or EXTENDED in element.attributes:
            return
        if own.matrix is not None:
            with np.errstate(all="ignore"):
                matrix = matrix @ own.matrix
        look = self.sheets.look(own.properties, inherited)
        begin = len(self.found)
        self._inside(own, element, matrix, look, frame, outermost=outermost, depth=depth)
        for name in ("clip-path", "mask"):
            target = self.named.get(named_clip(own.properties.get(name, "")))
            if target is not None and target.tag in ("clipPath", "mask"):
                self.clip(begin, target, matrix)

    def _inside(
        self,
        own: _Own,
        element: Element,
        matrix: Array,
        look: Look,
        frame: Element | None,
        *,
        outermost: bool,
        depth: int,
    ) -> None:
        if element.tag == "use":
            self.repeat(element, matrix, look, depth)
        elif element.tag in GROUPS or frame is not None:
            viewport = frame or (element if element.tag == "svg" and not outermost else None)
            begin, around = len(self.found), matrix
            if viewport is not None:
                matrix = matrix @ _nested_viewport(viewport, self.page)
            for child in _chosen(element) if element.tag == "switch" else element.children:
                self.collect(child, matrix, look, depth=depth + 1)
            if viewport is not None and own.properties.get("overflow") not in SPILLING:
                self.clip(begin, self.border(viewport), around)
        elif element.tag in UNREAD:
            self.unread[UNREAD[element.tag]] += look.visible
        else:
            self.take(own, element, matrix, look)

    def border(self, viewport: Element) -> Element:
        """Return the clip of an inner viewport: one for each that is written alike."""
        sides = tuple(viewport.attributes.get(side, "") for side in FRAME[:4])
        if sides not in self.borders:
            given = {side: said for side, said in zip(FRAME[:4], sides, strict=True) if said}
            area = Element("", "rect", {"width": "100%", "height": "100%", **given})
            self.borders[sides] = Element("", "clipPath", {}, [area])
        return self.borders[sides]

    def clip(self, begin: int, target: Element, matrix: Array) -> None:
        """Drop lines that a clip hides altogether, and note it on those that it may cut in two."""
        if not any(line.look.painted for line in self.found[begin:]):
            return
        if target not in self.clips:
            self.clips[target] = Clip.of(target, self.own, self.named, self.page)
        clip = self.clips[target]
        with np.errstate(all="ignore"):
            seen = clip.look(matrix)
        if seen is None:
            self.cut += 1
            return
        box, is_exact = seen
        lines = self.found[begin:]
        kept = [line for line in lines if line.box is None or not lies_apart(line.box, box)]
        may_cut = [
            line.box is not None and not (is_exact and lies_within(line.box, box)) for line in kept
        ]
        if any(may_cut):
            key = target, matrix.tobytes()
            if key not in self.regions:
                self.clip_corners += clip.size
                self.regions[key] = self.region(clip, matrix)
            region = self.regions[key]
            self.cut += region is None
            kept = [
                replace(line, clips=(*line.clips, region)) if cut and region is not None else line
                for line, cut in zip(kept, may_cut, strict=True)
            ]
        self.found[begin:] = kept

    def region(self, clip: Clip, matrix: Array) -> Region | None:
        """Return what a clip lets through; None where that is too much work to tell."""
        if self.clip_corners > MAX_EFFORT:
            return None
        try:
            return clip.region(matrix)
        except TooManyPairs:
            return None

    def left_out(self) -> tuple[str, ...]:
        """Return sentences about what the file shows and is not read; none where nothing is."""
        told = list(self._unread())
        if self.cut:
            parts, are = ("A part", "is") if self.cut == 1 else (f"{self.cut} parts", "are")
            told.append(
                f"{parts} of this drawing would be cut by a mask or a clip that is not understood, "
                f"and {are} read whole. Cut with it in the program that made it."
            )
        if self.unmoved:
            told.append(
                "A transform in a style is not understood, so parts of this drawing may lie "
                "elsewhere. Save it as plain SVG in the program that made it."
            )
        return tuple(told)

    def _unread(self) -> tuple[str, ...]:
        kinds = [(what, count) for what, count in sorted(self.unread.items()) if count]
        if not kinds:
            return ()
        total = sum(count for _, count in kinds)
        said = " and ".join(f"{count} {what}{'s' * (count > 1)}" for what, count in kinds)
        return (
            f"Only lines are read; {said} of this drawing {'is' if total == 1 else 'are'} "
            "left out. Turn text into paths, and trace pictures, in the program that made it.",
        )

    def take(self, own: _Own, element: Element, matrix: Array, look: Look) -> None:
        """Take the lines of a shape."""
        if is_sized_by_letters(element):
            self.unread["shape sized by letters"] += look.painted
            return
        if own.paths is None:
            own.paths = outline(element, self.page)
        self.pieces += sum(len(path.cubics) for path in own.paths)
        at_most(self.pieces, MAX_PIECES, "pieces of lines")
        at_most(len(self.found) + len(own.paths), MAX_STROKES, "strokes")
        for path in own.paths:
            with np.errstate(all="ignore"):
                cubics = path.cubics @ matrix[:2, :2].T + matrix[:2, 2]
            self.found.append(_Line(Subpath(cubics, path.closed), look, self.visited))

    def repeat(self, element: Element, matrix: Array, look: Look, depth: int) -> None:
        """Take the lines of the element that a ``use`` names (SVG 1.1, section 5.6)."""
        name = element.attributes.get("href", element.attributes.get(XLINK_HREF, ""))
        if not name.startswith("#"):
            raise FormatError(
                "It repeats something from another file (<use>). In the program that made "
                "it, embed or unlink that, and save again."
            )
        target = self.named.get(name[1:])
        if target is None:
            return
        frame = self.frame(element, target) if target.tag in ("symbol", "svg") else None
        matrix = matrix @ shift(*(length(element, k, 0.0, self.page) for k in "xy"))
        self.repeating += 1
        self.collect(target, matrix, look, frame=frame, depth=depth + 1)
        self.repeating -= 1

    def frame(self, use: Element, target: Element) -> Element:
        """Return the viewport, without content, in which a ``use`` shows a symbol."""
        sizes = {side: use.attributes.get(side) for side in ("width", "height")}
        if self.canvas is not None:
            whole = {"width": f"{self.canvas.width!r}", "height": f"{self.canvas.height!r}"}
            sizes = {side: said or target.attributes.get(side) or whole[side]
                     for side, said in sizes.items()}  # fmt: skip
        given = {key: said for key, said in sizes.items() if said is not None}
        own = {key: target.attributes[key] for key in FRAME if key in target.attributes}
        return Element("", "svg", own | given)


def read_drawing(data: bytes, name: str) -> Drawing:
    """Read the lines of an SVG file: one stroke for every stretch of the pen.

    Paths and basic shapes under nested transforms are read; a closed one repeats its first
    point at the end. Painted areas that overlap become one outline (`without_overlaps`).
    Clips cut them; text and pictures are left out, and named (`Drawing.left_out`), as are masks;
    what is not to be seen is ignored.

    Parameters
    ----------
    data : bytes
        Content of the file.
    name : str
        Name of the drawing.

    Raises
    ------
    FormatError
        If it is no SVG, is damaged or too large, defines entities, or holds no line.
    """
    root = parse_xml(data)
    if root.tag != "svg" or root.space not in ("", SPACE):
        raise FormatError("This is not an SVG file.")
    reader = _Reader(root)
    # Where nothing at all is painted, the lines themselves are meant.
    found = [line for line in reader.found if line.look.painted] or reader.found
    if not found:
        raise FormatError(" ".join(("There are no lines in this drawing.", *reader.left_out())))
    corners = np.concatenate([line.path.cubics.reshape(-1, 2) for line in found])
    if not (np.abs(corners) <= MAX_COORDINATE).all():
        raise FormatError("A point lies further away than a drawing can reach.")
    size = float(np.linalg.norm(np.ptp(corners, axis=0)))
    tolerance = max(FLATTENING * size, 1e-300)
    points = sum(int(chord_counts(line.path, tolerance).sum()) for line in found)
    at_most(points, MAX_POINTS, "points")
    lines = [
        _painted_ring(points, tolerance) if line.look.filled and line.look.painted else points
        for line in found
        for points in (flatten(line.path, tolerance),)
    ]
    areas = [
        Area(line.element, line.look.rule) if line.look.filled and line.look.painted else None
        for line in found
    ]
    seen = clipped(lines, areas, [line.clips for line in found])
    reader.cut += seen.given_up
    at_most(len(seen.lines), MAX_STROKES, "strokes")
    if not seen.lines:
        raise FormatError("All lines of this drawing are hidden by its clips.")
    joined = without_overlaps(seen.lines, seen.areas)
    if not joined:
        raise FormatError("The areas of this drawing cancel each other out.")
    colors = [found[seen.of[k]].look.color for k, _ in joined]
    sheet = reader.canvas and reader.canvas.scaled(reader.scale)
    drawing = sheet_drawing([points for _, points in joined], sheet, name, colors=colors)
    return replace(drawing, left_out=reader.left_out())


def _painted_ring(points: Array, tolerance: float) -> Array:
    """Return the border of what is filled: it ends where it began (SVG 2, section 13.4).

    A line that does not nearly come round stays one, whatever its inside would be.
    """
    gap = float(np.linalg.norm(points[0] - points[-1]))
    length = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
    if not 0.0 < gap <= NEARLY_ROUND * length:
        return points
    return np.concatenate((points[:-1] if gap <= tolerance else points, points[:1]))


def _canvas(root: Element) -> Sheet | None:
    """Return the view box, else width and height, else None."""
    text = root.attributes.get("viewBox", "")
    box = NUMBER.findall(text) if len(text) <= LONGEST_LENGTH else []
    if len(box) == 4:
        x, y, width, height = map(float, box)
    else:
        x = y = 0.0
        width, height = (length(root, side, math.nan) for side in ("width", "height"))
    sane = max(abs(x), abs(y)) <= MAX_COORDINATE
    if sane and 0 < width <= MAX_COORDINATE and 0 < height <= MAX_COORDINATE:
        return Sheet(x, y, width, height)
    return None


def millimetres(root: Element, canvas: Sheet | None) -> float:
    """Return the millimetres in a user unit: 1 unless a view box has a size on paper."""
    if canvas is None or "viewBox" not in root.attributes:
        return 1.0
    sides = {"width": canvas.width, "height": canvas.height}
    given = {side: size for side in sides if (size := paper_length(root, side)) is not None}
    scale = min((size / sides[side] for side, size in given.items()), default=1.0)
    # What is written in millimetres comes back to the bit.
    sane = LEAST_SCALE <= scale <= 1.0 / LEAST_SCALE and abs(scale - 1.0) > ROUNDED
    return scale if sane else 1.0


def _chosen(switch: Element) -> list[Element]:
    """Return the one child of a ``switch`` that is shown, in English where there is a choice."""
    children = [child for child in switch.children if EXTENDED not in child.attributes]
    english = [child for child in children if _is_english(child)]
    return (english or children)[:1]


def _is_english(element: Element) -> bool:
    languages = element.attributes.get("systemLanguage", "en").split(",")
    return any(language.strip().lower().startswith("en") for language in languages)


def _nested_viewport(element: Element, page: tuple[float, float] | None) -> Array:
    """Return the matrix from the units of an inner ``svg`` to those around it (SVG 2, section 8.2).

    Parameters
    ----------
    element : Element
        The inner one.
    page : (width, height), optional
        What percentages are of, and the size of one that says none.
    """
    places = np.array([length(element, side, 0.0, page) for side in "xy"])
    inner = _canvas(element) if "viewBox" in element.attributes else None
    size = np.array([
        length(element, side, whole, page)
        for side, whole in zip(("width", "height"), page or (0.0, 0.0), strict=True)
    ])  # fmt: skip
    if inner is None or (size <= 0).any():
        return shift(*places)
    units = np.array([inner.width, inner.height])
    with np.errstate(over="ignore"):  # of a view box that is hardly there
        scales = size / units
    said = FITTED.fullmatch(element.attributes.get("preserveAspectRatio", "")[:LONGEST_LENGTH])
    along, across, how = said.groups() if said else ("Mid", "Mid", None)
    if along:
        scales[:] = scales.max() if how == "slice" else scales.min()
    if not np.isfinite(scales).all():
        return shift(*places)
    shares = np.array([SHARES[each or "Min"] for each in (along, across)])
    origin = shares * (size - scales * units) - scales * (inner.x, inner.y)
    return shift(*(places + origin)) @ np.diag([*scales, 1.0])
