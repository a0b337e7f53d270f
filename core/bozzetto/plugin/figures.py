"""Figures of a report: the words, units and bounds with which a person reads them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Figure:
    """How one value of a report is shown.

    Parameters
    ----------
    label : str
        A few words.
    help : str
        One sentence for hovering: what it measures, with the field's own name for it.
    unit : str
        Unit of the value that is shown, such as "mm", "°" or "%".
    factor : float
        From the reported value to the one shown: 100 for a share that is shown in percent.
    digits : int
        Digits behind the decimal point; negative for as many as a bare number gets.
    spread : bool
        Whether a list of it is summed up: the middle one, and the largest.
    good, bad : float, optional
        Bounds of the reported value: from `good` on it is fine, from `bad` on it wants
        attention. Which of them is larger tells the direction.
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
