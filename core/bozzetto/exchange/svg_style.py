"""How the elements of an SVG are painted: attributes, style sheets and inheritance.

Of style sheets the rules for a type, a class or an id are understood, which is what drawing
programs write; others are passed over.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Final, Literal

from bozzetto.exchange.xml_tree import Element

__all__ = ["Color", "Look", "Sheets"]

Color = tuple[int, int, int]

COMMENT: Final = re.compile(r"/\*.*?\*/", re.DOTALL)
RULE: Final = re.compile(r"([^{}]*)\{([^{}]*)\}")
SELECTOR: Final = re.compile(r"\*|[.#]?[A-Za-z_][\w-]*")

UNPAINTED: Final = ("none", "transparent")


@dataclass(frozen=True)
class Look:
    """What an element shows and hands on to the elements inside it.

    Attributes
    ----------
    filled, stroked : bool
        Whether its inside and its line are painted.
    rule : {"nonzero", "evenodd"}
        What counts as its inside.
    color : (r, g, b) or None
        Of the line, where it is a plain colour.
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
            for selectors, body in RULE.findall(COMMENT.sub("", element.text)):
                order += 1
                said = _declarations(body)
                for selector in map(str.strip, selectors.split(",")):
                    if SELECTOR.fullmatch(selector):
                        known = self._rules.setdefault(selector, {})
                        known.update((name, (order, value)) for name, value in said.items())

    def said(self, element: Element, name: str) -> str | None:
        """What is said of one element's property: its style, its rules, then its attribute."""
        own = element.attributes.get("style")
        if own and (value := _declarations(own).get(name)) is not None:
            return value
        if self._rules:
            classes = [f".{word}" for word in element.attributes.get("class", "").split()]
            identity = f"#{element.attributes.get('id', '')}"
            for group in ([identity], classes, [element.tag], ["*"]):
                found = [r[name] for key in group if name in (r := self._rules.get(key, {}))]
                if found:
                    return max(found)[1]
        return element.attributes.get(name)

    def displayed(self, element: Element) -> bool:
        """Whether an element and those inside it are drawn at all."""
        return self.said(element, "display") != "none"

    def look(self, element: Element, inherited: Look) -> Look:
        """How an element is painted."""

        def said(name: str) -> str | None:
            value = self.said(element, name)
            return None if value == "inherit" else value

        fill, stroke, rule = said("fill"), said("stroke"), said("fill-rule")
        visibility = said("visibility")
        return Look(
            inherited.filled if fill is None else fill not in UNPAINTED,
            inherited.stroked if stroke is None else stroke not in UNPAINTED,
            inherited.rule if rule is None else "evenodd" if rule == "evenodd" else "nonzero",
            inherited.color if stroke is None else _color(stroke),
            inherited.visible if visibility is None else visibility == "visible",
        )


def _declarations(text: str) -> dict[str, str]:
    """Properties and their values, as in ``fill: none; stroke: red``."""
    result = {}
    for entry in text.split(";"):
        name, colon, value = entry.partition(":")
        if colon:
            result[name.strip()] = value.replace("!important", "").strip()
    return result


def _color(said: str) -> Color | None:
    if said in (*UNPAINTED, "currentColor") or said.startswith("url"):
        return None
    from PIL import ImageColor

    try:
        red, green, blue = ImageColor.getrgb(said)[:3]
    except ValueError:
        return None
    return min(max(red, 0), 255), min(max(green, 0), 255), min(max(blue, 0), 255)
