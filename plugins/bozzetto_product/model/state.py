"""The recipe of a product: curves on a rough shape, how they meet, and which loops are surfaces.

Curves are whole, from end to end. Where they meet stands in joints, by the parameter on each
curve, so that a curve that is bent takes its neighbours along. Patches name their boundary by
curves and joints. Loops are found when the network changes, by the tool that changes it, and stand
here as patches from then on: what a person confirmed or rejected stays as it is while the network
grows.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import frozen
from bozzetto.geometry import Spline
from bozzetto.ink import Strokes
from bozzetto.plugin import Group, Parameter, Part, PartsState
from bozzetto.scene import SurfacePlaces
from bozzetto_product.lettering.text_outlines import text_outlines

Point = tuple[float, float, float]
Color = tuple[int, int, int]
Finish = Literal["matt", "gloss", "rubber", "metal", "glass"]
FINISHES = (
    ("matt", "Matt"),
    ("gloss", "Gloss"),
    ("rubber", "Rubber"),
    ("metal", "Metal"),
    ("glass", "Glass"),
)
EdgeKind = Literal["auto", "smooth", "crease", "between"]
WallSide = Literal["inside", "outside"]
DetailKind = Literal["in", "raised", "cut", "button", "split"]
RoughKind = Literal[
    "box", "rounded box", "cylinder", "sphere", "wedge", "bottle", "mouse", "shoe last", "head"
]

FARTHEST = 1e9
"""Largest coordinate of a curve, mm: squares of it are still numbers."""

LONGEST_TEXT = 60
"""Letters of a text at most: each is carved by itself."""


@dataclass(frozen=True)
class Plane:
    """A plane by one of its points and its unit normal; mm."""

    point: Point
    normal: Point


@dataclass(frozen=True, eq=False)
class LaidPlaces:
    """Places of a curve on the surface of another model, which it follows.

    Parameters
    ----------
    part : str
        Id of the `FollowedShape`.
    count : int
        Faces of the surface then: with others the places are found anew.
    faces : (n,) int32
        Faces of the places.
    weights : (n, 3) float64
        Their barycentric coordinates.
    points : (n, 3) float64
        Where they were when the curve was drawn, mm, at equal steps of its parameter.
    """

    part: str
    count: int
    faces: NDArray[np.int32]
    weights: NDArray[np.float64]
    points: NDArray[np.float64]

    def __post_init__(self) -> None:
        object.__setattr__(self, "faces", frozen(self.faces, np.int32))
        object.__setattr__(self, "weights", frozen(self.weights, np.float64, 3))
        object.__setattr__(self, "points", frozen(self.points, np.float64, 3))
        if not len(self.faces) == len(self.weights) == len(self.points):
            raise ValueError("every place needs one face, three weights and one point")


@dataclass(frozen=True)
class Curve(Part):
    """A curve of the network, as it is now, with the ink that it comes from.

    Parameters
    ----------
    spline : Spline, optional
        In the frame of the model, mm. None only of the kind of part, before one is drawn.
    strokes : Strokes
        Raw ink, each stroke with its camera, in the order drawn, corrections among them.
    places : SurfacePlaces, optional
        Where equally spaced points of the curve lie on a model's surface.
    laid : LaidPlaces, optional
        The surface of another model that it follows.
    plane : Plane, optional
        The curve stays in it.
    mirrored : bool
        The mirror image in the state's symmetry plane is there as well: one curve, twice.
    told : tuple of str
        What a person should know of how it was laid in space; until it is drawn over.
    """

    spline: Spline | None = None
    strokes: Strokes = Strokes()
    places: SurfacePlaces | None = None
    laid: LaidPlaces | None = None
    plane: Plane | None = None
    mirrored: bool = False
    told: tuple[str, ...] = ()
    edge: Annotated[
        EdgeKind,
        Parameter(
            "Edge",
            help="How surfaces meet over this curve.",
            choices=(
                ("auto", "As drawn"),
                ("smooth", "Smooth"),
                ("crease", "Crease"),
                ("between", "Between"),
            ),
        ),
    ] = "auto"
    crease: Annotated[
        float, Parameter("Crease", 0.0, 1.0, 0.01, help="0 is smooth, 1 a full crease.")
    ] = 0.5
    color: Annotated[Color | None, Parameter("Colour", help="Colour of this curve.")] = None

    def __post_init__(self) -> None:
        if self.spline is not None and np.abs(self.spline.control_points).max() > FARTHEST:
            raise ValueError("a curve is farther away than anything can be drawn")


@dataclass(frozen=True)
class Meeting:
    """A place on a curve at which it meets others.

    Parameters
    ----------
    curve : str
        Id of the curve.
    at : float
        Share of its parameter range; 0 and 1 are its ends, anything between is a T-joint.
    mirrored : bool
        It is the mirror image that meets.
    """

    curve: str
    at: float
    mirrored: bool = False


@dataclass(frozen=True)
class Joint:
    """A place where curves meet.

    Parameters
    ----------
    id : str
        Unique among the joints.
    meetings : tuple of Meeting
        Those that were meant; the mirror image of a joint is not listed.
    in_plane : bool
        It lies in the symmetry plane, exactly.
    """

    id: str
    meetings: tuple[Meeting, ...]
    in_plane: bool = False


@dataclass(frozen=True)
class Run:
    """A part of a boundary: a curve from one joint to another.

    Parameters
    ----------
    curve : str
    start, end : str
        Ids of joints; both "" for a closed curve without a joint, and the same one for a closed
        curve all the way round.
    forward : bool
        Whether it goes along with the curve.
    mirrored : bool
        It is the mirror image of all that the other fields say.
    start_opposite, end_opposite : bool
        The end is the mirror image of the joint named: of a curve across the symmetry plane.
    """

    curve: str
    start: str = ""
    end: str = ""
    forward: bool = True
    mirrored: bool = False
    start_opposite: bool = False
    end_opposite: bool = False


Boundary = tuple[Run, ...]


@dataclass(frozen=True)
class Patch(Part):
    """A surface within a loop of curves.

    Parameters
    ----------
    boundary : tuple of Run
        Head to tail, counter-clockwise seen from outside. Joints within a run may be added later.
    confirmed : bool
        A person switched it on: finding loops never takes it away.
    mirrored : bool
        The mirror image is there as well.
    pulls, pulls_mirrored : Strokes
        Raw ink, each stroke with its camera, that its contour follows one after another, and
        ink that was drawn so over its mirror image.
    """

    boundary: Boundary = ()
    confirmed: bool = False
    mirrored: bool = False
    pulls: Strokes = Strokes()
    pulls_mirrored: Strokes = Strokes()
    pressure: Annotated[
        float,
        Parameter(
            "Pressure",
            -2.0,
            2.0,
            0.01,
            help="Inflates the surface, or sucks it in; measured by volume.",
        ),
    ] = 0.0
    color: Annotated[Color | None, Parameter("Colour", help="Colour of this surface.")] = None
    finish: Annotated[
        Finish,
        Parameter("Finish", choices=FINISHES),
    ] = "matt"


@dataclass(frozen=True, eq=False)
class OutlinePlaces:
    """Places of outlines on the surfaces of patches, which go along when these change.

    Parameters
    ----------
    patches : tuple of str
        Ids of the patches.
    rows : (n, 3) int32
        Of each place: number of its patch in `patches`, whether on its mirror image (0, 1), and
        number of the piece of the surface.
    parameters : (n, 2) float64
        u and v there.
    points : (n, 3) float64
        Where they were when they were drawn, mm.
    corners : (n,) uint8
        1 where the outline has a corner, else 0.
    starts : (k,) int32
        First place of each outline.
    """

    patches: tuple[str, ...]
    rows: NDArray[np.int32]
    parameters: NDArray[np.float64]
    points: NDArray[np.float64]
    corners: NDArray[np.uint8]
    starts: NDArray[np.int32]

    def __post_init__(self) -> None:
        object.__setattr__(self, "rows", frozen(self.rows, np.int32, 3))
        object.__setattr__(self, "parameters", frozen(self.parameters, np.float64, 2))
        object.__setattr__(self, "points", frozen(self.points, np.float64, 3))
        object.__setattr__(self, "corners", frozen(self.corners, np.uint8))
        object.__setattr__(self, "starts", frozen(self.starts, np.int32))
        counts = {len(self.rows), len(self.parameters), len(self.points), len(self.corners)}
        if len(counts) != 1:
            raise ValueError("every place needs a row, parameters, a point and whether a corner")
        which = self.rows[:, 0]
        if len(which) and not 0 <= which.min() <= which.max() < len(self.patches):
            raise ValueError("a place names a patch that is not there")
        ends = np.append(self.starts, len(self.rows))
        if len(self.starts) and (ends[0] != 0 or (np.diff(ends) < 2).any()):
            raise ValueError("an outline needs two places at least")


@dataclass(frozen=True, eq=False)
class FlatOutlines:
    """Outlines in a plane, as they are laid on a surface.

    Parameters
    ----------
    points : (n, 2) float64
        Of all outlines, y up, in heights of capitals, or of the whole.
    corners : (n,) uint8
        1 where the outline has a corner, else 0.
    starts : (k,) int32
        First point of each outline; all are closed.
    text : str
        The text that they are the outlines of; "" where they are drawn.
    missing : str
        Letters of it of which there is no outline.
    """

    points: NDArray[np.float64]
    corners: NDArray[np.uint8]
    starts: NDArray[np.int32]
    text: str = ""
    missing: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "points", frozen(self.points, np.float64, 2))
        object.__setattr__(self, "corners", frozen(self.corners, np.uint8))
        object.__setattr__(self, "starts", frozen(self.starts, np.int32))
        if len(self.points) != len(self.corners):
            raise ValueError("every point needs whether it is a corner")
        if not np.isfinite(self.points).all() or np.abs(self.points).max(initial=0.0) > FARTHEST:
            raise ValueError("an outline is farther away than anything can be drawn")
        ends = np.append(self.starts, len(self.points))
        if len(self.starts) and (ends[0] != 0 or (np.diff(ends) < 3).any()):
            raise ValueError("an outline needs three points at least")

    @property
    def rows(self) -> list[NDArray[np.float64]]:
        """The points of each outline, (n, 2)."""
        return np.split(self.points, self.starts[1:]) if len(self.starts) else []

    @classmethod
    def of_text(cls, text: str) -> FlatOutlines:
        """Return the outlines of a text."""
        found = text_outlines(text[:LONGEST_TEXT])
        if not found.rows:
            nothing = np.empty(0, np.uint8), np.empty(0, np.int32)
            return cls(np.empty((0, 2)), *nothing, text, found.missing)
        starts = np.cumsum([0, *(len(row) for row in found.rows[:-1])])
        corners = np.concatenate(found.corners).astype(np.uint8)
        return cls(
            np.concatenate(found.rows), corners, starts.astype(np.int32), text, found.missing
        )


@dataclass(frozen=True)
class Lettering(Part):
    """What an emblem has besides a detail; it stands before it in forms.

    Parameters
    ----------
    flat : FlatOutlines, optional
        What is laid on the surface. That of a text is kept, so that it stays what it was whatever
        letters a later program has.
    """

    text: Annotated[str, Parameter("Text", help="One line.")] = ""
    height: Annotated[
        float, Parameter("Height", 1e-2, 1e4, unit="mm", help="Of capitals, or of the outlines.")
    ] = 10.0
    turn: Annotated[
        float, Parameter("Turn", -180.0, 180.0, 1.0, unit="°", help="On the surface.")
    ] = 0.0
    flat: FlatOutlines | None = None

    def __post_init__(self) -> None:
        if self.text and (self.flat is None or self.flat.text != self.text):
            object.__setattr__(self, "flat", FlatOutlines.of_text(self.text))
        elif not self.text and self.flat is not None and self.flat.text:
            object.__setattr__(self, "flat", None)


@dataclass(frozen=True)
class Detail(Part):
    """A region of a finished surface that is pressed in, raised, cut out, or told apart.

    Parameters
    ----------
    strokes : Strokes
        Raw ink, each stroke with its camera.
    places : OutlinePlaces, optional
        The outlines. None only of the kind of part, before one is drawn.
    closed : bool
        Whether outlines are closed; else they run from border to border, and split only.
    mirrored : bool
        The mirror image in the state's symmetry plane is there as well.
    """

    strokes: Strokes = Strokes()
    places: OutlinePlaces | None = None
    closed: bool = True
    mirrored: Annotated[
        bool, Parameter("Mirrored", help="The same on the other side of the symmetry plane.")
    ] = False
    kind: Annotated[
        DetailKind,
        Parameter(
            "Kind",
            help="What becomes of the area inside.",
            choices=(
                ("in", "Pressed in"),
                ("raised", "Raised"),
                ("cut", "Cut through"),
                ("button", "Button with a gap"),
                ("split", "Split"),
            ),
        ),
    ] = "in"
    depth: Annotated[
        float,
        Parameter("Depth", 1e-3, 1e4, unit="mm", help="Of what is pressed in, raised, or a gap."),
    ] = 1.0
    draft: Annotated[
        float,
        Parameter("Draft angle", 0.0, 60.0, 0.5, unit="°", help="Between walls and normals."),
    ] = 3.0
    gap: Annotated[float, Parameter("Gap", 1e-3, 1e4, unit="mm", help="Round a button.")] = 0.5
    color: Annotated[Color | None, Parameter("Colour", help="Colour of this detail.")] = None
    finish: Annotated[
        Finish,
        Parameter("Finish", choices=FINISHES),
    ] = "matt"


@dataclass(frozen=True)
class Emblem(Detail, Lettering):
    """A text, or outlines drawn elsewhere, laid on a surface.

    `places` are two places on surfaces: its middle, and one above it. Both go along with the
    surfaces.
    """


@dataclass(frozen=True)
class RoughShape(Part):
    """A rough shape to draw on; it is no part of the product.

    Parameters
    ----------
    centre : (x, y, z)
        mm.
    """

    centre: Point = (0.0, 0.0, 0.0)
    kind: Annotated[RoughKind, Parameter("Shape")] = "box"
    length: Annotated[float, Parameter("Length", 1e-3, 1e6, unit="mm", help="Along x.")] = 120.0
    width: Annotated[float, Parameter("Width", 1e-3, 1e6, unit="mm", help="Along y.")] = 80.0
    height: Annotated[float, Parameter("Height", 1e-3, 1e6, unit="mm", help="Along z.")] = 60.0


@dataclass(frozen=True)
class FollowedShape(Part):
    """The surface of another model to draw on; it is no part of the product.

    Parameters
    ----------
    source : str
        Id of the model.
    """

    source: str = ""


@dataclass(frozen=True)
class CurveGroup(Group):
    """Parts that belong together; its surfaces may be faired as one."""

    let_go: Annotated[
        float,
        Parameter(
            "Let curves go",
            0.0,
            1.0,
            0.01,
            help="How far curves between the group's surfaces give way to one fair surface.",
        ),
    ] = 0.0


@dataclass(frozen=True)
class ProductState(PartsState):
    """Curves, the surfaces between them, and what they were drawn on.

    Parameters
    ----------
    joints : tuple of Joint
    rejected : tuple of Boundary
        Loops that a person switched off.
    symmetry : Plane
    """

    nodes: tuple[
        Curve | Patch | Detail | Emblem | RoughShape | FollowedShape | CurveGroup, ...
    ] = ()
    joints: tuple[Joint, ...] = ()
    rejected: tuple[Boundary, ...] = ()
    symmetry: Plane = Plane((0.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    mirror: Annotated[
        bool, Parameter("Draw symmetric", help="Curves get their mirror image while you draw.")
    ] = False
    wall: Annotated[
        float,
        Parameter(
            "Wall",
            0.0,
            1e4,
            0.1,
            unit="mm",
            zero="none",
            help="Thickness of a housing: closed products become hollow, open ones plates.",
        ),
    ] = 0.0
    wall_side: Annotated[
        WallSide,
        Parameter(
            "Wall grows",
            help="Whether the surfaces drawn are the outside or the inside of the walls.",
            choices=(("inside", "Inward"), ("outside", "Outward")),
            advanced=True,
        ),
    ] = "inside"
    controls: Annotated[
        int,
        Parameter(
            "Control points", 4, 40, advanced=True, help="Of a new curve: more follow the ink."
        ),
    ] = 7
    order: Annotated[
        Literal["drawn", "principal"],
        Parameter(
            "Order of points",
            advanced=True,
            help="How the strokes of a curve are put in order.",
            choices=(("drawn", "Along the strokes"), ("principal", "Along the principal axis")),
        ),
    ] = "drawn"
    rounding: Annotated[
        float,
        Parameter("Fillet", 1e-3, 1e5, unit="mm", help="Radius of the next fillet.", advanced=True),
    ] = 5.0
    spacing: Annotated[
        float,
        Parameter(
            "Offset", -1e5, 1e5, unit="mm", help="Distance of the next offset.", advanced=True
        ),
    ] = 5.0
