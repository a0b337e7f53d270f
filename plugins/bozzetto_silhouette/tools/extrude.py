"""Extrusions: a ring on the surface, then the outline of what grows out of it, or into it.

After Teddy (Igarashi et al., 1999, section 4.3), but what grows is a part of its own: it can
be moved, redrawn and blended like any other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import Unfinished, UserError
from bozzetto.ink import Stroke, Strokes, close_stroke, is_closed_gesture, resample
from bozzetto.plugin import Context, Gesture, Ink, override
from bozzetto.scene import Scene
from bozzetto.view import Camera, Rays
from bozzetto_silhouette.model.sketch_plane import Sheet
from bozzetto_silhouette.model.state import Part, SilhouetteState
from bozzetto_silhouette.outline.from_ink import outline_of, points_on_sheet
from bozzetto_silhouette.tools.erasing_tool import ErasingTool
from bozzetto_silhouette.tools.insert_node import (
    NOTHING,
    check_that_it_carves,
    insert_node,
    volume_left,
)
from bozzetto_silhouette.tools.through_preview import parts_at, trace_of
from bozzetto_silhouette.view.picking import Touch, shape_seen

RING_SAMPLES = 64

ON_SHAPE = 0.6
"""Share of the ring that must lie on the shape."""

SIDEWAYS = 0.3
"""Sine of the angle between the line of sight and what stands upright on the ring, below
which it cannot be seen how far something grows."""

NEAR = 0.5
"""How far from the ring the second stroke may start and end, in widths of the ring."""

NARROWEST = 0.2
"""Least width of the second stroke at its base, in widths of the ring."""

FLATTEST = 0.1
"""Least distance that the second stroke goes away from its base, in widths of that."""

ROOT = 0.5
"""How far what grows reaches back into the shape, as a share of its width; but never more
than this share of the way to the other side."""

ROOT_STEPS = 24

INFLATIONS = (0.2, 3.0)
"""Range of a part's inflation."""


@dataclass(frozen=True, eq=False)
class _Base:
    """The ring on the surface, in the model's frame, mm.

    Attributes
    ----------
    points : (n, 3) float array
    middle : (3,) float array
    outwards : (3,) float array
        Unit; the mean normal.
    room : float
        How far the shape goes on behind it.
    parts : tuple of Part
        What it lies on.
    """

    points: Array
    middle: Array
    outwards: Array
    room: float
    parts: tuple[Part, ...]


class Extrude(ErasingTool):
    """Two strokes: where something grows, and what grows there."""

    id = "extrude"
    title = "Extrude"
    icon = "icons/extrude.svg"
    hint = "Draw a ring on the shape, then the outline of what grows out of it or into it."

    @override
    def preview(self, state: SilhouetteState, gesture: Gesture, context: Context) -> Scene:
        """Show the ring on the surface, and the shape that the second stroke inflates to so far."""
        from bozzetto_silhouette.inflation.live_preview import inflated_scene

        if not isinstance(gesture, Ink):
            return Scene()
        ring, *more = gesture.strokes
        touch = shape_seen(state)
        if touch is None:
            return Scene()
        shown = trace_of(touch, _loop(ring), ring.camera).scene(through=False)
        if not more:
            return shown
        strokes, sheet = _drawn_so_far(state, _base(state, ring), more[0])
        return shown + inflated_scene(np.concatenate(points_on_sheet(strokes, sheet)), sheet)

    @override
    def draw(self, state: SilhouetteState, ink: Ink, context: Context) -> SilhouetteState:
        """Add what grows, or carve what is pressed in.

        Raises
        ------
        Unfinished
            After the ring.
        UserError
            If the ring is not on the shape, the second stroke does not start and end at it,
            or it cannot be seen from here how far it grows.
        """
        base = _base(state, ink.strokes[0])
        if len(ink.strokes) == 1:
            raise (UserError if ink.committed else Unfinished)(
                "Turn the view if you like, then draw the outline of what grows out of it."
            )
        if len(ink.strokes) > 2:
            raise UserError("Two strokes make an extrusion: the ring, and what grows out of it.")
        part = _grown(state, base, ink.strokes[1])
        outline_of(part)
        after = state.with_node(part)
        if part.operation == "carve":
            check_that_it_carves(state, after)
        elif volume_left(after) <= (1.0 + NOTHING) * volume_left(state):
            raise UserError("This lies inside the shape. Draw it outwards from the ring.")
        return insert_node(state, part, base.parts)


