"""Sketch over and smooth: the tools that change the outline of a part."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.ink import Stroke
from bozzetto.plugin import Context, Gesture, Ink, override
from bozzetto.scene import Layer, Lines, Scene
from bozzetto_silhouette.ink.oversketch import ring_drawn_over
from bozzetto_silhouette.ink.ring_smoothing import rubbed_ring
from bozzetto_silhouette.model.state import Edit, Oversketch, Part, SilhouetteState, Smoothing
from bozzetto_silhouette.outline.edits import Rings, size_of
from bozzetto_silhouette.outline.from_ink import outline_of, rings_of
from bozzetto_silhouette.solids.placements import (
    carried,
    drawn_rings,
    on_sheet,
    outlined_parts,
    stroke_in,
)
from bozzetto_silhouette.tools.erasing_tool import ErasingTool

ChooseRing = Callable[[Rings, Array, float], int]
MakeEdit = Callable[[Stroke, int], Edit]


def edited_part(state: SilhouetteState, stroke: Stroke, choose: ChooseRing, make: MakeEdit) -> Part:
    """Return the part that a stroke is meant for, with one more edit.

    Parameters
    ----------
    state : SilhouetteState
        The parts as they stand now.
    stroke : Stroke
        As drawn over the parts as they stand now.
    choose : callable
        The number of the ring that a line is meant for, of rings, the line and the size of
        the outline; raises `UserError` where none is.
    make : callable
        The edit from a stroke and the number of the ring.

    Raises
    ------
    UserError
        If no outline is near, or the outline would cross itself.
    """
    problem = UserError("There is no outline yet. Draw one first.")
    for part in _likely(state, stroke):
        line = on_sheet(state, part, stroke)
        if not np.isfinite(line).all():
            problem = UserError("From this side the sheet lies edge-on. Turn the view, then draw.")
            continue
        rings = rings_of(part)
        try:
            ring = choose(rings, line, size_of(rings))
        except UserError as far:
            problem = far
            continue
        edit = make(stroke_in(state, part, stroke), ring)
        changed = replace(part, edits=(*part.edits, edit))
        try:
            outline_of(changed)
        except UserError as crossed:
            raise _as_seen(crossed, carried(state, part).mirrors, stroke) from None
        return changed
    raise problem


def _likely(state: SilhouetteState, stroke: Stroke) -> list[Part]:
    """Return the parts a stroke may be meant for: the chosen one, then the nearest seen."""
    import shapely

    found = []
    ends = shapely.points(stroke.points[[0, -1]])
    for part in outlined_parts(state):
        try:
            rings = drawn_rings(state, part)
        except UserError:
            continue
        seen = [stroke.camera.project(ring)[0] for ring in rings]
        away = [
            float(shapely.distance(shapely.LinearRing(pixels), ends).max())
            for pixels in seen
            if np.isfinite(pixels).all()
        ]
        if away:
            found.append((part.id != state.selected, min(away), part))
    return [part for *_, part in sorted(found, key=lambda entry: entry[:2])]


def _as_seen(problem: UserError, mirrored: bool, stroke: Stroke) -> UserError:
    """Return a problem with its places on the canvas of the stroke, where a part is mirrored."""
    if not mirrored:
        return problem
    width = stroke.camera.viewport[0]
    return UserError(problem.message, places=[(width - x, y) for x, y in problem.places])


class _EditsOutline(ErasingTool):
    """A tool that changes the outline of the part that a stroke is drawn over.

    Attributes
    ----------
    choose : callable
        As for `edited_part`.
    make : callable
        As for `edited_part`.
    """

    choose: ChooseRing
    make: MakeEdit

    @override
    def preview(self, state: SilhouetteState, gesture: Gesture, context: Context) -> Scene:
        """Show the outline that would come; nothing while the stroke is not understood."""
        if not isinstance(gesture, Ink):
            return Scene()
        part = edited_part(state, gesture.strokes[-1], self.choose, self.make)
        rings = drawn_rings(state, part)
        closed = [np.vstack([ring, ring[:1]]) for ring in rings]
        starts = np.cumsum([0, *(len(ring) for ring in closed[:-1])])
        points = np.concatenate(closed)
        if not (np.abs(points) < np.finfo(np.float32).max).all():
            return Scene()
        lines = Lines(points.astype(np.float32), starts, color="accent", width=2.0, hidden="show")
        return Scene((Layer("preview", (lines,)),))

    @override
    def draw(self, state: SilhouetteState, ink: Ink, context: Context) -> SilhouetteState:
        """Change the outline of the part under each stroke.

        Raises
        ------
        UserError
            If no outline is near, or the new one crosses itself.
        """
        for stroke in ink.strokes:
            state = state.with_node(edited_part(state, stroke, self.choose, self.make))
        return state


class SketchOver(_EditsOutline):
    """An open stroke replaces a piece of the outline, a closed one all of a ring."""

    id = "oversketch"
    title = "Sketch over"
    icon = "icons/oversketch.svg"
    group = "Outline"
    hint = "Draw a piece of the outline again, from the line back to the line."
    choose = staticmethod(ring_drawn_over)
    make = Oversketch


class Smooth(_EditsOutline):
    """The stretch under the stroke is smoothed: more where the rub is broad or comes back."""

    id = "smooth"
    title = "Smooth"
    icon = "icons/smooth.svg"
    group = "Outline"
    hint = "Rub along the outline; broad or repeated rubbing smooths more."
    choose = staticmethod(rubbed_ring)
    make = Smoothing
