"""The elements of SVG that have an outline, and the numbers in their attributes."""

from __future__ import annotations

import math
import re
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import FormatError
from bozzetto.exchange.limits import MAX_COORDINATE, at_most
from bozzetto.exchange.safe_xml import Element
from bozzetto.exchange.svg.path_data import Subpath, ellipse, parse_path, polyline

SPACE: Final = "http://www.w3.org/2000/svg"
"""The namespace of SVG."""

PIXELS: Final = {
    "": 1.0, "px": 1.0, "mm": 96 / 25.4, "cm": 96 / 2.54, "in": 96.0, "pt": 96 / 72, "pc": 16.0,
}  # fmt: skip
"""User units in a unit of length (CSS: 96 to the inch)."""

MM_PER_PIXEL: Final = 25.4 / 96

# All quantifiers give nothing back: a text that does not fit is given up in one pass.
NUMBER: Final = re.compile(r"[+-]?(?:\d++\.?+\d*+|\.\d++)(?:[eE][+-]?\d++)?+")
LENGTH: Final = re.compile(rf"\s*+({NUMBER.pattern})\s*+(px|mm|cm|in|pt|pc)?+\s*+")
SHARE: Final = re.compile(rf"\s*+({NUMBER.pattern})\s*+%\s*+")
LETTERS: Final = re.compile(rf"\s*+{NUMBER.pattern}\s*+(?:em|ex|ch|rem|vw|vh)\s*+")
"""Lengths that depend on letters or on the window: nobody but a browser knows them."""

ACROSS: Final = frozenset(("x", "width", "cx", "rx", "x1", "x2"))
DOWN: Final = frozenset(("y", "height", "cy", "ry", "y1", "y2"))
"""Lengths of which a percentage is one of the width, and of the height (SVG 2, section 8.9)."""

LONGEST_LENGTH: Final = 200
"""Characters of a length or a view box; nobody writes as many digits."""

KEYWORDS: Final = {
    "left": "0%", "top": "0%", "center": "50%", "right": "100%", "bottom": "100%",
}  # fmt: skip

ARGUMENT: Final = re.compile(rf"({NUMBER.pattern})([A-Za-z]++|%)?+")
DEGREES: Final = {"": 1.0, "deg": 1.0, "rad": 180.0 / math.pi, "grad": 0.9, "turn": 360.0}
NO_TRANSFORM: Final = frozenset(("", "none", "initial", "unset", "revert"))

TRANSFORM: Final = re.compile(r"[\s,]*+([A-Za-z]++)\s*+\(([^()]*+)\)[\s,]*+")
MOST_TRANSFORMS: Final = 10_000
"""Limit of transforms of one element."""


def length(
    element: Element, name: str, default: float, page: tuple[float, float] | None = None
) -> float:
    """Return a length in user units; the default where it is absent or cannot be known.

    Parameters
    ----------
    element : Element
        What has it.
    name : str
        Of the attribute.
    default : float
        Where there is none.
    page : (width, height), optional
        What percentages are of, user units.

    Raises
    ------
    FormatError
        If it is larger than a drawing can be.
    """
    text = element.attributes.get(name, "")
    if len(text) > LONGEST_LENGTH:
        return default
    match = LENGTH.fullmatch(text)
    if match is not None:
        value = float(match[1]) * PIXELS[match[2] or ""]
    else:
        share = SHARE.fullmatch(text)
        if share is None or page is None:
            return default
        value = float(share[1]) / 100.0 * _whole(name, page)
    if abs(value) > MAX_COORDINATE:
        raise FormatError(f"The length “{name}” is larger than a drawing can be.")
    return value


def _whole(name: str, page: tuple[float, float]) -> float:
    """Return the length that a percentage of a name is of."""
    if name in ACROSS:
        return page[0]
    return page[1] if name in DOWN else math.hypot(*page) / math.sqrt(2.0)


def is_sized_by_letters(element: Element) -> bool:
    """Whether a length of a shape depends on its font or the window."""
    said = element.attributes
    return any(
        len(said[name]) <= LONGEST_LENGTH and LETTERS.fullmatch(said[name]) is not None
        for name in (*ACROSS, *DOWN, "r")
        if name in said
    )


def paper_length(element: Element, name: str) -> float | None:
    """Return a length on paper, mm; None where it is absent, relative or in pixels."""
    text = element.attributes.get(name, "")
    match = LENGTH.fullmatch(text) if len(text) <= LONGEST_LENGTH else None
    if match is None or match[2] in (None, "px"):
        return None
    value = float(match[1]) * PIXELS[match[2]] * MM_PER_PIXEL
    return value if 0.0 < value <= MAX_COORDINATE else None


