"""Construction lines: straight strokes along the box, or from one known place to another."""

from __future__ import annotations

import numpy as np

from bozzetto.plugin import Context, Gesture, Ink, override
from bozzetto.scene import Layer, Lines, Paint, Scene
from bozzetto_symmetry.model.axes import AXIS_PAINTS
from bozzetto_symmetry.model.state import Line, SymmetryState
from bozzetto_symmetry.operations.construction_lines import CHOSEN_WIDTH, Straight, line_of
from bozzetto_symmetry.operations.snap_targets import Targets, targets
from bozzetto_symmetry.solve.picking import solved_curves
from bozzetto_symmetry.tools.erase import ErasingTool


class DrawLine(ErasingTool):
    """Draws straight lines in space, one a stroke."""

    id = "line"
    title = "Line"
    icon = "icons/line.svg"
    hint = "Draw a line towards a vanishing point, or from one corner or curve to another."

    @override
    def preview(self, state: SymmetryState, gesture: Gesture, context: Context) -> Scene:
        """Return the line in space, in the colour of the axis that it runs along."""
        if not isinstance(gesture, Ink):
            return Scene()
        line = line_of(gesture.strokes[-1], state, _known(state, context), context)
        return Scene((Layer("line in the hand", (_lines(line),)),))

    @override
    def draw(self, state: SymmetryState, ink: Ink, context: Context) -> SymmetryState:
        """Add a line for every stroke; what one ends on may be the one before.

        Raises
        ------
        UserError
            If a stroke is too short or not straight.
        """
        for stroke in ink.strokes:
            line = line_of(stroke, state, _known(state, context), context)
            state = state.with_node(
                Line(
                    id=state.unused_id(),
                    name=state.unused_name("Line"),
                    begin=line.begin,
                    end=line.end,
                )
            )
        return state


def _known(state: SymmetryState, context: Context) -> Targets:
    return targets(state, (curve for _, curve in solved_curves(state)), context)


def _lines(line: Straight) -> Lines:
    paint: Paint = "ink" if line.axis is None else AXIS_PAINTS[line.axis]
    ends = np.array([line.begin, line.end], np.float32)
    return Lines(ends, color=paint, width=CHOSEN_WIDTH, hidden="show")
