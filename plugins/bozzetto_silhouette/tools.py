"""What the pen can do: draw outlines, and erase them with its other end."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np

from bozzetto.errors import Unfinished, UserError
from bozzetto.geometry import Mesh
from bozzetto.ink import Stroke, Strokes
from bozzetto.plugin import Context, Gesture, Ink
from bozzetto.scene import Layer, Scene, Shaded
from bozzetto_silhouette.ink_to_outline import outline_of, points_on_sheet, surrounds
from bozzetto_silhouette.sheet import sheet_under
from bozzetto_silhouette.state import Part, SilhouetteState

__all__ = ["DrawOutline"]

OPEN_GAP = 0.2
"""Gap between the ends of an outline, as a part of its diagonal, up to which a stroke counts
as meant to be closed."""


class DrawOutline:
    """One closed outline makes a part; drawn inside a part on its sheet, a hole in it."""

    id = "draw"
    title = "Draw outline"
    icon = "icons/draw.svg"
    hint = "Draw a closed outline; inside a shape it becomes a hole."
    gesture: Literal["ink", "tap", "drag"] = "ink"

    def preview(self, state: SilhouetteState, gesture: Gesture, context: Context) -> Scene:
        """The shape swelling under the pen, from the ink so far."""
        from bozzetto_silhouette.preview import inflate

        if not isinstance(gesture, Ink) or gesture.strokes[-1].tool == "eraser":
            return Scene()
        sheet = sheet_under(gesture.strokes[0], context)
        on_sheet = [sheet.from_pixels(s.points, s.camera) for s in gesture.strokes]
        points = np.concatenate(on_sheet)
        if not np.isfinite(points).all():
            return Scene()
        swollen = inflate(points, inflation=state.inflation)
        if swollen is None:
            return Scene()
        mesh = Mesh(
            sheet.to_world(swollen.vertices).astype(np.float32),
            swollen.faces,
            sheet.turn(swollen.normals).astype(np.float32),
        )
        return Scene((Layer("preview", (Shaded(mesh, pickable=False),)),))

    def apply(self, state: SilhouetteState, gesture: Gesture, context: Context) -> SilhouetteState:
        """Add a part or a hole.

        Raises
        ------
        Unfinished
            If the ends are far apart and more strokes may come.
        UserError
            If the ink crosses itself, or is too little to be an outline.
        """
        if not isinstance(gesture, Ink):
            raise UserError("Draw an outline with the pen.")
        if gesture.strokes[-1].tool == "eraser":
            return _erased(state, gesture.strokes[-1])
        if not gesture.committed and not _meets_itself(gesture.strokes):
            raise Unfinished("Go on with the outline, or press Enter to close it.")
        part = Part(Strokes(gesture.strokes), sheet_under(gesture.strokes[0], context))
        outline_of(part)
        return replace(state, parts=_nested(state.parts, part))


def _meets_itself(strokes: tuple[Stroke, ...]) -> bool:
    """Whether the chain of strokes comes back to where it began."""
    first, last = strokes[0].points, strokes[-1].points
    points = np.concatenate([stroke.points for stroke in strokes])
    diagonal = float(np.hypot(*np.ptp(points, axis=0)))
    gap = float(np.hypot(*(last[-1] - first[0])))
    return len(points) > 2 and gap <= OPEN_GAP * diagonal


def _nested(parts: tuple[Part, ...], new: Part) -> tuple[Part, ...]:
    """The parts with a new one among them.

    Inside another one on its sheet it is a hole; it takes in those that it is drawn around
    as its holes; anywhere else it stands for itself.
    """
    alike = [index for index, old in enumerate(parts) if new.sheet.faces_as(old.sheet)]
    for index in alike:
        old = parts[index]
        if _lies_within(new, old):
            whole = replace(old, strokes=old.strokes.extended(new.strokes))
            outline_of(whole)
            return (*parts[:index], whole, *parts[index + 1 :])
    taken = [index for index in alike if _lies_within(parts[index], new)]
    whole = new
    for index in taken:
        whole = replace(whole, strokes=whole.strokes.extended(parts[index].strokes))
    if taken:
        outline_of(whole)
    place = taken[0] if taken else len(parts)
    kept = [old for index, old in enumerate(parts) if index not in taken]
    return (*kept[:place], whole, *kept[place:])


def _lies_within(inner: Part, outer: Part) -> bool:
    """Whether all of one part's ink lies inside the outline of the other."""
    points = points_on_sheet(tuple(inner.strokes), outer.sheet)
    return surrounds(outline_of(outer), np.concatenate(points))


def _erased(state: SilhouetteState, eraser: Stroke) -> SilhouetteState:
    """Without the newest part that most of the eraser's path crosses.

    Raises
    ------
    UserError
        If nothing lies under the eraser.
    """
    for index in reversed(range(len(state.parts))):
        part = state.parts[index]
        path = part.sheet.from_pixels(eraser.points, eraser.camera)
        if not np.isfinite(path).all():
            continue
        inside = [surrounds(outline_of(part), point[None]) for point in path[:: len(path) // 8 + 1]]
        if np.mean(inside) >= 0.5:
            return replace(state, parts=state.parts[:index] + state.parts[index + 1 :])
    raise UserError("There is no part under the eraser. Rub across the part to take it away.")
