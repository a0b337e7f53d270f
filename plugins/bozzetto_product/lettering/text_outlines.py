"""The outlines of a text, from letters that come with the modeler.

A document must look the same on every machine, and the command line has no fonts: so the letters
are those of one free font, as outlines in a file (`docs/write_letters.py` makes it), and a recipe
keeps the outlines that it was made with.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any, Final

import numpy as np

from bozzetto.arrays import Array

PER_CURVE: Final = 5
"""Steps of a parabola."""

PER_LINE: Final = 2
"""Steps of a straight side: a curve through its ends only may bulge."""

SPACE: Final = 0.4
"""Width of a letter that is not known, in heights of capitals."""

SMOOTH: Final = float(np.cos(np.radians(14.0)))
"""Cosine of the turn between two curves below which there is a corner."""


@dataclass(frozen=True, eq=False)
class TextOutlines:
    """Outlines of a text.

    Parameters
    ----------
    rows : tuple of (n, 2) float
        Closed polygons, y up, in heights of capitals; the first point is not repeated.
    corners : tuple of (n,) bool
        Where an outline has a corner, or passes from a straight side to a curve.
    missing : str
        Letters of which there is no outline, each once.
    """

    rows: tuple[Array, ...]
    corners: tuple[Array, ...]
    missing: str


def text_outlines(text: str) -> TextOutlines:
    """Return the outlines of one line of text, its letters spaced as the font has it."""
    known = _letters()
    letters, kerning, cap = known["letters"], known["kerning"], float(known["cap"])
    at, before = 0.0, ""
    rows: list[Array] = []
    marks: list[Array] = []
    missing = []
    for letter in " ".join(text.split()):
        if letter not in letters:
            missing.append(letter)
            at += SPACE * cap
            before = ""
            continue
        at += kerning.get(before + letter, 0)
        advance, contours = letters[letter]
        for contour in contours:
            points, corners = _flattened(contour)
            rows.append((points + np.array((at, 0.0))) / cap)
            marks.append(corners)
        at += advance
        before = letter
    return TextOutlines(tuple(rows), tuple(marks), "".join(dict.fromkeys(missing)))


@cache
def _letters() -> dict[str, Any]:
    text = files("bozzetto_product").joinpath("lettering/letters.json").read_text("utf-8")
    return dict(json.loads(text))


def _flattened(contour: Sequence[Sequence[float]]) -> tuple[Array, Array]:
    """Return points of a contour of lines and parabolas, and which are corners.

    Between two control points that follow one another lies an unwritten place of the outline,
    half-way (TrueType).
    """
    places: list[tuple[Array, bool]] = []
    for number, (x, y, on) in enumerate(contour):
        here = np.array((x, y), float)
        if not on and not contour[number - 1][2]:
            places.append((0.5 * (here + contour[number - 1][:2]), True))
        places.append((here, bool(on)))
    first = next(k for k, (_, on) in enumerate(places) if on)
    places = [*places[first:], *places[:first], places[first]]
    points: list[Array] = []
    ways: list[tuple[int, Array, Array, bool]] = []
    k = 0
    while k < len(places) - 1:
        start = places[k][0]
        curved = not places[k + 1][1]
        control, end = (places[k + 1][0], places[k + 2][0]) if curved else (start, places[k + 1][0])
        k += 2 if curved else 1
        if not np.any(end - start):
            continue
        t = np.arange(PER_CURVE if curved else PER_LINE)[:, None] / (
            PER_CURVE if curved else PER_LINE
        )
        row = (
            (1 - t) ** 2 * start + 2 * t * (1 - t) * control + t * t * end
            if curved
            else (1 - t) * start + t * end
        )
        ways.append((len(points), row[1] - start, end - row[-1], curved))
        points += list(row)
    corners = np.zeros(len(points), bool)
    for number, (place, out, _, curved) in enumerate(ways):
        _, _, into, bent = ways[number - 1]
        turn = float(into @ out) / float(np.linalg.norm(into) * np.linalg.norm(out))
        corners[place] = turn < SMOOTH or curved != bent
    return np.array(points), corners
