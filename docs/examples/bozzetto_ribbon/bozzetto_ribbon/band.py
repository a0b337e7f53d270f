"""The mathematics: from ink in a plane to a ribbon in space."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bozzetto.errors import UserError
from bozzetto_ribbon.state import Band

Array = NDArray[np.float64]

SHORTEST = 1e-3
"""Length (mm) below which ink is a dot and not a stroke."""

SMOOTHING = 2
"""How often each place is averaged with its neighbours, against the tremor of the hand."""


@dataclass(frozen=True, eq=False)
class Strip:
    """A ribbon.

    Attributes
    ----------
    centre : (n, 3) float
        Its middle line, mm.
    left, right : (n, 3) float
        Its edges, mm.
    """

    centre: Array
    left: Array
    right: Array


def middle_line(band: Band) -> tuple[Array, Array]:
    """The ink in space, and the pressure along it.

    Returns
    -------
    places : (n, 3) float
        mm; samples that lie on one another are left out.
    pressure : (n,) float
        0 … 1.

    Raises
    ------
    UserError
        If the ink is a dot, or not in front of the camera.
    """
    camera = band.stroke.camera
    forward = camera.axes[2]
    places = camera.on_plane(band.stroke.points, band.through, forward)
    if not np.isfinite(places).all():
        raise UserError("The stroke lies behind the eye. Turn the view and draw it again.")
    steps = np.linalg.norm(np.diff(places, axis=0), axis=1)
    if steps.sum() < SHORTEST:
        raise UserError("This is a dot. Draw a stroke, and the ribbon will follow it.")
    moved = np.concatenate(([True], steps > 0.0))
    pressure = np.clip(band.stroke.pressure.astype(float), 0.0, 1.0)
    return places[moved] + band.shift, pressure[moved]


def strip(band: Band, count: int, width: float, influence: float, twist: float) -> Strip:
    """The ribbon along a band's ink.

    Parameters
    ----------
    band : Band
    count : int
        Places along the ribbon, at least 2.
    width : float
        mm, at full pressure.
    influence : float
        0 … 1, how much of the width comes from pressure.
    twist : float
        Turns from end to end.
    """
    places, pressure = middle_line(band)
    run = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(places, axis=0), axis=1))))
    at = np.linspace(0.0, run[-1], count)
    centre = smooth(np.column_stack([np.interp(at, run, places[:, axis]) for axis in range(3)]))
    half = 0.5 * width * (1.0 - influence * (1.0 - np.interp(at, run, pressure)))

    towards_eye = -band.stroke.camera.axes[2]
    along = np.gradient(centre, axis=0)
    side = np.cross(along, towards_eye)
    length = np.linalg.norm(side, axis=1)
    # Where the ink turns back on itself there is no direction: the neighbour's is taken.
    side = side[nearest_where(length > 1e-12 * run[-1])]
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    angle = 2.0 * np.pi * twist * np.linspace(0.0, 1.0, count)
    across = np.cos(angle)[:, None] * side + np.sin(angle)[:, None] * towards_eye
    return Strip(centre, centre - half[:, None] * across, centre + half[:, None] * across)


def smooth(places: Array) -> Array:
    """Places averaged with their neighbours; both ends stay where they are."""
    for _ in range(SMOOTHING):
        inner = 0.25 * places[:-2] + 0.5 * places[1:-1] + 0.25 * places[2:]
        places = np.concatenate((places[:1], inner, places[-1:]))
    return places


def nearest_where(good: NDArray[np.bool_]) -> NDArray[np.intp]:
    """For every place the index of a nearest good one."""
    places = np.flatnonzero(good)
    if not len(places):
        raise UserError("The stroke has no direction. Draw it again, a little longer.")
    return np.asarray([places[np.argmin(np.abs(places - i))] for i in range(len(good))])


def triangles(count: int) -> NDArray[np.int32]:
    """Faces of a strip whose vertices are its left edge and then its right edge."""
    left = np.arange(count - 1)
    right = left + count
    one = np.column_stack((left, right, left + 1))
    other = np.column_stack((left + 1, right, right + 1))
    return np.concatenate((one, other)).astype(np.int32)
