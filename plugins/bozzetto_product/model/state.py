"""The recipe of a product: curves on a rough shape, how they meet, and which loops are surfaces.

Curves are whole, from end to end; where they meet stands in joints. Patches name their boundary by
curves and joints. Loops are found when the network changes, by the tool that changes it, and stand
here as patches from then on: what a person confirmed or rejected stays as it is while the network
grows.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from bozzetto.plugin import Parameter, PartsState
from bozzetto_product.model.arcs import Arc
from bozzetto_product.model.curves import Curve
from bozzetto_product.model.details import Detail
from bozzetto_product.model.emblems import Emblem
from bozzetto_product.model.joints import Boundary, Joint
from bozzetto_product.model.patches import CurveGroup, Patch
from bozzetto_product.model.planes import Plane, Point
from bozzetto_product.model.rough_shapes import FollowedShape, RoughShape

WallSide = Literal["inside", "outside"]
SurfaceKind = Literal["fair", "paper"]
Lay = Literal["surface", "upright", "plane"]


@dataclass(frozen=True)
class ProductState(PartsState):
    """Curves, the surfaces between them, and what they were drawn on.

    Parameters
    ----------
    joints : tuple of Joint
    rejected : tuple of Boundary
        Loops that a person switched off.
    symmetry : Plane
    plane_places : tuple of (x, y, z)
        Places that were touched to set the plane of new curves, three at most, mm.
    """

    nodes: tuple[
        Curve | Arc | Patch | Detail | Emblem | RoughShape | FollowedShape | CurveGroup, ...
    ] = ()
    joints: tuple[Joint, ...] = ()
    rejected: tuple[Boundary, ...] = ()
    symmetry: Plane = Plane((0.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    mirror: Annotated[
        bool, Parameter("Draw symmetric", help="Curves get their mirror image while you draw.")
    ] = False
    surfaces: Annotated[
        SurfaceKind,
        Parameter(
            "Surfaces",
            help="Fair and exact, or triangles as in the paper: V-spring and pressed membrane.",
            choices=(("fair", "Fair"), ("paper", "As in the paper")),
        ),
    ] = "fair"
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
            idle_while=(("wall", (0.0,)),),
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
    lay: Annotated[
        Lay,
        Parameter(
            "New curves lie",
            advanced=True,
            help="On what is seen under them, upright on it from end to end, or in a set plane.",
            choices=(
                ("surface", "On the surface"),
                ("upright", "Upright on the surface"),
                ("plane", "In the plane of three places"),
            ),
        ),
    ] = "surface"
    plane_places: tuple[Point, ...] = ()
    rounding: Annotated[
        float,
        Parameter("Fillet", 1e-3, 1e5, unit="mm", help="Radius of the next fillet.", advanced=True),
    ] = 5.0
    strength: Annotated[
        float,
        Parameter(
            "Strength of creases",
            0.0,
            1.0,
            0.01,
            tools=("crease",),
            help="Of the next edge that is touched: 0 is smooth, 1 a full crease.",
        ),
    ] = 1.0
    spacing: Annotated[
        float,
        Parameter(
            "Offset", -1e5, 1e5, unit="mm", help="Distance of the next offset.", advanced=True
        ),
    ] = 5.0
