"""A modeler of marks with commands, an opinion of every view, and curves for others."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from bozzetto.errors import UserError
from bozzetto.geometry import Curve, Shapes
from bozzetto.plugin import Command, Modeler, Tool, ViewAdvice
from bozzetto.scene import Layer, Lines, Points, Scene
from bozzetto.view.standard_views import look_along

MODELER = "adviser.marks"

MANIFEST = f"""
id = "adviser.plugin"
title = "Adviser"
version = "1.0"
api = ">=2,<3"

[[modeler]]
id = "{MODELER}"
title = "Marks"
icon = "icon.svg"
hint = "Draw a mark."
order = 95
abilities = ["read_shapes"]
"""

ABOVE = 0.5
"""How steeply one must look down for a good view (sine)."""


@dataclass(frozen=True)
class MarksState:
    """Marks are pairs of places, joined by a straight line."""

    marks: tuple[tuple[tuple[float, float, float], tuple[float, float, float]], ...] = ()
    box: float = 0.0
    seen: int = 0


class DrawMark(Tool[MarksState]):
    id, title, icon, hint, gesture = "mark", "Mark", "", "Draw a mark.", "ink"

    def draw(self, state, gesture, context):
        stroke = gesture.strokes[0]
        places = stroke.camera.on_plane(stroke.points[[0, -1]], (0, 0, 0), (0, 1, 0))
        if not np.isfinite(places).all():
            raise UserError("There is no place. Draw elsewhere.")
        pair = tuple(tuple(float(v) for v in place) for place in places)
        return replace(state, marks=(*state.marks, pair), seen=len(context.curves))


def flip(state: MarksState, context: Any) -> MarksState:
    def mirrored(place):
        return (-place[0], place[1], place[2])

    flipped = tuple((mirrored(a), mirrored(b)) for a, b in state.marks)
    return replace(state, marks=flipped, seen=len(context.curves))


def refuse(state: MarksState, context: Any) -> MarksState:
    raise UserError("This cannot be done. Do something else.")


class Marks(Modeler[MarksState, tuple]):
    id, state_type = MODELER, MarksState

    def __init__(self) -> None:
        self.asked = 0
        self.keys = {"flip": "X", "refuse": "F"}
        self.advise = self._advise

    def create(self, context):
        return MarksState(box=float(context.facts.get("box", 0.0)))

    def tools(self):
        return (DrawMark(),)

    def solve(self, state, job):
        return state.marks

    def scene(self, state, result):
        lines = tuple(Lines(np.array(pair, np.float32)) for pair in state.marks)
        return Scene((Layer("marks", lines),))

    def shapes(self, state, result):
        return Shapes(curves=self.curves(state, result))

    def curves(self, state, result):
        knots = np.array([0.0, 0.0, 1.0, 1.0])
        return tuple(Curve(1, knots, np.array(pair)) for pair in result)

    def read_shapes(self, shapes):
        if not shapes.curves:
            raise UserError("There are no curves in it. Choose another object.")
        ends = ((c.control_points[0], c.control_points[-1]) for c in shapes.curves)
        pairs = tuple((tuple(map(float, a)), tuple(map(float, b))) for a, b in ends)
        return MarksState(pairs)

    def commands(self):
        return [
            Command("flip", "Flip", "Exchange left and right.", flip, self.keys["flip"],
                    lambda state: bool(state.marks)),
            Command("refuse", "Refuse", "Says no.", refuse, key=self.keys["refuse"]),
        ]  # fmt: skip

    def view_advice(self, state, camera, job):
        self.asked += 1
        return self.advise(state, camera)

    def _advise(self, state, camera):
        steepness = -float(camera.axes[2][2])
        layer = Layer("vanishing", (Points(np.array([camera.target], np.float32)),))
        if steepness >= ABOVE - 1e-9:
            return ViewAdvice("good", "Seen from above", scene=Scene((layer,)))
        level = "warn" if steepness > 0.1 else "refuse"
        better = look_along(camera, (0.0, 1.0, -1.0))
        return ViewAdvice(level, f"{steepness:.0%} from above", better, Scene((layer,)))
