"""Of what things are made, for files that know materials."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, NamedTuple

if TYPE_CHECKING:
    from bozzetto.geometry.curve import Color

Finish = Literal["matt", "gloss", "rubber", "metal", "glass"]
"""Materials that surfaces look as if they were made of."""


class Look(NamedTuple):
    """Colour and material of a surface.

    Parameters
    ----------
    color : (r, g, b), optional
        sRGB; None for that of the whole.
    finish : {"matt", "gloss", "rubber", "metal", "glass"}
    material : str
        Name of the material, one for all that have it; "" for a material of one surface only.
    """

    color: Color | None = None
    finish: Finish = "matt"
    material: str = ""
