"""Checks of places on the sheet: finite, and not beyond all bounds."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bozzetto.errors import UserError

if TYPE_CHECKING:
    from bozzetto.view.camera import Camera

FARTHEST: Final = 1e9
"""Largest coordinate, px: a million screens away. Squares of it and of its differences are
still exact to a few digits, so nothing overflows."""


def is_on_sheet(points: ArrayLike) -> bool:
    """Whether all coordinates are finite and not beyond all bounds."""
    return bool((np.abs(np.asarray(points, float)) <= FARTHEST).all())


def places_on_sheet(points: ArrayLike, what: str) -> NDArray[np.float64]:
    """Return places as an array of shape (n, 2), px, that is checked.

    Parameters
    ----------
    points : (n, 2) array_like
        Places, canvas pixels.
    what : str
        What they are of, for the message.

    Raises
    ------
    UserError
        If there is none, or a coordinate is not finite or beyond `FARTHEST`.
    """
    place = np.array(points, float).reshape(-1, 2)
    if not len(place):
        raise UserError(f"The {what} has no points; draw it again.")
    if not is_on_sheet(place):
        raise UserError(f"The {what} holds a place that is not on the sheet; draw it again.")
    return place


def seen_through(points: ArrayLike, drawn: Camera, camera: Camera) -> NDArray[np.float64]:
    """Return places on the sheet of one view as seen in another, canvas pixels, shape (n, 2).

    Ink lies on the sheet: the plane through the target of its camera that faced the eye.
    What lies behind the other eye is not finite.
    """
    place = np.asarray(points, float).reshape(-1, 2)
    if drawn == camera:
        return place
    return np.asarray(camera.project(drawn.on_plane(place, drawn.target, drawn.axes[2]))[0])


def is_seen(points: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return which places, shape (n, 2), are finite and not beyond all bounds."""
    with np.errstate(invalid="ignore"):
        return np.asarray((np.abs(points) <= FARTHEST).all(axis=1))
