"""Ink that is replayed: how much of a stroke is there after a while."""

from __future__ import annotations

from typing import Final

from bozzetto.ink.stroke import COLUMNS, Stroke

__all__ = ["PAUSE", "TICK_MS", "beginning", "samples_after"]

TICK_MS: Final = 33
"""Milliseconds between two steps of the pen."""

UNTIMED_SAMPLES_PER_SECOND: Final = 200.0
"""Speed of strokes that were recorded without time."""

PAUSE: Final = 0.35
"""Seconds between two strokes."""


def samples_after(stroke: Stroke, seconds: float) -> int:
    """Return how many samples of a stroke are there after so much time."""
    if stroke.has_time:
        return int((stroke.t <= stroke.t[0] + seconds).sum())
    return int(seconds * UNTIMED_SAMPLES_PER_SECOND)


def beginning(stroke: Stroke, count: int) -> Stroke:
    """Return the first samples of a stroke."""
    columns = {name: getattr(stroke, name)[:count] for name in COLUMNS}
    if not stroke.has_pressure:
        del columns["pressure"]
    if not stroke.has_time:
        del columns["t"]
    return Stroke(camera=stroke.camera, tool=stroke.tool, color=stroke.color, **columns)
