"""Colours of surfaces: calm, and neighbours in the list apart."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from bozzetto_product.model.appearance import Color
from bozzetto_product.model.patches import Patch
from bozzetto_product.solve.result import SolvedPatch

CALM: Final[tuple[Color, ...]] = (
    (0xC9, 0xB8, 0x9A),
    (0x9D, 0xB4, 0xB5),
    (0xC3, 0xA2, 0x97),
    (0xA8, 0xB7, 0x93),
    (0xB1, 0xA9, 0xC0),
    (0xCB, 0xC0, 0x8C),
    (0x92, 0xA9, 0xC0),
    (0xC6, 0xA9, 0xB4),
    (0x9C, 0xBB, 0xA6),
    (0xB9, 0xAF, 0xA4),
)
"""Colours of about one lightness under dark and light lines, warm and cool in turn."""


def colors_of(patches: Sequence[SolvedPatch]) -> tuple[Color, ...]:
    """Return the colours of patches: their own, or calm ones that differ from their neighbours'.

    A mirror image has the colour of its patch.
    """
    taken: dict[int, set[Color]] = {}
    known: dict[str, Color] = {}
    for one in patches:
        near = set().union(*(taken.get(edge, set()) for edge, _ in one.loop))
        first = _number(one.patch)
        row = (CALM[(first + step) % len(CALM)] for step in range(len(CALM)))
        free = next((color for color in row if color not in near), CALM[first % len(CALM)])
        color = known.setdefault(one.patch.id, one.patch.color or free)
        for edge, _ in one.loop:
            taken.setdefault(edge, set()).add(color)
    return tuple(known[one.patch.id] for one in patches)


def _number(patch: Patch) -> int:
    digits = "".join(letter for letter in patch.id if letter.isdecimal())
    return int(digits) if digits else sum(map(ord, patch.id))
