"""Names that look like a known one: what a misspelt name was meant to be."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

MOST_EDITS: Final = 2
"""Letters that may be missing, too many, exchanged or wrong in a misspelt name."""

SHORT: Final = 4
"""Letters of either name up to which two edits make another word of it: drop, group."""

SHORTEST: Final = 3
"""Letters of a name up to which another letter makes another word of it: tap, top, map."""


def meant_by(name: str, known: Iterable[str]) -> str:
    """Return the known name that another one is a misspelling of; "" for none."""
    plain = _plain(name)
    for other in sorted(known):
        wanted = _plain(other)
        if plain == wanted:
            return other
        if len(wanted) <= SHORTEST and len(plain) == len(wanted):
            if sorted(plain) == sorted(wanted):
                return other
            continue
        most = MOST_EDITS if min(len(plain), len(wanted)) > SHORT else 1
        if _edits(plain, wanted, most) <= most:
            return other
    return ""


def _plain(name: str) -> str:
    return name.replace("_", "").lower()


def _edits(one: str, other: str, most: int) -> int:
    """Count the letters that must be inserted, left out, changed or swapped with the next one.

    The distance of Damerau (1964) with non-overlapping swaps; more than `most` is only told
    as more.
    """
    if abs(len(one) - len(other)) > most:
        return most + 1
    rows = [list(range(len(other) + 1))]
    for i, letter in enumerate(one, 1):
        row = [i]
        for j, wanted in enumerate(other, 1):
            cost = min(row[-1] + 1, rows[-1][j] + 1, rows[-1][j - 1] + (letter != wanted))
            swapped = i > 1 and j > 1 and letter == other[j - 2] and one[i - 2] == wanted
            row.append(min(cost, rows[-2][j - 2] + 1) if swapped else cost)
        rows.append(row)
    return rows[-1][-1]
