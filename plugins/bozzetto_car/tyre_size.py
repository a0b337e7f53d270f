"""Sizes of tyres as they are written on their sides, such as 205/55 R16 (ISO 4000-1).

The first number is the width of the section, mm; the second its height in per cent of the width;
the third the diameter of the rim, inches. What may follow, the load and the speed, is no size.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Final

from bozzetto.errors import UserError

MM_PER_INCH: Final = 25.4

WRITTEN: Final = re.compile(
    r"(?:P|LT)?\s*(\d{3})\s*/\s*(\d{2})\s*(?:-|Z?R|B|D)?\s*(\d{2})\s*C?"
    r"(?:\s+\(?\d{2,3}(?:/\d{2,3})?\s*[A-Z]\)?)?",
    re.ASCII | re.IGNORECASE,
)

RANGES: Final = (("width", 105, 405, "mm"), ("height", 20, 95, "%"), ("rim", 10, 26, "inches"))
"""What is made: lowest and highest of each number."""

UNKNOWN: Final = (
    "“{}” is no size of a tyre. Write it as on the side of a tyre, such as 205/55 R16: width in "
    "mm, height in per cent of it, rim in inches. Leave it empty for wheels as the car is drawn."
)


@dataclass(frozen=True)
class TyreSize:
    """Width of a tyre, and diameters of the rim under it and of the whole, mm."""

    width: float
    rim: float
    diameter: float


def tyre_size(text: str) -> TyreSize | None:
    """Return the size that a text names; None where there is no text.

    Raises
    ------
    UserError
        If it is no size, or one that nobody makes.
    """
    if not text.strip():
        return None
    said = WRITTEN.fullmatch(text.strip())
    if said is None:
        raise UserError(UNKNOWN.format(text.strip()[:40]))
    width, height, rim = (int(number) for number in said.groups())
    for (name, low, high, unit), value in zip(RANGES, (width, height, rim), strict=True):
        if not low <= value <= high:
            raise UserError(
                f"No tyre has a {name} of {value} {unit}. Give one from {low} to {high} {unit}, "
                "such as 205/55 R16."
            )
    bead = MM_PER_INCH * rim
    return TyreSize(float(width), bead, bead + 2.0 * width * height / 100.0)
