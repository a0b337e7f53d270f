"""Figures of a report: the words, units and bounds with which a person reads them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final

UNITS: Final[Mapping[str, str]] = {
    "mm": "mm",
    "mm2": "mm²",
    "mm3": "mm³",
    "px": "px",
    "deg": "°",
    "percent": "%",
    "ms": "ms",
    "s": "s",
}
"""What the key of a reported value may end in, and how it is written behind the value."""


@dataclass(frozen=True)
class Figure:
    """How one value of a report is shown.

    Parameters
    ----------
    label : str
        A few words; "" for what is only there for other programs, and not shown.
    help : str
        One sentence for hovering: what it measures, with the field's own name for it;
        not empty where there is a label.
    unit : str
        Unit of the value that is shown, such as "mm", "°" or "%".
    factor : float
        From the reported value to the one shown: 100 for a share that is shown in percent.
    digits : int
        Digits behind the decimal point; negative for as many as a bare number gets.
    spread : bool
        Whether a list of it is summed up: the middle one, and the largest.
    good, bad : float, optional
        Bounds of the reported value, both or neither: from `good` on it is fine, from `bad` on
        it wants attention. Which of them is larger tells the direction. Yes and no have bounds,
        too: ``good=True, bad=False``.
    most : float
        Reported value from which on `beyond` is said in its place.
    beyond : str
    values : mapping of str to str
        Words for texts that are reported, such as "pair": "left and right".
    verdicts : mapping of str to bool
        Texts that are a verdict, good where true.
    """

    label: str
    help: str = ""
    unit: str = ""
    factor: float = 1.0
    digits: int = -1
    spread: bool = False
    good: float | None = None
    bad: float | None = None
    most: float = math.inf
    beyond: str = ""
    values: Mapping[str, str] = field(default_factory=dict)
    verdicts: Mapping[str, bool] = field(default_factory=dict)

    def verdict(self, value: Any) -> bool | None:
        """Return whether a reported value is fine; None where it is neither fine nor bad.

        A list is as good as the worst of it.
        """
        if isinstance(value, str):
            return self.verdicts.get(value)
        if isinstance(value, list | tuple):
            told = [self.verdict(entry) for entry in value]
            if False in told:
                return False
            return True if told and None not in told else None
        if self.good is None or self.bad is None or not isinstance(value, int | float):
            return None
        sense = 1.0 if self.good > self.bad else -1.0
        if sense * value >= sense * self.good:
            return True
        return False if sense * value <= sense * self.bad else None


def without_unit(key: str) -> tuple[str, str]:
    """Return a key of a report without the unit that it ends in, and that unit; "" for none."""
    stem, _, last = key.replace("-", "_").rpartition("_")
    return (key[: len(stem)], UNITS[last]) if stem.strip("_") and last in UNITS else (key, "")


def figure_of(key: str, figures: Mapping[str, Figure]) -> Figure | None:
    """Return what a modeler says of a reported value, by its key with or without the unit."""
    return figures.get(key) or figures.get(without_unit(key)[0])
