"""Advice on the view of a car: through its sketch, or from elsewhere.

Every mark changes the camera of a sketch, and what was a view through the sketch then misses it
by a little. The host knows the car as it was a moment ago, and with it such views are recognized.
They follow to the same window of the picture, so that only the car moves.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from bozzetto.errors import UserError
from bozzetto.plugin import Context, ViewAdvice
from bozzetto.scene import Scene
from bozzetto.view import Camera
from bozzetto_car.body.body import Body
from bozzetto_car.body.build import is_shown, sketch_cameras_of
from bozzetto_car.camera.sketch_camera import SketchCamera
from bozzetto_car.marking.mark_mesh import asked_on_mesh
from bozzetto_car.marking.next_mark import in_work, problem_of
from bozzetto_car.solver.initial_cameras import Placed
from bozzetto_car.state import CarState, Sketch
from bozzetto_car.view.scene import look_layers, view_dependent_scene


def cars_seen(context: Context) -> tuple[CarState, ...]:
    """Return the car as it was when the person saw it, newest first."""
    return tuple(state for state in context.seen if isinstance(state, CarState))


def camera_looked_through(
    sketch: Sketch, body: Body, camera: Camera, seen: Iterable[CarState] = ()
) -> SketchCamera | None:
    """Return the camera through which a view looks at a sketch, now or a moment ago.

    Parameters
    ----------
    sketch : Sketch
        The sketch.
    body : Body
        The body as it is now.
    camera : Camera
        The view.
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
    """Return the view of the same window of the sketch after the car has changed; else None."""
    sketch = state.sketch
    before = None if sketch is None else _camera_before(sketch, seen)
    if sketch is None or before is None or not before.is_seen_through(camera):
        return None
    now = sketch_cameras_of(state).get(sketch.id)
    if now is None or now.is_seen_through(camera):
        return None
    return now.windowed(camera.viewport, before.window(camera))


def advice_following(
    state: CarState, body: Body, camera: Camera, seen: Sequence[Body]
) -> ViewAdvice:
    """Return advice on a view that goes along with the sketch if that has another camera now.

    Parameters
    ----------
    state : CarState
        The car.
    body : Body
        The car as it is shown.
    camera : Camera
        The view.
    seen : sequence of Body
        The car as it was shown a moment ago, newest first.
    """
    sketch = state.sketch
    now = None if sketch is None else body.sketch_cameras.get(sketch.id)
    if sketch is None or now is None or now.is_seen_through(camera):
        return advice_on(state, body, camera)
    for earlier in seen:
        before = earlier.sketch_cameras.get(sketch.id)
        if before is None or before.camera.viewport != now.camera.viewport:
            continue
        if before.is_seen_through(camera):
            along = now.windowed(camera.viewport, before.window(camera))
            advice = advice_on(state, body, along)
            return replace(advice, better=along, pinned=True, follow=True)
    if _sees_what_has_gone(state, camera, seen):
        return replace(advice_on(state, body, camera), follow=True)
    return advice_on(state, body, camera)


def _sees_what_has_gone(state: CarState, camera: Camera, seen: Iterable[Body]) -> bool:
    """Whether a view looks through a sketch that the car had a moment ago and has no more."""
    here = {sketch.id for sketch in state.sketches}
    return any(
        before.is_seen_through(camera)
        for earlier in seen
        for sketch, before in earlier.sketch_cameras.items()
        if sketch not in here
    )


def _camera_before(sketch: Sketch, state: CarState) -> SketchCamera | None:
    """Return the camera of a sketch in an earlier state of its car; None if there was none."""
    if not any(one.id == sketch.id and one.size == sketch.size for one in state.sketches):
        return None
    try:
        return sketch_cameras_of(state).get(sketch.id)
    except UserError:
        return None


def advice_on(state: CarState, body: Body, camera: Camera) -> ViewAdvice:
    """Return advice on a view: through the sketch in work, or the way back to it."""
    scene, placed = view_dependent_scene(state, body, camera), in_work(state, body.solved)
    if placed is None:
        is_marked = state.mesh is not None and asked_on_mesh(state) is not None
        on_mesh = is_marked and state.shading == "shaded" and is_shown(state, body)
        return ViewAdvice("good", "", scene=scene + _thin(state, body) if on_mesh else scene)
    sketch = placed.sketch
    sketch_camera = body.sketch_cameras[sketch.id]
    if sketch_camera.is_seen_through(camera):
        problem = problem_of(placed)
        return ViewAdvice(
            "warn" if problem else "good",
            problem,
            None,
            scene + _draft(state, body, placed),
            pinned=True,
        )
    better = sketch_camera.view(camera.viewport)
    if state.selected == sketch.id and _sees_another(state, body, camera):
        return ViewAdvice("good", f"“{sketch.name}” is chosen.", better, scene, follow=True)
    return ViewAdvice("good", f"Not seen through “{sketch.name}”.", better, scene)


def _draft(state: CarState, body: Body, placed: Placed) -> Scene:
    """Return the body so thin that the drawing shows through, unless its own look is wanted.

    Over a sketch whose own camera is not known, the body does not fit and hides the points to
    mark, so there it is always thin.
    """
    sketch = placed.sketch
    drawn = sketch.picture is not None and sketch.visible and sketch.opacity > 0.0
    judged = state.shading != "shaded" and placed.is_known
    if not drawn or judged or not is_shown(state, body):
        return Scene()
    return _thin(state, body)


def _thin(state: CarState, body: Body) -> Scene:
    """Return the body so thin that what it is shaped by shows through."""
    return Scene(tuple(look_layers(replace(state, shading="draft"), body)))


def _sees_another(state: CarState, body: Body, camera: Camera) -> bool:
    """Whether a view looks through a sketch of the car that is not the one in work."""
    others = (one for one in state.sketches if one is not state.sketch)
    return any(camera_looked_through(other, body, camera) is not None for other in others)
