"""The recipe of line drawings: strokes, the answer that was chosen, and typed dimensions."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Literal, TypeAlias

import numpy as np

from bozzetto.arrays import Array, frozen
from bozzetto.geometry import Placement
from bozzetto.ink import Strokes
from bozzetto.plugin import Group, Parameter, Part, PartsState
from bozzetto_polyhedron.model.changes import (
    Added,
    Chamfer,
    Change,
    Copies,
    Fillet,
    Join,
    Mirror,
    Point,
    Push,
)
from bozzetto_polyhedron.model.fittings import (
    Anchor,
    Coil,
    Crank,
    Fitting,
    Hinge,
    Link,
    Pin,
    Place,
    Slider,
    Trace,
)
from bozzetto_polyhedron.model.followed import Followed
from bozzetto_polyhedron.model.limits import require_near
from bozzetto_polyhedron.model.round_sizes import RimSize, RoundSize

Color: TypeAlias = tuple[int, int, int]

MOST_ANSWERS = 8
"""Readings of a drawing that are kept: the right one is hardly ever further behind."""


@dataclass(frozen=True)
class Choice:
    """The answer that a person chose, told by its shape.

    So it is found again when strokes are added, or when better code ranks the answers otherwise.

    Parameters
    ----------
    number : int
        What `Body.answer` was then; a choice counts as long as it is still that.
    vertices : tuple of (x, y, z)
        Of the answer, mm, in the frame of the drawing.
    """

    number: int = 1
    vertices: tuple[Point, ...] = ()


def _no_rows() -> Array:
    return frozen([], np.float64, 3)


@dataclass(frozen=True, eq=False)
class Moved:
    """Where the pieces of a machine are, and how they move; see `mechanism.assembly.Motion`.

    Parameters
    ----------
    places, velocities, momenta : (n, 3) float64
        m, m/s, kg m²/s.
    turns : (3 n, 3) float64
        Rotations, row by row.
    seconds : float
        Time since rest.
    """

    places: Array = field(default_factory=_no_rows)
    turns: Array = field(default_factory=_no_rows)
    velocities: Array = field(default_factory=_no_rows)
    momenta: Array = field(default_factory=_no_rows)
    seconds: float = 0.0

    def __post_init__(self) -> None:
        counts = {len(self.places), len(self.velocities), len(self.momenta)}
        if counts != {len(self.turns) / 3}:
            raise ValueError("every piece needs a place, a turn, a velocity and a momentum")
        for values in (self.places, self.turns, self.velocities, self.momenta, self.seconds):
            require_near(values, "A piece")


@dataclass(frozen=True)
class Grab:
    """Grip of the pen.

    Parameters
    ----------
    begin : (x, y)
        Where the drag began, px: another one grabs anew.
    body : str
        Id.
    vertex : int
        Of the body.
    depth : float
        How far the pen has pulled along the view, away from the eye, mm.
    """

    begin: Place
    body: str
    vertex: int
    depth: float = 0.0


@dataclass(frozen=True, eq=False)
class Recording:
    """Poses of all pieces of a machine, one after the other.

    Parameters
    ----------
    seconds : (t, 1) float64
        Time since rest.
    places : (t n, 3) float64
        m.
    turns : (3 t n, 3) float64
        Rotations, row by row.
    """

    seconds: Array = field(default_factory=lambda: frozen([], np.float64, 1))
    places: Array = field(default_factory=_no_rows)
    turns: Array = field(default_factory=_no_rows)

    def __post_init__(self) -> None:
        count = len(self.seconds)
        if 3 * len(self.places) != len(self.turns) or (count and len(self.places) % count):
            raise ValueError("every pose needs a place and a turn of each piece")
        for values in (self.seconds, self.places, self.turns):
            require_near(values, "A piece")


@dataclass(frozen=True)
class Body(Part):
    """A drawing of one solid or sheet, seen in one view.

    Parameters
    ----------
    strokes : Strokes
        Raw ink, each stroke with its camera, in the order drawn, in the frame of the drawing.
    choice : Choice, optional
        None until a person turned the drawing into a solid.
    placement : Placement
        From the frame of the drawing to that of the model: how the body was moved since.
    anchors : tuple of Anchor
        Corners that stay where they are held when the body moves.
    guessed : Strokes
        Hidden edges that were guessed, as they were put behind the strokes drawn.
    guess : int
        Which guess they are, counted from 0.
    guess_certainty : float
        How likely they are what was meant.
    """

    strokes: Strokes = Strokes()
    choice: Choice | None = None
    placement: Placement = Placement()
    anchors: tuple[Anchor, ...] = ()
    guessed: Strokes = Strokes()
    guess: int = 0
    guess_certainty: float = 1.0
    answer: Annotated[
        int,
        Parameter(
            "Answer",
            1,
            MOST_ANSWERS,
            help="Which solid the drawing shows, the likeliest first.",
            in_forms=False,
        ),
    ] = 1
    hidden: Annotated[
        Literal["light", "unmarked"],
        Parameter(
            "Hidden edges",
            help="Whether edges that were drawn lightly or dashed are the hidden ones.",
            choices=(("light", "Drawn lightly"), ("unmarked", "Drawn like the others")),
        ),
    ] = "light"
    rounds: Annotated[
        Literal["clear", "all", "none"],
        Parameter(
            "Ellipses",
            help="What of the drawing is round: ellipses, and arcs between two lines.",
            choices=(
                ("clear", "Round where that is clear"),
                ("all", "Round wherever it may be"),
                ("none", "Nothing is round"),
            ),
        ),
    ] = "clear"
    wall: Annotated[
        float, Parameter("Sheet", 0.0, 1e4, unit="mm", zero="solid", help="Thickness of its faces.")
    ] = 0.0
    density: Annotated[
        float,
        Parameter("Density", 1.0, 30000.0, unit="kg/m³", help="What weighs how much; PLA 1240."),
    ] = 1240.0
    moves: Annotated[
        Literal["whole", "links", "plates", "flat"],
        Parameter(
            "Moves as",
            help="What of it stays rigid when it is pulled.",
            choices=(
                ("whole", "One piece"),
                ("links", "Bars between corners"),
                ("plates", "Faces hinged at edges"),
                ("flat", "Bars, flat as drawn"),
            ),
        ),
    ] = "whole"
    lid: Annotated[
        Literal["closed", "open"],
        Parameter(
            "Top",
            help="Open leaves out the face that looks up most, as in a box without a lid.",
            choices=(("closed", "Closed"), ("open", "Open")),
        ),
    ] = "closed"
    color: Annotated[Color | None, Parameter("Colour", help="Colour of this solid.")] = None

    @property
    def drawn(self) -> Strokes:
        """The strokes without guessed ones, if these are still the last ones as they were.

        Where a person erased some of them or drew on, they are what that person means, and stay.
        """
        count = len(self.guessed)
        last = tuple(self.strokes)[len(self.strokes) - count :] if count else ()
        alike = [
            np.array_equal(one.points, other.points)
            for one, other in zip(last, self.guessed, strict=False)
        ]
        if count and len(alike) == count and all(alike):
            return Strokes(tuple(self.strokes)[:-count])
        return self.strokes

    @property
    def evidence(self) -> Literal["clear", "all", "none"]:
        """How much evidence reading something as round needs; bars are never round."""
        return "none" if self.moves == "flat" else self.rounds

    def __post_init__(self) -> None:
        for camera in {stroke.camera for stroke in self.strokes}:
            require_near((*camera.eye, *camera.target, camera.height), "A drawing")
            if min(camera.viewport) < 1.0:
                raise ValueError("a drawing needs a canvas of a pixel at least")
        for stroke in self.strokes:
            require_near(stroke.points, "Ink")
        require_near((*self.placement.offset, self.placement.scale), "A body")
        if not 0.0 <= self.guess_certainty <= 1.0:
            raise ValueError("a certainty is a share of 1")


@dataclass(frozen=True)
class Measure(Part):
    """A dimension that a person typed: the distance of two parallel faces along an edge.

    Parameters
    ----------
    body : str
        Id of the body.
    begin, end : (x, y)
        Ends of the edge in the drawing, px: they name the edge whatever the order of strokes.
    """

    body: str = ""
    begin: Place = (0.0, 0.0)
    end: Place = (0.0, 0.0)
    length: Annotated[
        float,
        Parameter("Length", 1e-3, 1e6, unit="mm", help="Distance of the faces at its two ends."),
    ] = 100.0


@dataclass(frozen=True)
class Slant(Part):
    """A face that keeps the angle that was drawn, and all that are parallel to it.

    Parameters
    ----------
    body : str
        Id of the body.
    corners : tuple of (x, y)
        Of the face in the drawing, px: they name it whatever the order of strokes.
    """

    body: str = ""
    corners: tuple[Place, ...] = ()


@dataclass(frozen=True)
class Opening(Part):
    """A face that is left out, after all that was drawn on its body.

    Parameters
    ----------
    body : str
        Id of the body.
    place : (x, y, z)
        Of a point within the face, as shares of the box around the body.
    normal : (x, y, z)
        Of the face, outward, in the frame of the body's drawing.
    """

    body: str = ""
    place: Point = (0.0, 0.0, 0.0)
    normal: Point = (0.0, 0.0, 1.0)


@dataclass(frozen=True)
class BodyGroup(Group):
    """Parts that belong together."""


@dataclass(frozen=True)
class Dimension:
    """A distance between two parallel faces.

    Parameters
    ----------
    faces : (int, int)
        Numbers of faces in the order of the answer.
    length : float
        mm.
    """

    faces: tuple[int, int]
    length: float


@dataclass(frozen=True)
class PolyhedronState(PartsState):
    """Bodies, each with the drawing that it comes from, their dimensions, and how they moved.

    Parameters
    ----------
    moved : Moved, optional
        None where everything is as it was drawn.
    grab : Grab, optional
        What the pen holds, or held last.
    recorded : Recording, optional
        How everything moved since it was at rest, while that was recorded.
    """

    nodes: tuple[
        Body
        | Measure
        | RoundSize
        | RimSize
        | Slant
        | Opening
        | Push
        | Added
        | Chamfer
        | Fillet
        | Mirror
        | Copies
        | Join
        | Link
        | Coil
        | Slider
        | Pin
        | Hinge
        | Crank
        | Trace
        | Followed
        | BodyGroup,
        ...,
    ] = ()
    exact: Annotated[
        bool,
        Parameter("Right angles", help="Angles that are nearly right become right, exactly."),
    ] = True
    equal: Annotated[
        bool,
        Parameter("Equal lengths", help="Lengths that are nearly equal become equal, exactly."),
    ] = False
    files: Annotated[
        Literal["solids", "faces", "nets"],
        Parameter(
            "Files get",
            help="Solids, or their faces laid flat at true size for SVG and DXF.",
            choices=(
                ("solids", "Solids"),
                ("faces", "Every face, flat"),
                ("nets", "Nets to cut and fold"),
            ),
        ),
    ] = "solids"
    tab: Annotated[
        float,
        Parameter(
            "Tabs", 0.0, 1e3, unit="mm", zero="none", help="Width of the tabs of nets, to glue on."
        ),
    ] = 0.0
    behind: Annotated[
        Literal["faint", "dashed", "hide"],
        Parameter(
            "Edges behind",
            help="How edges are shown that the solid itself hides.",
            choices=(("faint", "Faint"), ("dashed", "Dashed"), ("hide", "Not at all")),
        ),
    ] = "faint"
    gravity: Annotated[bool, Parameter("Gravity", help="Whether what moves is heavy.")] = False
    damping: Annotated[
        float,
        Parameter(
            "Damping", 0.0, 20.0, step=0.1, unit="1/s", help="How soon what swings comes to rest."
        ),
    ] = 1.0
    ground: Annotated[bool, Parameter("Ground", help="Whether what falls lands on the ground.")] = (
        False
    )
    contact: Annotated[
        bool,
        Parameter("Contact", help="Whether bodies meet: solids one another, a lid its box."),
    ] = True
    friction: Annotated[
        float,
        Parameter("Friction", 0.0, 2.0, step=0.05, help="Of all that touches (Coulomb's μ)."),
    ] = 0.5
    forces: Annotated[
        bool,
        Parameter(
            "Forces", help="Show how much bars are pulled or pressed by weights and springs."
        ),
    ] = False
    records: Annotated[
        bool, Parameter("Record", help="Whether motions are kept, for traces and films.")
    ] = True
    planar: Annotated[
        Literal["no", "x", "y", "z"],
        Parameter(
            "Flat motion",
            help="The direction in which nothing moves.",
            choices=(
                ("no", "Free in space"),
                ("x", "Not along X"),
                ("y", "Not along Y"),
                ("z", "Not along Z"),
            ),
            advanced=True,
        ),
    ] = "no"
    moved: Moved | None = None
    grab: Grab | None = None
    recorded: Recording | None = None

    def measures_of(self, body: Body) -> tuple[Measure, ...]:
        """Return the visible dimensions of a body."""
        return tuple(each for each in self.shown(Measure) if each.body == body.id)

    def round_sizes_of(self, body: Body) -> tuple[RoundSize, ...]:
        """Return the visible typed sizes of what was drawn round in a body."""
        return tuple(each for each in self.shown(RoundSize) if each.body == body.id)

    def slants_of(self, body: Body) -> tuple[Slant, ...]:
        """Return the visible faces of a body that keep their slant."""
        return tuple(each for each in self.shown(Slant) if each.body == body.id)

    def openings_of(self, body: Body) -> tuple[Opening, ...]:
        """Return the visible openings of a body."""
        return tuple(each for each in self.shown(Opening) if each.body == body.id)

    def changes_of(self, body: Body) -> tuple[Change, ...]:
        """Return what was done to a body and is visible, in order."""
        return tuple(each for each in self.shown(Change) if each.body == body.id)

    def body_of_chosen(self) -> str:
        """Return the id of the body that is chosen, or the one that what is chosen belongs to."""
        if not any(node.id == self.selected for node in self.nodes):
            return self.selected
        node = self.node(self.selected)
        of_body = isinstance(node, Measure | RoundSize | Slant | Opening | Change)
        return node.body if of_body else self.selected

    def chosen_first(self) -> list[Body]:
        """Return the bodies that are shown and have ink, the chosen one first."""
        bodies = [body for body in self.shown(Body) if len(body.strokes)]
        wanted = self.body_of_chosen()
        return sorted(bodies, key=lambda body: body.id != wanted)

    def fittings(self) -> tuple[Fitting, ...]:
        """Return the visible links, springs, hinges, sliders and cranks."""
        return self.shown(Fitting)
