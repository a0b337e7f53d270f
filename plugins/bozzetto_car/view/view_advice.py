"""From where a car is looked at: through its sketch, or past it.

With every mark the camera of a sketch becomes another, and what was a view through the sketch
looks past it by a hair. Such views are known by the car as it was a moment ago, which the host
knows, and they go along to the same window of the picture, so that nothing but the car moves.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Final, Literal

from bozzetto.errors import UserError
from bozzetto.plugin import ViewAdvice
from bozzetto.scene import Scene
from bozzetto.view import Camera
from bozzetto_car.body.build import Body, body_of
from bozzetto_car.camera.sketch_camera import SketchCamera
from bozzetto_car.marking.next_mark import asked_of, in_work, node_title
from bozzetto_car.solver.initial_cameras import FEWEST, Placed
from bozzetto_car.state import CarState, Sketch
from bozzetto_car.view.scene import body_layers, hanging_on_view, is_shown

NO_SKETCH: Final = "Drop a sketch on the sheet, or look at the template."

EXCHANGED: Final = (
    "Left and right seem to be exchanged. The command “Exchange left and right” puts it right."
)
"""What is said of marks that fit a car as a mirror shows it."""

DRAFTED: Final = ("body", "wheels", "network")
"""Layers that look otherwise over a drawing, so that it can be seen."""


def camera_looked_through(
    sketch: Sketch, body: Body, camera: Camera, seen: Iterable[CarState] = ()
) -> SketchCamera | None:
    """The stand through which a view looks at a sketch, as it is or was a moment ago.

    Parameters
    ----------
    sketch : Sketch
    body : Body
        As the car is now.
    camera : Camera
    seen : iterable of CarState
        The car as it was a moment ago, newest first.
    """
    now = body.sketch_cameras.get(sketch.id)
    if now is None or now.is_seen_through(camera):
        return now
    for state in seen:
        before = _camera_before(sketch, state)
        if before is not None and before.is_seen_through(camera):
            return before
    return None


def view_after(seen: CarState, state: CarState, camera: Camera) -> Camera | None:
    """The view of the same window of the sketch in work, where the car had another shape before."""
    body = body_of(state)
    placed = in_work(state, body.solved)
    if placed is None:
        return None
    now, before = body.sketch_cameras[placed.sketch.id], _camera_before(placed.sketch, seen)
    if before is None or now.is_seen_through(camera) or not before.is_seen_through(camera):
        return None
    return now.windowed(camera.viewport, before.window(camera))


def _camera_before(sketch: Sketch, state: CarState) -> SketchCamera | None:
    """Where a sketch stood in an earlier state of its car; None where it was not there."""
    if not any(one.id == sketch.id and one.size == sketch.size for one in state.sketches):
        return None
    try:
        return body_of(state).sketch_cameras.get(sketch.id)
    except UserError:
        return None


def advice_on(state: CarState, body: Body, camera: Camera) -> ViewAdvice:
    """What to say of a view: which mark is asked for, or that the sketch is seen from elsewhere."""
    scene, placed = hanging_on_view(state, body, camera), in_work(state, body.solved)
    if placed is None:
        return ViewAdvice("good", NO_SKETCH, scene=scene)
    sketch = placed.sketch
    sketch_camera = body.sketch_cameras[sketch.id]
    if sketch_camera.is_seen_through(camera):
        level, message = _said_of(state, body, placed)
        return ViewAdvice(level, message, None, scene + _draft(state, body, placed), pinned=True)
    better = sketch_camera.view(camera.viewport)
    if state.selected == sketch.id and _sees_another(state, body, camera):
        return ViewAdvice("good", f"“{sketch.name}” is chosen.", better, scene, follow=True)
    return ViewAdvice("good", f"Not seen through “{sketch.name}”.", better, scene)


def _draft(state: CarState, body: Body, placed: Placed) -> Scene:
    """The body so thin that the drawing shows through, unless its own look is wanted.

    Over a sketch whose own camera is not known it does not fit and hides what is to be marked:
    there it is thin in any case.
    """
    sketch = placed.sketch
    drawn = sketch.picture is not None and sketch.visible and sketch.opacity > 0.0
    judged = state.shading != "shaded" and placed.is_known
    if not drawn or judged or not is_shown(state, body):
        return Scene()
    thin = replace(state, shading="draft")
    return Scene(tuple(layer for layer in body_layers(thin, body) if layer.name in DRAFTED))


def _sees_another(state: CarState, body: Body, camera: Camera) -> bool:
    """Whether a view looks through a sketch of the car that is not the one in work."""
    others = (one for one in state.sketches if one is not state.sketch)
    return any(camera_looked_through(other, body, camera) is not None for other in others)


def _said_of(state: CarState, body: Body, placed: Placed) -> tuple[Literal["good", "warn"], str]:
    """What to say where the sketch in work is seen through its own camera."""
    sketch = placed.sketch
    if placed.problem and len(sketch.marks) >= FEWEST:
        return "warn", placed.problem
    if placed.exchanged:
        return "warn", EXCHANGED
    asked = asked_of(state, body.solved)
    if asked is None:
        return "good", f"All of “{sketch.name}” is marked."
    return "good", f"Next mark: {node_title(asked.node, sketch, body.template)}"
