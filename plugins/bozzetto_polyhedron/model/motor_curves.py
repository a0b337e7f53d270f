"""Curves of motors as they are typed: “0: 0, 1: 90, 2: 0”, seconds and degrees or mm."""

from __future__ import annotations

import re
from itertools import pairwise
from typing import Final, TypeAlias

from bozzetto.plugin import UserError

Keys: TypeAlias = tuple[tuple[float, float], ...]

MOST_KEYS: Final = 60
"""Keys of one curve."""

LONGEST: Final = 3600.0
"""Last time of a curve, s."""

LARGEST: Final = 1e5
"""Largest value of a curve, degrees or mm."""

CLOSEST: Final = 0.01
"""Time between two keys at least, s."""

_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_ROW = re.compile(rf"\s*({_NUMBER})\s*s?\s*:\s*({_NUMBER})\s*(?:°|mm)?\s*")


def typed_keys(text: str) -> Keys:
    """Return the keys of a curve, in the order of time.

    Raises
    ------
    UserError
        If the text is no such curve, with how one is written.
    """
    rows = [row for row in re.split(r"[,;\n]", text) if row.strip()]
    found = [_ROW.fullmatch(row) for row in rows]
    wrong = next((row for row, match in zip(rows, found, strict=True) if match is None), None)
    if wrong is not None:
        raise UserError(
            f"“{wrong.strip()[:40]}” is no time with its value. Write seconds, a colon and the "
            "value, rows with commas between them: 0: 0, 1: 90, 2: 0."
        )
    keys = tuple((float(match[1]), float(match[2])) for match in found if match is not None)
    if not 2 <= len(keys) <= MOST_KEYS:
        raise UserError(
            f"A curve of a motor has 2 to {MOST_KEYS} times; this has {len(keys)}. "
            "Write it as 0: 0, 1: 90, 2: 0."
        )
    times = [time for time, _ in keys]
    late = [b for a, b in pairwise(times) if b - a < CLOSEST * (1.0 - 1e-9)]
    if late:
        raise UserError(
            f"Each time of a curve is at least {CLOSEST:g} s after the one before it; {late[0]:g} "
            "is not. Put the rows into the order of time."
        )
    if times[0] < 0.0 or times[-1] > LONGEST:
        raise UserError(f"Times of a curve are from 0 to {LONGEST:g} s. Change the first or last.")
    if any(abs(value) > LARGEST for _, value in keys):
        raise UserError(f"Values of a curve are {LARGEST:g} at most. Make the largest smaller.")
    return keys


def written_keys(keys: Keys) -> str:
    """Return keys as a person types them."""
    return ", ".join(f"{time:.6g}: {value:.6g}" for time, value in keys)
