"""Draw outlines: each is a part, or a hole in one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import Unfinished, UserError
from bozzetto.ink import Stroke, Strokes
from bozzetto.plugin import Context, Gesture, Ink, NextStep, Tap, override
from bozzetto.scene import Scene
from bozzetto_silhouette.appearance.paint_layer import paint_in_part
from bozzetto_silhouette.model.sketch_plane import FRONT_TOLERANCE, sheet_under
from bozzetto_silhouette.model.state import Edit, Part, Removal, SilhouetteState
from bozzetto_silhouette.outline.from_ink import outline_of, points_on_sheet, rings_of, surrounds
from bozzetto_silhouette.solids.placements import (
    carried,
    outlined_parts,
    placement_of,
    stroke_in,
)
from bozzetto_silhouette.tools.animate import PLAY, Animate
from bozzetto_silhouette.tools.attachment import floating_part, offer_to_attach
from bozzetto_silhouette.tools.erase import without
from bozzetto_silhouette.tools.erasing_tool import ErasingTool
from bozzetto_silhouette.tools.hole_filling import FILL, part_drawn_around
from bozzetto_silhouette.tools.plane_preview import plane_scene
from bozzetto_silhouette.tools.reflection import reflected, reflected_scene, reflection_of
from bozzetto_silhouette.tools.through_preview import trace_through

OPEN_GAP = 0.2
"""Gap between the ends of an outline, as a part of its diagonal, up to which a stroke counts
as meant to be closed."""


DOT = 6.0
"""Size in pixels below which ink is a touch of the pen, and no outline."""


class DrawOutline(ErasingTool):
    """One closed outline makes a part; drawn inside a part on its sheet, a hole in it."""

    id = "draw"
    title = "Draw outline"
    icon = "icons/draw.svg"
    hint = "Draw a closed outline; inside a shape it becomes a hole."
    hovers = True

    @override
    def preview(self, state: SilhouetteState, gesture: Gesture, context: Context) -> Scene:
        """Show what comes of the ink so far: a shape, or a hole; before, where a part would lie."""
        from bozzetto_silhouette.inflation.live_preview import inflated_scene

        if isinstance(gesture, Tap):
            if not state.nodes and not context.scene.layers:
                return Scene()
            return plane_scene(gesture.x, gesture.y, gesture.camera, context)
        if not isinstance(gesture, Ink):
            return Scene()
        sheet = sheet_under(gesture.strokes[0], context)
        points = np.concatenate([sheet.from_pixels(s.points, s.camera) for s in gesture.strokes])
        if not np.isfinite(points).all():
            return Scene()
        new = Part(id="", name="", strokes=Strokes(gesture.strokes), sheet=sheet)
        old, inner = _owner_of(state, new), []
        trace = None if old is None else trace_through(state, gesture.strokes, sheet)
        if old is None:
            inner = _rings_within(state, new, points)
        scene = inflated_scene(points, sheet, inner) if trace is None else trace.scene(through=True)
        return reflected_scene(scene, reflection_of(sheet, context)) if state.mirrored else scene

    @override
    def next_step(self, state: SilhouetteState) -> NextStep:
        """Return the hint, or what to do with a loose part, a pierced one or a motion."""
        part = floating_part(state)
        if part is None:
            pierced = part_drawn_around(state)
            if pierced is None:
                if state.keys and not state.posing:
                    return NextStep(PLAY, tool=Animate.id, panel=True)
                return super().next_step(state)
            return NextStep(
                f"“{pierced.name}” has what it was drawn around as its hole. {FILL.title} "
                f"({FILL.key}) makes each a body."
            )
        return NextStep(offer_to_attach(part))

    @override
    def draw(self, state: SilhouetteState, ink: Ink, context: Context) -> SilhouetteState:
        """Add a part or a hole.

        Raises
        ------
        Unfinished
            If the ends are far apart and more strokes may come.
        UserError
            If the ink crosses itself, or is too little to be an outline.
        """
        if not ink.committed and not meets_itself(ink.strokes):
            raise Unfinished("Go on with the outline, or press Enter to close it.")
        part = Part(
            id=state.unused_id(),
            name=state.unused_name("Part"),
            strokes=Strokes(ink.strokes),
            sheet=sheet_under(ink.strokes[0], context),
        )
        if is_dot(ink.strokes):
            raise UserError("This is a dot. Draw around a shape; a longer line will do.")
        outline_of(part)
        nested = _nested(state, part)
        return reflected(state, nested, part, context) if state.mirrored else nested


def is_dot(strokes: tuple[Stroke, ...]) -> bool:
    """Whether all strokes together are no larger than where a pen was set down."""
    points = np.concatenate([stroke.points for stroke in strokes])
    return bool(np.ptp(points, axis=0).max() < DOT)


def meets_itself(strokes: tuple[Stroke, ...]) -> bool:
    """Whether the chain of strokes comes back to where it began."""
    first, last = strokes[0].points, strokes[-1].points
    points = np.concatenate([stroke.points for stroke in strokes])
    diagonal = float(np.hypot(*np.ptp(points, axis=0)))
    gap = float(np.hypot(*(last[-1] - first[0])))
    return len(points) > 2 and gap <= OPEN_GAP * diagonal


def _nested(state: SilhouetteState, new: Part) -> SilhouetteState:
    """Add a new part to the state.

    Inside another one on a parallel sheet it is a hole; it takes in those that it is drawn
    around as its holes, unless these overlap each other; anywhere else it stands for itself.
    Parts are where they have been moved to; those that are switched off have no say.
    """
    old = _owner_of(state, new)
    if old is not None:
        whole = replace(old, strokes=old.strokes.extended(_carried_in(state, old, new)))
        outline_of(whole)
        return state.with_node(whole)
    taken = [part for part in _alike(state, new) if _lies_within(_as_seen(state, part), new)]
    if not taken:
        return state.with_node(new)
    whole = _taken_in(state, taken, new)
    try:
        outline_of(whole)
    except UserError:  # parts that overlap each other are no holes
        return state.with_node(new)
    return without(state, {part.id for part in taken[1:]}).with_node(whole)


def _alike(state: SilhouetteState, new: Part) -> list[Part]:
    """Return the parts on sheets that are parallel to that of a new one; none if all stay apart."""
    if state.inner == "apart":
        return []
    return [part for part in outlined_parts(state) if _faces_as(state, part, new)]


def _owner_of(state: SilhouetteState, new: Part) -> Part | None:
    """Return the part inside whose outline a new one lies, and so becomes a hole of it."""
    alike = _alike(state, new)
    points = np.concatenate(points_on_sheet(new.strokes, new.sheet)) if alike else np.zeros((0, 2))
    for old in alike:
        if old.sheet == new.sheet and carried(state, old).is_identity:
            inside = _surrounds(old, points)  # as it lies: most parts share one sheet
        else:
            inside = _lies_within(_carried_in(state, old, new), old)
        if inside:
            return old
    return None


def _carried_in(state: SilhouetteState, old: Part, new: Part) -> tuple[Stroke, ...]:
    """Return the ink of a new part in the frame of another one."""
    return tuple(stroke_in(state, old, stroke) for stroke in new.strokes)


def _rings_within(state: SilhouetteState, new: Part, points: Array) -> list[Array]:
    """Return the outer rings (k, 2), on its sheet, of what a line is drawn around so far."""
    import shapely

    if len(points) < 3 or not (alike := _alike(state, new)):
        return []
    around = shapely.buffer(shapely.Polygon(points), 0.0)
    shapely.prepare(around)
    sheet, found = new.sheet, []
    for part in alike:
        try:
            outline = outline_of(part)
        except UserError:  # it stays as it is whatever is drawn
            continue
        there = placement_of(state, part)
        for number in outline.outers:
            ring = outline.rings[number]
            away = there.points(np.column_stack((ring, np.zeros(len(ring))))) - sheet.origin
            seen = np.column_stack((away @ sheet.right, away @ sheet.up))
            if shapely.contains_xy(around, seen[:, 0], seen[:, 1]).all():
                found.append(seen)
    return found


def _faces_as(state: SilhouetteState, part: Part, new: Part) -> bool:
    """Whether a part, as it stands now, lies parallel to a new one and faces the same way."""
    normal = carried(state, part).directions(part.sheet.normal)[0]
    return bool(normal @ new.sheet.normal > 1.0 - FRONT_TOLERANCE)


def _as_seen(state: SilhouetteState, part: Part) -> tuple[Stroke, ...]:
    """Return a part's ink where the part stands now."""
    moved = carried(state, part)
    return tuple(s if moved.is_identity else s.moved(moved) for s in part.strokes)


