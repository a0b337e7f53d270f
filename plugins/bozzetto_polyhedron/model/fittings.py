"""Parts that join bodies and drive them: links, springs, hinges, sliders, motors, and traces."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal, TypeAlias

from bozzetto.plugin import Parameter, Part
from bozzetto_polyhedron.model.changes import Point
from bozzetto_polyhedron.model.limits import require_near

Place: TypeAlias = tuple[float, float]
Drive: TypeAlias = Literal["no", "steady", "swing"]


@dataclass(frozen=True)
class Spot:
    """A place on a body, or fixed in space.

    Parameters
    ----------
    body : str
        Id; "" for what does not move.
    point : (x, y, z)
        Where it is at rest, mm, in the frame of the drawing of its body; of the model where it has
        none.
    corner : (x, y), optional
        Place in the drawing, px, of the corner that it is at, and goes with.
    """

    body: str = ""
    point: Point = (0.0, 0.0, 0.0)
    corner: Place | None = None

    def __post_init__(self) -> None:
        require_near((*self.point, *(self.corner or ())), "A spot")


@dataclass(frozen=True)
class Anchor:
    """A corner that is held.

    Parameters
    ----------
    spot : Spot
        The corner, where it is at rest.
    at : (x, y, z), optional
        Where it is held, mm in the frame of the model; None where it is at rest.
    """

    spot: Spot = Spot()
    at: Point | None = None

    def __post_init__(self) -> None:
        require_near(self.at or (), "A held corner")


@dataclass(frozen=True)
class Fitting(Part):
    """Fitting that joins two spots."""

    begin: Spot = Spot()
    end: Spot = Spot()


@dataclass(frozen=True)
class Link(Fitting):
    """A bar without mass that keeps two corners at a distance."""

    length: Annotated[
        float, Parameter("Length", 1e-3, 1e6, unit="mm", help="Distance of its two ends.")
    ] = 100.0


@dataclass(frozen=True)
class Coil(Fitting):
    """A spring between two corners."""

    length: Annotated[
        float, Parameter("Length", 0.0, 1e6, unit="mm", help="Where it neither pulls nor pushes.")
    ] = 100.0
    stiffness: Annotated[
        float,
        Parameter("Stiffness", 0.01, 1e6, unit="N/m", help="Force of one metre of stretch."),
    ] = 10.0


@dataclass(frozen=True)
class Slider(Fitting):
    """Lets the place where it begins slide along its line, which stands still."""

    turning: Annotated[
        Literal["free", "locked"],
        Parameter(
            "Turning",
            help="Whether what slides may turn meanwhile, as a piston's pin, or not, as a drawer.",
            choices=(("free", "Free"), ("locked", "Locked")),
        ),
    ] = "free"


@dataclass(frozen=True)
class Pin(Fitting):
    """Joins bars of a flat drawing where they cross."""


@dataclass(frozen=True)
class Driven(Fitting):
    """Fitting that turns, by itself or driven."""

    drive: Annotated[
        Drive,
        Parameter(
            "Motor",
            help="How it is driven.",
            choices=(("no", "Turns freely"), ("steady", "Turns steadily"), ("swing", "To and fro")),
        ),
    ] = "no"
    speed: Annotated[
        float,
        Parameter(
            "Speed",
            -3600.0,
            3600.0,
            unit="°/s",
            help="Of a motor that turns steadily.",
            idle_while=(("drive", ("no", "swing")),),
        ),
    ] = 90.0
    angle: Annotated[
        float,
        Parameter(
            "Swing",
            -720.0,
            720.0,
            unit="°",
            help="To each side, to and fro.",
            idle_while=(("drive", ("no", "steady")),),
        ),
    ] = 30.0
    period: Annotated[
        float,
        Parameter(
            "Period",
            0.05,
            600.0,
            unit="s",
            help="Time of once to and fro.",
            idle_while=(("drive", ("no", "steady")),),
        ),
    ] = 2.0


@dataclass(frozen=True)
class Hinge(Driven):
    """An axis along its line: the body where it begins turns about it.

    Parameters
    ----------
    second : str
        Id of the body that it turns against; "" for what does not move, its own where two faces of
        it that are hinged turn at the edge that they share.
    """

    second: str = ""


@dataclass(frozen=True)
class Crank(Driven):
    """Turns the bar between two corners of a flat drawing about the first of them."""

    drive: Annotated[
        Drive,
        Parameter(
            "Motor",
            help="How it is driven.",
            choices=(("no", "Turns freely"), ("steady", "Turns steadily"), ("swing", "To and fro")),
        ),
    ] = "steady"


@dataclass(frozen=True)
class Trace(Part):
    """The path of a corner while things move."""

    at: Spot = Spot()
