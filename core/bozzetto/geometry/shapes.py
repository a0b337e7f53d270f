"""Shapes for downstream programs: meshes, and exact curves and surfaces where there are any."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import frozen
from bozzetto.geometry.mesh import Mesh
from bozzetto.geometry.patches.patchwork import Patchwork
from bozzetto.geometry.placement import Placement
from bozzetto.geometry.rig import Skin
from bozzetto.geometry.texture import Texture

Color = tuple[int, int, int]
"""Red, green and blue, 0 … 255, sRGB."""


@dataclass(frozen=True)
class Solid:
    """A closed triangle mesh that bounds a volume; exporters refuse it where it does not.

    Parameters
    ----------
    mesh : Mesh
    name : str
    color : (r, g, b), optional
        sRGB.
    texture : Texture, optional
        In formats that hold pictures it takes the place of the mesh's colours.
    skin : Skin, optional
        The rig that the mesh follows. The mesh is as the rig's turns have it.
    """

    mesh: Mesh
    name: str = "solid"
    color: Color | None = None
    texture: Texture | None = None
    skin: Skin | None = None

    def __post_init__(self) -> None:
        if self.texture is not None and len(self.texture.corners) != len(self.mesh.faces):
            raise ValueError("a texture needs a place for every corner of every face")
        if self.skin is not None and len(self.skin.joints) != len(self.mesh.vertices):
            raise ValueError("a skin belongs to a mesh of as many vertices")

    def placed(self, placement: Placement) -> Solid:
        """Return the solid moved by a placement."""
        texture = self.texture
        if texture is not None and placement.mirrors:
            texture = texture.turned_over()
        skin = None if self.skin is None else self.skin.placed(placement)
        return replace(self, mesh=self.mesh.placed(placement), texture=texture, skin=skin)


@dataclass(frozen=True)
class Surface:
    """An open triangle mesh: a skin without an inside."""

    mesh: Mesh
    name: str = "surface"
    color: Color | None = None


@dataclass(frozen=True, eq=False)
class Curve:
    """A B-spline curve, rational where weights are given; or a polyline (degree 1).

    Parameters
    ----------
    degree : int
    knots : (m + degree + 1,) float64
        Full knot vector, not decreasing.
    control_points : (m, 3) float64
        mm.
    weights : (m,) float64, optional
    closed : bool
        Whether the curve returns to its start.
    """

    degree: int
    knots: NDArray[np.float64]
    control_points: NDArray[np.float64]
    weights: NDArray[np.float64] | None = None
    closed: bool = False
    name: str = "curve"
    color: Color | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "knots", frozen(self.knots, np.float64))
        object.__setattr__(self, "control_points", frozen(self.control_points, np.float64, 3))
        if self.weights is not None:
            object.__setattr__(self, "weights", frozen(self.weights, np.float64))
        count = len(self.control_points)
        if self.degree < 1 or count <= self.degree:
            raise ValueError("a curve needs more control points than its degree")
        if len(self.knots) != count + self.degree + 1 or (np.diff(self.knots) < 0).any():
            raise ValueError("a curve's knots must not decrease and must fit its control points")
        if self.weights is not None and (len(self.weights) != count or (self.weights <= 0).any()):
            raise ValueError("a curve needs one positive weight per control point")


@dataclass(frozen=True, eq=False)
class Skeleton:
    """Joints and bones of a shape.

    Parameters
    ----------
    joints : (n, 3) float64
        mm.
    radii : (n,) float64
        Thickness of the shape around each joint, mm.
    bones : (m, 2) int32
        Pairs of joints.
    """

    joints: NDArray[np.float64]
    radii: NDArray[np.float64]
    bones: NDArray[np.int32]
    name: str = "skeleton"

    def __post_init__(self) -> None:
        object.__setattr__(self, "joints", frozen(self.joints, np.float64, 3))
        object.__setattr__(self, "radii", frozen(self.radii, np.float64))
        object.__setattr__(self, "bones", frozen(self.bones, np.int32, 2))


@dataclass(frozen=True)
class Shapes:
    """Everything one or several models hand over, each part named and coloured."""

    solids: tuple[Solid, ...] = ()
    surfaces: tuple[Surface, ...] = ()
    curves: tuple[Curve, ...] = ()
    skeletons: tuple[Skeleton, ...] = ()
    patchworks: tuple[Patchwork, ...] = ()

    def __bool__(self) -> bool:
        return any((self.solids, self.surfaces, self.curves, self.skeletons, self.patchworks))

    def __add__(self, other: Shapes) -> Shapes:
        return Shapes(
            self.solids + other.solids,
            self.surfaces + other.surfaces,
            self.curves + other.curves,
            self.skeletons + other.skeletons,
            self.patchworks + other.patchworks,
        )

    def meshes(self) -> Iterator[Solid | Surface]:
        """Yield solids, then surfaces: all that is made of triangles."""
        yield from self.solids
        yield from self.surfaces

    def placed(self, placement: Placement) -> Shapes:
        """Return all parts moved by a placement."""
        if placement.is_identity:
            return self
        return Shapes(
            tuple(s.placed(placement) for s in self.solids),
            tuple(replace(s, mesh=s.mesh.placed(placement)) for s in self.surfaces),
            tuple(
                replace(c, control_points=placement.points(c.control_points)) for c in self.curves
            ),
            tuple(
                replace(s, joints=placement.points(s.joints), radii=s.radii * placement.scale)
                for s in self.skeletons
            ),
            tuple(p.placed(placement) for p in self.patchworks),
        )
