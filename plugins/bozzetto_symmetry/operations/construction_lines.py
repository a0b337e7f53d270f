"""Construction lines: straight strokes that get their place in space.

A stroke towards a vanishing point is a line along that axis (Bae, Kijima & Kim 2004 draw in
a box for this reason; Schmidt et al. 2009 call it a scaffold). Its depth comes from what it
touches.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.ink import Stroke, distances_to_polyline
from bozzetto.plugin import Context
from bozzetto.scene import Layer, Lines
from bozzetto.view import Camera, triple
from bozzetto_symmetry.model.axes import AXES, along
from bozzetto_symmetry.model.box_grid import clip_to_box
from bozzetto_symmetry.model.perspective import focal_length, pixel_size, toward_vanishing
from bozzetto_symmetry.model.state import Line, SymmetryState
from bozzetto_symmetry.model.symmetry_plane import Point
from bozzetto_symmetry.operations.snap_targets import Targets, nearest_target

TOWARDS: Final = np.radians(6.0)
"""Angle between a stroke and the direction of a vanishing point, up to which it is meant to
go there."""

STRAIGHT: Final = 0.15
"""How far a stroke may leave its chord, as a share of the chord."""

SHORTEST: Final = 12.0
"""Least length of a stroke, px: below, the hand gives it no direction."""

REACH: Final = 2.0
"""How near to a known point an end must be, as a multiple of the pen's tolerance. To curves and
edges it is one: there are so many that ends come near them by chance."""

GRAZING: Final = np.sin(np.radians(5.0))
"""Sine of the angle between a plane and the line of sight below which nothing can be drawn
on the plane."""

FARTHEST: Final = 1e7
"""Greatest coordinate of a line's ends, mm."""

LINE_WIDTH: Final = 1.2
"""Width of a construction line, px."""

CHOSEN_WIDTH: Final = 2.0
"""Width of the chosen construction line, px."""


@dataclass(frozen=True)
class Straight:
    """The line in space that a stroke stands for.

    Parameters
    ----------
    begin, end : (x, y, z)
        In the sense of the stroke; in the model's frame, mm.
    axis : int, optional
        Which axis of the box it runs along; None where it runs along none.
    """

    begin: Point
    end: Point
    axis: int | None


POINT, CURVE, SURFACE = 3, 2, 1
"""How much what lies under an end of the stroke counts: a single place, a place along a curve
or an edge, a place of a surface."""


@dataclass(frozen=True, eq=False)
class _Anchor:
    """Anchor under an end of the stroke, and how much it counts."""

    point: Array
    rank: int


def line_of(stroke: Stroke, state: SymmetryState, known: Targets, context: Context) -> Straight:
    """Return the straight line in space that a stroke stands for.

    1. A stroke from one known point (an end, a corner) to another joins them, in any
       direction.
    2. A stroke towards a vanishing point (within 6°) runs along that axis, through the known
       place at its start or its end; else through the visible surface there; else from the
       far wall of the box that its start lies on, seen from inside; beside the box from the
       centre plane. It stops at a known place that it meets in space.
    3. Any other stroke between two known places or places of visible surfaces joins them.
    4. The rest lies in a plane: that of the wall that it is drawn over, moved to its known
       end where there is one.

    Parameters
    ----------
    stroke : Stroke
        A straight stroke.
    state : SymmetryState
        Its box and centre plane.
    known : Targets
        Places that the line can start from or end on.
    context : Context
        Its visible surfaces, and how near counts as touching.

    Raises
    ------
    UserError
        If the stroke is too short or not straight, or would run beyond all bounds.
    """
    ends = _chord(stroke)
    camera = stroke.camera
    first, last = (_anchor(pixel, camera, known, context) for pixel in ends)
    if first is not None and last is not None and first.rank == last.rank == POINT:
        return _checked(first.point, last.point)
    axis = axis_of(*ends, camera)
    if axis is not None:
        return _along_axis(axis, ends, (first, last), camera, state, context)
    if first is not None and last is not None:
        return _checked(first.point, last.point)
    return _on_wall(ends, (first, last), camera, state)


def axis_of(begin: Array, end: Array, camera: Camera, within: float = TOWARDS) -> int | None:
    """Return the axis towards or away from whose vanishing point a stroke runs, or None.

    Parameters
    ----------
    begin, end : (2,) float
        px.
    camera : Camera
        In the model's frame.
    within : float
        Greatest angle between them, radians.
    """
    middle, chord = 0.5 * (begin + end), end - begin
    chord = chord / max(float(np.linalg.norm(chord)), 1e-300)
    least, found = float(np.sin(within)), None
    for axis, way in enumerate(AXES):
        toward = toward_vanishing(camera, way, middle) / focal_length(camera)
        length = float(np.linalg.norm(toward))
        if length < GRAZING:
            continue  # it is seen as a point here
        sine = abs(float(toward[0] * chord[1] - toward[1] * chord[0])) / length
        if sine < least:
            least, found = sine, axis
    return found


