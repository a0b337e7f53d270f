"""Recorded motions, shown again on the sheet."""

from __future__ import annotations

from typing import Final

from bozzetto.errors import UserError
from bozzetto.plugin import Context, Drag, NextStep, Tool, override
from bozzetto_polyhedron.model.state import PolyhedronState
from bozzetto_polyhedron.solve.recording import at_time, recorded_times

MARGIN: Final = 0.1
"""Share of the sheet's width at each side in which everything is at the beginning or the end."""

NOTHING: Final = "Nothing was recorded. Take “Move” and pull at a corner, or play."


class Replay(Tool[PolyhedronState]):
    """The recording again: as it was while it plays, or wherever the pen is across the sheet.

    The recording stays. What is moved afterwards goes on from there, and overwrites what comes
    later in it.
    """

    id = "replay"
    title = "Replay"
    icon = "icons/replay.svg"
    hint = "Play to see again what was recorded, or drag from left to right across the sheet."
    gesture = "drag"
    grabs = True
    plays = True
    group = "Mechanism"

    @override
    def step(
        self, state: PolyhedronState, held: Drag | None, seconds: float, context: Context
    ) -> PolyhedronState:
        """Return the state a moment later in its recording; after the end it begins again."""
        times = recorded_times(state)
        if len(times) < 2 or state.moved is None:
            raise UserError(NOTHING)
        first, last = times[0], times[-1]
        if held is not None:
            width = held.camera.viewport[0]
            share = (float(held.path.x[-1]) / width - MARGIN) / (1.0 - 2.0 * MARGIN)
            return at_time(state, first + (last - first) * share)
        now = state.moved.seconds
        return at_time(state, first if now >= last else now + seconds)

    @override
    def next_step(self, state: PolyhedronState) -> NextStep:
        """Return the hint, with how long it takes; where nothing was recorded, what records."""
        times = recorded_times(state)
        if len(times) < 2:
            return NextStep(NOTHING, tool="move")
        return NextStep(
            f"{self.hint} {times[-1] - times[0]:.1f} s are recorded; “Film of what moves” in the "
            "menu “File” saves them."
        )
