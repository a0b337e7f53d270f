"""The pen and the window on real platforms.

A circle of 61 places is drawn again and again in the real window, while its thread is kept busy
in pieces of 100 and 150 ms: with the pointer of an X server (XTEST; it reaches the Wayland
compositor, too, which runs in a window of that server), and with simulated events of a stylus.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from pathlib import Path

import numpy as np

from tests.display.program import Program
from tests.display.screens import Screen, absent, headless_weston, nested_weston, xvfb
from tests.display.strokes import SAMPLES, draw_with_mouse, draw_with_stylus, only_stroke
from tests.reliability.figures import Row

__all__ = ["rows"]

PLATFORMS: dict[str, tuple[Callable[[Path], AbstractContextManager[Screen]], tuple[str, ...]]] = {
    "X11 (Xvfb, Openbox)": (xvfb, ("Xvfb", "openbox", "xdotool")),
    "Wayland (Weston, headless)": (headless_weston, ("weston",)),
    "Wayland (Weston in X11)": (nested_weston, ("weston", "Xvfb", "openbox", "xdotool")),
}

STROKES = 40
"""Strokes of each kind in the full run."""

REST = 60.0
"""How long the window is left alone in the full run, seconds; never less than 5."""

PAUSES = (100, 150)
"""Lengths of the pieces in which the window is busy, milliseconds."""

MOST_IDLE = 0.02
LEAST_SAMPLES = 55
MOST_DIFFERENCE = 0.005
"""Of the volumes of a stroke's solid, drawn fast in a busy window and slowly in an idle one."""


def rows(share: float) -> Iterator[Row]:
    """Measure on every platform that is installed here."""
    count = max(2, round(STROKES * share))
    for name, (screen, programs) in PLATFORMS.items():
        reason = absent(*programs)
        if reason:
            yield Row(name, f"not measured: {reason}")
            continue
        with tempfile.TemporaryDirectory(prefix="bozzetto-pen-") as folder:
            with screen(Path(folder)) as opened, Program(opened) as program:
                yield from _of_platform(name, program, count, max(5.0, REST * share))


def _of_platform(name: str, program: Program, count: int, seconds: float) -> Iterator[Row]:
    program.wait_painted()
    idle, wakeups = program.idle_share(seconds)
    yield Row(
        f"{name}: window at rest for {seconds:.0f} s",
        f"{100 * idle:.2f} % of a processor, {wakeups:.1f} wakeups/s",
        f"≤ {100 * MOST_IDLE:.0f} %",
        idle <= MOST_IDLE,
    )
    ways = {"stylus": draw_with_stylus}
    if program.screen.pointer is not None:
        ways["mouse"] = draw_with_mouse
    for way, draw in ways.items():
        kept = []
        for k in range(count):
            draw(program, busy=PAUSES[k % len(PAUSES)])
            kept.append(len(only_stroke(program)))
        yield Row(
            f"{name}: {count} strokes of the {way} in a busy window",
            f"{min(kept)} of {SAMPLES} samples in the worst, {np.mean(kept):.1f} on average",
            f"≥ {LEAST_SAMPLES}",
            min(kept) >= LEAST_SAMPLES,
        )
    if program.screen.pointer is not None:
        yield _fast_and_slow(name, program, max(1, count // 4))


def _fast_and_slow(name: str, program: Program, pairs: int) -> Row:
    apart = []
    for _ in range(pairs):
        volumes = []
        for busy, pace in ((0, 0.02), (150, 0.004)):
            draw_with_mouse(program, busy=busy, pace=pace)
            volumes.append(program.ask("volume"))
            only_stroke(program)
        slow, fast = volumes
        apart.append(abs(fast - slow) / slow)
    return Row(
        f"{name}: {pairs} circles drawn fast in a busy window and slowly in an idle one",
        f"volumes differ by {100 * max(apart):.3f} % at most",
        f"≤ {100 * MOST_DIFFERENCE:.1f} %",
        max(apart) <= MOST_DIFFERENCE,
    )
