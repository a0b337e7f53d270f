"""Draw styling curves on the body, from any side; draw over one to change it."""

from __future__ import annotations

from functools import partial
from typing import Final, Literal

import numpy as np

from bozzetto.errors import UserError
from bozzetto.plugin import Context, Gesture, Ink, Memory, Tool
from bozzetto.scene import Layer, Lines, Scene
from bozzetto_car.body.build import body_of
from bozzetto_car.state import CarState, StylingCurve
from bozzetto_car.styling.curve import mirror_curve, project_stroke
from bozzetto_car.styling.erase import erase
from bozzetto_car.styling.live_preview import Growing
from bozzetto_car.styling.oversketch import oversketch
from bozzetto_car.styling.picking import target_of
from bozzetto_car.styling.scene import CHOSEN_WIDTH, shown_styling
from bozzetto_car.styling.stroke_line import one_stroke

NAME: Final = "Styling"
"""Name of new curves; a number follows."""

_growing: Memory[Growing] = Memory(limit=4)


class Style(Tool[CarState]):
    """The tool for styling curves: a stroke along a curve bends it, any other is a new curve."""

    id = "style"
    title = "Style"
    icon = "icons/style.svg"
    hint = "Draw a line on the body, from any side. Draw over a styling curve to change it."
    gesture: Literal["ink", "tap", "drag"] = "ink"

    def preview(self, state: CarState, gesture: Gesture, context: Context) -> Scene:
        """Show the line on the body as it is drawn."""
        if not isinstance(gesture, Ink) or gesture.strokes[-1].tool == "eraser":
            return Scene()
        stroke = gesture.strokes[-1]
        try:
            body = body_of(state)
        except UserError:
            return Scene()
        question = (body, stroke.camera, stroke.points[:1].tobytes())
        growing = _growing.recall(question, partial(Growing, body.nets, stroke.camera))
        lines = tuple(
            Lines(line.astype(np.float32), color="accent", width=CHOSEN_WIDTH, hidden="show")
            for line in growing.lines(stroke.points.astype(float))
        )
        return Scene((Layer("styling growing", lines),)) if lines else Scene()

    def apply(self, state: CarState, gesture: Gesture, context: Context) -> CarState:
        """Add a curve, or change the one that was drawn over.

        Raises
        ------
        UserError
            If the stroke is a dot, misses the body, or leads a curve off it; if there is
            nothing under the eraser.
        """
        if not isinstance(gesture, Ink):
            raise UserError("Draw a line on the body with the pen.")
        body = body_of(state)
        if gesture.strokes[-1].tool == "eraser":
            return erase(state, body, gesture.strokes[-1])
        camera, stroke = gesture.camera, one_stroke(gesture.strokes)
        target = target_of(shown_styling(state), body, stroke, camera, state.selected)
        if target is None:
            new = project_stroke(body, stroke, camera)
            name, number = state.unused_name(NAME), state.unused_id()
            return state.with_node(StylingCurve(number, name, True, "", *new))
        side = mirror_curve(target.curve) if target.mirrored else target.curve
        bent = oversketch(side, body, stroke, camera)
        return state.with_node(mirror_curve(bent) if target.mirrored else bent)