def _taken_in(state: SilhouetteState, taken: list[Part], new: Part) -> Part:
    """Return the first of some parts with an outline around them; they all become its holes.

    The rings keep their order, so that edits find theirs again.
    """
    first = taken[0]
    strokes, edits, paint = first.strokes, first.edits, first.paint_strokes
    count = len(rings_of(first))
    for other in taken[1:]:
        back = tuple(stroke_in(state, first, stroke) for stroke in _as_seen(state, other))
        strokes = strokes.extended(back)
        edits = (*edits, *(_renumbered(state, first, other, edit, count) for edit in other.edits))
        paint = (*paint, *paint_in_part(state, first, other))
        count += len(rings_of(other))
    around = tuple(stroke_in(state, first, stroke) for stroke in new.strokes)
    return replace(first, strokes=strokes.extended(around), edits=edits, paint_strokes=paint)


def _renumbered(state: SilhouetteState, first: Part, other: Part, edit: Edit, count: int) -> Edit:
    """Turn an edit of one part into an edit of another, whose own rings come first."""
    if isinstance(edit, Removal):
        return replace(edit, ring=edit.ring + count)
    moved = carried(state, other)
    stroke = stroke_in(state, first, edit.stroke.moved(moved))
    return replace(edit, stroke=stroke, ring=edit.ring + count)


def _lies_within(strokes: Sequence[Stroke], outer: Part) -> bool:
    """Whether all of some ink lies inside the outline of a part, in whose frame it is."""
    try:
        points = points_on_sheet(strokes, outer.sheet)
    except UserError:
        return False
    return _surrounds(outer, np.concatenate(points))


def _surrounds(outer: Part, points: Array) -> bool:
    """Whether all points (n, 2) on a part's sheet lie inside its outline."""
    try:
        outline = outline_of(outer)
    except UserError:
        return False
    low = np.min([ring.min(axis=0) for ring in outline.rings], axis=0)
    high = np.max([ring.max(axis=0) for ring in outline.rings], axis=0)
    within = bool((points >= low).all() and (points <= high).all())
    return within and surrounds(outline, points)
