"""Where an underlay lies: its middle, width and turn, and two places brought to two others.

The picture is moved, turned in its plane and scaled; never stretched, sheared or turned over.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bozzetto.errors import UserError

if TYPE_CHECKING:
    from bozzetto.document.model import Underlay
    from bozzetto.view.camera import Rays

__all__ = ["LARGEST", "SMALLEST", "UnderlayPlace", "aligned", "place_of", "placed", "places_under"]

SMALLEST: Final = 1e-3
"""Least width of an underlay, mm."""

LARGEST: Final = 1e6
"""Greatest width of an underlay, and farthest of its middle from the origin, mm."""

NEAREST: Final = 1e-6
"""Two places that are nearer than this share of the picture's width are one place."""

Array = NDArray[np.float64]


@dataclass(frozen=True)
class UnderlayPlace:
    """Where a picture lies in its plane.

    Parameters
    ----------
    middle : (x, y, z)
        mm.
    width : float
        Of the picture from its left to its right side, mm.
    turn : float
        By which it is turned counterclockwise as one looks at its front, degrees, above −180 to
        180. Not turned, its upper and lower sides are level; one that lies flat has them along x.
    """

    middle: tuple[float, float, float]
    width: float
    turn: float


def place_of(underlay: Underlay) -> UnderlayPlace:
    """Return where an underlay lies.

    Raises
    ------
    UserError
        If it has no area, as a file may say.
    """
    across, up = _sides(underlay)
    level, upright = _level(across, up)
    turn = math.degrees(math.atan2(float(across @ upright), float(across @ level)))
    x, y, z = (float(value) for value in _middle(underlay))
    width = float(np.linalg.norm(underlay.across))
    return UnderlayPlace((x, y, z), width, 180.0 if turn == -180.0 else turn + 0.0)


def placed(underlay: Underlay, place: UnderlayPlace) -> Underlay:
    """Return an underlay somewhere else, in a plane parallel to its own.

    Raises
    ------
    UserError
        If the place is not finite, too far away, or the picture too small or large there.
    """
    numbers = (*place.middle, place.width, place.turn)
    if not np.isfinite(numbers).all() or np.abs(place.middle).max() > LARGEST:
        raise UserError("The picture would be too far away. Type a place nearer to the origin.")
    if not SMALLEST <= place.width <= LARGEST:
        raise UserError(
            f"The picture would be {place.width:g} mm wide. Type a width from {SMALLEST:g} to "
            f"{LARGEST:g} mm."
        )
    level, upright = _level(*_sides(underlay))
    angle = math.radians(place.turn)
    along = math.cos(angle) * level + math.sin(angle) * upright
    upwards = math.cos(angle) * upright - math.sin(angle) * level
    was = float(np.linalg.norm(underlay.across))
    tall = float(np.linalg.norm(underlay.down)) * (place.width / was)
    return _laid(underlay, np.array(place.middle), place.width * along, -tall * upwards)


def aligned(underlay: Underlay, places: ArrayLike, goals: ArrayLike) -> Underlay:
    """Return an underlay moved, turned and scaled so that two places of it lie at two goals.

    Parameters
    ----------
    underlay : Underlay
        As it lies now.
    places, goals : (2, 3) array_like
        In the world, mm; what of them is off the plane of the picture does not count.

    Raises
    ------
    UserError
        If the two places, or the two goals, are one, or the picture would get too small or large.

    Notes
    -----
    In the plane, with places as complex numbers, the similarity is z ↦ g₁ + (z − p₁) s, where
    s = (g₂ − g₁) / (p₂ − p₁): its modulus is the scale, its argument the turn.
    """
    across, up = _sides(underlay)
    middle = _middle(underlay)
    width = float(np.linalg.norm(underlay.across))

    def flat(points: ArrayLike) -> NDArray[np.complex128]:
        away = np.asarray(points, float).reshape(2, 3) - middle
        made: NDArray[np.complex128] = away @ across + 1j * (away @ up)
        return made

    before, after = flat(places), flat(goals)
    far = abs(before[1] - before[0]), abs(after[1] - after[0])
    if not min(far) > NEAREST * width:
        raise UserError("The two places are one. Touch a second place farther from the first.")
    by = (after[1] - after[0]) / (before[1] - before[0])
    off = after[0] - before[0] * by
    if not np.isfinite([by, off]).all():
        raise UserError("The picture would be too far away. Touch places nearer to it.")
    now = place_of(underlay)
    x, y, z = (float(v) for v in middle + off.real * across + off.imag * up)
    turn = (now.turn + math.degrees(math.atan2(by.imag, by.real)) + 180.0) % 360.0 - 180.0
    return placed(underlay, UnderlayPlace((x, y, z), now.width * abs(by), turn))


def places_under(underlay: Underlay, rays: Rays) -> Array | None:
    """Return where rays meet the plane of an underlay, (n, 3) mm; None if one does not.

    Parameters
    ----------
    underlay : Underlay
        The picture; its plane goes on beyond its border.
    rays : Rays
        Through places of the canvas.
    """
    across, up = _sides(underlay)
    normal = np.cross(across, up)
    with np.errstate(divide="ignore", invalid="ignore"):
        far = (_middle(underlay) - rays.origins) @ normal / (rays.directions @ normal)
        points: Array = rays.origins + far[:, None] * rays.directions
    return points if np.isfinite(points).all() and (far > 0.0).all() else None


def _middle(underlay: Underlay) -> Array:
    made: Array = np.array(underlay.corner) + 0.5 * (
        np.array(underlay.across) + np.array(underlay.down)
    )
    return made


def _sides(underlay: Underlay) -> tuple[Array, Array]:
    """Return unit vectors to the right and upwards in the picture, at right angles."""
    across, down = np.array(underlay.across), np.array(underlay.down)
    long = float(np.linalg.norm(across))
    right = across / long if long > 0.0 else across
    up = -(down - (down @ right) * right)
    tall = float(np.linalg.norm(up))
    if not (long > 0.0 and tall > 0.0 and math.isfinite(long) and math.isfinite(tall)):
        raise UserError("This underlay has no area. Drop the picture on the sheet again.")
    return right, up / tall


def _level(across: Array, up: Array) -> tuple[Array, Array]:
    """Return the level direction in the plane of a picture, and that a quarter turn on."""
    normal = np.cross(across, up)
    level = np.cross((0.0, 0.0, 1.0), normal)
    long = float(np.linalg.norm(level))
    if long < 1e-9:  # it lies flat
        level, long = np.array((1.0, 0.0, 0.0)), 1.0
    level = level / long
    return level, np.cross(normal, level)


def _laid(underlay: Underlay, middle: Array, across: Array, down: Array) -> Underlay:
    x, y, z = (float(value) for value in middle - 0.5 * (across + down))
    a, b, c = (float(value) for value in across)
    d, e, f = (float(value) for value in down)
    return replace(underlay, corner=(x, y, z), across=(a, b, c), down=(d, e, f))
