"""Curves of the network, whole from end to end.

Where a curve meets others stands in joints, not in pieces of it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Final, Literal

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import frozen
from bozzetto.geometry import Spline
from bozzetto.ink import Strokes
from bozzetto.plugin import Parameter, Part, UserError
from bozzetto.scene import SurfacePlaces
from bozzetto_product.model.appearance import Color
from bozzetto_product.model.planes import Plane

EdgeKind = Literal["auto", "smooth", "crease", "between"]

CREASES: Final = {"auto": float("nan"), "smooth": 0.0, "crease": 1.0}
"""Crease of an edge by its kind; another kind takes its own number."""


FARTHEST = 1e9
"""Largest coordinate of a curve, mm: squares of it are still numbers."""


@dataclass(frozen=True, eq=False)
class LaidPlaces:
    """Places of a curve on the surface of another model, which it follows.

    Parameters
    ----------
    part : str
        Id of the `FollowedShape`.
    count : int
        Faces of the surface then.
    topology : str
        What tells its triangles from others (`bozzetto.scene.topology_of`): on others the places
        are found anew. "" in documents of before: there only the number of faces is compared.
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
    topology: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "faces", frozen(self.faces, np.int32))
        object.__setattr__(self, "weights", frozen(self.weights, np.float64, 3))
        object.__setattr__(self, "points", frozen(self.points, np.float64, 3))
        if not len(self.faces) == len(self.weights) == len(self.points):
            raise ValueError("every place needs one face, three weights and one point")
        if self.topology:
            self.on_surface()  # refuses what are no places

    def on_surface(self) -> SurfacePlaces:
        """Return the places as those of a surface that a scene could show."""
        return SurfacePlaces(self.part, "", 0, self.topology, self.faces, self.weights)


@dataclass(frozen=True)
class Stretch:
    """A part of a curve over which surfaces meet in a way of its own.

    Parameters
    ----------
    low, high : float
        Shares of the parameter range of the curve; (0.8, 1.3) is over the seam of a closed one.
    edge : EdgeKind
    crease : float
        As of a curve.
    """

    low: float
    high: float
    edge: EdgeKind
    crease: float = 0.5


@dataclass(frozen=True)
class Curve(Part):
    """A curve of the network, as it is now, with the ink that it comes from.

    Parameters
    ----------
    spline : Spline, optional
        In the frame of the model, mm. None only of the kind of part, before one is drawn.
    strokes : Strokes
        Raw ink, each stroke with its camera, in the order drawn, corrections among them.
    laid : LaidPlaces, optional
        The surface of another model that it follows.
    plane : Plane, optional
        The curve stays in it.
    mirrored : bool
        The mirror image in the state's symmetry plane is there as well: one curve, twice.
    stretches : tuple of Stretch
        Parts over which surfaces meet otherwise than over the rest; they do not overlap.
    told : tuple of str
        What a person should know of how it was laid in space; until it is laid anew: drawn over,
        straightened, laid in a plane, cut at the edges under it.
    """

    spline: Spline | None = None
    strokes: Strokes = Strokes()
    laid: LaidPlaces | None = None
    plane: Plane | None = None
    mirrored: bool = False
    stretches: tuple[Stretch, ...] = ()
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
        float,
        Parameter(
            "Crease",
            0.0,
            1.0,
            0.01,
            help="0 is smooth, 1 a full crease.",
            idle_while=(("edge", ("auto", "smooth", "crease")),),
        ),
    ] = 0.5
    color: Annotated[Color | None, Parameter("Colour", help="Colour of this curve.")] = None

    def __post_init__(self) -> None:
        if self.spline is not None and np.abs(self.spline.control_points).max() > FARTHEST:
            raise UserError(
                "A curve is farther away than anything can be drawn. Show all of the drawing, and "
                "draw there."
            )
