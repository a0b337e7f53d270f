"""A modeler of balls on springs: tools that move them in time."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np

from bozzetto.errors import UserError
from bozzetto.geometry import Mesh, Shapes, Solid
from bozzetto.plugin import Modeler, Parameter, Tool
from bozzetto.scene import Handle, Layer, Lines, Scene

MODELER = "spring.balls"

MANIFEST = f"""
id = "spring.plugin"
title = "Springs"
version = "1.0"
api = ">=2,<3"

[[modeler]]
id = "{MODELER}"
title = "Balls"
icon = "icon.svg"
hint = "Draw where the ball hangs."
order = 97
"""


@dataclass(frozen=True)
class Balls:
    """A ball on a spring about the origin, in the plane y = 0; mm, mm/s, seconds.

    What is recorded are rows of the time and the place.
    """

    place: tuple[float, float, float] = (0.0, 0.0, 0.0)
    speed: tuple[float, float, float] = (0.0, 0.0, 0.0)
    clock: float = 0.0
    steps: int = 0
    kept: tuple[tuple[float, float, float, float], ...] = ()
    stiffness: Annotated[float, Parameter("Stiffness", 0.0, 500.0)] = 40.0


class Draw(Tool[Balls]):
    id, title, hint = "draw", "Draw", "Draw where the ball hangs."

    def draw(self, state, ink, context):
        place = ink.camera.on_plane(ink.strokes[-1].points[-1:], (0, 0, 0), (0, 1, 0))[0]
        return replace(state, place=tuple(map(float, place)))


class Pull(Tool[Balls]):
    """Pulls the ball; it swings on while it plays."""

    id, title, hint = "pull", "Pull", "Pull the ball."
    gesture = "drag"
    grabs = plays = True

    def __init__(self, owner) -> None:
        self.owner = owner

    def tap(self, state, tap, context):
        return replace(state, speed=(0.0, 0.0, 100.0 * tap.pressure))

    def step(self, state, held, seconds, context):
        self.owner.seen.append(held)
        time.sleep(self.owner.takes)
        self.owner.misdeed(state)
        count, clock = state.steps + 1, state.clock + seconds
        if held is not None:
            place = held.camera.on_plane(held.path.points[-1:], (0, 0, 0), (0, 1, 0))[0]
            if not np.isfinite(place).all():
                raise UserError("There is no place. Pull elsewhere.")
            state = replace(state, place=tuple(map(float, place)), clock=clock, steps=count)
            return self.owner.recording(state)
        place, speed = np.array(state.place), np.array(state.speed)
        speed = speed - seconds * state.stiffness * place
        place = place + seconds * speed
        state = replace(
            state,
            place=tuple(map(float, place)),
            speed=tuple(map(float, speed)),
            clock=clock,
            steps=count,
        )
        return self.owner.recording(state)


class Springs(Modeler[Balls, None]):
    """`takes` is how long a step lasts, s; `seen` what each step was told was held.

    `records` says whether steps are recorded.
    """

    id, state_type = MODELER, Balls

    def __init__(self) -> None:
        self.takes = 0.0
        self.seen = []
        self.records = False
        self.misdeed = lambda state: None

    def tools(self):
        return Draw(), Pull(self)

    def recording(self, state):
        if not self.records:
            return state
        return replace(state, kept=(*state.kept, (state.clock, *state.place)))

    def recorded(self, state):
        return [row[0] for row in state.kept]

    def replayed(self, state, seconds):
        rows = np.array(state.kept)
        place = (float(np.interp(seconds, rows[:, 0], column)) for column in rows[:, 1:].T)
        return replace(state, place=tuple(place))

    def solve(self, state, job):
        return None

    def scene(self, state, result):
        line = Lines(np.array([(0, 0, 0), state.place], np.float32))
        return Scene((Layer("spring", (line, Handle("ball", state.place))),))

    def shapes(self, state, result):
        corners = np.array([[0, 0, 0], [9, 0, 0], [0, 9, 0], [0, 0, 9]], np.float32)
        faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]], np.int32)
        return Shapes(solids=(Solid(Mesh(corners + np.float32(state.place), faces)),))
