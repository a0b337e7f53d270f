"""Plain values of files, read carefully: objects, lists, numbers and points."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError

MOST_POINTS: Final = 20_000
"""Points of one curve."""

FARTHEST: Final = 1e6
"""Largest coordinate, mm."""


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
        raise UserError(f"“{where}” has more than {most} entries.")
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
    raise UserError(f"“{where}” is a number from {least:g} to {most:g}.")


def point_rows(value: object, where: str, count: int) -> Array:
    """Return the points of a curve, (n, count).

    Parameters
    ----------
    value : object
        A list of lists of numbers.
    where : str
        The place in the file.
    count : int
        Coordinates of each point: 2 or 3.

    Raises
    ------
    UserError
        If it is something else; the message names the place in the file.
    """
    rows = a_list(value, where, MOST_POINTS)
    if len(rows) < 2:
        raise UserError(f"“{where}” needs two points at least.")
    try:
        points = [_point(row, f"{where}[{k}]", count) for k, row in enumerate(rows)]
        made = np.array(points, float)
    except OverflowError:
        raise UserError(f"“{where}” holds a number that is too large.") from None
    return made


def a_point(value: object, where: str) -> Array:
    """Return a point in space, (3,).

    Raises
    ------
    UserError
        If it is none; the message names the place in the file.
    """
    return np.array(_point(value, where, 3))


def _point(value: object, where: str, count: int) -> list[float]:
    row = a_list(value, where, count)
    if len(row) != count:
        raise UserError(f"“{where}” is a point [{', '.join('xyz'[:count])}].")
    return [a_number(part, where, -FARTHEST, FARTHEST) for part in row]
