"""Brush: paint on the surface under the pen, each stroke over those before it."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Final

import numpy as np

from bozzetto.errors import UserError
from bozzetto.ink import Stroke
from bozzetto.plugin import Command, Context, Gesture, Ink, Preview, Tap, override
from bozzetto.scene import Layer, Lines, Scene, Shaded
from bozzetto_silhouette.appearance.brush_cover import Segments
from bozzetto_silhouette.appearance.live_canvas import Canvas
from bozzetto_silhouette.appearance.surface_look import canvas_of
from bozzetto_silhouette.model.paint_stroke import BrushLook
from bozzetto_silhouette.model.state import SilhouetteState
from bozzetto_silhouette.rigging.posing import bent
from bozzetto_silhouette.tools.brush_marks import (
    BrushSurface,
    Marks,
    brush_surface,
    marks_under,
    mirrored_marks,
    path_of,
    with_marks,
)
from bozzetto_silhouette.tools.erasing_tool import ColouringTool

NOTHING_YET = "There is nothing to paint on yet. Draw a shape first."
BESIDE = "This passes the shape by. Paint over the shape."
SIZED: Final = 1.2
"""By which the brush gets larger at once."""

SMALLEST, LARGEST = 1.0, 400.0
"""Bounds of its size, px; those of the parameter."""

ROUND: Final = 64
"""Sides of the circle that shows how wide it is."""

RIM: Final = 4.0
"""Width of the line beneath that circle, of which an edge is seen on both sides, px."""

NO_PAINT = "There is no paint to rub out. Paint with the pen first."


class Brush(ColouringTool):
    """A stroke paints the surface that it is seen on; the pen's other end rubs paint out."""

    id = "brush"
    title = "Brush"
    icon = "icons/brush.svg"
    hint = (
        "Paint on the shape: press harder for a wider stroke, [ and ] size the brush; the eraser "
        "rubs paint out."
    )
    hovers = True

    @override
    def draw(self, state: SilhouetteState, ink: Ink, context: Context) -> SilhouetteState:
        """Keep every stroke as paint on the parts under it.

        Raises
        ------
        UserError
            If there is no shape, or all strokes pass it by.
        """
        return _painted(state, ink.strokes, state.paint, context)

    @override
    def erase(self, state: SilhouetteState, ink: Ink, context: Context) -> SilhouetteState:
        """Rub paint out; see `draw`. Colours of parts stay."""
        return _painted(state, ink.strokes, None, context)

    @override
    def tap(self, state: SilhouetteState, tap: Tap, context: Context) -> SilhouetteState:
        """Paint a dot; see `draw`."""
        dot = Stroke([tap.x], [tap.y], tap.camera, pressure=[tap.pressure])
        return _painted(state, (dot,), state.paint, context)

    @override
    def begin(self, state: SilhouetteState, context: Context) -> Preview[SilhouetteState]:
        """Return the preview of a stroke, which grows with it."""
        return BrushPreview(self, state, context)


def brush_commands() -> tuple[Command, ...]:
    """Return what makes the brush smaller and larger."""
    return tuple(
        Command(
            f"brush-{word}",
            f"{word.capitalize()} brush",
            f"Paint with a brush that is {word} by a fifth.",
            partial(_sized, factor),
            key=key,
            enabled=lambda state: bool(state.nodes),
            menu="Brush",
        )
        for word, factor, key in (("smaller", 1.0 / SIZED, "["), ("larger", SIZED, "]"))
    )


def _sized(factor: float, state: SilhouetteState, context: Context) -> SilhouetteState:
    size = round(state.brush_size * factor)
    size += (size == round(state.brush_size)) * (1 if factor > 1.0 else -1)
    return replace(state, brush_size=float(np.clip(size, SMALLEST, LARGEST)))


def _ring(tap: Tap, size: float) -> tuple[Lines, Lines]:
    """Return a circle of the width of the brush where it is pressed hard.

    A dark line within a light one, or the other way round: it may lie on paint of any colour.
    """
    turn = np.linspace(0.0, 2.0 * np.pi, ROUND + 1)
    pixels = (tap.x, tap.y) + 0.5 * size * np.column_stack([np.cos(turn), np.sin(turn)])
    camera = tap.camera
    points = camera.on_plane(pixels, camera.target, camera.axes[2])
    line = points.astype(np.float32)
    rim = Lines(line, color="paper", width=RIM, hidden="show")
    return rim, Lines(line, color="ink", hidden="show")


def _painted(
    state: SilhouetteState,
    strokes: tuple[Stroke, ...],
    color: tuple[int, int, int] | None,
    context: Context,
) -> SilhouetteState:
    """Return the state with strokes of paint of a colour, or with paint rubbed out."""
    if color is None and not any(part.paint_strokes for part in state.parts):
        raise UserError(NO_PAINT)
    surface = brush_surface(state)
    if surface is None:
        raise UserError(NOTHING_YET)
    painted = state
    for stroke in strokes:
        marks, *images = _marks_of(stroke, 0, surface, state, context)
        for image in images:
            marks = marks.followed_by(image)
        if len(marks.points):
            painted = with_marks(painted, surface.body, marks, _look(painted, color))
    if painted is state:
        raise UserError(BESIDE)
    return painted


def _look(state: SilhouetteState, color: tuple[int, int, int] | None) -> BrushLook:
    """Return the look of the next stroke."""
    used = [stroke.number for part in state.parts for stroke in part.paint_strokes]
    number = max(used, default=0) + 1
    return BrushLook(number, color, state.brush_opacity, state.brush_softness)


def _marks_of(
    stroke: Stroke, first: int, surface: BrushSurface, state: SilhouetteState, context: Context
) -> list[Marks]:
    """Return what a stroke leaves from one of its samples on, and its mirror image if wanted."""
    pixels, radii = path_of(stroke, state.brush_size, first)
    marks = marks_under(surface, pixels, radii, stroke.camera)
    if not state.mirrored or not len(marks.points):
        return [marks]
    return [marks, mirrored_marks(marks, surface, state, context)]


class BrushPreview(Preview[SilhouetteState]):
    """The shape with the stroke that is being painted; only what is new of it is worked out."""

    _surface: BrushSurface | None = None
    _canvas: Canvas | None = None
    _done = 0

    @override
    def update(self, gesture: Gesture) -> Scene:
        """Return the shape as it is painted so far; of a pen that hovers, how wide it paints.

        What a stroke begins with is found while the pen hovers.

        Raises
        ------
        UserError
            If a part's ink is no outline.
        """
        if isinstance(gesture, Tap):
            self._start()
            return Scene((Layer("brush", _ring(gesture, self.state.brush_size)),))
        if not isinstance(gesture, Ink):
            return Scene()
        stroke = gesture.strokes[-1]
        if self._canvas is None or len(stroke) < self._done:
            self._start()
        surface, canvas = self._surface, self._canvas
        if surface is None or canvas is None:
            return Scene()
        color = None if gesture.erases else self.state.paint
        new = max(self._done - 1, 0)
        for marks in _marks_of(stroke, new, surface, self.state, self.context):
            if len(marks.points):
                canvas.lay(
                    Segments.through(marks.points, marks.normals, marks.radii, marks.joined),
                    _look(self.state, color),
                )
        self._done = len(stroke)
        return Scene((Layer("shape", (Shaded(canvas.mesh, pickable=False),)),))

    def _start(self) -> None:
        self._done = 0
        self._surface = brush_surface(self.state)
        if self._surface is not None:
            body = self._surface.body
            self._canvas = Canvas(
                canvas_of(self.state, body, lambda mesh: bent(self.state, body, mesh))
            )
