"""What the pen can do: draw a ribbon, move one by its handle, take one away."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from bozzetto.errors import UserError
from bozzetto.ink import Stroke
from bozzetto.plugin import Context, Drag, Gesture, Ink, Tap, Tool, override
from bozzetto.scene import Layer, Lines, Scene
from bozzetto_ribbon.band import middle_line
from bozzetto_ribbon.state import Band, Point, RibbonState

REACH = 3.0
"""How far from a ribbon's middle a tap still means it, in tolerances of the pen."""


class RibbonTool(Tool[RibbonState]):
    """While the pen is down, the middle lines of the ribbons that would be new."""

    @override
    def preview(self, state: RibbonState, gesture: Gesture, context: Context) -> Scene:
        made = self.apply(state, gesture, context).bands
        lines = [middle_line(band)[0] for band in made if band not in state.bands]
        shown = (Lines(line.astype(np.float32), color="accent", hidden="show") for line in lines)
        return Scene((Layer("preview", tuple(shown)),))


class DrawRibbon(RibbonTool):
    """Every stroke makes a ribbon."""

    id = "draw"
    title = "Draw ribbon"
    icon = "icons/ribbon.svg"
    hint = "Draw a stroke; press harder to make the ribbon wider."

    @override
    def draw(self, state: RibbonState, ink: Ink, context: Context) -> RibbonState:
        bands = tuple(laid_down(stroke, context) for stroke in ink.strokes)
        for band in bands:
            middle_line(band)  # refuses ink that no ribbon can follow
        return replace(state, bands=state.bands + bands)


class MoveRibbon(RibbonTool):
    """A ribbon's handle takes it along, parallel to the screen."""

    id = "move"
    title = "Move ribbon"
    icon = "icons/move.svg"
    hint = "Drag the dot at the beginning of a ribbon."
    gesture = "drag"

    @override
    def drag(self, state: RibbonState, drag: Drag, context: Context) -> RibbonState:
        numbers = {str(number): number for number in range(len(state.bands))}
        if drag.handle not in numbers:
            raise UserError(self.hint)
        number = numbers[drag.handle]
        band = state.bands[number]
        start = middle_line(band)[0][0]
        here = drag.camera.on_plane(drag.path.points[-1:], start, drag.camera.axes[2])[0]
        if not np.isfinite(here).all():
            raise UserError("The ribbon lies behind the eye. Turn the view, then drag.")
        moved = replace(band, shift=point(np.add(band.shift, here - start)))
        return replace(state, bands=(*state.bands[:number], moved, *state.bands[number + 1 :]))


class TakeAway(Tool[RibbonState]):
    """A tap takes a ribbon away."""

    id = "erase"
    title = "Take away"
    icon = "icons/erase.svg"
    hint = "Tap on the middle of a ribbon to take it away."
    gesture = "tap"

    @override
    def tap(self, state: RibbonState, tap: Tap, context: Context) -> RibbonState:
        gaps = [gap_to(band, tap) for band in state.bands]
        if not gaps or min(gaps) > REACH * context.pen.tolerance:
            raise UserError("There is no ribbon here. Tap on the middle of one.")
        number = int(np.argmin(gaps))
        return replace(state, bands=state.bands[:number] + state.bands[number + 1 :])


def laid_down(stroke: Stroke, context: Context) -> Band:
    """A stroke in the plane parallel to the screen through what is under its first point.

    Where nothing is there, through the point about which the view turns.
    """
    camera = stroke.camera
    hits = context.surface_hit(camera.rays(stroke.points[:1]))
    return Band(stroke, point(hits.points[0]) if hits.hit[0] else camera.target)


def gap_to(band: Band, tap: Tap) -> float:
    """Distance on the sheet from a tap to the middle of a ribbon, px; inf if out of view."""
    pixels, _ = tap.camera.project(middle_line(band)[0])
    gaps = np.hypot(*(pixels - (tap.x, tap.y)).T)
    return float(np.min(np.where(np.isnan(gaps), np.inf, gaps)))


def point(values: NDArray[np.float64]) -> Point:
    """Three plain floats: numpy's own are not stored in documents."""
    x, y, z = (float(value) for value in values)
    return x, y, z
