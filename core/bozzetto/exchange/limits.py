"""Limits of files from outside, and of ours for other programs."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from typing import Final

from bozzetto.errors import FormatError

USUAL_BYTES: Final = 64 << 20
"""Size up to which a file has one `Budget`, bytes; a larger one gets more, in proportion."""


@dataclass(frozen=True)
class Budget:
    """Cost allowed for reading one file; beyond it the reading process is ended.

    Attributes
    ----------
    seconds : int
        Processor time. Ten seconds are as long as a person waits without doubt.
    megabytes : int
        Memory that the reading process takes beyond what it begins with. The rest of a
        gigabyte is what the answer takes in the process that asked.
    wall_seconds : int
        Time by the clock, where the system does not count processor time and for disks
        that do not answer: long enough for a machine that does ten things at once.
    """

    seconds: int = 10
    megabytes: int = 760
    wall_seconds: int = 120


def budget_for(size: int) -> Budget:
    """Return the budget of a file of so many bytes."""
    usual = Budget()
    share = max(1.0, size / USUAL_BYTES)
    return Budget(
        int(share * usual.seconds),
        int(share * usual.megabytes),
        int(share * usual.wall_seconds),
    )


MAX_MESH_BYTES: Final = 1 << 30
"""Largest mesh or image file, bytes."""

MAX_INK_BYTES: Final = 1 << 27
"""Largest ink or SVG file, bytes: text, which takes several times its size in memory."""

MAX_VERTICES: Final = 20_000_000
MAX_FACES: Final = 40_000_000

MAX_PARTS: Final = 20_000
"""Parts, groups and copies of parts of one file: an assembly of as many screws has not more."""

MAX_STROKES: Final = 200_000
MAX_STEPS: Final = 200_000
"""Limit of steps, the same as of strokes: most steps draw one."""

MAX_SAMPLES: Final = 20_000_000
"""Samples of all strokes together; one stroke is bounded by `Stroke` itself."""

MAX_CONTROL_POINTS: Final = 1_000_000
"""Control points of all curves written to one file: 100 MB of text, and far more than a CAD
program works with."""

MAX_ELEMENTS: Final = 1_000_000
"""Elements of an XML file."""

MAX_DEPTH: Final = 100
"""Levels of nesting: XML elements, groups, nodes."""

MAX_WORDS: Final = 12_000_000
"""Words of a mesh that is told in text: as objects half a gigabyte. 64 MB of nine digits hold
seven million."""

MAX_PIXELS: Final = 72_000_000
"""Pixels of an image: 288 MB as RGBA, once decoded and once handed over; an A3 scan at 600 dpi
has 70 million."""

MAX_COORDINATE: Final = 1e9
"""Largest coordinate, mm or pixels: a thousand kilometres. Far inside what float32 holds,
so that sums and squares stay finite."""


_trusting: ContextVar[bool] = ContextVar("trusting", default=False)


@contextmanager
def unlimited() -> Iterator[None]:
    """Lift the limits of number within the block: for files that a person trusts."""
    before = _trusting.set(True)
    try:
        yield
    finally:
        _trusting.reset(before)


def exceeds(count: int, limit: int) -> bool:
    """Whether a file that is not trusted holds more of something than we take."""
    return count > limit and not _trusting.get()


def at_most(count: int, limit: int, what: str) -> None:
    """Refuse a file that holds more of something than we take, unless it is trusted.

    Raises
    ------
    FormatError
    """
    if exceeds(count, limit):
        raise FormatError(
            f"This file holds {count:,} {what}, more than the {limit:,} that can be read. "
            "Split it or simplify it first."
        )
