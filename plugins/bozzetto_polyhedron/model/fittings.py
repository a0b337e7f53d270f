"""Parts that join bodies and drive them: links, springs, hinges, sliders, motors, and traces."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal, TypeAlias

from bozzetto.plugin import Parameter, Part, override
from bozzetto_polyhedron.model.changes import Point
from bozzetto_polyhedron.model.limits import require_near
from bozzetto_polyhedron.model.motor_curves import typed_keys

Place: TypeAlias = tuple[float, float]
TurningMotor: TypeAlias = Literal["no", "steady", "swing", "curve"]
PushingMotor: TypeAlias = Literal["no", "swing", "curve"]
Repeats: TypeAlias = Literal["again", "once"]

_TURNING = Parameter(
    "Motor",
    help="How it is driven.",
    choices=(
        ("no", "Turns freely"),
        ("steady", "Turns steadily"),
        ("swing", "To and fro"),
        ("curve", "By a curve"),
    ),
)


def _period(*idle: str) -> Parameter:
    return Parameter(
        "Period",
        0.05,
        600.0,
        unit="s",
        help="Time of once to and fro.",
        idle_while=(("drive", idle),),
    )


def _repeats(*idle: str) -> Parameter:
    return Parameter(
        "Then",
        help="Whether the curve begins again after its last time, or stays there.",
        choices=(("again", "Begins again"), ("once", "Stays there")),
        idle_while=(("drive", idle),),
    )


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
class Driven(Fitting):
    """Fitting that may have a motor.

    Parameters
    ----------
    since : float
        Time since rest at which its motor began, s.
    offset : float
        By how much things were beyond its course then, ° or mm.
    """

    since: float = 0.0
    offset: float = 0.0

    def __post_init__(self) -> None:
        require_near((self.since, self.offset), "A motor")


@dataclass(frozen=True)
class Slider(Driven):
    """Lets the place where it begins slide along its line, which stands still."""

    turning: Annotated[
        Literal["free", "locked"],
        Parameter(
            "Turning",
            help="Whether what slides may turn meanwhile, as a piston's pin, or not, as a drawer.",
            choices=(("free", "Free"), ("locked", "Locked")),
        ),
    ] = "free"
    drive: Annotated[
        PushingMotor,
        Parameter(
            "Motor",
            help="How it is driven along its line.",
            choices=(("no", "Slides freely"), ("swing", "To and fro"), ("curve", "By a curve")),
        ),
    ] = "no"
    travel: Annotated[
        float,
        Parameter(
            "Travel",
            -1e5,
            1e5,
            unit="mm",
            help="To each side, to and fro.",
            idle_while=(("drive", ("no", "curve")),),
        ),
    ] = 20.0
    period: Annotated[float, _period("no", "curve")] = 2.0
    curve: Annotated[
        str,
        Parameter(
            "Places at times",
            help="Seconds, a colon and mm along its line, with commas: 0: 0, 1: 40, 2: 0.",
            idle_while=(("drive", ("no", "swing")),),
        ),
    ] = "0: 0, 1: 40, 2: 0"
    repeats: Annotated[Repeats, _repeats("no", "swing")] = "again"

    @override
    def __post_init__(self) -> None:
        super().__post_init__()
        typed_keys(self.curve)


@dataclass(frozen=True)
class Pin(Fitting):
    """Joins bars of a flat drawing where they cross."""


@dataclass(frozen=True)
class Turning(Driven):
    """Fitting that turns, by itself or driven."""

    drive: Annotated[TurningMotor, _TURNING] = "no"
    speed: Annotated[
        float,
        Parameter(
            "Speed",
            -3600.0,
            3600.0,
            unit="°/s",
            help="Of a motor that turns steadily.",
            idle_while=(("drive", ("no", "swing", "curve")),),
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
            idle_while=(("drive", ("no", "steady", "curve")),),
        ),
    ] = 30.0
    period: Annotated[float, _period("no", "steady", "curve")] = 2.0
    curve: Annotated[
        str,
        Parameter(
            "Angles at times",
            help="Seconds, a colon and degrees, with commas: 0: 0, 1: 90, 2: 0.",
            idle_while=(("drive", ("no", "steady", "swing")),),
        ),
    ] = "0: 0, 1: 90, 2: 0"
    repeats: Annotated[Repeats, _repeats("no", "steady", "swing")] = "again"

    @override
    def __post_init__(self) -> None:
        super().__post_init__()
        typed_keys(self.curve)


@dataclass(frozen=True)
class Hinge(Turning):
    """An axis along its line: the body where it begins turns about it.

    Parameters
    ----------
    second : str
        Id of the body that it turns against; "" for what does not move, its own where two faces of
        it that are hinged turn at the edge that they share.
    """

    second: str = ""


@dataclass(frozen=True)
class Crank(Turning):
    """Turns the bar between two corners of a flat drawing about the first of them."""

    drive: Annotated[TurningMotor, _TURNING] = "steady"


@dataclass(frozen=True)
class Trace(Part):
    """The path of a corner while things move."""

    at: Spot = Spot()
