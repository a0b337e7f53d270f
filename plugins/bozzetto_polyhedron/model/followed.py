"""Bodies of a mechanism that other objects hand over."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from bozzetto.plugin import Parameter, Part
from bozzetto_polyhedron.model.fittings import Anchor


@dataclass(frozen=True)
class Followed(Part):
    """A part of another object, which moves as one piece.

    Parameters
    ----------
    source : str
        Id of the object.
    solid : str
        Name of the part as the object hands it over; "" for all of it.
    piece : str
        Name of what moves by itself of that part, such as a limb or a door; "" for all that no
        other body is.
    anchors : tuple of Anchor
        Places that stay where they are held.
    """

    source: str = ""
    solid: str = ""
    piece: str = ""
    anchors: tuple[Anchor, ...] = ()
    density: Annotated[
        float,
        Parameter("Density", 1.0, 30000.0, unit="kg/m³", help="What weighs how much; PLA 1240."),
    ] = 1240.0
