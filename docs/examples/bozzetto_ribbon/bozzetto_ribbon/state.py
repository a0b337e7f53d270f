"""The recipe of ribbons: the ink, where it lies in space, and how to make ribbons of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from bozzetto.ink import Stroke
from bozzetto.plugin import Parameter

Point = tuple[float, float, float]


@dataclass(frozen=True)
class Band:
    """One stroke and the plane it lies in.

    Parameters
    ----------
    stroke : Stroke
        The ink as it was drawn, with its camera.
    through : (x, y, z)
        A point of the plane, mm; the plane is parallel to the screen of that camera.
    shift : (x, y, z)
        How far the ribbon was moved afterwards, mm.
    """

    stroke: Stroke
    through: Point
    shift: Point = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class RibbonState:
    """All ribbons of a model and the parameters that they share."""

    bands: tuple[Band, ...] = ()
    width: Annotated[
        float,
        Parameter("Width", 0.5, 100.0, step=0.5, unit="mm", help="Width at full pressure."),
    ] = 8.0
    influence: Annotated[
        float,
        Parameter(
            "Pressure",
            0.0,
            1.0,
            step=0.05,
            help="How much a light hand narrows the ribbon; 0 keeps it even.",
        ),
    ] = 0.7
    twist: Annotated[
        float,
        Parameter(
            "Twist",
            -5.0,
            5.0,
            step=0.25,
            unit="turns",
            help="How often the ribbon winds about its middle from end to end.",
            advanced=True,
        ),
    ] = 0.0