def line_layer(state: SymmetryState, lines: Sequence[Line]) -> Layer:
    """Return construction lines as they are shown; the chosen one in the accent colour."""
    items = tuple(
        Lines(
            np.array([line.begin, line.end], np.float32),
            color="accent" if line.id == state.selected else "ghost",
            width=CHOSEN_WIDTH if line.id == state.selected else LINE_WIDTH,
        )
        for line in lines
    )
    return Layer("construction lines", items)


def _chord(stroke: Stroke) -> tuple[Array, Array]:
    """Return both ends of a straight stroke, px."""
    points = stroke.points
    begin, end = points[0], points[-1]
    length = float(np.linalg.norm(end - begin))
    reach = float(np.linalg.norm(np.ptp(points, axis=0)))
    if reach < SHORTEST:
        raise UserError("This is too short for a line. Draw it longer.")
    if distances_to_polyline(points, np.stack((begin, end))).max() > STRAIGHT * length:
        raise UserError("A construction line is straight. Draw it in one straight stroke.")
    return begin, end


def _anchor(pixel: Array, camera: Camera, known: Targets, context: Context) -> _Anchor | None:
    place = nearest_target(pixel, camera, known, REACH * context.pen.tolerance)
    if place is not None and place.kind in ("end", "crossing", "corner"):
        return _Anchor(np.asarray(place.point), POINT)
    if place is not None and place.pixels <= context.pen.tolerance:
        return _Anchor(np.asarray(place.point), CURVE)
    hits = context.surface_hit(camera.rays(pixel))
    return _Anchor(hits.points[0], SURFACE) if hits.hit[0] else None


def _along_axis(
    axis: int,
    ends: tuple[Array, Array],
    anchors: Sequence[_Anchor | None],
    camera: Camera,
    state: SymmetryState,
    context: Context,
) -> Straight:
    """Return a line along an axis, through the end that counts most."""
    ranks = [0 if anchor is None else anchor.rank for anchor in anchors]
    held = int(ranks[1] > ranks[0])
    anchor, aim = anchors[held], anchors[1 - held]
    point = _on_far_wall(ends[0], camera, state)[0] if anchor is None else anchor.point
    way = along(camera, ends[1 - held], point, AXES[axis])
    if way is None:
        raise UserError("The line would have no end there. Turn the view, or draw it shorter.")
    if aim is not None:
        offset = aim.point - point
        aside = float(np.linalg.norm(np.delete(offset, axis)))
        if aside <= REACH * context.pen.tolerance * float(pixel_size(camera, aim.point)[0]):
            way = float(offset[axis])
    other = point.copy()
    other[axis] += way
    return _checked(other, point) if held else _checked(point, other)


def _on_wall(
    ends: tuple[Array, Array],
    anchors: Sequence[_Anchor | None],
    camera: Camera,
    state: SymmetryState,
) -> Straight:
    """Return a line in the plane of the wall under the stroke, through an end that is known."""
    place, normal = _on_far_wall(0.5 * (ends[0] + ends[1]), camera, state)
    held = next((anchor for anchor in anchors if anchor is not None), None)
    point = place if held is None else held.point
    first, last = camera.on_plane(ends, point, normal)
    if anchors[0] is not None:
        first = anchors[0].point
    if anchors[1] is not None:
        last = anchors[1].point
    return _checked(first, last)


def _on_far_wall(pixel: Array, camera: Camera, state: SymmetryState) -> tuple[Array, Array]:
    """Return where a line of sight leaves the box, and the normal of that wall.

    Beside the box it is the centre plane, and where that is seen edge-on the plane through
    the middle of the box that faces the eye.
    """
    (origin,), (way,) = camera.rays(pixel)
    _, end, inside = clip_to_box([origin], [way], state.centre, state.size)
    if inside[0] and (end[0] > 0.0 or camera.kind == "orthographic"):
        place = origin + end[0] * way
        share = np.abs(place - state.centre) / np.asarray(state.size)
        return place, AXES[int(np.argmax(share))]
    normal = np.asarray(state.plane.normal)
    if abs(float(way @ normal)) > GRAZING:
        (place,) = camera.on_plane(pixel, state.plane.point, normal)
        if np.isfinite(place).all():
            return place, normal
    facing = AXES[int(np.argmax(np.abs(way)))]
    (place,) = camera.on_plane(pixel, state.centre, facing)
    return place, facing


def _checked(begin: Array, end: Array) -> Straight:
    ends = np.stack((begin, end))
    if not np.isfinite(ends).all() or np.abs(ends).max() > FARTHEST:
        raise UserError("The line would run beyond all bounds. Turn the view, or draw it shorter.")
    runs = np.flatnonzero(begin != end)
    if not len(runs):
        raise UserError("The line begins and ends in one place. Draw it longer.")
    axis = int(runs[0]) if len(runs) == 1 else None
    return Straight(triple(begin), triple(end), axis)
