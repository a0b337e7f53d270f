"""Styling curves changed: drawn over, and smoothed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.errors import UserError
from bozzetto.geometry.patches.closest_points import foot_points
from bozzetto.geometry.patches.patch import Places, normals_at, points_at
from bozzetto.ink.curves.nearest import distances_to_polyline
from bozzetto.ink.curves.resample import arc_length, resample
from bozzetto.ink.curves.smooth import smooth
from bozzetto.ink.oversketch.snake import modified
from bozzetto.view import Camera
from bozzetto_car.array_types import Array
from bozzetto_car.body.build import Body
from bozzetto_car.state import StylingCurve
from bozzetto_car.styling.curve import curve_paths, with_paths
from bozzetto_car.styling.curve_fit import Course, courses_on
from bozzetto_car.styling.picking import seen_parts, sight_of
from bozzetto_car.styling.project_on_body import laid_paths
from bozzetto_car.styling.stroke_line import STEP, smoothed_line
from bozzetto_car.styling.surface_path import connected, is_closed, joined

NODES: Final = 3.0
"""Distance of the nodes of the picture of a curve that is drawn over, px."""

JUMP: Final = 20.0
"""Farthest, mm, that a changed stretch may begin or end from the curve that it is a part of: what
is farther is another part of the body in front of it."""

TURNED_AWAY: Final = 60.0
"""Length, mm, of what turns away from the eye at the end of a curve and goes with the end."""

CLOSE: Final = 0.5
"""Distance from the joint within which a place of the old curve is left out, per usual step."""

SMOOTHED: Final = 24.0
"""Distance of the places of a smoothed curve, mm."""

FEWEST, MOST = 24, 400
"""Least and greatest number of its places."""

UNCHANGED: Final = 0.1
"""Distance, px, by which a stroke must bend a curve to change it."""

OFF: Final = (
    "The stroke leads off the body or behind a part of it. Turn the view so that all of it is "
    "seen, then draw over the curve."
)

HALVINGS: Final = 3
"""Times that they are taken half as far apart, where the way from patch to patch is not found."""


def smoothed(curve: StylingCurve, body: Body, share: float) -> StylingCurve:
    """A curve without its small bends; its ends stay.

    It is convolved with a Gaussian in space, and goes back to the nearest places of the body.

    Parameters
    ----------
    curve : StylingCurve
    body : Body
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
        whole = joined([ends[:1], feet[1:-1], ends[1:]])
        paths = connected(body.template, body.nets, whole, normals_at(body.nets, whole))
        if len(paths) == 1:
            return paths[0]
        count *= 2
    raise UserError("The curve cannot be smoothed where it is: draw over it instead.")


# -- drawn over ------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class _Picture:
    """The part of a curve that is seen: lengths along it, mm, and where these are seen, px."""

    number: int
    course: Course
    along: Array
    pixels: Array


def oversketched(
    curve: StylingCurve, body: Body, stroke: ArrayLike, camera: Camera
) -> StylingCurve:
    """A curve that runs where a stroke was drawn over it.

    The picture of the curve gives way to the stroke as a contour that resists bending
    (`bozzetto.ink.oversketch.snake`), so it leaves its old way and comes back to it
    smoothly, and a stroke that runs on beyond an end takes the end along. What was changed is
    laid on the body anew.

    Parameters
    ----------
    curve : StylingCurve
    body : Body
    stroke : (n, 2) array_like
        px; along the curve or against it.
    camera : Camera

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
    line = smoothed_line(stroke)
    curve, given = begun_away(curve, body, line, camera), curve
    courses = courses_on(curve, body.nets, body.template)
    picture = _picture_near(body, courses, line, camera)
    if picture is None:
        raise UserError("The curve is not seen here. Turn the view, then draw over it.")
    along = arc_length(picture.pixels)
    nodes = resample(picture.pixels, spacing=NODES)
    bent = modified(nodes, [(line, np.ones(len(line)))])
    if np.linalg.norm(bent.points - nodes, axis=1).max() < UNCHANGED:
        return given
    moved = np.flatnonzero(bent.moved)
    ends = max(int(moved[0]) - 1, 0), min(int(moved[-1]) + 1, len(nodes) - 1)
    stretch = resample(bent.points[ends[0] : ends[1] + 1], spacing=STEP)
    way = np.interp(along[-1] * np.array(ends) / (len(nodes) - 1), along, picture.along)
    # An end of the curve that moves has nothing beyond it to be joined to.
    unseen = picture.along[0], picture.course.length - picture.along[-1]
    free = bent.moved[[0, -1]] & (np.array(unseen) < TURNED_AWAY)
    laid = laid_paths(body.template, body.nets, stretch, camera)
    if len(laid) > 1 and not free.any():
        raise UserError(OFF)
    new = laid[-1] if free[0] and not free[1] else laid[0]
    parts = [new]
    if not free[0]:
        parts.insert(0, _rest(body.nets, picture.course, way[0], new[:1], before=True))
    if not free[1]:
        parts.append(_rest(body.nets, picture.course, way[1], new[-1:], before=False))
    whole = joined(parts)
    sight = sight_of(points_at(body.nets, whole), camera)
    changed = connected(body.template, body.nets, whole, sight)
    if len(changed) > 1:
        raise UserError(OFF)
    paths = [course.path for course in courses]
    paths[picture.number] = changed[0]
    return with_paths(curve, body, paths)


def begun_away(curve: StylingCurve, body: Body, line: ArrayLike, camera: Camera) -> StylingCurve:
    """A closed curve with its ends, where it does not change, as far as can be from a line.

    An open one as it is.
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
    return with_paths(curve, body, [joined([path[begin:], path[1 : begin + 1]])])


def _picture_near(
    body: Body, courses: list[Course], line: Array, camera: Camera
) -> _Picture | None:
    """The part that is seen of a path to which a line is nearest."""
    best, found = np.inf, None
    for number, course in enumerate(courses):
        for part in seen_parts(body, course, camera):
            distance = float(distances_to_polyline(line, part.pixels).mean())
            if distance < best and arc_length(part.pixels)[-1] > NODES:
                best, found = distance, _Picture(number, course, part.along, part.pixels)
    return found


def _rest(nets: Array, course: Course, at: float, joint: Places, *, before: bool) -> Places:
    """The places of a curve before or behind a length at which a changed stretch joins it."""
    there = points_at(nets, joined([course.places(np.array([at])), joint]))
    if np.linalg.norm(there[1] - there[0]) > JUMP:
        raise UserError(OFF)
    steps = np.diff(course.along)
    margin = CLOSE * float(np.median(steps[steps > 0.0]))
    chosen = course.along < at - margin if before else course.along > at + margin
    return course.path[chosen]
