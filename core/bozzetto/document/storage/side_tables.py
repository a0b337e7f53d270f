"""Tables beside a state's JSON: strokes and arrays, referred to by number."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.ink.stroke import Stroke

MAX_REPEATS: Final = 16
"""Greatest number of times that a state may name each of its strokes, on average: memory stays
near the size of the file."""

FEW: Final = 100_000
"""Names of strokes that are never too many: they take less than a megabyte."""


class Refusal(ValueError):
    """A value that does not fit its type; says where in the state."""

    def __init__(self, what: str) -> None:
        super().__init__(what)
        self.what = what
        self.where: list[str] = []

    def __str__(self) -> str:
        return f"state{''.join(reversed(self.where))}: {self.what}"


@dataclass
class Aside:
    """Strokes and arrays of a state, in the order in which the JSON refers to them."""

    strokes: list[Stroke] = field(default_factory=list)
    arrays: list[NDArray[Any]] = field(default_factory=list)
    depth: int = 0
    named: int = 0
    numbers: dict[int, int] = field(default_factory=dict)

    def put(self, shelf: list[Any], item: object) -> int:
        """Return the number of an item in its table; the same object gets the same number."""
        number = self.numbers.setdefault(id(item), len(shelf))
        if number == len(shelf):
            shelf.append(item)
        return number

    def name_strokes(self, count: int) -> None:
        """Count the strokes that rows of strokes name; raises `Refusal` for endless repeats."""
        self.named += count
        if self.named > max(FEW, MAX_REPEATS * len(self.strokes)):
            raise Refusal("names the same strokes over and over")

    @staticmethod
    def get(shelf: list[Any], number: object) -> Any:
        """Return the item of a number found in a file."""
        if type(number) is not int or not 0 <= number < len(shelf):
            raise Refusal(f"refers to number {number!r} of {len(shelf)} strokes or arrays")
        return shelf[number]


def runs(numbers: Sequence[int]) -> list[tuple[int, int]]:
    """Return numbers as (first, count) of consecutive ones."""
    if not numbers:
        return []
    row = np.asarray(numbers, np.int64)
    starts = np.flatnonzero(np.diff(row, prepend=row[0] - 2) != 1)
    counts = np.diff(starts, append=len(row))
    return list(zip(row[starts].tolist(), counts.tolist(), strict=True))
