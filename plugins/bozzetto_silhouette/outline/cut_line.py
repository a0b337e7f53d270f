"""Cutting: an open line across an object, and all that lies on one side of it."""

from __future__ import annotations

from itertools import product

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.ink import smooth
from bozzetto_silhouette.model.state import Cut
from bozzetto_silhouette.model.view_rays import view_rays_through
from bozzetto_silhouette.outline.from_ink import points_on_sheet
from bozzetto_silhouette.outline.outline import Outline, outline_from_rings

CALM = 1.2e-2
"""Width of the filter for jitter, as a share of the line's length."""

FEW = 12
"""A line of fewer samples is exact, not ink."""

FLAT = 1e-4
"""Deviation up to which a stretch of the line counts as straight, as a share of the size."""

END = 0.15
"""Share of the line at each end that tells in which direction it goes on."""

ROOM = 1.25
"""How far beyond the object the sides reach, as a share of the circle around it."""

ARC_STEP = np.deg2rad(6.0)
"""Largest step along the arc that closes a side, beyond the object."""


def cut_side(cut: Cut, corners: Array | None) -> Outline:
    """Return the side that falls away: the line, carried on beyond the object and closed around it.

    Both sides share the line to the last digit, so that what they take away adds up.

    Parameters
    ----------
    cut : Cut
        Its line, and which side of it falls away.
    corners : (n, 3) float array, optional
        Points around the object, in the cut's object frame.

    Returns
    -------
    Outline
        In the object frame.

    Raises
    ------
    UserError
        If there is no line, or it crosses itself.
    """
    if not len(cut.strokes):
        raise UserError("There is no ink yet. Draw a line right across the shape.")
    (line, *_) = points_on_sheet(tuple(cut.strokes)[:1], cut.sheet)
    around = line
    if corners is not None:
        view_rays = view_rays_through(cut.sheet, cut.strokes[0].camera)
        low, high = view_rays.before_eye(float(corners[:, 2].min()), float(corners[:, 2].max()))
        held = np.column_stack([corners[:, :2], np.clip(corners[:, 2], low, high)])
        around = np.concatenate([line, view_rays.drawn(held)])
    middle = 0.5 * (around.min(axis=0) + around.max(axis=0))
    radius = ROOM * float(np.hypot(*(around - middle).T).max())
    if not float(np.hypot(*np.ptp(line, axis=0))) > 1e-6 * radius:
        raise UserError("This is a dot. Draw a line right across the shape.")
    whole = _carried_on((_calm(line) - middle) / radius)
    first, last = (float(np.arctan2(y, x)) for x, y in (whole[0], whole[-1]))
    if cut.side == "left":
        ring = np.concatenate([whole, _arc(last, first)])
    else:
        ring = np.concatenate([whole[::-1], _arc(first, last)])
    return outline_from_rings([ring * radius + middle])


def _calm(line: Array) -> Array:
    """Remove the jitter from the line, and the vertices that it does not need."""
    from shapely import LineString, get_coordinates

    if len(line) < FEW:
        return line
    length = float(np.hypot(*np.diff(line, axis=0).T).sum())
    calm = smooth(line, CALM * length)
    size = float(np.ptp(line, axis=0).max())
    return np.asarray(get_coordinates(LineString(calm).simplify(FLAT * size)), np.float64)


def _carried_on(line: Array) -> Array:
    """Carry both ends of the line on to the unit circle.

    They go on in the direction of the ink; where the line would cross itself, straight
    outwards.
    """
    from shapely import LineString

    ends = [_directions(line[::-1]), _directions(line)]
    for before, after in product(*ends):
        whole = np.vstack([_exit(line[0], before), line, _exit(line[-1], after)])
        if LineString(whole).is_simple:
            return whole
    raise UserError("This line crosses itself. Draw the cut again, in one sweep across the shape.")


def _directions(line: Array) -> tuple[Array, Array]:
    """Return directions in which the end of a line may go on: as the ink goes, or outwards."""
    arc = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    start = np.array([np.interp((1.0 - END) * arc[-1], arc, axis) for axis in line.T])
    along, out = line[-1] - start, line[-1]
    return (along if along.any() else out), (out if out.any() else along)


def _exit(start: Array, direction: Array) -> Array:
    """Return where a ray from inside the unit circle leaves it."""
    size = float(np.hypot(*direction))
    toward = direction / size if size > 0.0 else np.array([1.0, 0.0])
    half = float(start @ toward)
    return np.asarray(start + (np.sqrt(half**2 + 1.0 - start @ start) - half) * toward)


def _arc(begin: float, end: float) -> Array:
    """Return inner points of the unit circle's arc, counter-clockwise between two angles."""
    turn = (end - begin) % (2.0 * np.pi)
    count = max(2, int(np.ceil(turn / ARC_STEP)) + 1)
    angle = begin + np.linspace(0.0, turn, count)[1:-1]
    return np.column_stack([np.cos(angle), np.sin(angle)])
