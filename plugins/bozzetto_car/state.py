"""The state of a car: sketches with marks, edits by hand, and styling curves.

It holds nothing that can be computed. Marks are in pixels of their picture and stay valid when
cameras and templates change. Edits are listed in the order in which they were made; whenever a
mark changes, they are applied again, each to the result of those before it.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Final, Literal

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.geometry import Mesh, frozen
from bozzetto.ink import Strokes
from bozzetto.plugin import Group, Parameter, Part, PartsState
from bozzetto.scene import Picture
from bozzetto_car.dimensions import LONGEST, Dimensions
from bozzetto_car.template.line_joints import LineJoint
from bozzetto_car.template.loader import Bundled, bundled_file
from bozzetto_car.tyre_size import tyre_size

Point = tuple[float, float, float]
Color = tuple[int, int, int]
Side = Literal["L", "R"]

BLANK: Final = (1600.0, 1000.0)
"""Size of a sketch without a picture, px."""

TRACE: Final = 0.6
"""Default balance of marks and template: a hand of 0.2 per cent, 2 px for a car of 1000 px."""

BESIDE: Final = 1e-6
"""How far rounding may put a place of a styling curve outside its patch, in u and v."""

NO_OWN: Final = (
    "This car has no template of its own. Choose another template, or import the file of one: "
    "that begins a car with it."
)

FOUND: Final = "as drawn"
"""The text that a panel shows for a dimension that is not given."""

GIVEN: Final = ("length", "width", "height", "front_overhang", "wheelbase")
"""Fields of the dimensions that may be given; 0 for those that are not."""

TITLES: Final = (
    ("sedan", "Sedan"),
    ("hatchback", "Hatchback"),
    ("minivan", "Minivan"),
    ("estate", "Estate"),
    ("coupe", "Coupé"),
    ("limousine", "Limousine"),
    ("city_car", "City car"),
    ("suv", "SUV"),
    ("van", "Van"),
    ("pickup", "Pickup"),
)
"""Bundled templates, and what a person reads."""


# -- what was done to the body ---------------------------------------------------------------------


@dataclass(frozen=True)
class BodyEdit:
    """An edit of nodes or edges by hand.

    Parameters
    ----------
    dimensions : Dimensions
        The dimensions that the body had at the time of the edit, none where it could not have
        those that were wanted; the edit is applied to the body with these.
    kept : bool or None
        Whether the car was solved for them, and not stretched to them. None in a drawing that is
        older than this: they are taken to be as the car's are now.
    """

    dimensions: Dimensions = Dimensions()
    kept: bool | None = field(default=None, kw_only=True)


@dataclass(frozen=True)
class TracedEdges(BodyEdit):
    """A stroke along the picture of the body, which bends the edges that it runs along.

    Parameters
    ----------
    strokes : Strokes
        One stroke, with the camera of the view that it was drawn in.
    sketch : str
        Id of the sketch that it was drawn on; "" for any other view. On a sketch, its places are
        pixels of the picture, and its camera is the solved camera of the sketch.
    edges : tuple of str
        Names of the edges that are meant, in the order of the row that they make; none for the
        nearest edges.
    nodes_follow : bool
        Whether nodes move to the stroke, too.
    """

    strokes: Strokes = Strokes()
    sketch: str = ""
    edges: tuple[str, ...] = ()
    nodes_follow: bool = False


@dataclass(frozen=True)
class MovedNode(BodyEdit):
    """A move of a node and its mirror image, mm; tangents stay as they are."""

    node: str = ""
    by: Point = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class BentEdge(BodyEdit):
    """Another tangent, mm, of an edge at its start (0) or its end (1)."""

    edge: str = ""
    end: int = 0
    tangent: Point = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Treatment(BodyEdit):
    """An edit of all edges at once.

    Parameters
    ----------
    kind : {"anneal", "reduce", "pull out"}
        Smooth lines through their nodes; tangents cut to a third of the chord; panels and
        corners pulled out.
    """

    kind: Literal["anneal", "reduce", "pull out"] = "anneal"


# -- parts -----------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Mark:
    """The place of a node in a sketch, in px from the top left corner of the picture, y down."""

    node: str
    u: float
    v: float


@dataclass(frozen=True)
class Sketch(Part):
    """A picture of the car, and the marks on it.

    Parameters
    ----------
    picture : Picture, optional
    width, height : float
        Size of the picture that marks refer to, px.
    marks : tuple of Mark
        Marks in the order in which they were set; a node is marked once at most.
    skipped : tuple of str
        Nodes that the person has noted as not visible in this sketch.
    """

    picture: Picture | None = None
    width: float = BLANK[0]
    height: float = BLANK[1]
    marks: tuple[Mark, ...] = ()
    skipped: tuple[str, ...] = ()
    shows: Annotated[
        Side,
        Parameter(
            "Shows",
            help="The side of the car that the sketch shows; two marked wheels tell it.",
            choices=(("L", "Left side: nose to the left"), ("R", "Right side: nose to the right")),
        ),
    ] = "L"
    kind: Annotated[
        Literal["auto", "perspective", "orthographic"],
        Parameter(
            "Camera",
            help="The projection in which the sketch was drawn.",
            choices=(
                ("auto", "Find out"),
                ("perspective", "Perspective"),
                ("orthographic", "Orthographic"),
            ),
        ),
    ] = "auto"
    cropped: Annotated[
        bool, Parameter("Cropped", help="The picture is cut out of a larger one.")
    ] = False
    opacity: Annotated[
        float,
        Parameter("Strength", 0.0, 1.0, step=0.05, help="Opacity of the picture on the sheet."),
    ] = 0.8

    locked: Annotated[
        bool, Parameter("Locked", help="The marks on this sketch cannot be set, moved or erased.")
    ] = False

    @property
    def size(self) -> tuple[float, float]:
        """Width and height of the picture, px."""
        return self.width, self.height

    def mark_of(self, node: str) -> Mark | None:
        """Return the mark of a node; None if it is not set."""
        return next((mark for mark in self.marks if mark.node == node), None)


@dataclass(frozen=True)
class SurfacePoint:
    """The place of a node on the mesh of a car, mm; of a pair, of the right one."""

    node: str
    x: float
    y: float
    z: float

    @property
    def place(self) -> Array:
        """The place, (3,)."""
        return np.array([self.x, self.y, self.z])

    def on_both_sides(self) -> tuple[tuple[str, Array], ...]:
        """Return the node and its place, and those of its image if it is one of a pair."""
        half, right, _ = self.node.partition(".R")
        own = (self.node, self.place)
        return (own, (f"{half}.L", self.place * [1.0, -1.0, 1.0])) if right else (own,)


def _no_mesh() -> Mesh:
    return Mesh(np.zeros((0, 3), np.float32), np.zeros((0, 3), np.int32))


@dataclass(frozen=True)
class CarMesh(Part):
    """The mesh of a car that the template takes the shape of, and the points marked on it.

    Parameters
    ----------
    mesh : Mesh
        Standing as a template does, mm.
    points : tuple of SurfacePoint
        In the order in which they were set; a node is marked once at most.
    """

    mesh: Mesh = field(default_factory=_no_mesh)
    points: tuple[SurfacePoint, ...] = ()
    opacity: Annotated[
        float, Parameter("Opacity", 0.0, 1.0, step=0.05, help="How much of the mesh is seen.")
    ] = 0.5

    def point_of(self, node: str) -> SurfacePoint | None:
        """Return the mark of a node; None if it is not set."""
        return next((point for point in self.points if point.node == node), None)


@dataclass(frozen=True, eq=False)
class StylingCurve(Part):
    """A line on the body, stored by patch, u and v, so that it follows all later changes.

    Parameters
    ----------
    patches : tuple of str
        Names of patches.
    on : (n,) int
        For each place of the curve, in order, the index of its patch in `patches`.
    places : (n, 2) float
        u and v on that patch.
    """

    patches: tuple[str, ...] = ()
    on: NDArray[np.int32] = field(default_factory=lambda: np.zeros(0, np.int32))
    places: Array = field(default_factory=lambda: np.zeros((0, 2)))
    both: Annotated[
        bool, Parameter("On both sides", help="Show the mirror image on the other side, too.")
    ] = True
    color: Annotated[Color | None, Parameter("Colour", help="Colour of this curve.")] = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "on", frozen(self.on, np.int32))
        object.__setattr__(self, "places", frozen(self.places, np.float64, 2))
        if self.on.shape != (len(self.places),):
            raise ValueError("a styling curve needs the patch of each of its places")
        if len(self.on) and not 0 <= self.on.min() <= self.on.max() < len(self.patches):
            raise ValueError("a styling curve lies on a patch that it does not name")
        if not (np.abs(self.places - 0.5) <= 0.5 + BESIDE).all():
            raise ValueError("a styling curve has a place beside its patch")


# -- the car ---------------------------------------------------------------------------------------


def _dimension(label: str, help_: str) -> Parameter:
    return Parameter(label, 0.0, LONGEST, step=10.0, unit="mm", help=help_, zero=FOUND)


def _advanced(label: str, help_: str) -> Parameter:
    return Parameter(label, advanced=True, help=help_)


@dataclass(frozen=True)
class CarState(PartsState):
    """Sketches, styling curves, edits by hand, and how the car is solved and shown.

    Parameters
    ----------
    nodes : tuple of Sketch, CarMesh, StylingCurve or Group
    selected : str
        Id of the node that is chosen; "" for none.
    asked : str
        The node that is to be marked next, out of order; "" for the next one in order.
    revealed : str
        Name of the node or the edge whose tangents are shown to be dragged; "" for none.
    edits : tuple of BodyEdit
        Edits by hand in the order in which they were made.
    joints : tuple of LineJoint
        Lines that are sharp or smooth other than in the template.
    flowing : tuple of str
        Names of edges; the smooth line along each runs with one curvature (G2) over its nodes.
    without : tuple of str
        Names of the soundness constraints that are switched off.
    own : str
        A template of the person's own (``bozzetto-car-template/1``, JSON), which counts where
        `template` is "own"; "" for none.
    """

    nodes: tuple[Sketch | CarMesh | StylingCurve | Group, ...] = ()
    selected: str = ""
    asked: str = ""
    revealed: str = ""
    edits: tuple[TracedEdges | MovedNode | BentEdge | Treatment, ...] = ()
    joints: tuple[LineJoint, ...] = ()
    flowing: tuple[str, ...] = ()
    without: tuple[str, ...] = ()
    own: str = ""
    template: Annotated[
        Literal[Bundled, "own"],
        Parameter(
            "Template",
            help="The car that takes the shape of the sketch; one of your own comes from its file.",
            choices=(*TITLES, ("own", "My own")),
        ),
    ] = "sedan"
    blend: Annotated[
        Literal["none", Bundled],
        Parameter(
            "Blend with",
            help="Another template: the car begins between both.",
            choices=(("none", "Nothing"), *TITLES),
        ),
    ] = "none"
    share: Annotated[
        float,
        Parameter("Share", 0.0, 1.0, step=0.05,
                  help="How far from the template to the one it is blended with.",
                  idle_while=(("blend", ("none",)),)),
    ] = 0.5  # fmt: skip
    trace: Annotated[
        float,
        Parameter("Follow the marks", 0.0, 1.0, step=0.05,
                  help="0 stays plausible, 1 traces the marks exactly."),
    ] = TRACE  # fmt: skip
    shading: Annotated[
        Literal["shaded", "zebra", "curvature", "certainty", "draft"],
        Parameter(
            "Shading",
            help="What the colour of the body shows.",
            choices=(
                ("shaded", "Paint and glass"),
                ("zebra", "Zebra: reflection lines"),
                ("curvature", "Curvature"),
                ("certainty", "Seen, mirrored or guessed"),
                ("draft", "Draft: over the sketch"),
            ),
        ),
    ] = "shaded"
    body: Annotated[bool, Parameter("Body", help="Show the surfaces of the template.")] = True
    network: Annotated[bool, Parameter("Edges", help="Show the edges of the template.")] = True
    wheels: Annotated[bool, Parameter("Wheels", help="Show the wheels.")] = True
    complete: Annotated[
        bool,
        Parameter("Complete car",
                  help="Hand over a closed body with wheel arches and a floor, panes, lamps and "
                  "trim, instead of its surfaces."),
    ] = False  # fmt: skip
    mirrors: Annotated[
        bool,
        Parameter(
            "Mirrors",
            help="Give a complete car mirrors at its foremost side windows.",
            idle_while=(("complete", (False,)),),
        ),
    ] = False
    creases: Annotated[
        bool, Parameter("Creases", help="Show by how many degrees surfaces meet at an angle.")
    ] = False
    tyre: Annotated[
        str,
        Parameter("Tyres",
                  help="Size of the tyres, such as 205/55 R16; empty for wheels as drawn."),
    ] = ""  # fmt: skip
    length: Annotated[float, _dimension("Length", "From nose to tail.")] = 0.0
    width: Annotated[float, _dimension("Width", "Without mirrors.")] = 0.0
    height: Annotated[float, _dimension("Height", "From the ground.")] = 0.0
    front_overhang: Annotated[
        float, _dimension("Front overhang", "From the nose to the front wheels.")
    ] = 0.0
    wheelbase: Annotated[float, _dimension("Wheelbase", "Between the wheels.")] = 0.0
    lock: Annotated[
        bool,
        Parameter("Keep while solving",
                  help="Solve for a car of these dimensions, instead of stretching it afterwards.",
                  idle_while=tuple((name, (0.0,)) for name in GIVEN)),
    ] = False  # fmt: skip
    default_shape: Annotated[
        bool, _advanced("Pull panels out", "Make panels and corners bulge after deformation.")
    ] = True
    annealed: Annotated[
        bool, _advanced("Fair lines", "Bend lines like the template, once, through the nodes.")
    ] = True
    smooth: Annotated[
        bool, _advanced("Smooth surfaces", "Make surfaces meet smoothly where smooth lines cross.")
    ] = True
    nodes_follow: Annotated[
        bool, _advanced("Nodes follow strokes", "Move the nodes of a traced edge to the stroke.")
    ] = False
    cost: Annotated[
        Literal["balanced", "paper"],
        Parameter(
            "Cost",
            advanced=True,
            help="The balance between the marks and the template.",
            choices=(("balanced", "Balanced"), ("paper", "As in the paper, α = β = 0.5")),
        ),
    ] = "balanced"
    direct: Annotated[
        bool,
        _advanced("Direct transform", "Show the marks as the direct linear transform sees them."),
    ] = False

    def __post_init__(self) -> None:
        tyre_size(self.tyre)  # what is no size is refused

    # -- parts --

    @property
    def template_source(self) -> str:
        """The file of the template (``bozzetto-car-template/1``, JSON).

        Raises
        ------
        UserError
            If there is no template of one's own where that is wanted.
        """
        if self.template != "own":
            return bundled_file(self.template).decode()
        if not self.own:
            raise UserError(NO_OWN)
        return self.own

    @property
    def is_begun(self) -> bool:
        """Whether it is somebody's car: with a sketch, curve, edit, blend or own template."""
        changed = self.edits or self.joints or self.flowing
        return bool(self.nodes or changed or self.template == "own" or self.blend != "none")

    @property
    def sketches(self) -> tuple[Sketch, ...]:
        """The sketches, in their order."""
        return tuple(node for node in self.nodes if isinstance(node, Sketch))

    @property
    def styling(self) -> tuple[StylingCurve, ...]:
        """The styling curves, in their order."""
        return tuple(node for node in self.nodes if isinstance(node, StylingCurve))

    @property
    def sketch(self) -> Sketch | None:
        """The sketch that is worked on: the chosen one, or else the first."""
        sketches = self.sketches
        chosen = (sketch for sketch in sketches if sketch.id == self.selected)
        return next(chosen, sketches[0] if sketches else None)

    @property
    def mesh(self) -> CarMesh | None:
        """The visible mesh that the template takes the shape of, where there is no sketch."""
        meshes = self.shown(CarMesh)
        return meshes[0] if meshes and not self.sketches else None

    @property
    def dimensions(self) -> Dimensions:
        """The dimensions that are given, mm."""
        return Dimensions(**{name: getattr(self, name) or None for name in GIVEN})
