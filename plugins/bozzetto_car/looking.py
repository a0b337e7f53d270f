"""From where a car is looked at: through its sketch, or past it.

With every mark the camera of a sketch becomes another, and what was a view through the sketch
looks past it by a hair. Such views are known by the stands that the sketch had a moment ago, and
they go along to the same window of the picture, so that nothing but the car moves.
"""

from __future__ import annotations

from typing import Final

from bozzetto.plugin import Memory, ViewAdvice
from bozzetto.view import Camera
from bozzetto_car.asking import asked_of, in_work, titled
from bozzetto_car.body import Body
from bozzetto_car.showing import hanging_on_view
from bozzetto_car.solving import FEWEST, Placed
from bozzetto_car.stand import Stand
from bozzetto_car.state import CarState, Sketch

__all__ = ["advice_on", "note_stand", "stand_seen"]

NO_SKETCH: Final = "Drop a sketch on the sheet, or look at the template."

EXCHANGED: Final = (
    "Left and right seem to be exchanged. The command “Exchange left and right” puts it right."
)
"""What is said of marks that fit a car as a mirror shows it."""

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
    placed = in_work(state, body.solved)
    if placed is None:
        return ViewAdvice("good", NO_SKETCH)
    sketch = placed.sketch
    stand = body.stands[sketch.id]
    seen = stand_seen(sketch, body, camera)
    note_stand(sketch, stand)
    if seen is stand:
        return _said_of(state, body, placed)
    if seen is not None:
        better = stand.windowed(camera.viewport, seen.window(camera))
        said = _said_of(state, body, placed)
        return ViewAdvice(said.level, said.message, better, pinned=True, follow=True)
    better, scene = stand.view(camera.viewport), hanging_on_view(state, body, camera)
    if state.selected == sketch.id and _sees_another(state, body, camera):
        return ViewAdvice("good", f"“{sketch.name}” is chosen.", better, scene, follow=True)
    return ViewAdvice("good", f"Not seen through “{sketch.name}”.", better, scene)


def _sees_another(state: CarState, body: Body, camera: Camera) -> bool:
    """Whether a view looks through a sketch of the car that is not the one in work."""
    others = (one for one in state.sketches if one is not state.sketch)
    return any(stand_seen(other, body, camera) is not None for other in others)


def _said_of(state: CarState, body: Body, placed: Placed) -> ViewAdvice:
    """What to say where the sketch in work is seen through its own camera."""
    sketch = placed.sketch
    if placed.problem and len(sketch.marks) >= FEWEST:
        return ViewAdvice("warn", placed.problem, pinned=True)
    if placed.exchanged:
        return ViewAdvice("warn", EXCHANGED, pinned=True)
    asked = asked_of(state, body.solved)
    if asked is None:
        return ViewAdvice("good", f"All of “{sketch.name}” is marked.", pinned=True)
    title = titled(asked.node, sketch, body.template)
    return ViewAdvice("good", f"Next mark: {title}", pinned=True)
