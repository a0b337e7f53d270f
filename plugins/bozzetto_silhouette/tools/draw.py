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
from bozzetto_silhouette.state import Cut, Group, Part, SilhouetteState

__all__ = ["DrawOutline", "meets_itself"]

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
        swollen = inflate(points)
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
        if not gesture.committed and not meets_itself(gesture.strokes):
            raise Unfinished("Go on with the outline, or press Enter to close it.")
        part = Part(
            id=state.unused_id(),
            name=state.unused_name(),
            strokes=Strokes(gesture.strokes),
            sheet=sheet_under(gesture.strokes[0], context),
        )
        outline_of(part)
        return _nested(state, part)


def meets_itself(strokes: tuple[Stroke, ...]) -> bool:
    """Whether the chain of strokes comes back to where it began."""
    first, last = strokes[0].points, strokes[-1].points
    points = np.concatenate([stroke.points for stroke in strokes])
    diagonal = float(np.hypot(*np.ptp(points, axis=0)))
    gap = float(np.hypot(*(last[-1] - first[0])))
    return len(points) > 2 and gap <= OPEN_GAP * diagonal


def _nested(state: SilhouetteState, new: Part) -> SilhouetteState:
    """The state with a new part.

    Inside another one on its sheet it is a hole; it takes in those that it is drawn around
    as its holes; anywhere else it stands for itself.
    """
    if state.inner == "apart":
        return state.with_node(new)
    outlined = [part for part in state.parts if not isinstance(part, Cut)]
    alike = [part for part in outlined if new.sheet.faces_as(part.sheet)]
    for old in alike:
        if _lies_within(new, old):
            whole = replace(old, strokes=old.strokes.extended(new.strokes))
            outline_of(whole)
            return state.with_node(whole)
    taken = [part for part in alike if _lies_within(part, new)]
    if not taken:
        return state.with_node(new)
    strokes = new.strokes
    for old in taken:
        strokes = strokes.extended(old.strokes)
    whole = replace(taken[0], strokes=strokes, sheet=new.sheet)
    outline_of(whole)
    rest = taken[1:]
    return replace(state, nodes=_without(state.nodes, rest)).with_node(whole)


def _without(nodes: tuple[Part | Group, ...], gone: list[Part]) -> tuple[Part | Group, ...]:
    ids = {node.id for node in gone}
    return tuple(node for node in nodes if node.id not in ids)


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
    for part in reversed(state.parts):
        path = part.sheet.from_pixels(eraser.points, eraser.camera)
        if isinstance(part, Cut) or not np.isfinite(path).all():
            continue
        inside = [surrounds(outline_of(part), point[None]) for point in path[:: len(path) // 8 + 1]]
        if np.mean(inside) >= 0.5:
            return replace(state, nodes=_without(state.nodes, [part]))
    raise UserError("There is no part under the eraser. Rub across the part to take it away.")
