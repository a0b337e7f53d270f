"""Paint: the part under the pen takes the paint colour."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from bozzetto.errors import UserError
from bozzetto.plugin import Context, Ink, Tap, override
from bozzetto.view import Camera
from bozzetto_silhouette.model.state import SilhouetteState
from bozzetto_silhouette.tools.erasing_tool import ColouringTool
from bozzetto_silhouette.view.picking import touched_part

Place = tuple[float, float, Camera]

MOST_TOUCHES = 32
"""Samples of a stroke at which the shape is looked at: parts are larger than the gaps."""


class Paint(ColouringTool):
    """A stroke over parts colours them; the pen's other end takes their colour away."""

    id = "paint"
    title = "Paint"
    icon = "icons/paint.svg"
    hint = "Draw over a part to give it the paint colour; the eraser takes it away."

    @override
    def draw(self, state: SilhouetteState, ink: Ink, context: Context) -> SilhouetteState:
        """Give the paint colour to every part under the ink.

        Raises
        ------
        UserError
            If no part is under the pen, or there is no colour to take away.
        """
        return _painted(state, _places(ink), state.paint)

    @override
    def erase(self, state: SilhouetteState, ink: Ink, context: Context) -> SilhouetteState:
        """Take the colour of every part under the eraser; see `draw`."""
        return _painted(state, _places(ink), None)

    @override
    def tap(self, state: SilhouetteState, tap: Tap, context: Context) -> SilhouetteState:
        """Give the paint colour to the part that is touched; see `draw`."""
        return _painted(state, [(tap.x, tap.y, tap.camera)], state.paint)


def _painted(
    state: SilhouetteState, places: Iterable[Place], color: tuple[int, int, int] | None
) -> SilhouetteState:
    """Return the state with every part under some places in a colour, or in none."""
    touched = {
        part.id: part
        for x, y, camera in places
        if (part := touched_part(state, x, y, camera)) is not None
    }
    if not touched:
        raise UserError("There is no part under the pen. Draw over the shape.")
    if color is None and all(part.color is None for part in touched.values()):
        raise UserError("This part has no paint to take away. Choose a paint colour first.")
    painted = {id_: replace(part, color=color) for id_, part in touched.items()}
    return replace(state, nodes=tuple(painted.get(node.id, node) for node in state.nodes))


def _places(ink: Ink) -> list[Place]:
    """Return where the pen touched the canvas, px, and the cameras."""
    return [
        (float(x), float(y), stroke.camera)
        for stroke in ink.strokes
        for x, y in stroke.points[:: len(stroke) // MOST_TOUCHES + 1]
    ]
