"""Hidden lines that were guessed, as light strokes among those of the drawing."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from bozzetto.ink import Stroke
from bozzetto_polyhedron.reconstruction.hidden_lines import HiddenLines

LIGHTER: Final = 0.4
"""Pressure of guessed lines, in shares of the median of the drawing."""

SAMPLES: Final = 16
"""Of a guessed line."""


def completed(strokes: Sequence[Stroke], guess: HiddenLines) -> tuple[Stroke, ...]:
    """Return a drawing with guessed lines behind its own strokes."""
    return (*strokes, *light_strokes(strokes, guess))


def light_strokes(strokes: Sequence[Stroke], guess: HiddenLines) -> tuple[Stroke, ...]:
    """Return guessed lines as strokes, lighter than those of the drawing.

    Parameters
    ----------
    strokes : sequence of Stroke
        Of the drawing, at least one.
    guess : HiddenLines
        Places on their canvas.
    """
    pressure = LIGHTER * float(np.median([np.mean(each.pressure) for each in strokes]))
    share = np.linspace(0.0, 1.0, SAMPLES)[:, None]
    made = []
    for start, stop in guess.ends:
        x, y = (start + share * (stop - start)).T
        light = np.full(SAMPLES, pressure)
        made.append(Stroke(x, y, strokes[0].camera, pressure=light, group=strokes[0].group))
    return tuple(made)
