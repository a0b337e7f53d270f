"""Typed sizes of what was drawn round."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from bozzetto.plugin import Parameter, Part
from bozzetto_polyhedron.model.fittings import Place


@dataclass(frozen=True)
class RoundSize(Part):
    """Diameter of an edge that was drawn round.

    Parameters
    ----------
    body : str
        Id of the body.
    place : (x, y)
        On the curve in the drawing, px: it names the curve whatever the order of strokes.
    """

    body: str = ""
    place: Place = (0.0, 0.0)
    diameter: Annotated[
        float,
        Parameter("Diameter", 0.0, 1e6, unit="mm", zero="as drawn", help="Of the cylinder."),
    ] = 0.0


@dataclass(frozen=True)
class RimSize(RoundSize):
    """Diameter and depth of a hole, a pocket or a cylinder, all drawn by their rims."""

    depth: Annotated[
        float,
        Parameter(
            "Depth",
            0.0,
            1e6,
            unit="mm",
            zero="as drawn",
            help="How deep a hole is, or how high a cylinder.",
        ),
    ] = 0.0
