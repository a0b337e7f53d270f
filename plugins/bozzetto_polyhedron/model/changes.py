"""What is done to a body after it was reconstructed: the recipe of each change."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal, TypeAlias

from bozzetto.ink import Strokes
from bozzetto.plugin import Parameter, Part

Point: TypeAlias = tuple[float, float, float]


@dataclass(frozen=True)
class Change(Part):
    """What was done to a body after it was reconstructed.

    Parameters
    ----------
    body : str
        Id of the body.
    """

    body: str = ""


@dataclass(frozen=True)
class Push(Change):
    """A loop that was drawn on a face of a body and is pushed in, pulled out, or cut through.

    Parameters
    ----------
    strokes : Strokes
        Of one view, in the frame of the body's drawing.
    """

    strokes: Strokes = Strokes()
    depth: Annotated[
        float,
        Parameter("Depth", -1e5, 1e5, unit="mm", help="How far out it is pulled; below 0, in."),
    ] = 0.0
    through: Annotated[bool, Parameter("Through", help="Cut through all of the body.")] = False
    outline: Annotated[
        Literal["drawn", "circle"],
        Parameter(
            "Outline",
            help="Whether the loop has the corners that were drawn, or is a circle on its face.",
            choices=(("drawn", "As drawn"), ("circle", "Circle")),
        ),
    ] = "drawn"
    diameter: Annotated[
        float,
        Parameter(
            "Diameter", 0.0, 1e5, unit="mm", zero="as drawn", help="Of a loop that is a circle."
        ),
    ] = 0.0


@dataclass(frozen=True)
class Added(Change):
    """Lines that were added to a body in one view; where they close, they are faces or solids.

    Parameters
    ----------
    strokes : Strokes
        Of one view, in the frame of the body's drawing.
    """

    strokes: Strokes = Strokes()


@dataclass(frozen=True)
class Chamfer(Change):
    """A bevel along an edge.

    Parameters
    ----------
    begin, end : (x, y, z)
        Ends of the edge, as shares of the box around the body: they name it whatever its size.
    """

    begin: Point = (0.0, 0.0, 0.0)
    end: Point = (0.0, 0.0, 0.0)
    width: Annotated[
        float,
        Parameter("Width", 0.0, 1e5, unit="mm", help="From the old edge to the new ones."),
    ] = 0.0


@dataclass(frozen=True)
class Mirror(Change):
    """A plane in which a body is mirrored, and joined with its image.

    Parameters
    ----------
    place : (x, y, z)
        A point of the plane, as shares of the box around the body.
    normal : (x, y, z)
        Across the plane, in the frame of the body's drawing.
    """

    place: Point = (0.0, 0.0, 0.0)
    normal: Point = (1.0, 0.0, 0.0)
    keeps: Annotated[
        Literal["both", "image"],
        Parameter(
            "Keep",
            help="Whether the body stays beside its mirror image.",
            choices=(("both", "Both, as one"), ("image", "The image alone")),
        ),
    ] = "both"


@dataclass(frozen=True)
class Copies(Change):
    """Copies of a body at even steps along a stroke.

    Parameters
    ----------
    strokes : Strokes
        One, in the frame of the body's drawing.
    """

    strokes: Strokes = Strokes()
    count: Annotated[
        int, Parameter("Copies", 1, 200, help="How many there are, the first one included.")
    ] = 2


@dataclass(frozen=True)
class Join(Change):
    """Strokes from a body to another one, which becomes part of it.

    Parameters
    ----------
    other : str
        Id of the body that is joined to the first.
    strokes : Strokes
        Each from the first to the other, in the frame of the model.
    """

    other: str = ""
    strokes: Strokes = Strokes()
