"""Text files: one encoding for all, and their words counted before they are made."""

from __future__ import annotations

import codecs
from typing import Final

import numpy as np

from bozzetto.exchange.limits import MAX_WORDS, at_most

PIECE: Final = 1 << 20
"""Bytes that are looked at in one go."""

BLANK: Final = 0x20
"""Largest byte that is taken for a blank."""


def word_count(text: bytes) -> int:
    """Count the words that ``text.split()`` finds; a few more where control characters stand."""
    count = 0
    after_blank = True
    for first in range(0, len(text), PIECE):
        blank = np.frombuffer(text, np.uint8, min(PIECE, len(text) - first), first) <= BLANK
        begins = ~blank
        begins[1:] &= blank[:-1]
        begins[0] &= after_blank
        count += int(begins.sum())
        after_blank = bool(blank[-1])
    return count


def checked_text(data: bytes) -> bytes:
    """Return the text of a file as UTF-8 without a mark at its beginning, if it is not too long.

    Windows PowerShell and old editors write UTF-16, with such a mark.

    Raises
    ------
    FormatError
        If it has more words than can be held.
    """
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        data = data.decode("utf-16", "replace").encode()
    data = data.removeprefix(codecs.BOM_UTF8)
    check_words(data)
    return data


def check_words(text: bytes) -> None:
    """Refuse a text of more words than can be held.

    Raises
    ------
    FormatError
    """
    at_most(word_count(text), MAX_WORDS, "words")
