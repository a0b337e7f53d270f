"""Shapes for downstream programs: meshes, and exact curves and surfaces where there are any."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, TypeVar

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import frozen
from bozzetto.geometry.brep.brep import Brep
from bozzetto.geometry.corner_normals import CornerNormals
from bozzetto.geometry.curve import Color as Color
from bozzetto.geometry.curve import Curve as Curve
from bozzetto.geometry.look import Finish as Finish
from bozzetto.geometry.mesh import Mesh
from bozzetto.geometry.patches.patchwork import Patchwork
from bozzetto.geometry.rig import Skin
from bozzetto.geometry.texture import Texture

if TYPE_CHECKING:
    from bozzetto.geometry.placement import Placement


@dataclass(frozen=True)
class FaceGroup:
    """Triangles of a mesh that follow one another and belong together.

    Parameters
    ----------
    name : str
    count : int
        How many triangles.
    color : (r, g, b), optional
        sRGB; None for that of the part. The colours of the mesh's vertices come before it.
    finish : {"matt", "gloss", "rubber", "metal", "glass"}
        Of what it is made, for files that know materials.
    material : str
        Name of the material in such files, one for all that have it; "" for a material that is
        called like the group.
    """

    name: str
    count: int
    color: Color | None = None
    finish: Finish = "matt"
    material: str = ""


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
    groups : tuple of FaceGroup
        All triangles, in their order; none where the solid is one piece.
    exact : Brep, optional
        The same shape for formats that hold exact surfaces.
    path : tuple of str
        Names of what it is in, the outermost first, as assemblies have it.
    normals : CornerNormals, optional
        Of the exact shape at the corners of the triangles, for formats that hold normals; those of
        the mesh without them. A skin or a texture has none.
    polygons : (p,) uint8, optional
        How many triangles in turn, 1 or 2, are a face each in files that hold polygons; the second
        of a quad has the edge between the first one's last corner and its first. None where every
        triangle is a face.
    """

    mesh: Mesh
    name: str = "solid"
    color: Color | None = None
    texture: Texture | None = None
    skin: Skin | None = None
    groups: tuple[FaceGroup, ...] = ()
    exact: Brep | None = None
    path: tuple[str, ...] = ()
    normals: CornerNormals | None = None
    polygons: NDArray[np.uint8] | None = None

    def __post_init__(self) -> None:
        _check(self)

    def placed(self, placement: Placement) -> Solid:
        """Return the solid moved by a placement."""
        return _placed(self, placement)


@dataclass(frozen=True)
class Surface:
    """An open triangle mesh: a skin without an inside.

    Parameters
    ----------
    mesh : Mesh
    name : str
    color : (r, g, b), optional
        sRGB.
    groups : tuple of FaceGroup
        All triangles, in their order; none where the surface is one piece.
    exact : Brep, optional
        The same shape for formats that hold exact surfaces.
    texture, skin, path, normals, polygons
        As of a `Solid`.
    """

    mesh: Mesh
    name: str = "surface"
    color: Color | None = None
    groups: tuple[FaceGroup, ...] = ()
    exact: Brep | None = None
    texture: Texture | None = None
    skin: Skin | None = None
    path: tuple[str, ...] = ()
    normals: CornerNormals | None = None
    polygons: NDArray[np.uint8] | None = None

    def __post_init__(self) -> None:
        _check(self)

    def placed(self, placement: Placement) -> Surface:
        """Return the surface moved by a placement."""
        return _placed(self, placement)


_Part = TypeVar("_Part", Solid, Surface)


def _check(part: Solid | Surface) -> None:
    counts = [group.count for group in part.groups]
    if counts and (min(counts) < 0 or sum(counts) != len(part.mesh.faces)):
        raise ValueError("groups must hold all triangles of their mesh")
    if part.texture is not None and len(part.texture.corners) != len(part.mesh.faces):
        raise ValueError("a texture needs a place for every corner of every face")
    if part.normals is not None and len(part.normals.corners) != len(part.mesh.faces):
        raise ValueError("a part needs a normal for every corner of every face")
    if part.skin is not None and len(part.skin.joints) != len(part.mesh.vertices):
        raise ValueError("a skin belongs to a mesh of as many vertices")
    if part.polygons is not None:
        polygons = frozen(part.polygons, np.uint8)
        object.__setattr__(part, "polygons", polygons)
        if not np.isin(polygons, (1, 2)).all() or polygons.sum() != len(part.mesh.faces):
            raise ValueError("polygons of one or two triangles must hold all of their mesh")


def _placed(part: _Part, placement: Placement) -> _Part:
    texture = part.texture
    if texture is not None and placement.mirrors:
        texture = texture.turned_over()
    skin = None if part.skin is None else part.skin.placed(placement)
    exact = None if part.exact is None else part.exact.placed(placement)
    mesh = part.mesh.placed(placement)
    normals = None if part.normals is None else part.normals.placed(placement)
    return replace(part, mesh=mesh, texture=texture, skin=skin, exact=exact, normals=normals)


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
    breps: tuple[Brep, ...] = ()

    def __bool__(self) -> bool:
        return any(getattr(self, entry.name) for entry in fields(self))

    def __add__(self, other: Shapes) -> Shapes:
        names = [entry.name for entry in fields(self)]
        return Shapes(**{name: getattr(self, name) + getattr(other, name) for name in names})

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
            tuple(s.placed(placement) for s in self.surfaces),
            tuple(c.placed(placement) for c in self.curves),
            tuple(
                replace(s, joints=placement.points(s.joints), radii=s.radii * placement.scale)
                for s in self.skeletons
            ),
            tuple(p.placed(placement) for p in self.patchworks),
            tuple(b.placed(placement) for b in self.breps),
        )
