"""Style of SVG elements: attributes, style sheets and inheritance.

Of style sheets the rules for a type, a class or an id are understood, which is what drawing
programs write; others are passed over.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, Literal

from bozzetto.exchange.safe_xml import Element

Color = tuple[int, int, int]

SELECTOR: Final = re.compile(r"\*|[.#]?[A-Za-z_][\w-]*")

PROPERTIES: Final[tuple[str, ...]] = (
    "display", "fill", "stroke", "fill-rule", "visibility", "transform", "transform-origin",
    "clip-path", "clip-rule", "mask", "overflow",
)  # fmt: skip
"""Properties that are read; nothing else is kept of a style sheet."""

Properties = dict[str, str]
"""Properties of an element: some of `PROPERTIES`, with their values."""

LONGEST_COLOR: Final = 100
"""Longest name of a colour, characters."""

UNPAINTED: Final = ("none", "transparent")


@dataclass(frozen=True)
class Look:
    """Painting of an element, handed on to the elements inside it.

    Attributes
    ----------
    filled, stroked : bool
        Whether its inside and its line are painted.
    rule : {"nonzero", "evenodd"}
        What counts as its inside.
    color : (r, g, b) or None
        Colour of the line, where it is a plain colour.
    visible : bool
    """

    filled: bool = True
    stroked: bool = False
    rule: Literal["nonzero", "evenodd"] = "nonzero"
    color: Color | None = None
    visible: bool = True

    @property
    def painted(self) -> bool:
        """Whether anything of the element is to be seen."""
        return self.visible and (self.filled or self.stroked)


class Sheets:
    """The style sheets of a document.

    Parameters
    ----------
    root : Element
        The document; its ``style`` elements are read, wherever they are.
    """

    def __init__(self, root: Element) -> None:
        self._rules: dict[str, dict[str, tuple[int, str]]] = {}
        order = 0
        waiting = [root]
        while waiting:
            element = waiting.pop()
            waiting.extend(reversed(element.children))
            if element.tag != "style":
                continue
            for selectors, body in _rules(element.text):
                order += 1
                said = _declarations(body)
                for selector in map(str.strip, selectors.split(",")):
                    if said and SELECTOR.fullmatch(selector):
                        known = self._rules.setdefault(selector, {})
                        known.update((name, (order, value)) for name, value in said.items())

    def properties(self, element: Element) -> Properties:
        """Return the properties of an element: attributes, then rules, above all its own style."""
        attributes = element.attributes
        properties: Properties = {
            name: attributes[name] for name in PROPERTIES if name in attributes
        }
        if self._rules:
            classes = [f".{word}" for word in attributes.get("class", "").split()]
            identity = f"#{attributes.get('id', '')}"
            for group in (["*"], [element.tag], classes, [identity]):
                found: dict[str, tuple[int, str]] = {}
                for key in group:
                    for name, told in self._rules.get(key, {}).items():
                        found[name] = max(told, found.get(name, told))
                properties |= {name: value for name, (_, value) in found.items()}
        if own := attributes.get("style"):
            properties |= _declarations(own)
        return properties

    def look(self, properties: Properties, inherited: Look) -> Look:
        """Return the look of an element that has these properties."""
        if not properties:
            return inherited
        told = {name: value for name, value in properties.items() if value != "inherit"}
        fill, stroke, rule = told.get("fill"), told.get("stroke"), told.get("fill-rule")
        visibility = told.get("visibility")
        return Look(
            inherited.filled if fill is None else fill not in UNPAINTED,
            inherited.stroked if stroke is None else stroke not in UNPAINTED,
            inherited.rule if rule is None else "evenodd" if rule == "evenodd" else "nonzero",
            inherited.color if stroke is None else _color(stroke),
            inherited.visible if visibility is None else visibility == "visible",
        )


def _rules(text: str) -> Iterator[tuple[str, str]]:
    """Yield selectors and bodies of a style sheet's innermost blocks, in one pass."""
    for piece in _without_comments(text).split("}")[:-1]:
        head, brace, body = piece.rpartition("{")
        if brace:
            yield head.rpartition("{")[2], body


def _without_comments(text: str) -> str:
    """Return the text without its comments; one without an end reaches to the end."""
    kept: list[str] = []
    at = 0
    while (begin := text.find("/*", at)) >= 0:
        kept.append(text[at:begin])
        end = text.find("*/", begin + 2)
        if end < 0:
            return "".join(kept)
        at = end + 2
    return "".join((*kept, text[at:]))


def _declarations(text: str) -> Properties:
    """Return properties that matter and their values, as in ``fill: none; stroke: red``."""
    result = {}
    for entry in text.split(";"):
        name, colon, value = entry.partition(":")
        if colon and name.strip() in PROPERTIES:
            result[name.strip()] = value.replace("!important", "").strip()
    return result


def _color(said: str) -> Color | None:
    if said in (*UNPAINTED, "currentColor") or said.startswith("url"):
        return None
    if len(said) > LONGEST_COLOR:
        return None
    from PIL import ImageColor

    try:
        red, green, blue = ImageColor.getrgb(said)[:3]
    except ValueError:
        return None
    return min(max(red, 0), 255), min(max(green, 0), 255), min(max(blue, 0), 255)
