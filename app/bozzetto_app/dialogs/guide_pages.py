"""The guide's pages: where they lie, and their text as the guide window shows it.

A wheel brings the pages and their pictures along; in a checkout they are read where they are
written, in ``docs``.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Final, NamedTuple

__all__ = [
    "FIRST_PAGE",
    "Heading",
    "guide_folder",
    "headings_of",
    "shares_of",
    "shown_text",
    "slug",
]

FIRST_PAGE: Final = "guide.md"

PACKED: Final = Path(__file__).parents[1] / "guide"
WRITTEN: Final = Path(__file__).parents[3] / "docs"

KEY: Final = re.compile(r"<kbd>(.*?)</kbd>")
HEADING: Final = re.compile(r"^(#{1,6}) +(.*?) *#*$", re.MULTILINE)
STAR: Final = re.compile(r"^( *)\*(?= )", re.MULTILINE)
PICTURE: Final = re.compile(r"!\[[^\]]*\]\(([^)\s]+)\)")
FENCE: Final = re.compile(r"^```.*?^```", re.MULTILINE | re.DOTALL)


class Heading(NamedTuple):
    """A heading of a page: its words, how deep it is (1 is the page's title), its anchor."""

    words: str
    depth: int
    anchor: str


def guide_folder() -> Path:
    """Return the folder of the pages."""
    return PACKED if (PACKED / FIRST_PAGE).is_file() else WRITTEN


def slug(words: str) -> str:
    """Return the anchor of a heading as GitHub makes it, for links between pages."""
    kept = re.sub(r"[^\w\- ]", "", words.strip().lower())
    return kept.replace(" ", "-")


def headings_of(text: str) -> Iterator[Heading]:
    """Return the headings of a page, from the top."""
    for marks, words in HEADING.findall(FENCE.sub("", text)):
        plain = KEY.sub(r"\1", words).replace("`", "")
        yield Heading(plain, len(marks), slug(plain))


def shown_text(text: str) -> str:
    """Return a page in the Markdown that Qt reads.

    Keys are set like code, for Qt's Markdown knows no ``kbd``; lists get dots, which Qt sets for
    ``-`` alone.
    """
    return STAR.sub(r"\1-", KEY.sub(r"`\1`", text))


def shares_of(text: str) -> dict[str, float]:
    """By the name of a picture in a table: the share of the page's width that it has."""
    shares = {}
    for line in text.splitlines():
        if line.startswith("|"):
            columns = line.strip().strip("|").count("|") + 1
            shares.update(dict.fromkeys(PICTURE.findall(line), 1.0 / columns))
    return shares
