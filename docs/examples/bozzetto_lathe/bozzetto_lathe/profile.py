"""The mathematics: from ink to a profile of radius and height, and to its spline in space."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bozzetto.geometry import Curve
from bozzetto.plugin import Ink, UserError
from bozzetto_lathe.state import LatheState

Array = NDArray[np.float64]

SHORTEST = 1e-3
"""Length (mm) below which ink is a dot and not a stroke."""

STEEPEST = 0.1
"""Sine of the angle between the line of sight and the axis below which no profile can be seen."""

REACH = 0.05
"""How far a stroke over the profile may begin or end beside it, as share of its length."""

NOTHING = 0.01
"""Share of the largest radius below which an end lies on the axis."""

DENSE = 400
"""Places along a profile while strokes are laid over it."""

DOT = "This is a dot. Draw a stroke."
EYE = "The stroke lies behind the eye. Turn the view and draw it again."


def axis_of(state: LatheState) -> tuple[Array, Array]:
    """Return a point of the axis and its direction, of length 1, upward by default."""
    if state.axis is None:
        return np.zeros(3), np.array([0.0, 0.0, 1.0])
    camera = state.axis.camera
    points = state.axis.strokes[0].points[[0, -1]]
    start, end = camera.on_plane(points, camera.target, camera.axes[2])
    length = float(np.linalg.norm(end - start))
    if not np.isfinite(length):
        raise UserError(EYE)
    if length < SHORTEST:
        raise UserError("An axis is a straight stroke. Draw it from one end to the other.")
    return start, (end - start) / length


def profile_of(state: LatheState) -> Array:
    """Return the profile with all strokes over it: radius and height (mm), shape (n, 2).

    Raises
    ------
    UserError
        If ink is a dot, crosses the axis, or does not lie over the profile.
    """
    point, axis = axis_of(state)
    first, *others = (_beside(ink, point, axis) for ink in state.profile)
    line = resampled(first, DENSE)
    for stroke in others:
        line = resampled(_oversketched(line, stroke), DENSE)
    return line


def spline_of(state: LatheState) -> Curve:
    """Return the profile as a cubic spline in space, with straight ends to the axis if closed."""
    point, axis = axis_of(state)
    line = resampled(profile_of(state), state.detail)
    line[[0, -1], 0] *= line[[0, -1], 0] > NOTHING * line[:, 0].max()
    gap = float(np.linalg.norm(line[-1] - line[0]))
    if comes_round := gap < REACH * _length(line) * 2.0:
        line[-1] = line[0]
    # A straight piece as a cubic: two control points between its ends, three knots at the joint.
    capped = (line[[0, -1], 0] > 0.0) & (state.ends == "closed" and not comes_round)
    inner = np.linspace(0.0, 1.0, len(line) - 2)[1:-1]
    before, after = ([-1.0] * 4 if capped[0] else [0.0]), ([2.0] * 4 if capped[1] else [1.0])
    knots = np.concatenate((before, [0.0] * 3, inner, [1.0] * 3, after))
    thirds = np.array([[0.0, 1.0], [1.0 / 3.0, 1.0], [2.0 / 3.0, 1.0]])
    start, end = thirds * line[0], (thirds * line[-1])[::-1]
    control = np.concatenate((start[: 3 * capped[0]], line, end[: 3 * capped[1]]))
    forward = state.profile[0].camera.axes[2]
    side = np.cross(forward, axis)
    side /= np.linalg.norm(side)
    return Curve(3, knots, point + control[:, :1] * side + control[:, 1:] * axis)


def resampled(line: Array, count: int) -> Array:
    """Return places at even steps along a line, shape (count, 2)."""
    run = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))))
    if run[-1] < SHORTEST:
        raise UserError(DOT)
    at = np.linspace(0.0, run[-1], count)
    return np.column_stack([np.interp(at, run, column) for column in line.T])


def _length(line: Array) -> float:
    return float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum())


def _beside(ink: Ink, point: Array, axis: Array) -> Array:
    """Return ink as radius and height in the plane through the axis that faces its camera."""
    forward = ink.camera.axes[2]
    normal = forward - (forward @ axis) * axis
    if np.linalg.norm(normal) < STEEPEST:
        raise UserError("The axis points at you here. Turn the view, then draw.")
    places = ink.camera.on_plane(ink.strokes[0].points, point, normal) - point
    if not np.isfinite(places).all():
        raise UserError(EYE)
    side = np.cross(forward, axis)
    radius = places @ (side / np.linalg.norm(side))
    radius = radius if radius.sum() > 0.0 else -radius
    if radius.min() < -REACH * np.abs(radius).max():
        raise UserError("The profile crosses the axis. Draw it on one side.")
    return np.column_stack((np.maximum(radius, 0.0), places @ axis))


def _oversketched(line: Array, stroke: Array) -> Array:
    """Return a line with the part between the ends of a stroke drawn as the stroke is."""
    gaps = np.linalg.norm(line - stroke[[0, -1], None], axis=2)
    if gaps.min(axis=1).max() > REACH * _length(line):
        raise UserError("To change the profile, begin and end the stroke on it.")
    start, end = gaps.argmin(axis=1)
    if start > end:
        start, end, stroke = end, start, stroke[::-1]
    return np.concatenate((line[:start], stroke, line[end + 1 :]))
