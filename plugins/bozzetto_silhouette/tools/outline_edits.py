"""What tools share that change the outline of a part: which part is meant, and how it shows."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from bozzetto.errors import UserError
from bozzetto.ink import Stroke
from bozzetto.plugin import Gesture, Ink
from bozzetto.scene import Layer, Lines, Scene
from bozzetto_silhouette.model.state import Edit, Part, SilhouetteState
from bozzetto_silhouette.outline.edits import Rings, size_of
from bozzetto_silhouette.outline.from_ink import outline_of, rings_of
from bozzetto_silhouette.solids.placements import (
    carried,
    drawn_rings,
    on_sheet,
    outlined_parts,
    stroke_in,
)

__all__ = ["edited_part", "preview_of"]

Points = NDArray[np.float64]
ChooseRing = Callable[[Rings, Points, float], int]
MakeEdit = Callable[[Stroke, int], Edit]


def edited_part(state: SilhouetteState, stroke: Stroke, choose: ChooseRing, make: MakeEdit) -> Part:
    """The part that a stroke is meant for, with one more edit.

    Parameters
    ----------
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


def preview_of(
    state: SilhouetteState, gesture: Gesture, choose: ChooseRing, make: MakeEdit
) -> Scene:
    """The outline that would come, as lines; nothing while the stroke is not understood."""
    if not isinstance(gesture, Ink) or gesture.strokes[-1].tool == "eraser":
        return Scene()
    try:
        part = edited_part(state, gesture.strokes[-1], choose, make)
        rings = drawn_rings(state, part)
    except UserError:
        return Scene()
    closed = [np.vstack([ring, ring[:1]]) for ring in rings]
    starts = np.cumsum([0, *(len(ring) for ring in closed[:-1])])
    points = np.concatenate(closed)
    if not (np.abs(points) < np.finfo(np.float32).max).all():
        return Scene()
    lines = Lines(points.astype(np.float32), starts, color="accent", width=2.0, hidden="show")
    return Scene((Layer("preview", (lines,)),))


def _likely(state: SilhouetteState, stroke: Stroke) -> list[Part]:
    """The parts that a stroke may be meant for: the chosen one, then by nearness in the picture."""
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
    """The places of a problem on the canvas of the stroke, where a part stands mirrored."""
    if not mirrored:
        return problem
    width = stroke.camera.viewport[0]
    return UserError(problem.message, places=[(width - x, y) for x, y in problem.places])
