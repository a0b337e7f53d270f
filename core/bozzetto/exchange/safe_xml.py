"""XML from outside: no entities, nothing fetched, no bottomless nesting."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Final
from xml.parsers import expat

from bozzetto.errors import FormatError, words_of
from bozzetto.exchange.limits import MAX_DEPTH, MAX_ELEMENTS, at_most

XML_SPACE: Final = "http://www.w3.org/XML/1998/namespace"

GZIP: Final = b"\x1f\x8b"

NOT_XML: Final = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def writable(text: str) -> str:
    """Remove the characters that XML 1.0 has no way to write."""
    return NOT_XML.sub("", text)


@dataclass(eq=False, slots=True)
class Element:
    """One element; equal only to itself.

    Attributes
    ----------
    space, tag : str
        Namespace ("" where there is none) and name without prefix.
    attributes : dict
        Names without prefix for those in no namespace or in the XML one; others as
        "namespace name".
    children : list of Element
    text : str
        All text directly inside, put together.
    """

    space: str
    tag: str
    attributes: dict[str, str]
    children: list[Element] = field(default_factory=list)
    text: str = ""


def parse_xml(data: bytes) -> Element:
    """Parse an XML file and return its root element.

    A document type may be named, as many programs do; what it refers to is not fetched.
    One that defines something is refused before that is looked at, and with it every
    entity: there the known attacks on XML readers live.

    Raises
    ------
    FormatError
        If it is not well-formed, its DOCTYPE defines something, or it is too large or too
        deep.
    """
    if data.startswith(GZIP):
        raise FormatError("It is compressed. Unpack it first, or save it as a plain file.")
    top = Element("", "", {})
    stack: list[Element] = [top]
    words: list[list[str]] = [[]]
    count = 0

    def refuse(*_: object) -> None:
        raise FormatError(
            "Its document type (<!DOCTYPE … [ … ]>) defines something, which is not accepted. "
            "Export the file again as plain SVG or InkML."
        )

    def doctype(name: str, system: str | None, public: str | None, defines: bool) -> None:
        if defines:
            refuse()

    def start(name: str, attributes: dict[str, str]) -> None:
        nonlocal count
        count += 1
        at_most(count, MAX_ELEMENTS, "elements")
        at_most(len(stack), MAX_DEPTH, "levels of nesting")
        space, _, tag = name.rpartition(" ")
        plain = {key.removeprefix(f"{XML_SPACE} "): value for key, value in attributes.items()}
        made = Element(space, tag, plain)
        stack[-1].children.append(made)
        stack.append(made)
        words.append([])

    def end(_: str) -> None:
        stack.pop().text = "".join(words.pop())

    parser = expat.ParserCreate(namespace_separator=" ")
    parser.buffer_text = True
    parser.StartDoctypeDeclHandler = doctype
    parser.EntityDeclHandler = refuse
    parser.StartElementHandler = start
    parser.EndElementHandler = end
    parser.CharacterDataHandler = lambda text: words[-1].append(text)
    try:
        parser.Parse(data, True)
    except expat.ExpatError as error:
        raise FormatError(f"This is not well-formed XML: {words_of(error)}.") from error
    except (LookupError, ValueError) as error:  # an encoding that Python does not know
        raise FormatError(f"Its text encoding cannot be read: {words_of(error)}.") from error
    return top.children[0]
