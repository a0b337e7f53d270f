"""Outlines laid on surfaces: from ink, from points, and from flat drawings."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags, cross_product
from bozzetto.errors import UserError
from bozzetto.geometry import Mesh, Spline
from bozzetto.ink import (
    Stroke,
    close_stroke,
    distances_to_polyline,
    fit_spline,
    is_closed_gesture,
    merge_strokes,
    resample,
)
from bozzetto.scene import Layer, Scene, Shaded, cast_rays
from bozzetto.view import Camera, Rays
from bozzetto_product.details.floor_places import LaidFloor, without_floors
from bozzetto_product.details.ground import Ground, kept_places, located
from bozzetto_product.details.shell import Shell, face_meshes
from bozzetto_product.model.details import OutlinePlaces

CONTROLS: Final = (6, 8, 12, 18, 26, 40)
"""Control points of a stretch of ink, fewest first."""

CLOSE: Final = 0.9
"""Root mean square distance from the ink, px, that needs no more control points."""

PER_STRETCH: Final = 64
"""Places kept of a smooth stretch of ink."""

CORNER: Final = np.radians(42.0)
"""Turn of ink within a short way that makes a corner."""

GATHERED: Final = 0.72
"""Share of the turn over twice the way that a corner has within the way: an arc has half."""

WAY: Final = 0.035
"""The way within which ink turns at a corner, as share of the length of the outline."""

LEAST_WAY: Final = 6.0
"""The same at least, px."""

SHARP: Final = np.radians(14.0)
"""Turn between sides of a polygon that makes a corner."""

ON: Final = 0.05
"""Distance from the surfaces, as share of their size, at which a point does not lie on them."""

OVER: Final = 0.08
"""Distance between rounds, as share of their size, within which one was drawn over the other."""

MIXED: Final = (
    "Some of these lines are open. Draw closed rounds, or one line from border to border."
)
BESIDE: Final = "The outline leaves the surfaces. Draw it where there is a surface under all of it."
HANGING: Final = "A part of it is beside the surfaces. Make it smaller, or move it."
SMALL: Final = "This is too small for an outline. Draw a larger round on a surface."
NO_SURFACE: Final = (
    "There is no surface to draw a detail on. Draw curves first until they enclose an area."
)


def places_of_ink(
    strokes: Sequence[Stroke],
    grounds: Sequence[Ground],
    shells: Sequence[Shell] = (),
    floors: Sequence[LaidFloor] = (),
) -> tuple[OutlinePlaces, bool]:
    """Return where ink lies on surfaces, and whether it is closed.

    Ink on a floor is kept where that is the offset of the surface.

    Parameters
    ----------
    strokes : sequence of Stroke
        In one view; over one another they are one outline.
    grounds : sequence of Ground
        The surfaces without details.
    shells : sequence of Shell
        The same with details, which are seen.
    floors : sequence of LaidFloor
        Those of the details.

    Raises
    ------
    UserError
        If there is no surface, or none under a part of the ink.
    """
    if not grounds:
        raise UserError(NO_SURFACE)
    rows, corners = [], []
    lines = [_one_line(group) for group in _groups(strokes)]
    closed = all(ring for _, ring in lines)
    if not closed and len(lines) > 1:
        raise UserError(MIXED)
    for points, _ in lines:
        pixels, marks = smoothed(points, closed=closed)
        rows.append(seen_places(pixels, strokes[0].camera, grounds, shells, floors))
        corners.append(marks)
    starts = np.cumsum([0, *(len(row) for row in rows[:-1])]).tolist()
    return kept_places(grounds, np.concatenate(rows), np.concatenate(corners), starts), closed


def _groups(strokes: Sequence[Stroke]) -> list[list[Stroke]]:
    """Return strokes that make one outline each: rounds that lie apart are several."""
    rounds = [s for s in strokes if len(s.points) > 1 and is_closed_gesture(s.points)]
    if len(rounds) < len(strokes):
        return [list(strokes)]
    groups: list[list[Stroke]] = []
    for stroke in strokes:
        for group in groups:
            other = np.asarray(group[0].points, float)
            size = float(np.linalg.norm(np.ptp(other, axis=0)))
            gaps = distances_to_polyline(np.asarray(stroke.points, float), other)
            if float(np.median(gaps)) <= OVER * size:
                group.append(stroke)
                break
        else:
            groups.append([stroke])
    return groups


def _one_line(strokes: Sequence[Stroke]) -> tuple[Array, bool]:
    """Return the points of strokes as one line, and whether it is closed."""
    rows = [np.asarray(stroke.points, float) for stroke in strokes]
    rows = [row for row in rows if len(row) > 1 and np.ptp(row, axis=0).max() > 0.0]
    if not rows:
        raise UserError(SMALL)
    if len(rows) == 1:
        closed = bool(is_closed_gesture(rows[0]))
        return (np.asarray(close_stroke(rows[0])) if closed else rows[0]), closed
    merged = merge_strokes(rows)
    return np.asarray(merged.points), bool(merged.closed or is_closed_gesture(merged.points))


def smoothed(points: Array, *, closed: bool) -> tuple[Array, Flags]:
    """Return a line without the tremor of the hand, and which of its points are corners.

    Parameters
    ----------
    points : (n, 2) float
        px.
    closed : bool
        Whether the last is followed by the first.

    Returns
    -------
    points : (m, 2) float
        px; of a closed line the first is not repeated.
    corners : (m,) bool
    """
    line = np.vstack((points, points[:1])) if closed else points
    length = float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum())
    if length < 4.0 * LEAST_WAY:
        raise UserError(SMALL)
    step = min(2.0, length / 200.0)
    even = np.asarray(resample(line, spacing=step))
    if closed:
        even = even[:-1]
    marks = _corners(even, max(LEAST_WAY, WAY * length) / step, closed=closed)
    if closed and not marks:
        spline = _fitted(even, closed=True)
        at = np.linspace(*spline.range, 2 * PER_STRETCH + 1)[:-1]
        return spline.value(at), np.zeros(len(at), bool)
    return _stretches(even, marks, closed=closed)


def _stretches(even: Array, marks: list[int], *, closed: bool) -> tuple[Array, Flags]:
    if closed:
        even = np.roll(even, -marks[0], axis=0)
        breaks = [mark - marks[0] for mark in marks] + [len(even)]
        even = np.vstack((even, even[:1]))
    else:
        breaks = [0, *marks, len(even) - 1]
    rows = []
    for a, b in itertools.pairwise(breaks):
        spline = _fitted(even[a : b + 1], closed=False)
        rows.append(spline.value(np.linspace(*spline.range, PER_STRETCH + 1)))
    for before, after in zip(rows, rows[1:] + (rows[:1] if closed else []), strict=closed):
        before[-1] = after[0] = 0.5 * (before[-1] + after[0])
    points = np.concatenate([row[:-1] for row in rows] + ([] if closed else [rows[-1][-1:]]))
    corners = np.zeros(len(points), bool)
    corners[np.arange(len(rows)) * PER_STRETCH] = True
    if not closed:
        corners[0] = False
    return points, corners


def _fitted(points: Array, *, closed: bool) -> Spline:
    """Return the spline of fewest control points that is near enough to points, px."""
    for controls in CONTROLS:
        if controls + 2 > len(points):
            break
        fit = fit_spline(points, controls=controls, closed=closed)
        if fit.rms <= CLOSE:
            break
    else:
        return fit.spline
    return fit.spline


def _corners(even: Array, way: float, *, closed: bool) -> list[int]:
    """Return the numbers of points at which a line turns within a short way."""
    reach = max(2, round(way))
    count = len(even)
    if count < 4 * reach:
        return []
    short, long = (_turns(even, k, closed=closed) for k in (reach, 2 * reach))
    marks = np.flatnonzero((short > CORNER) & (short > GATHERED * long))
    if closed and _is_slip(even, reach):
        marks = marks[np.minimum(marks, count - marks) > reach]
    found: list[int] = []
    for mark in sorted(marks.tolist(), key=lambda k: -short[k]):
        gaps = [abs(mark - other) for other in found]
        if closed:
            gaps = [min(gap, count - gap) for gap in gaps]
        if all(gap > 2 * reach for gap in gaps) and (closed or reach <= mark < count - reach):
            found.append(mark)
    return sorted(found)


def _is_slip(even: Array, reach: int) -> bool:
    """Whether a round goes on where it began but for a step aside: a hand does not meet its start.

    Its direction is looked at before and after what lies within the reach of the first point, where
    a corner turns it by more than the curve does between these places.
    """
    into, out = even[-reach] - even[-2 * reach], even[2 * reach] - even[reach]
    turn = abs(np.arctan2(into[0] * out[1] - into[1] * out[0], into @ out))
    return bool(turn - 3.0 * reach * 2.0 * np.pi / len(even) < 0.5 * CORNER)


def _turns(even: Array, reach: int, *, closed: bool) -> Array:
    """Return the turn at each point between the ways to and from it, radians, (n,)."""
    if closed:
        before, after = np.roll(even, reach, axis=0), np.roll(even, -reach, axis=0)
    else:
        number = np.arange(len(even))
        before = even[np.maximum(number - reach, 0)]
        after = even[np.minimum(number + reach, len(even) - 1)]
    into, out = even - before, after - even
    cross = into[:, 0] * out[:, 1] - into[:, 1] * out[:, 0]
    return np.asarray(np.abs(np.arctan2(cross, (into * out).sum(axis=1))))


def seen_places(
    pixels: Array,
    camera: Camera,
    grounds: Sequence[Ground],
    shells: Sequence[Shell] = (),
    floors: Sequence[LaidFloor] = (),
    beside: str = BESIDE,
) -> Array:
    """Return the places of surfaces without details at pixels, (n, 3) mm.

    Where a floor is seen it is the place that the floor is the offset of.

    Parameters
    ----------
    pixels : (n, 2) float
        px.
    camera : Camera
        Of the sheet.
    grounds, shells, floors : sequence of Ground, Shell, LaidFloor
        See `places_of_ink`.
    beside : str
        What to say where there is no surface.

    Raises
    ------
    UserError
        If there is no surface at a pixel.
    """
    rays = camera.rays(pixels)
    hits = cast_rays(_scene_of([ground.fill.mesh for ground in grounds]), rays)
    points = np.array(hits.points, float)
    there = np.array(hits.hit)
    if floors:
        meshes = [mesh for shell in shells for mesh in face_meshes(shell)]
        owners = [owner for shell in shells for owner in shell.owners]
        seen = cast_rays(_scene_of(meshes), rays)
        for number, surface in enumerate(seen.surfaces):
            if owners[surface.number].floor is not None:
                rows = seen.hit & (seen.on == number)
                points[rows], there[rows] = seen.points[rows], True
    if not there.all():
        raise UserError(beside)
    return without_floors(floors, points)


def _scene_of(meshes: Sequence[Mesh]) -> Scene:
    return Scene((Layer("surfaces", tuple(map(Shaded, meshes))),))


def places_of_points(
    rows: Sequence[Array], corners: Sequence[Flags], grounds: Sequence[Ground], name: str
) -> OutlinePlaces:
    """Return where outlines that are given by points in space lie on surfaces.

    Parameters
    ----------
    rows : sequence of (n, 3) float
        mm.
    corners : sequence of (n,) bool
        Which of them are corners.
    grounds : sequence of Ground
        What they lie on.
    name : str
        Of the detail, for messages.

    Raises
    ------
    UserError
        If a point is far from all surfaces.
    """
    if not grounds:
        raise UserError(NO_SURFACE)
    points = np.concatenate(rows)
    starts = np.cumsum([0, *(len(row) for row in rows[:-1])]).tolist()
    kept = kept_places(grounds, points, np.concatenate(corners), starts)
    boxes = np.array([ground.fill.mesh.bounds for ground in grounds], float)
    size = float(np.linalg.norm(boxes[:, 1].max(axis=0) - boxes[:, 0].min(axis=0)))
    off = float(np.linalg.norm(kept.points - points, axis=1).max())
    if off > ON * size:
        raise UserError(
            f"A point of the detail “{name}” is {off:.3g} mm from the surfaces. Give points that "
            "lie on them."
        )
    return kept


def laid_flat(
    rows: Sequence[Array],
    at: Array,
    up: Array,
    width: float,
    grounds: Sequence[Ground],
    turn: float = 0.0,
) -> list[Array]:
    """Return flat outlines on the tangent plane at a place, let down on to the surface.

    Parameters
    ----------
    rows : sequence of (n, 2) float
        In any unit, y up.
    at : (3,) float
        Where the middle of the outlines comes to lie, mm.
    up : (3,) float
        Where their y axis points, as far as the surface lets it.
    width : float
        Of all outlines together, mm.
    grounds : sequence of Ground
        What they are laid on.
    turn : float
        By which they are turned then, counter-clockwise, radians.

    Returns
    -------
    list of (n, 3) float
        mm.

    Raises
    ------
    UserError
        If a part of them is not over the surface.
    """
    if not grounds:
        raise UserError(NO_SURFACE)
    above = np.concatenate(placed_flat(rows, at, up, width, grounds, turn))
    _, (*_, normal) = tangent_axes(at, up, grounds)
    scene = _scene_of([ground.fill.mesh for ground in grounds])
    start = above + 0.5 * width * normal
    hits = cast_rays(scene, Rays(start, np.broadcast_to(-normal, start.shape)))
    if not hits.hit.all():
        raise UserError(HANGING)
    found = np.asarray(hits.points, float)
    return np.split(found, np.cumsum([len(row) for row in rows])[:-1].tolist())


def placed_flat(
    rows: Sequence[Array],
    at: Array,
    up: Array,
    width: float,
    grounds: Sequence[Ground],
    turn: float = 0.0,
) -> list[Array]:
    """Return flat outlines on the tangent plane at a place, (n, 3) mm each; see `laid_flat`."""
    middle, (x, y, _) = tangent_axes(at, up, grounds)
    x, y = np.cos(turn) * x + np.sin(turn) * y, np.cos(turn) * y - np.sin(turn) * x
    every = np.concatenate(rows)
    low, high = every.min(axis=0), every.max(axis=0)
    scale = width / float(high[0] - low[0])
    flat = [scale * (row - 0.5 * (low + high)) for row in rows]
    return [middle + row[:, :1] * x + row[:, 1:] * y for row in flat]


def tangent_axes(at: Array, up: Array, grounds: Sequence[Ground]) -> tuple[Array, Array]:
    """Return the nearest place of surfaces, (3,) mm, and axes there: x, y near up, normal."""
    place = located(grounds, at[None])
    normal, middle = place.normals[0], place.points[0]
    y = up - (up @ normal) * normal
    if np.linalg.norm(y) < 1e-6 * np.linalg.norm(up):
        y = cross_product(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
    y = y / np.linalg.norm(y)
    return middle, np.stack((cross_product(y, normal), y, normal))


def corners_on(grounds: Sequence[Ground], row: Array) -> Flags:
    """Return which points of a closed polygon on surfaces, (n, 3), are corners.

    What goes over an edge of the surfaces turns with them; whether it has a corner there is seen
    when the sides before and behind the edge are laid in one plane.
    """
    marks = polygon_corners(row)
    if not grounds or not marks.any():
        return marks
    here = located(grounds, row).normals
    there = np.roll(here, -1, axis=0)
    into = row - np.roll(row, 1, axis=0)
    behind = np.roll(row, -2, axis=0) - np.roll(row, -1, axis=0)
    # The least rotation from one normal to the other (Rodrigues), the other way round.
    axis, cosine = cross_product(there, here), (here * there).sum(axis=1)[:, None]
    turned = cosine * behind + cross_product(axis, behind)
    turned += axis * (axis * behind).sum(axis=1)[:, None] / (1.0 + np.maximum(cosine, -0.99))
    lengths = np.linalg.norm(into, axis=1) * np.linalg.norm(turned, axis=1)
    straight = (into * turned).sum(axis=1) > np.cos(CORNER) * lengths
    over = (cosine[:, 0] < np.cos(SHARP)) & straight
    return np.asarray(marks & ~(over | np.roll(over, 1)))


def polygon_corners(row: Array) -> Flags:
    """Return which points of a closed polygon, (n, d), are corners and not steps of a curve."""
    into = row - np.roll(row, 1, axis=0)
    out = np.roll(row, -1, axis=0) - row
    lengths = np.linalg.norm(into, axis=1) * np.linalg.norm(out, axis=1)
    cosine = (into * out).sum(axis=1) / np.where(lengths > 0.0, lengths, 1.0)
    return np.asarray(np.arccos(np.clip(cosine, -1.0, 1.0)) > SHARP)
