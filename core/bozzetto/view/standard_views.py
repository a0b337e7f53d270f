"""Views with names, and the 26 directions of the view cube."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.errors import UserError
from bozzetto.view.rotations import POLE, placed, steepness, unit, upright

if TYPE_CHECKING:
    from bozzetto.view.camera import Camera, Point

STANDARD_VIEWS: Final[Mapping[str, tuple[Point, Point]]] = MappingProxyType(
    {
        "front": ((0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
        "back": ((0.0, -1.0, 0.0), (0.0, 0.0, 1.0)),
        "left": ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
        "right": ((-1.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
        "top": ((0.0, 0.0, -1.0), (0.0, 1.0, 0.0)),
        "bottom": ((0.0, 0.0, 1.0), (0.0, -1.0, 0.0)),
        "three-quarter": ((-0.55, 0.75, -0.42), (0.0, 0.0, 1.0)),
    }
)
"""Line of sight (from the eye) and up, by name. "left" shows the side at negative x."""

CUBE_DIRECTIONS: Final[tuple[Point, ...]] = tuple(
    (x, y, z) for x, y, z in product((-1.0, 0.0, 1.0), repeat=3) if (x, y, z) != (0.0, 0.0, 0.0)
)
"""Outward directions of the view cube's 6 faces, 12 edges and 8 corners, not of unit length."""


def standard_view(camera: Camera, name: str) -> Camera:
    """Look at the same target from a side that has a name.

    Parameters
    ----------
    camera : Camera
        The view to turn.
    name : str
        A key of `STANDARD_VIEWS`.

    Raises
    ------
    UserError
        If there is no view of that name.
    """
    if name not in STANDARD_VIEWS:
        names = ", ".join(STANDARD_VIEWS)
        raise UserError(f"There is no view called {name!r}. Choose one of: {names}.")
    direction, up = STANDARD_VIEWS[name]
    return placed(camera, unit(direction), np.array(up))


def look_along(camera: Camera, direction: ArrayLike) -> Camera:
    """Look at the same target along any direction, upright.

    Parameters
    ----------
    camera : Camera
        The view to turn.
    direction : (3,) array_like
        From the eye into the world. For a place on the view cube it is the negative of
        one of `CUBE_DIRECTIONS`.

    Returns
    -------
    Camera
        Straight down or up, the sheet is turned to the world axis nearest to the way it
        lies now; every other direction has Z up.

    Raises
    ------
    UserError
        If the direction is zero or not finite.
    """
    towards = np.asarray(direction, float)
    if towards.shape != (3,) or not np.isfinite(towards).all() or not towards.any():
        raise UserError("A view needs a direction of three finite numbers, not all zero.")
    forward = unit(towards)
    if np.hypot(forward[0], forward[1]) > POLE:
        return placed(camera, forward, np.array((0.0, 0.0, 1.0)))
    azimuth, _ = steepness(camera)
    quarter = round(azimuth / (np.pi / 2.0)) * (np.pi / 2.0)
    frame = upright(quarter, -np.sign(forward[2]) * np.pi / 2.0)
    return placed(camera, forward, np.round(frame[1]))
