"""Draw styling curves on the body, from any side; draw over one to change it."""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto.plugin import Context, Gesture, Ink, Preview, Tool, override
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


class Style(Tool[CarState]):
    """The tool for styling curves: a stroke along a curve bends it, any other is a new curve."""

    id = "style"
    title = "Style"
    icon = "icons/style.svg"
    hint = "Draw a line on the body, from any side. Draw over a styling curve to change it."

    @override
    def begin(self, state: CarState, context: Context) -> Preview[CarState]:
        """Return the preview of a line that grows."""
        return GrowingPreview(self, state, context)

    @override
    def draw(self, state: CarState, ink: Ink, context: Context) -> CarState:
        """Add a curve, or change the one that was drawn over.

        Raises
        ------
        UserError
            If the stroke is a dot, misses the body, or leads a curve off it.
        """
        body = body_of(state)
        camera, stroke = ink.camera, one_stroke(ink.strokes)
        target = target_of(shown_styling(state), body, stroke, camera, state.selected)
        if target is None:
            new = project_stroke(body, stroke, camera)
            name, number = state.unused_name(NAME), state.unused_id()
            return state.with_node(StylingCurve(number, name, True, "", *new))
        side = mirror_curve(target.curve) if target.mirrored else target.curve
        bent = oversketch(side, body, stroke, camera)
        return state.with_node(mirror_curve(bent) if target.mirrored else bent)

    @override
    def erase(self, state: CarState, ink: Ink, context: Context) -> CarState:
        """Take away what the eraser's path lies over; see `erase`."""
        return erase(state, body_of(state), ink.strokes[-1])


class GrowingPreview(Preview[CarState]):
    """The line on the body as it is drawn."""

    _growing: Growing | None = None

    @override
    def update(self, gesture: Gesture) -> Scene:
        """Return what lies on the body of the stroke so far.

        Raises
        ------
        UserError
            If there is no body yet.
        """
        if not isinstance(gesture, Ink) or gesture.erases:
            return Scene()
        stroke = gesture.strokes[-1]
        if self._growing is None:
            self._growing = Growing(body_of(self.state).nets, stroke.camera)
        lines = tuple(
            Lines(line.astype(np.float32), color="accent", width=CHOSEN_WIDTH, hidden="show")
            for line in self._growing.lines(stroke.points.astype(float))
        )
        return Scene((Layer("styling growing", lines),)) if lines else Scene()
