"""XML from outside, plain or compressed: no entities, nothing fetched, no bottomless nesting.

The names of namespaces that Adobe Illustrator defines in its document type are put in their places
before the file is parsed; no parser ever sees a definition.
"""

from __future__ import annotations

import re
import zlib
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final
from xml.parsers import expat

from bozzetto.errors import FormatError, words_of
from bozzetto.exchange.limits import MAX_DEPTH, MAX_ELEMENTS, USUAL_BYTES, at_most

XML_SPACE: Final = "http://www.w3.org/XML/1998/namespace"

GZIP: Final = b"\x1f\x8b"

GZIP_FORM: Final = 16 + zlib.MAX_WBITS
"""What zlib calls the form of such files."""

NOT_XML: Final = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


HEAD: Final = 20_000
"""Bytes in which a document type begins."""

MAX_NAMES: Final = 1_000
"""Most places at which the name of a namespace is put in."""

NAMED_SPACES: Final = re.compile(
    rb"""<!DOCTYPE\s++svg\b[^\[<>]{0,400}\[
    (?:\s*+
      (?:<!ENTITY\s++[\w.-]{1,40}\s++"https?://[^"&%<>]{0,200}"\s*+>
        |<!ATTLIST\s++svg\s++xmlns:[\w.-]{1,40}\s++CDATA\s++\#FIXED\s++"[^"&%<>]{0,200}"\s*+>)
    )++\s*+\]\s*+>""",
    re.VERBOSE,
)
"""A document type that gives short names to namespaces and does nothing else."""

NAMED_SPACE: Final = re.compile(rb'<!ENTITY\s++([\w.-]+)\s++"([^"]+)"')

USED_SPACE: Final = re.compile(rb"""=(["'])&([\w.-]{1,40});\1""")


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

    Raises
    ------
    FormatError
        As `parse_events`, and if it has too many elements or is too deep.
    """
    top = Element("", "", {})
    stack: list[Element] = [top]
    words: list[list[str]] = [[]]
    count = 0

    def start(space: str, tag: str, attributes: dict[str, str]) -> None:
        nonlocal count
        count += 1
        at_most(count, MAX_ELEMENTS, "elements")
        at_most(len(stack), MAX_DEPTH, "levels of nesting")
        made = Element(space, tag, attributes)
        stack[-1].children.append(made)
        stack.append(made)
        words.append([])

    def end() -> None:
        stack.pop().text = "".join(words.pop())

    parse_events(data, start, end, lambda text: words[-1].append(text))
    return top.children[0]


def parse_events(
    data: bytes,
    start: Callable[[str, str, dict[str, str]], None],
    end: Callable[[], None] | None = None,
    text: Callable[[str], None] | None = None,
) -> None:
    """Go through an XML file without keeping it.

    A document type may be named, as many programs do; what it refers to is not fetched.
    One that defines something is refused before that is looked at, and with it every
    entity: there the known attacks on XML readers live. Only names for namespaces are accepted,
    as Adobe Illustrator writes them, where they are whole values of attributes.

    Parameters
    ----------
    data : bytes
        The file.
    start : callable
        Takes namespace, name and attributes of every element, as an `Element` has them.
    end : callable, optional
        Called at the end of every element.
    text : callable, optional
        Takes text as it comes.

    Raises
    ------
    FormatError
        If it is not well-formed, or its DOCTYPE defines something; or if it is compressed and
        damaged, or too large when it is unpacked.
    """
    if data.startswith(GZIP):
        data = _unpacked(data)

    def refuse(*_: object) -> None:
        raise FormatError(
            "Its document type (<!DOCTYPE … [ … ]>) defines something, which is not accepted. "
            "Save it again without one; drawings as plain SVG or InkML."
        )

    def doctype(name: str, system: str | None, public: str | None, defines: bool) -> None:
        if defines:
            refuse()

    def started(name: str, attributes: dict[str, str]) -> None:
        space, _, tag = name.rpartition(" ")
        start(space, tag, {key.removeprefix(f"{XML_SPACE} "): v for key, v in attributes.items()})

    parser = expat.ParserCreate(namespace_separator=" ")
    parser.buffer_text = True
    parser.StartDoctypeDeclHandler = doctype
    parser.EntityDeclHandler = refuse
    parser.StartElementHandler = started
    if end is not None:
        parser.EndElementHandler = lambda _: end()
    if text is not None:
        parser.CharacterDataHandler = text
    try:
        parser.Parse(_with_namespaces(data), True)
    except expat.ExpatError as error:
        raise FormatError(f"This is not well-formed XML: {words_of(error)}.") from error
    except (LookupError, ValueError) as error:  # an encoding that Python does not know
        raise FormatError(f"Its text encoding cannot be read: {words_of(error)}.") from error


def _unpacked(data: bytes) -> bytes:
    """Return what a file that gzip compressed holds, such as SVGZ; a file within it is refused."""
    unpacking = zlib.decompressobj(GZIP_FORM)
    try:
        plain = unpacking.decompress(data, USUAL_BYTES + 1)
    except zlib.error as error:
        raise FormatError(f"It is compressed and damaged: {words_of(error)}.") from error
    if len(plain) > USUAL_BYTES:
        raise FormatError(
            f"It has more than {USUAL_BYTES >> 20} MB when it is unpacked. Save it as a plain file."
        )
    if not unpacking.eof:
        raise FormatError("It is compressed and cut short.")
    if plain.startswith(GZIP):
        raise FormatError("It is compressed twice. Unpack it first, or save it as a plain file.")
    return plain


def _with_namespaces(data: bytes) -> bytes:
    """Return a file with its namespaces written out, where its document type names them."""
    head = NAMED_SPACES.search(data, 0, HEAD)
    if head is None:
        return data
    names = dict(NAMED_SPACE.findall(head.group()))
    body = data[head.end() :]
    at_most(len(USED_SPACE.findall(body)), MAX_NAMES, "names of namespaces")
    written = USED_SPACE.sub(
        lambda use: b'="%s"' % names[use[2]] if use[2] in names else use.group(), body
    )
    return data[: head.start()] + written
