"""Changes of a body after it was reconstructed: the recipe of each."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Annotated, Any, ClassVar, Literal, Self, TypeAlias

from bozzetto.ink import Strokes
from bozzetto.plugin import Parameter, Part

Point: TypeAlias = tuple[float, float, float]


@dataclass(frozen=True)
class Change(Part):
    """Change of a body after it was reconstructed.

    Parameters
    ----------
    body : str
        Id of the body.
    """

    body: str = ""


@dataclass(frozen=True)
class DrawnChange(Change):
    """A change that strokes say.

    Parameters
    ----------
    strokes : Strokes
        Of one view, in the frame of the body's drawing.
    """

    strokes: Strokes = Strokes()


@dataclass(frozen=True)
class EdgeChange(Change):
    """A change of one edge, of some size.

    Parameters
    ----------
    begin, end : (x, y, z)
        Ends of the edge, as shares of the box around the body: they name it whatever its size.
    """

    begin: Point = (0.0, 0.0, 0.0)
    end: Point = (0.0, 0.0, 0.0)

    sized_by: ClassVar[str]
    """Field that its dot changes, in mm."""

    @property
    def size(self) -> float:
        """Length that its dot changes, mm."""
        return float(getattr(self, self.sized_by))

    def sized(self, size: float) -> Self:
        """Return the same change of another size, mm."""
        changed: dict[str, Any] = {self.sized_by: size}
        return replace(self, **changed)


@dataclass(frozen=True)
class Push(DrawnChange):
    """A loop that was drawn on a face of a body and is pushed in, pulled out, or cut through."""

    depth: Annotated[
        float,
        Parameter(
            "Depth",
            -1e5,
            1e5,
            unit="mm",
            help="How far out it is pulled; below 0, in.",
            idle_while=(("through", (True,)),),
        ),
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
            "Diameter",
            0.0,
            1e5,
            unit="mm",
            zero="as drawn",
            help="Of a loop that is a circle.",
            idle_while=(("outline", ("drawn",)),),
        ),
    ] = 0.0


@dataclass(frozen=True)
class Added(DrawnChange):
    """Lines that were added to a body in one view; where they close, they are faces or solids."""


@dataclass(frozen=True)
class Chamfer(EdgeChange):
    """A bevel along an edge."""

    width: Annotated[
        float,
        Parameter("Width", 0.0, 1e5, unit="mm", help="From the old edge to the new ones."),
    ] = 0.0

    sized_by = "width"


@dataclass(frozen=True)
class Fillet(EdgeChange):
    """An edge that is rounded: a cylinder that touches both of its faces."""

    radius: Annotated[
        float, Parameter("Radius", 0.0, 1e5, unit="mm", help="Of the round edge.")
    ] = 0.0

    sized_by = "radius"


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
class Copies(DrawnChange):
    """Copies of a body at even steps along its one stroke."""

    count: Annotated[
        int, Parameter("Copies", 1, 200, help="How many there are, the first one included.")
    ] = 2


@dataclass(frozen=True)
class Join(DrawnChange):
    """Strokes from a body to another one, which becomes part of it; in the frame of the model.

    Parameters
    ----------
    other : str
        Id of the body that is joined to the first.
    """

    other: str = ""
