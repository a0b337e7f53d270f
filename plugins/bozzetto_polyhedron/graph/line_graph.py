"""Lines that meet in corners, and where that looks wrong."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from bozzetto.arrays import Array, Index

FindingKind = Literal[
    "loose end",
    "corner of two lines",
    "crossing",
    "tick",
    "close corners",
    "gap",
    "second reading",
    "open faces",
    "curved stroke",
]


@dataclass(frozen=True)
class Finding:
    """One thing about a graph that looks wrong.

    Parameters
    ----------
    place : (x, y)
        Where, canvas pixels.
    what : str
    sentence : str
        What to do about it, for a person.
    """

    place: tuple[float, float]
    what: FindingKind
    sentence: str


@dataclass(frozen=True, eq=False)
class LineGraph:
    """Corners on the sheet and the lines between them.

    Parameters
    ----------
    places : (n, 2) float64
        Of the corners, canvas pixels.
    lines : (m, 2) intp
        Numbers of corners, the smaller one first.
    light : (m,) float64
        How likely the line was drawn as a hidden one, lightly or dashed: 0 … 1.
    strokes : tuple of tuple of int
        For every line the strokes that it was drawn with.
    dropped : tuple of int
        Strokes that are in no line, such as ticks.
    noise : float
        Estimated root mean square distance of a corner from where it was meant, px.
    health : tuple of Finding
        Empty where all is well.
    certainty : float
        Probability that lines and corners are those meant, 0 … 1.
    """

    places: Array
    lines: Index
    light: Array
    strokes: tuple[tuple[int, ...], ...]
    dropped: tuple[int, ...]
    noise: float
    health: tuple[Finding, ...]
    certainty: float = 1.0
