"""Plain values of drawings' files, read carefully: objects, lists, numbers and points."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from bozzetto.errors import UserError

if TYPE_CHECKING:
    from bozzetto.arrays import Array

MOST_POINTS: Final = 20_000
"""Points of one curve."""

SPACE: Final = ("xyz", 1e6)
"""For `a_point` and `point_rows`: names of coordinates in space, and the largest one, mm."""

PLANE: Final = ("xy", 1e6)
"""For `a_point` and `point_rows`: names of coordinates in a plane, and the largest one, mm."""

PIXELS: Final = ("uv", 1e8)
"""For `a_point` and `point_rows`: names of coordinates in a picture, and the largest one, px."""

Coordinates = tuple[str, float]
"""Names of coordinates, and the largest one."""


def an_object(value: object, where: str) -> Mapping[str, Any]:
    """Return a value that is an object.

    Raises
    ------
    UserError
        If it is none; the message names the place in the file.
    """
    if not isinstance(value, Mapping):
        raise UserError(f"“{where}” is missing, or no object {{…}}.")
    return value


def a_list(value: object, where: str, most: int) -> Sequence[Any]:
    """Return a value that is a list, not too long.

    Raises
    ------
    UserError
        If it is not; the message names the place in the file.
    """
    if not isinstance(value, list | tuple):
        raise UserError(f"“{where}” is missing, or no list […].")
    if len(value) > most:
        entries = "entry" if most == 1 else "entries"
        raise UserError(f"“{where}” has {len(value):,} entries; write {most:,} {entries} at most.")
    return value


def a_number(value: object, where: str, least: float, most: float) -> float:
    """Return a value that is a number within bounds.

    Raises
    ------
    UserError
        If it is not; the message names the place in the file.
    """
    if isinstance(value, int | float) and not isinstance(value, bool) and least <= value <= most:
        return float(value)  # a NaN is in no range
    raise UserError(f"“{where}” must be a number from {least:g} to {most:g}.")


def point_rows(value: object, where: str, coordinates: Coordinates) -> Array:
    """Return the points of a curve, (n, 2) or (n, 3).

    Parameters
    ----------
    value : object
        A list of lists of numbers.
    where : str
        The place in the file.
    coordinates : (str, float)
        `SPACE`, `PLANE` or `PIXELS`.

    Raises
    ------
    UserError
        If it is something else; the message names the place in the file.
    """
    rows = a_list(value, where, MOST_POINTS)
    if len(rows) < 2:
        raise UserError(f"“{where}” needs two points at least.")
    try:
        points = [_point(row, f"{where}[{k}]", coordinates) for k, row in enumerate(rows)]
        made = np.array(points, float)
    except OverflowError:
        raise UserError(f"“{where}” holds a number that is too large.") from None
    return made


def a_point(value: object, where: str, coordinates: Coordinates = SPACE) -> Array:
    """Return a point, (3,) in space, or (2,) with `PLANE` or `PIXELS`.

    Parameters
    ----------
    value : object
        A list of numbers.
    where : str
        The place in the file.
    coordinates : (str, float)
        `SPACE`, `PLANE` or `PIXELS`.

    Raises
    ------
    UserError
        If it is none; the message names the place in the file.
    """
    return np.array(_point(value, where, coordinates))


def _point(value: object, where: str, coordinates: Coordinates) -> list[float]:
    names, farthest = coordinates
    row = a_list(value, where, MOST_POINTS)
    if len(row) != len(names):
        raise UserError(f"“{where}” must be a point [{', '.join(names)}].")
    return [a_number(part, where, -farthest, farthest) for part in row]
