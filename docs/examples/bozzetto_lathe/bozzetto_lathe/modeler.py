"""What the pen can do, and what becomes of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from bozzetto.geometry import Shapes, shaded_brep, surface_of_revolution
from bozzetto.plugin import Context, Gesture, Ink, Job, Modeler, Tool, UserError, override
from bozzetto.scene import Layer, Lines, Scene, Shaded
from bozzetto_lathe.profile import axis_of, spline_of
from bozzetto_lathe.state import LatheState

COARSE, FINE = 0.01, 0.001
"""How far triangles may be from the surface, as share of the profile's size."""

Turned = tuple[Shapes, Shaded] | None
"""What is handed over, and what is shown of it; None without a profile."""


class LatheTool(Tool[LatheState]):
    """Shows the turned surface while the pen is down."""

    @override
    def preview(self, state: LatheState, gesture: Gesture, context: Context) -> Scene:
        made = self.apply(state, gesture, context)
        return picture(made, turned(made, COARSE))


class DrawProfile(LatheTool):
    """The first stroke is the profile, the next ones change it."""

    id = "profile"
    title = "Draw profile"
    icon = "icons/lathe.svg"
    hint = "Draw a profile beside the axis; draw over it to change it."

    @override
    def draw(self, state: LatheState, ink: Ink, context: Context) -> LatheState:
        strokes = tuple(Ink((stroke,)) for stroke in ink.strokes)
        drawn = replace(state, profile=state.profile + strokes)
        swept(drawn)  # refuses what cannot be turned
        return drawn

    @override
    def erase(self, state: LatheState, ink: Ink, context: Context) -> LatheState:
        if not state.profile:
            raise UserError("There is no profile here. Draw one.")
        return replace(state, profile=())


class DrawAxis(LatheTool):
    """A stroke is the axis."""

    id = "axis"
    title = "Draw axis"
    icon = "icons/axis.svg"
    hint = "Draw the axis as a straight stroke."

    @override
    def draw(self, state: LatheState, ink: Ink, context: Context) -> LatheState:
        drawn = replace(state, axis=Ink(ink.strokes[-1:]))
        axis_of(drawn)
        swept(drawn)
        return drawn


class Lathe(Modeler[LatheState, Turned]):
    """A profile turns about an axis."""

    id = "example.lathe"
    state_type = LatheState
    first_parameters = ("detail", "ends")

    @override
    def tools(self) -> Sequence[Tool[LatheState]]:
        return (DrawProfile(), DrawAxis())

    @override
    def solve(self, state: LatheState, job: Job) -> Turned:
        job.checkpoint(0.0, "Turning")
        return turned(state, COARSE if job.quality == "preview" else FINE)

    @override
    def scene(self, state: LatheState, result: Turned) -> Scene:
        return picture(state, result)

    @override
    def shapes(self, state: LatheState, result: Turned) -> Shapes:
        return Shapes() if result is None else result[0]


def swept(state: LatheState) -> Shapes:
    """Return what a profile sweeps, exactly; nothing without a profile.

    Raises
    ------
    UserError
        If the ink makes no profile.
    """
    if not state.profile:
        return Shapes()
    return Shapes(breps=(surface_of_revolution(spline_of(state), *axis_of(state), name="lathe"),))


def turned(state: LatheState, coarse: float) -> Turned:
    """Return what a profile sweeps, and triangles of it; see `swept`."""
    shapes = swept(state)
    if not shapes:
        return None
    size = float(np.linalg.norm(np.ptp(spline_of(state).control_points, axis=0)))
    return shapes, Shaded(shaded_brep(shapes.breps[0], coarse * size))


def picture(state: LatheState, result: Turned) -> Scene:
    """Return the surface, the control polygon of its profile, and the axis."""
    lines = []
    if state.profile:
        lines.append(spline_of(state).control_points)
    if state.axis is not None:
        start, way = axis_of(state)
        lines.append(start + np.array([[-200.0], [200.0]]) * way)
    ink = tuple(Lines(line.astype(np.float32), color="ghost", hidden="show") for line in lines)
    return Scene((Layer("lathe", () if result is None else (result[1],)), Layer("ink", ink)))
