"""Shapes to draw on: rough shapes, and surfaces of other models."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Final, Literal, get_args

from bozzetto.plugin import Parameter, Part
from bozzetto_product.model.planes import Point

RoughKind = Literal[
    "box", "rounded box", "cylinder", "sphere", "wedge", "bottle", "mouse", "shoe last", "head"
]

KINDS: Final = tuple((kind, kind.capitalize()) for kind in get_args(RoughKind))
"""Rough shapes, and what people call them."""


@dataclass(frozen=True)
class RoughShape(Part):
    """A rough shape to draw on; it is no part of the product.

    Parameters
    ----------
    centre : (x, y, z)
        mm.
    """

    centre: Point = (0.0, 0.0, 0.0)
    kind: Annotated[RoughKind, Parameter("Shape", choices=KINDS)] = "box"
    length: Annotated[float, Parameter("Length", 1e-3, 1e6, unit="mm", help="Along x.")] = 120.0
    width: Annotated[float, Parameter("Width", 1e-3, 1e6, unit="mm", help="Along y.")] = 80.0
    height: Annotated[float, Parameter("Height", 1e-3, 1e6, unit="mm", help="Along z.")] = 60.0


DRAWN_ON: Final = "Drawn on"
"""How the name of a `FollowedShape` begins."""


@dataclass(frozen=True)
class FollowedShape(Part):
    """The surface of another model to draw on; it is no part of the product.

    Parameters
    ----------
    source : str
        Id of the model.
    """

    source: str = ""
