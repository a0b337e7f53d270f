"""First guesses of a camera: views from all around, and the direct linear transform.

For a direction of sight and a perspectivity the rest of the camera, that is scale, roll and
offset, is a similarity of the picture and has a closed form. So a start needs no guess, and
all of them together take less time than one adjustment.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from bozzetto.errors import UserError
from bozzetto.view.calibration.dlt import FEWEST, direct_linear_transform
from bozzetto.view.calibration.pose import PERSPECTIVITIES, SCALES, Poses, rotations
from bozzetto.view.rotations import unit
from bozzetto.view.standard_views import CUBE_DIRECTIONS

if TYPE_CHECKING:
    from bozzetto.arrays import Array

STRENGTHS: Final = (0.3, 1.0)
"""Perspectivities to start from, in reciprocal diagonals: a long and a usual lens."""

NEAR_START: Final = 0.2
"""Least depth of a point before the eye in a start, in depths of the centroid. A start whose
eye would be nearer gets a longer lens."""

REFINED: Final = 2
"""Times that scale and depths are found from each other."""


def starts(points: Array, marks: Array) -> Poses:
    """Return poses to start from, in the units of `Framing`.

    Returns
    -------
    Poses
        An orthographic pose for each direction, and one for each of `STRENGTHS`.
    """
    turns = np.concatenate((AROUND, _direct(points, marks)))
    strengths = np.repeat((0.0, *STRENGTHS), len(turns))
    return _fitted(points, marks, np.tile(turns, (1 + len(STRENGTHS), 1, 1)), strengths)


def resume_poses(points: Array, marks: Array, before: Poses, cropped: bool) -> Poses:
    """Return poses like one found before, next to it, for the marks there are now."""
    principal = before.principal * cropped
    made = _fitted(points, marks - principal, before.turn, before.perspectivity)
    return replace(made, principal=principal)


def _around() -> Array:
    """Return frames (26, 3, 3) that look from the places of the view cube."""
    frames = []
    for direction in CUBE_DIRECTIONS:
        forward = -unit(direction)
        beside = np.eye(3)[np.argmin(np.abs(forward))]
        right = unit(np.cross(forward, beside))
        frames.append(np.stack((right, np.cross(forward, right), forward)))
    return np.array(frames)


AROUND: Final = _around()
"""The frames of all starts but that of the direct linear transform."""


def _direct(points: Array, marks: Array) -> Array:
    """Return the frame that the direct linear transform finds, (1, 3, 3), or (0, 3, 3) for none."""
    if len(points) < FEWEST:
        return np.zeros((0, 3, 3))
    try:
        return direct_linear_transform(points, marks).parts.turn[None]
    except UserError:
        return np.zeros((0, 3, 3))


def _fitted(points: Array, marks: Array, turns: Array, strengths: Array) -> Poses:
    """Fit scale, roll and offset of a perspectivity to each turn by linear least squares.

    With the depths w known, the marks times w are a similarity of the points across the
    sight: as complex numbers, mark · w = factor · point + offset.
    """
    across = points @ np.swapaxes(turns, 1, 2)
    flat = across[:, :, 0] + 1j * across[:, :, 1]
    middle = flat.mean(axis=1)
    flat = flat - middle[:, None]
    spread = np.maximum(np.sum(np.abs(flat) ** 2, axis=1), 1e-12)
    seen = marks[:, 0] + 1j * marks[:, 1]
    depth = np.ones(flat.shape)
    for _ in range(REFINED):
        target = seen * depth
        offset = target.mean(axis=1)
        factor = np.sum(np.conj(flat) * (target - offset[:, None]), axis=1) / spread
        scale = np.clip(np.abs(factor), *np.exp(SCALES))
        nearest = scale * np.maximum(-across[:, :, 2].min(axis=1), 1e-12)
        allowed = np.minimum(strengths, (1.0 - NEAR_START) / nearest)
        depth = 1.0 + (allowed * scale)[:, None] * across[:, :, 2]
    offset = offset - factor * middle
    # A roll by an angle turns right and down of the picture by it.
    rolls = rotations(np.angle(factor)[:, None] * np.array([0.0, 0.0, 1.0]))
    allowed = np.where(strengths > 0.0, np.clip(allowed, *PERSPECTIVITIES), 0.0)
    return Poses(
        rolls @ turns,
        np.log(scale),
        np.column_stack((offset.real, offset.imag)),
        allowed,
        np.zeros((len(turns), 2)),
    )