def _base(state: SilhouetteState, stroke: Stroke) -> _Base:
    touch = shape_seen(state)
    if touch is None:
        raise UserError("There is nothing to grow from yet. Draw a shape first.")
    if not is_closed_gesture(stroke.points):
        raise UserError("The first stroke is a ring. Draw it closed, on the shape.")
    hits = touch.under(_loop(stroke), stroke.camera)
    if hits.hit.mean() < ON_SHAPE:
        raise UserError("The ring lies beside the shape. Draw it where something is to grow.")
    points = hits.points[hits.hit]
    middle = points.mean(axis=0)
    normal = hits.normals[hits.hit].mean(axis=0)
    length = float(np.linalg.norm(normal))
    outwards = normal / length if length > 1e-6 else -stroke.camera.axes[2]
    room = _room(touch, points, middle, outwards)
    return _Base(points, middle, outwards, room, tuple(parts_at(state, touch, points)))


def _loop(stroke: Stroke) -> Array:
    """Return a ring as it was drawn, closed, in pixels."""
    return resample(close_stroke(stroke.points), count=RING_SAMPLES, closed=True)


def _room(touch: Touch, points: Array, middle: Array, outwards: Array) -> float:
    """Measure how far the shape goes on inwards from the middle of the ring."""
    depth = (points - middle) @ outwards
    start = middle + (depth.min() - 1e-3 * np.ptp(points, axis=0).max()) * outwards
    found = touch.hits(Rays(start[None], -outwards[None]))
    return float(found.distance[0])


def _facing(base: _Base, camera: Camera) -> Sheet:
    """Return the plane parallel to the screen through the base."""
    right, up, _ = camera.axes
    return Sheet(_point(base.middle), _point(right), _point(up))


def _drawn_so_far(
    state: SilhouetteState, base: _Base, stroke: Stroke
) -> tuple[Sequence[Stroke], Sheet]:
    """Return the outline of what grows, with its root as soon as the stroke has come back."""
    try:
        part = _grown(state, base, stroke)
    except UserError:
        return (stroke,), _facing(base, stroke.camera)
    return tuple(part.strokes), part.sheet


def _grown(state: SilhouetteState, base: _Base, stroke: Stroke) -> Part:
    """Return the part that the second stroke describes, on the plane parallel to the screen."""
    camera = stroke.camera
    right, up, _ = camera.axes
    sheet = _facing(base, camera)
    (line,) = points_on_sheet((stroke,), sheet)
    seen, _ = camera.project(base.points)
    ring = sheet.from_pixels(seen, camera)
    upright = np.array([base.outwards @ right, base.outwards @ up])
    if not np.isfinite(ring).all() or np.hypot(*upright) < SIDEWAYS:
        raise UserError(
            "From here the ring is seen face on. Draw the ring, turn the view to its side, then "
            "draw what grows."
        )
    upright /= np.hypot(*upright)
    across = ring @ (-upright[1], upright[0])
    width = float(np.ptp(across))
    _check_ends(line, ring, width)
    middle, chord = 0.5 * (line[0] + line[-1]), float(np.hypot(*(line[-1] - line[0])))
    reach = (line - middle) @ upright
    if np.abs(reach).max() < FLATTEST * chord:
        raise UserError("This line goes neither out nor in. Draw it away from the ring and back.")
    inwards = float(reach.mean()) < 0.0
    if inwards:
        rise = float(((ring - middle) @ upright).max())
        root = (max(rise, 0.0) + ROOT * chord) * upright
    else:
        root = -ROOT * min(chord, base.room) * upright
    deep = float(np.ptp((base.points - base.middle) @ sheet.normal))
    plain = Part()
    return Part(
        id=state.unused_id(),
        name=state.unused_name("Dent" if inwards else "Extrusion"),
        strokes=Strokes((stroke, _root_stroke(line, middle, root, sheet, camera))),
        sheet=sheet,
        operation="carve" if inwards else plain.operation,
        inflation=float(np.clip(deep / chord, *INFLATIONS)),
    )


def _check_ends(line: Array, ring: Array, width: float) -> None:
    from shapely import MultiPoint, Point

    hull = MultiPoint(ring).convex_hull
    if max(hull.distance(Point(end)) for end in (line[0], line[-1])) > NEAR * width:
        raise UserError(
            "This does not start and end at the ring. Begin on one side of the ring and come "
            "back to its other side."
        )
    if not float(np.hypot(*(line[-1] - line[0]))) > NARROWEST * width:
        raise UserError(
            "This starts and ends at one place. Begin on one side of the ring and come back to "
            "its other side."
        )


def _root_stroke(line: Array, middle: Array, root: Array, sheet: Sheet, camera: Camera) -> Stroke:
    """Return half an ellipse from the end of a line to its start, as far as `root` beyond."""
    angle = np.linspace(0.0, np.pi, ROOT_STEPS + 1)
    places = middle + np.outer(np.cos(angle), line[-1] - middle) + np.outer(np.sin(angle), root)
    pixels, _ = camera.project(sheet.to_world(places))
    return Stroke(pixels[:, 0], pixels[:, 1], camera, tool="imported")


def _point(values: Array) -> tuple[float, float, float]:
    x, y, z = (float(v) for v in values)
    return x, y, z
