"""Notices about a curve that may have been meant otherwise, or lies off its ink."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from bozzetto_symmetry.interpretation.candidate import Read

UNSURE: Final = "It is unclear how the strokes belong together. Draw the curve again."

ON_INK: Final = 1.5
"""Distance between ink and image (rms, px) above which a person is told: a hand strays by less."""

MISSES: Final = (
    "The curve is {:.1f} px off its ink. Draw it again in another view, or press X or C to read it "
    "in another way."
)

UNDECIDED: Final = 1.2
"""Ratio of prices below which the ink does not say how two sides belong together."""

UNDECIDED_LOOPS: Final = 0.6
"""Difference, px, that says the same of loops. Their prices are logarithms of odds, for nearly all
of them are what people seldom mean: beyond it one drawing of two hundred is read in the wrong
sense. Told by the ratio of prices, it is one of eighty for as many that are told in vain."""

EITHER: Final = (
    "The sides fit one another in two ways. Press C to take the other one if it is meant."
)

UNDECIDED_PLANES: Final = 0.7
"""Difference of prices, px, below which the ink does not say in which plane a curve lies."""

PLANES: Final = (
    "The ink fits the curve in two planes. Press C to take the other one if it is meant."
)


def is_undecided(first: Read, rest: Sequence[Read]) -> bool:
    """Return whether two sides may as well belong together in another way.

    Parameters
    ----------
    first : Read
        What they were read as.
    rest : sequence of Read
        What else they may be.
    """
    pairs = [other.cost for other in rest if first.reading == other.reading == "pair"]
    most = first.cost + UNDECIDED_LOOPS if first.closed else UNDECIDED * first.cost
    return bool(pairs) and min(pairs) < most


def lies_in_either(first: Read, rest: Sequence[Read]) -> bool:
    """Return whether a flat curve across the centre plane may as well lie in another plane.

    Parameters
    ----------
    first : Read
        What the ink was read as.
    rest : sequence of Read
        What else it may be, the likeliest first.
    """
    forms = [each.form for each in (first, *rest[:1]) if each.form is not None]
    flat = [form for form in forms if len(form.planes) == 1]
    return len(flat) == 2 and rest[0].cost < first.cost + UNDECIDED_PLANES


def off_the_ink(off: float) -> tuple[str, ...]:
    """Return what is said of a curve whose image is so far, px (rms), from its ink."""
    return () if off <= ON_INK else (MISSES.format(off),)


def notices(first: Read, rest: Sequence[Read], off: float, sure: bool) -> tuple[str, ...]:
    """Return all that a person is told of a curve.

    Parameters
    ----------
    first : Read
        What the ink was read as.
    rest : sequence of Read
        What else it may be.
    off : float
        How far the image is from the ink, px (rms).
    sure : bool
        Whether strokes upon one another merge well into one line.
    """
    either = (EITHER,) if is_undecided(first, rest) else ()
    planes = (PLANES,) if lies_in_either(first, rest) else ()
    return *first.warnings, *either, *planes, *off_the_ink(off), *(() if sure else (UNSURE,))
