"""Strokes to draw on a screen, and how they are drawn on the program's sheet."""

from __future__ import annotations

import math
import time
from typing import Any

from tests.display.program import Program
from tests.display.screens import wait_until

__all__ = ["SAMPLES", "circle", "draw_with_mouse", "draw_with_stylus", "only_stroke"]

SAMPLES = 61
"""A press, 59 movements, and a last one where the button is lifted."""

Place = tuple[float, float]
Sample = tuple[float, float, float]


def circle(middle: Place, radius: float = 150.0, samples: int = SAMPLES) -> list[Place]:
    """Whole pixels on a closed circle: what a mouse on a screen can say."""
    turns = [2.0 * math.pi * k / (samples - 1) for k in range(samples)]
    return [
        (
            float(round(middle[0] + radius * math.cos(a))),
            float(round(middle[1] + radius * math.sin(a))),
        )
        for a in turns
    ]


def draw_with_mouse(
    program: Program, *, busy: int = 0, pace: float = 0.01, radius: float = 150.0
) -> list[Place]:
    """Draw a circle with the screen's pointer while the window is kept busy.

    Parameters
    ----------
    busy : int
        Length of the pieces in which the window is busy, milliseconds; 0 for not at all.
    pace : float
        Time between two movements, seconds.

    Returns
    -------
    list of (x, y)
        Where the pointer was, in pixels of the sheet.
    """
    facts = program.ask("facts")
    scale = facts["scale"]
    middle = tuple(
        scale * (c + 0.5 * s) for c, s in zip(facts["corner"], facts["size"], strict=True)
    )
    places = circle(middle, radius)
    program.ask("busy", milliseconds=busy)
    first, *rest = places
    program.screen.press(first)
    # An X server holds movements back, and merges them, until the window manager has seen the
    # press and let it through: what it merges never reaches any program.
    wait_until(lambda: program.ask("facts")["mode"] == "INKING", "the press")
    program.screen.move(rest, pace)
    program.screen.lift()
    _settle(program)
    x, y = facts["corner"]
    return [(a / scale - x, b / scale - y) for a, b in places]


def draw_with_stylus(program: Program, *, busy: int = 0, pace: float = 0.005) -> list[Place]:
    """Draw a circle with simulated events of a stylus while the window is kept busy."""
    width, height = program.ask("facts")["size"]
    places = circle((0.5 * width, 0.5 * height))
    program.ask("busy", milliseconds=busy)
    program.ask("stylus", points=places, pace=pace)
    _settle(program)
    return places


def only_stroke(program: Program) -> list[Sample]:
    """The one stroke that was handed over since the last question; the next begins anew."""
    strokes: list[Any] = program.ask("strokes")
    assert len(strokes) == 1, f"{len(strokes)} strokes: {[len(stroke) for stroke in strokes]}"
    program.ask("run", action="edit.commit")
    program.wait_calm()
    return [tuple(sample) for sample in strokes[0]]


def _settle(program: Program) -> None:
    """Wait until the stroke has arrived and everything that follows from it is done."""
    wait_until(lambda: program.ask("lifted"), "the lift of the pen")
    program.ask("busy", milliseconds=0)
    time.sleep(0.05)
    program.wait_calm()
