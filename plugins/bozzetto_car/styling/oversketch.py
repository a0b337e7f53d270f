"""Change styling curves: draw over them, or smooth them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.geometry.patches import Places, foot_points, normals_at, points_at
from bozzetto.ink import arc_length, distances_to_polyline, oversketch_curve, resample, smooth
from bozzetto.view import Camera
from bozzetto_car.body.body import Body
from bozzetto_car.state import StylingCurve
from bozzetto_car.styling.curve import curve_paths, with_paths
from bozzetto_car.styling.curve_fit import Course, courses_on
from bozzetto_car.styling.picking import seen_parts, sight_of
from bozzetto_car.styling.project_on_body import project_line
from bozzetto_car.styling.stroke_line import STEP, smooth_line
from bozzetto_car.styling.surface_path import connect_places, is_closed, join_paths

NODES: Final = 3.0
"""Distance of the nodes of the picture of a curve that is drawn over, px."""

JUMP: Final = 20.0
"""Farthest, mm, that a changed stretch may begin or end from its curve. What is farther lies on
another part of the body in front of it."""

TURNED_AWAY: Final = 60.0
"""Length, mm, of the part at the end of a curve that faces away from the eye and moves with the
end."""

CLOSE: Final = 0.5
"""Distance from the join within which a place of the old curve is left out, per usual step."""

SMOOTHED: Final = 24.0
"""Distance of the places of a smoothed curve, mm."""

FEWEST, MOST = 24, 400
"""Least and greatest number of places of a smoothed curve."""

UNCHANGED: Final = 0.1
"""Distance, px, by which a stroke must bend a curve to change it."""

OFF: Final = (
    "The stroke leads off the body or behind a part of it. Turn the view so that all of it is "
    "seen, then draw over the curve."
)

HALVINGS: Final = 3
"""Times that the distance of places is halved where no way from patch to patch is found."""


def smooth_curve(curve: StylingCurve, body: Body, share: float) -> StylingCurve:
    """Smooth a curve; its ends stay.

    The curve is convolved with a Gaussian in space and goes back to the nearest places of the body.

    Parameters
    ----------
    curve : StylingCurve
        The curve.
    body : Body
        The body that it is on.
    share : float
        Standard deviation of the Gaussian per length of the curve, above 0.

    Raises
    ------
    UserError
        If the body has none of the curve's patches, or the curve would leave it.
    """
    courses = courses_on(curve, body.nets, body.template)
    if not courses:
        raise UserError("The body has no part of this curve. Go back to its template.")
    return with_paths(curve, body, [_smooth(body, course, share) for course in courses])


def _smooth(body: Body, course: Course, share: float) -> Places:
    count = int(np.clip(course.length / SMOOTHED, FEWEST, MOST))
    for _ in range(HALVINGS + 1):
        along = np.linspace(0.0, course.length, count + 1)
        points = smooth(points_at(body.nets, course.places(along)), share * course.length)
        feet = foot_points(body.nets, points)
        ends = course.places(along[[0, -1]])
        whole = join_paths([ends[:1], feet[1:-1], ends[1:]])
        paths = connect_places(body.template, body.nets, whole, normals_at(body.nets, whole))
        if len(paths) == 1:
            return paths[0]
        count *= 2
    raise UserError("The curve cannot be smoothed where it is: draw over it instead.")


# -- drawn over ------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class _Picture:
    """The part of a curve that is seen: lengths along it, mm, and their places in the view, px."""

    number: int
    course: Course
    along: Array
    pixels: Array


def oversketch(curve: StylingCurve, body: Body, stroke: ArrayLike, camera: Camera) -> StylingCurve:
    """Move a curve to where a stroke was drawn over it.

    The picture of the curve gives way to the stroke as a contour that resists bending
    (`bozzetto.ink.oversketch.snake`), so it leaves its old course and returns to it smoothly.
    A stroke that runs on beyond an end moves the end. The changed stretch is projected onto
    the body again.

    Parameters
    ----------
    curve : StylingCurve
        The curve.
    body : Body
        The body that it is on.
    stroke : (n, 2) array_like
        Samples of the stroke, px, along the curve or against it.
    camera : Camera
        The view that the stroke was drawn in.

    Returns
    -------
    StylingCurve
        The same object where the stroke follows the curve as it is.

    Raises
    ------
    UserError
        If the curve is not seen near the stroke, or the stroke leads off the body or behind a
        part of it.
    """
    line = smooth_line(stroke)
    curve, given = begun_away(curve, body, line, camera), curve
    courses = courses_on(curve, body.nets, body.template)
    picture = _picture_near(body, courses, line, camera)
    if picture is None:
        raise UserError("The curve is not seen here. Turn the view, then draw over it.")
    along = arc_length(picture.pixels)
    nodes = resample(picture.pixels, spacing=NODES)
    bent = oversketch_curve(nodes, [(line, np.ones(len(line)))])
    if np.linalg.norm(bent.points - nodes, axis=1).max() < UNCHANGED:
        return given
    moved = np.flatnonzero(bent.moved)
    ends = max(int(moved[0]) - 1, 0), min(int(moved[-1]) + 1, len(nodes) - 1)
    stretch = resample(bent.points[ends[0] : ends[1] + 1], spacing=STEP)
    way = np.interp(along[-1] * np.array(ends) / (len(nodes) - 1), along, picture.along)
    # Beyond an end of the curve that moves there is nothing to join.
    unseen = picture.along[0], picture.course.length - picture.along[-1]
    free = bent.moved[[0, -1]] & (np.array(unseen) < TURNED_AWAY)
    laid = project_line(body.template, body.nets, stretch, camera)
    if len(laid) > 1 and not free.any():
        raise UserError(OFF)
    new = laid[-1] if free[0] and not free[1] else laid[0]
    parts = [new]
    if not free[0]:
        parts.insert(0, _rest(body.nets, picture.course, way[0], new[:1], before=True))
    if not free[1]:
        parts.append(_rest(body.nets, picture.course, way[1], new[-1:], before=False))
    whole = join_paths(parts)
    sight = sight_of(points_at(body.nets, whole), camera)
    changed = connect_places(body.template, body.nets, whole, sight)
    if len(changed) > 1:
        raise UserError(OFF)
    paths = [course.path for course in courses]
    paths[picture.number] = changed[0]
    return with_paths(curve, body, paths)


def begun_away(curve: StylingCurve, body: Body, line: ArrayLike, camera: Camera) -> StylingCurve:
    """Return a closed curve with its ends where it does not change, far from a line.

    An open curve is returned as it is.
    """
    paths = curve_paths(curve, body.nets, body.template)
    if len(paths) != 1 or not is_closed(body.nets, paths[0]):
        return curve
    (path,) = paths
    pixels = camera.project(points_at(body.nets, path))[0]
    away = distances_to_polyline(np.nan_to_num(pixels, nan=0.0), line)
    away[np.append(True, np.diff(path.patches) != 0)] = -1.0  # a crossing stays a pair
    begin = int(np.argmax(away))
    if not begin:
        return curve
    return with_paths(curve, body, [join_paths([path[begin:], path[1 : begin + 1]])])


def _picture_near(
    body: Body, courses: list[Course], line: Array, camera: Camera
) -> _Picture | None:
    """Return the visible part of a path to which a line is nearest."""
    best, found = np.inf, None
    for number, course in enumerate(courses):
        for part in seen_parts(body, course, camera):
            distance = float(distances_to_polyline(line, part.pixels).mean())
            if distance < best and arc_length(part.pixels)[-1] > NODES:
                best, found = distance, _Picture(number, course, part.along, part.pixels)
    return found


def _rest(nets: Array, course: Course, at: float, joint: Places, *, before: bool) -> Places:
    """Return the places of a curve before or after the length at which a changed stretch joins."""
    there = points_at(nets, join_paths([course.places(np.array([at])), joint]))
    if np.linalg.norm(there[1] - there[0]) > JUMP:
        raise UserError(OFF)
    steps = np.diff(course.along)
    margin = CLOSE * float(np.median(steps[steps > 0.0]))
    chosen = course.along < at - margin if before else course.along > at + margin
    return course.path[chosen]
