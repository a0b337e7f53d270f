"""From where a car is looked at: through its sketch, or past it.

With every mark the camera of a sketch becomes another, and what was a view through the sketch
looks past it by a hair. Such views are known by the stands that the sketch had a moment ago, and
they go along to the same window of the picture, so that nothing but the car moves.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final, Literal

from bozzetto.plugin import Memory, ViewAdvice
from bozzetto.scene import Scene
from bozzetto.view import Camera
from bozzetto_car.asking import asked_of, in_work, titled
from bozzetto_car.body import Body
from bozzetto_car.showing import body_layers, hanging_on_view, is_shown
from bozzetto_car.solving import FEWEST, Placed
from bozzetto_car.stand import Stand
from bozzetto_car.state import CarState, Sketch

__all__ = ["advice_on", "note_stand", "stand_seen"]

NO_SKETCH: Final = "Drop a sketch on the sheet, or look at the template."

EXCHANGED: Final = (
    "Left and right seem to be exchanged. The command “Exchange left and right” puts it right."
)
"""What is said of marks that fit a car as a mirror shows it."""

DRAFTED: Final = ("body", "wheels", "network")
"""Layers that look otherwise over a drawing, so that it can be seen."""

MOST_SKETCHES: Final = 32
"""Sketches whose stands are remembered."""

MOST_STANDS: Final = 32
"""Stands of one sketch that are remembered, the newest ones: a hand that drags a mark and lets it
go, or takes a few steps back, passes through no more before the view has gone along."""

_stands: Memory[tuple[Stand, ...]] = Memory(MOST_SKETCHES)


def note_stand(sketch: Sketch, stand: Stand) -> None:
    """Remember that a sketch stood like this, so that views through it are known later on."""
    question = (sketch.id, sketch.size)
    known = _stands.known(question) or ()
    if not known or known[0] is not stand:
        others = tuple(one for one in known if one is not stand)
        _stands.put(question, (stand, *others)[:MOST_STANDS])


def stand_seen(sketch: Sketch, body: Body, camera: Camera) -> Stand | None:
    """The stand through which a view looks at a sketch, as it is or was a moment ago."""
    now = body.stands.get(sketch.id)
    if now is None:
        return None
    before = _stands.known((sketch.id, sketch.size)) or ()
    return next((stand for stand in (now, *before) if stand.is_seen_through(camera)), None)


def advice_on(state: CarState, body: Body, camera: Camera) -> ViewAdvice:
    """What to say of a view: which mark is asked for, or that the sketch is seen from elsewhere."""
    scene, placed = hanging_on_view(state, body, camera), in_work(state, body.solved)
    if placed is None:
        return ViewAdvice("good", NO_SKETCH, scene=scene)
    sketch = placed.sketch
    stand, seen = body.stands[sketch.id], stand_seen(sketch, body, camera)
    note_stand(sketch, stand)
    if seen is not None:
        level, message = _said_of(state, body, placed)
        if seen is stand:
            scene = scene + _draft(state, body, placed)
            return ViewAdvice(level, message, None, scene, pinned=True)
        better = stand.windowed(camera.viewport, seen.window(camera))
        scene = hanging_on_view(state, body, better) + _draft(state, body, placed)
        return ViewAdvice(level, message, better, scene, pinned=True, follow=True)
    better = stand.view(camera.viewport)
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
    return any(stand_seen(other, body, camera) is not None for other in others)


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
    return "good", f"Next mark: {titled(asked.node, sketch, body.template)}"