def outline(element: Element, page: tuple[float, float] | None = None) -> list[Subpath]:
    """Return the subpaths of one shape; none for what is no shape.

    Parameters
    ----------
    element : Element
        The shape.
    page : (width, height), optional
        What percentages are of, user units.

    Raises
    ------
    FormatError
    """

    def at(name: str) -> float:
        return length(element, name, 0.0, page)

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
            return _rectangle(element, page)
        case _:
            return []


def _rectangle(element: Element, page: tuple[float, float] | None) -> list[Subpath]:
    x, y, width, height = (length(element, k, 0.0, page) for k in ("x", "y", "width", "height"))
    if width <= 0 or height <= 0:
        return []
    rx, ry = length(element, "rx", -1.0, page), length(element, "ry", -1.0, page)
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


def shift(x: float, y: float) -> Array:
    """Return a translation as a matrix (3, 3)."""
    return np.array([[1.0, 0.0, x], [0.0, 1.0, y], [0.0, 0.0, 1.0]])


def transform(text: str, page: tuple[float, float] | None = None) -> Array | None:
    """Return a transform list, of an attribute or of a style, as one matrix (3, 3); or None.

    Parameters
    ----------
    text : str
        The list; "none" and the like are no transform.
    page : (width, height), optional
        What percentages are of, user units.

    Raises
    ------
    FormatError
    """
    if text.strip() in NO_TRANSFORM:
        return None
    matrix: Array = np.eye(3)
    at = count = 0
    while at < len(text):
        count += 1
        at_most(count, MOST_TRANSFORMS, "transforms of one element")
        match = TRANSFORM.match(text, at)
        if match is None:
            if text[at:].strip():
                raise FormatError(f"A transform cannot be understood: “{text[at : at + 30]}”.")
            break
        numbers = _arguments(match[1], match[2], page)
        with np.errstate(all="ignore"):
            matrix = matrix @ _single_transform(match[1], numbers)
        at = match.end()
    if not (np.abs(matrix) <= MAX_COORDINATE).all():
        raise FormatError("A transform moves its lines further than a drawing can reach.")
    return matrix


def _arguments(kind: str, text: str, page: tuple[float, float] | None) -> list[float]:
    """Return what a transform is given: user units, degrees, or factors."""
    turns, moves = kind in ("rotate", "skewX", "skewY"), kind.startswith("translate")
    numbers = []
    for place, (digits, unit) in enumerate(ARGUMENT.findall(text)):
        number = float(digits)
        if unit == "%" and (page is not None or not moves):
            down = kind == "translateY" or place == 1
            number *= (page[down] if page is not None and moves else 1.0) / 100.0
        elif unit:
            units = DEGREES if turns and not place else PIXELS
            if unit not in units:
                raise FormatError(f"A transform has a unit that is not known: “{unit[:20]}”.")
            number *= units[unit]
        numbers.append(number)
    return numbers


def _single_transform(kind: str, numbers: list[float]) -> Array:
    if not all(abs(number) <= MAX_COORDINATE for number in numbers):
        raise FormatError("A transform holds a number that is too large.")
    match kind, numbers:
        case "matrix", [a, b, c, d, e, f]:
            return np.array([[a, c, e], [b, d, f], [0.0, 0.0, 1.0]])
        case "translate", [x, *rest] if len(rest) < 2:
            return shift(x, *rest or [0.0])
        case "translateX", [x]:
            return shift(x, 0.0)
        case "translateY", [y]:
            return shift(0.0, y)
        case "scaleX", [x]:
            return np.diag([x, 1.0, 1.0])
        case "scaleY", [y]:
            return np.diag([1.0, y, 1.0])
        case "scale", [x, *rest] if len(rest) < 2:
            return np.diag([x, *(rest or [x]), 1.0])
        case "rotate", [degrees, *center] if len(center) in (0, 2):
            x, y = center or (0.0, 0.0)
            c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
            turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
            return np.asarray(shift(x, y) @ turn @ shift(-x, -y))
        case "skewX", [degrees]:
            return np.array([[1, math.tan(math.radians(degrees)), 0], [0, 1, 0], [0, 0, 1.0]])
        case "skewY", [degrees]:
            return np.array([[1, 0, 0], [math.tan(math.radians(degrees)), 1, 0], [0, 0, 1.0]])
        case _:
            raise FormatError(f"A transform cannot be understood: “{kind[:20]}”.")


def origin(text: str, page: tuple[float, float] | None) -> tuple[float, float]:
    """Return the point about which a style transforms; (0, 0) where it is not understood."""
    words = text.split()[:2] if len(text) <= LONGEST_LENGTH else []
    if len(words) == 1:
        words = ["center", *words] if words[0] in ("top", "bottom") else [*words, "center"]
    if len(words) == 2 and (words[0] in ("top", "bottom") or words[1] in ("left", "right")):
        words.reverse()
    said = {name: KEYWORDS.get(word, word) for name, word in zip("xy", words, strict=False)}
    point = Element("", "", said)
    return length(point, "x", 0.0, page), length(point, "y", 0.0, page)
