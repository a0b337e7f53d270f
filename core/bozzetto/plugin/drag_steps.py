"""A drag that was recorded, in the steps that a tool takes under the hand."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Final

from bozzetto.ink.stroke import Stroke

if TYPE_CHECKING:
    from bozzetto.plugin.gesture import Drag

INTERVAL: Final = 1.0 / 60.0
"""Least time between two steps, s; also that between samples that carry no time."""

LONGEST: Final = 0.05
"""Most time that one step stands for, s: after a pause nothing jumps."""


def drag_steps(drag: Drag) -> Iterator[tuple[Drag, float]]:
    """Yield the drag so far and the seconds since the step before, from the touch to the lift.

    Samples that follow one another more quickly than the host takes steps are one step.

    Parameters
    ----------
    drag : Drag
        The whole drag.
    """
    path = drag.path
    last = len(path.x) - 1
    before = float(path.t[0]) - INTERVAL if path.has_time else -INTERVAL
    for number in range(last + 1):
        now = float(path.t[number]) if path.has_time else number * INTERVAL
        if number == last or now - before >= INTERVAL:
            yield replace(drag, path=_begun(path, number + 1)), min(now - before, LONGEST)
            before = now


def _begun(path: Stroke, count: int) -> Stroke:
    """Return the first samples of a stroke."""
    return Stroke(
        path.x[:count],
        path.y[:count],
        path.camera,
        pressure=path.pressure[:count] if path.has_pressure else None,
        t=path.t[:count] if path.has_time else None,
        tilt_x=path.tilt_x[:count],
        tilt_y=path.tilt_y[:count],
        twist=path.twist[:count],
        tool=path.tool,
        color=path.color,
        group=path.group,
    )
