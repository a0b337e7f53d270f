"""Colours in files."""

from __future__ import annotations

from bozzetto.errors import UserError
from bozzetto.ink import a_list, a_number
from bozzetto_product.model.appearance import Color


def a_color(value: object, where: str) -> Color:
    """Return a value that is a colour: red, green and blue from 0 to 255.

    Raises
    ------
    UserError
        If it is none; the message names the place in the file.
    """
    row = a_list(value, where, 3)
    if len(row) != 3:
        raise UserError(f"“{where}” is [red, green, blue].")
    red, green, blue = (round(a_number(part, where, 0, 255)) for part in row)
    return red, green, blue
