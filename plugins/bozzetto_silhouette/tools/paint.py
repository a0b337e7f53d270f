"""Paint: the part under the pen takes the paint colour."""

from __future__ import annotations

from dataclasses import replace

from bozzetto.errors import UserError
from bozzetto.plugin import Context, Gesture, Ink, Tap
from bozzetto.view import Camera
from bozzetto_silhouette.model.state import SilhouetteState
from bozzetto_silhouette.tools.posing_hints import PoseAwareTool
from bozzetto_silhouette.view.picking import touched_part

MOST_TOUCHES = 32
"""Samples of a stroke at which the shape is looked at: parts are larger than the gaps."""


class Paint(PoseAwareTool):
    """A stroke over parts colours them; the pen's other end takes their colour away."""

    id = "paint"
    title = "Paint"
    icon = "icons/paint.svg"
    hint = "Draw over a part to give it the paint colour; the eraser takes it away."

    def apply(self, state: SilhouetteState, gesture: Gesture, context: Context) -> SilhouetteState:
        """Give the paint colour to every part under the ink or the tap.

        Raises
        ------
        UserError
            If no part is under the pen, or there is no colour to take away.
        """
        places = _places(gesture)
        touched = {
            part.id: part
            for x, y, camera in places
            if (part := touched_part(state, x, y, camera)) is not None
        }
        if not touched:
            raise UserError("There is no part under the pen. Draw over the shape.")
        erases = isinstance(gesture, Ink) and gesture.strokes[-1].tool == "eraser"
        color = None if erases else state.paint
        if color is None and all(part.color is None for part in touched.values()):
            raise UserError("This part has no paint to take away. Choose a paint colour first.")
        painted = {id_: replace(part, color=color) for id_, part in touched.items()}
        return replace(state, nodes=tuple(painted.get(node.id, node) for node in state.nodes))


def _places(gesture: Gesture) -> list[tuple[float, float, Camera]]:
    """Return where the pen touched the canvas, px, and the cameras."""
    if isinstance(gesture, Tap):
        return [(gesture.x, gesture.y, gesture.camera)]
    if isinstance(gesture, Ink):
        return [
            (float(x), float(y), stroke.camera)
            for stroke in gesture.strokes
            for x, y in stroke.points[:: len(stroke) // MOST_TOUCHES + 1]
        ]
    raise UserError("Draw over a part with the pen to paint it.")
