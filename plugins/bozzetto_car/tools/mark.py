"""Mark the points that are asked for on the sketch; drag marks that are not right."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

from bozzetto.errors import UserError
from bozzetto.plugin import Context, Drag, Gesture, Tap
from bozzetto.scene import Scene
from bozzetto_car.asking import asked_of
from bozzetto_car.body import body_of
from bozzetto_car.showing_marks import MARK, MARK_TOOL
from bozzetto_car.state import CarState, Mark

__all__ = ["MarkPoints"]


class MarkPoints:
    """A tap marks the node that is asked for; a drag moves a mark."""

    id = MARK_TOOL
    title = "Mark points"
    icon = "icons/mark.svg"
    hint = "Touch the point that is asked for. Drag a mark to move it."
    gesture: Literal["ink", "tap", "drag"] = "drag"
    aims = True

    def preview(self, state: CarState, gesture: Gesture, context: Context) -> Scene:
        """Nothing yet."""
        return Scene()

    def apply(self, state: CarState, gesture: Gesture, context: Context) -> CarState:
        """Set or move a mark.

        Raises
        ------
        UserError
            If there is nothing to mark.
        """
        sketch = state.sketch
        if sketch is None:
            raise UserError("There is no sketch to mark. Drop a picture on the sheet first.")
        body = body_of(state)
        stand = body.stands[sketch.id]
        if isinstance(gesture, Drag):
            place = gesture.path.points[-1]
            node = gesture.handle.removeprefix(MARK)
        elif isinstance(gesture, Tap):
            place = (gesture.x, gesture.y)
            asked = asked_of(state, body.solved)
            if asked is None:
                raise UserError("All points are marked. Drag a mark to move it.")
            node = asked.node
        else:
            raise UserError("Touch the point that is asked for.")
        u, v = stand.seen_at(gesture.camera, [place])[0].tolist()
        mark = Mark(node, u, v)
        kept = tuple(mark if old.node == node else old for old in sketch.marks)
        if sketch.mark_of(node) is None:
            kept = (*kept, mark)
        return replace(state.with_node(replace(sketch, marks=kept)), asked="")
