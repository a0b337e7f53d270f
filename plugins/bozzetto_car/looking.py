"""From where a car is looked at: through its sketch, or past it."""

from __future__ import annotations

from typing import Final

from bozzetto.plugin import ViewAdvice
from bozzetto.view import Camera
from bozzetto_car.asking import asked_of
from bozzetto_car.body import Body
from bozzetto_car.showing import hanging_on_view
from bozzetto_car.state import CarState

__all__ = ["advice_on"]

NO_SKETCH: Final = "Drop a sketch on the sheet, or look at the template."


def advice_on(state: CarState, body: Body, camera: Camera) -> ViewAdvice:
    """What to say of a view: which mark is asked for, or that the sketch is seen from elsewhere."""
    sketch = state.sketch
    placed = None if sketch is None else body.solved.placed.get(sketch.id)
    if sketch is None or placed is None:
        return ViewAdvice("good", NO_SKETCH)
    stand, scene = body.stands[sketch.id], hanging_on_view(state, body, camera)
    if not stand.is_seen_through(camera):
        better = stand.view(camera.viewport)
        return ViewAdvice("good", f"Not seen through “{sketch.name}”.", better, scene)
    asked = asked_of(state, body.solved)
    title = "" if asked is None else body.template.titles.get(asked.node, asked.node)
    said = f"Next mark: {title}." if title else f"All of “{sketch.name}” is marked."
    if placed.problem and len(placed.sketch.marks) >= 6:
        return ViewAdvice("warn", placed.problem, None, scene, pinned=True)
    return ViewAdvice("good", said, None, scene, pinned=True)
