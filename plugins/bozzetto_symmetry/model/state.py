"""The recipe of a symmetry model: a box, a centre plane, and curves as they were drawn.

Every curve keeps its ink with the cameras, and what was done to it since, in order, so that
better code can solve it again.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Annotated, Literal, Self

import numpy as np

from bozzetto.arrays import Array
from bozzetto.ink import SnakeForces, Strokes
from bozzetto.plugin import Group, Parameter, Part, PartsState, cached_property
from bozzetto_symmetry.model.canvas import Canvas, DrawingPlane
from bozzetto_symmetry.model.symmetry_plane import CentrePlane, Point

Color = tuple[int, int, int]
AskedReading = Literal["auto", "pair", "self", "plane", "half"]


@dataclass(frozen=True)
class Modification:
    """Strokes drawn over the curve in one view, which the curve follows.

    Parameters
    ----------
    strokes : Strokes
        Of one camera.
    mirrored : bool
        They were drawn over the mirror image.
    """

    strokes: Strokes
    mirrored: bool = False


@dataclass(frozen=True)
class Trim:
    """A stretch of the curve that is kept.

    Parameters
    ----------
    begin, end : float
        Shares of the curve's parameter range, ``begin < end``; on a closed curve `end` may be
        above 1. Of a curve across the plane these are shares of the half, counted from the
        plane.
    """

    begin: float = 0.0
    end: float = 1.0


@dataclass(frozen=True)
class Snap:
    """An end of the curve that is moved to a place in space.

    Parameters
    ----------
    end : {0, 1}
        The first or the last end; of a curve across the plane its one free end is 1.
    point : (x, y, z)
        In the frame of the model, on the side that was drawn; mm.
    tangent : (x, y, z), optional
        Unit direction in which the curve leaves that end; default as it was.
    """

    end: int
    point: Point
    tangent: Point | None = None


@dataclass(frozen=True)
class EndSnap:
    """A known place that an end of a stroke was drawn to, beside the ink that it belongs to.

    It holds wherever the ink still ends near it in space, so that reading the ink in another way
    or solving it again makes no end jump.

    Parameters
    ----------
    stroke : int
        Number of the stroke in the ink of the curve.
    end : {0, 1}
        Where the stroke begins or ends.
    point : (x, y, z)
        In the frame of the model, mm.
    tangent : (x, y, z), optional
        Unit direction in which the curve leaves that end.
    """

    stroke: int
    end: int
    point: Point
    tangent: Point | None = None


@dataclass(frozen=True)
class Joint:
    """An end that is joined to another one, with a common tangent there.

    Parameters
    ----------
    end : {0, 1}
        Of this curve.
    other : Curve or None
        The curve that the other end belongs to, as it was; it is no node of its own any more.
        None is this curve itself: its two ends close it, or, mirrored, an end meets its image.
    other_end : {0, 1}
    mirrored : bool
        The other end is one of the mirror image.
    """

    end: int
    other: Curve | None
    other_end: int
    mirrored: bool = False


Edit = Modification | Trim | Snap | Joint


@dataclass(frozen=True)
class Curve(Part):
    """A curve, drawn in one or several views.

    Parameters
    ----------
    strokes : Strokes
        Raw ink, each stroke with its camera, in the order drawn.
    edits : tuple of Edit
        What was done to the curve since, in order.
    pieces : tuple of (int, int)
        Numbers of two strokes of which one goes on where the other ended: the pen was lifted there.
    canvas : DrawingPlane or LaidInk, optional
        What it was drawn on; default in the air, from both sides.
    end_snaps : tuple of EndSnap
        Known places that its ends snapped to while it was drawn.
    axis : {-1, 0, 1, 2}
        It was drawn straight along this axis of the box; -1 for none.
    """

    strokes: Strokes = Strokes()
    edits: tuple[Edit, ...] = ()
    pieces: tuple[tuple[int, int], ...] = ()
    canvas: Canvas | None = None
    end_snaps: tuple[EndSnap, ...] = ()
    axis: Literal[-1, 0, 1, 2] = -1
    reading: Annotated[
        AskedReading,
        Parameter(
            "Reading",
            help="What the strokes are: both sides, one stroke across, or in the centre plane.",
            choices=(
                ("auto", "Find out"),
                ("pair", "Left and right"),
                ("self", "Across the plane"),
                ("plane", "In the plane"),
                ("half", "One side, waiting"),
            ),
        ),
    ] = "auto"
    other: Annotated[
        bool,
        Parameter(
            "Other matching",
            help="Match the two sides in the second-best way.",
        ),
    ] = False
    goes_on: Annotated[
        bool,
        Parameter(
            "Goes on",
            help="Take it for a piece of a line where it begins or ends at an end of another one.",
        ),
    ] = True
    settles: Annotated[
        bool,
        Parameter(
            "Settle ends",
            help="Let its ends go to what they nearly meet, or leave them where they were drawn.",
        ),
    ] = True
    detail: Annotated[
        Literal["adaptive", "seven"],
        Parameter(
            "Control points",
            advanced=True,
            help="As many as the ink needs, or always seven for a half.",
            choices=(("adaptive", "As needed"), ("seven", "Seven")),
        ),
    ] = "adaptive"
    color: Annotated[Color | None, Parameter("Colour", help="Colour of this curve.")] = None

    def with_only(self, kept: Sequence[int]) -> Self:
        """Return the curve with some of its strokes, by their numbers; pieces follow them."""
        place = {number: k for k, number in enumerate(kept)}
        pieces = tuple((place[i], place[j]) for i, j in self.pieces if i in place and j in place)
        strokes = Strokes(self.strokes[number] for number in kept)
        return replace(self, strokes=strokes, pieces=pieces)


@dataclass(frozen=True)
class Line(Part):
    """A construction line: straight, to draw by, and in no exported file.

    Parameters
    ----------
    begin, end : (x, y, z)
        mm, in the frame of the model.
    """

    begin: Point = (0.0, 0.0, 0.0)
    end: Point = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class SymmetryState(PartsState):
    """The box, the plane, the curves, and what is chosen.

    Parameters
    ----------
    nodes : tuple of Curve, Line or Group
    selected : str
        Id of the node that is chosen; "" for none.
    centre : (x, y, z)
        Middle of the box, mm.
    free_plane : CentrePlane
        The plane of symmetry where it is not one of the box.
    plane_places : tuple of (x, y, z)
        Places that were touched for the drawing plane, mm.
    drawing_plane : DrawingPlane, optional
        In which new curves lie, if `lay` says so.
    """

    nodes: tuple[Curve | Line | Group, ...] = ()
    selected: str = ""
    centre: Point = (0.0, 0.0, 0.0)
    free_plane: CentrePlane = CentrePlane()
    plane_places: tuple[Point, ...] = ()
    drawing_plane: DrawingPlane | None = None
    length: Annotated[float, Parameter("Length", 0.1, unit="mm", help="Of the box, along x.")] = (
        200.0
    )
    width: Annotated[float, Parameter("Width", 0.1, unit="mm", help="Of the box, along y.")] = 100.0
    height: Annotated[float, Parameter("Height", 0.1, unit="mm", help="Of the box, along z.")] = (
        100.0
    )
    symmetry: Annotated[
        Literal["width", "length", "height", "free"],
        Parameter(
            "Centre plane",
            help="Where the plane between left and right lies.",
            choices=(
                ("width", "Across the width (y)"),
                ("length", "Across the length (x)"),
                ("height", "Across the height (z)"),
                ("free", "As it was given"),
            ),
        ),
    ] = "width"
    lay: Annotated[
        Literal["space", "plane", "surface"],
        Parameter(
            "New curves lie",
            help="In space, seen from both sides; in the drawing plane; on surfaces of others.",
            choices=(
                ("space", "In space"),
                ("plane", "In the drawing plane"),
                ("surface", "On surfaces"),
            ),
        ),
    ] = "space"
    snapping: Annotated[
        bool,
        Parameter("Snap", help="Ends of curves snap to ends, curves, edges and planes near them."),
    ] = True
    grid: Annotated[
        bool, Parameter("Grid", help="Show faint grids on the box's floor and its centre plane.")
    ] = True
    vanishing: Annotated[
        bool,
        Parameter("Vanishing lines", help="Lengthen the box's edges to where they meet."),
    ] = False
    restitution: Annotated[
        float,
        Parameter("Stiffness", 0.05, 2.0, step=0.05, advanced=True,
                  help="How much a curve resists being bent when it is drawn over."),
    ] = 0.3  # fmt: skip
    location: Annotated[
        float,
        Parameter("Nearness counts", 0.0, 1.0, step=0.05, advanced=True,
                  help="How much the nearer of several strokes pulls."),
    ] = 0.4  # fmt: skip
    pressure: Annotated[
        float,
        Parameter("Pressure counts", 0.0, 1.0, step=0.05, advanced=True,
                  help="How much the firmer of several strokes pulls."),
    ] = 0.3  # fmt: skip

    @property
    def forces(self) -> SnakeForces:
        """Forces on curves that are drawn over, and what resists them."""
        return SnakeForces(self.restitution, self.location, self.pressure)

    @property
    def size(self) -> Point:
        """Length, width and height of the box, mm."""
        return self.length, self.width, self.height

    @property
    def diagonal(self) -> float:
        """Diagonal of the box, mm."""
        return float(sum(side**2 for side in self.size) ** 0.5)

    @cached_property
    def plane(self) -> CentrePlane:
        """The plane of symmetry: through the middle of the box, or as it was given."""
        normals: dict[str, Point] = {
            "width": (0.0, 1.0, 0.0),
            "length": (1.0, 0.0, 0.0),
            "height": (0.0, 0.0, 1.0),
        }
        if self.symmetry == "free":
            return self.free_plane
        return CentrePlane(self.centre, normals[self.symmetry])

    @cached_property
    def bounds(self) -> Array:
        """Corners (2, 3) of the box in the frame of the centre plane, mm."""
        half = 0.5 * np.asarray(self.size)
        corners = self.centre + half * np.array(list(product((-1.0, 1.0), repeat=3)))
        inside = self.plane.inverse.points(corners)
        return np.stack((inside.min(axis=0), inside.max(axis=0)))

    @property
    def curves(self) -> tuple[Curve, ...]:
        """The nodes that are curves."""
        return tuple(node for node in self.nodes if isinstance(node, Curve))

    @property
    def shown_curves(self) -> tuple[Curve, ...]:
        """The curves that are switched on together with all groups that they are in."""
        return self.shown(Curve)

    @property
    def shown_lines(self) -> tuple[Line, ...]:
        """The construction lines that are switched on together with all their groups."""
        return self.shown(Line)

    @property
    def chosen(self) -> Curve | None:
        """The curve that is chosen, if one is."""
        return self.chosen_of(Curve)
