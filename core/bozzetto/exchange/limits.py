"""How much a file from outside may ask of us, and one of ours of others."""

from __future__ import annotations

from typing import Final

from bozzetto.errors import FormatError

__all__ = [
    "MAX_CONTROL_POINTS",
    "MAX_COORDINATE",
    "MAX_DEPTH",
    "MAX_ELEMENTS",
    "MAX_FACES",
    "MAX_INK_BYTES",
    "MAX_MESH_BYTES",
    "MAX_PIXELS",
    "MAX_SAMPLES",
    "MAX_STEPS",
    "MAX_STROKES",
    "MAX_VERTICES",
    "at_most",
]

MAX_MESH_BYTES: Final = 1 << 30
"""Largest mesh or image file, bytes."""

MAX_INK_BYTES: Final = 1 << 27
"""Largest ink or SVG file, bytes: text, which takes several times its size in memory."""

MAX_VERTICES: Final = 20_000_000
MAX_FACES: Final = 40_000_000

MAX_STROKES: Final = 200_000
MAX_STEPS: Final = 200_000
"""As many as strokes: most steps draw one."""

MAX_SAMPLES: Final = 20_000_000
"""Samples of all strokes together; one stroke is bounded by `Stroke` itself."""

MAX_CONTROL_POINTS: Final = 1_000_000
"""Control points of all curves written to one file: 100 MB of text, and far more than a CAD
program works with."""

MAX_ELEMENTS: Final = 1_000_000
"""Elements of an XML file."""

MAX_DEPTH: Final = 100
"""Levels of nesting: XML elements, groups, nodes."""

MAX_PIXELS: Final = 80_000_000
"""Pixels of an image: 320 MB as RGBA; an A3 scan at 600 dpi has 70 million."""

MAX_COORDINATE: Final = 1e9
"""Largest coordinate, mm or pixels: a thousand kilometres. Far inside what float32 holds,
so that sums and squares stay finite."""


def at_most(count: int, limit: int, what: str) -> None:
    """Refuse a file that holds more of something than we take.

    Raises
    ------
    FormatError
    """
    if count > limit:
        raise FormatError(
            f"This file holds {count:,} {what}, more than the {limit:,} that can be read. "
            "Split it or simplify it first."
        )
