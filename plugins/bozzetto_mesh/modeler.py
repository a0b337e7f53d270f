"""The modeler of imported meshes: it keeps them, shows them and hands them on."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Annotated, Final, Literal

from bozzetto.geometry import FaceGroup, Mesh, Placement, Shapes, Solid, Surface, meshed
from bozzetto.plugin import Job, Modeler, Parameter, override
from bozzetto.scene import Layer, Scene, Shaded

MM_PER: Final = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4}
"""Millimetres in a unit."""

Z_UP: Final = (1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0)
"""Rows of the turn that makes the second axis of a file our z."""


@dataclass(frozen=True)
class MeshState:
    """Meshes as they were read.

    Parameters
    ----------
    meshes : tuple of Mesh
    closed : tuple of bool
        For each, whether its file said that it bounds a volume.
    names : tuple of str
        Of each; none in documents from before they were kept.
    colors : tuple of (r, g, b) or None
        Of each, sRGB; none in such documents.
    groups : tuple of tuple of FaceGroup
        Of each; none in such documents.
    up : {"z", "y"}
        The axis of the file that points up.
    unit : {"mm", "cm", "m", "in"}
        In which the numbers of the file are.
    """

    meshes: tuple[Mesh, ...] = ()
    closed: tuple[bool, ...] = ()
    names: tuple[str, ...] = ()
    colors: tuple[tuple[int, int, int] | None, ...] = ()
    groups: tuple[tuple[FaceGroup, ...], ...] = ()
    up: Annotated[
        Literal["z", "y"],
        Parameter("Up in the file", choices=(("z", "Z"), ("y", "Y")), help="Y in most OBJ files."),
    ] = "z"
    unit: Annotated[
        Literal["mm", "cm", "m", "in"],
        Parameter(
            "Unit of the file",
            choices=(("mm", "mm"), ("cm", "cm"), ("m", "m"), ("in", "in")),
            help="STL, OBJ and PLY files do not say in which unit their numbers are.",
        ),
    ] = "mm"

    def __post_init__(self) -> None:
        if len(self.closed) != len(self.meshes):
            raise ValueError("every mesh is closed or is not")
        for row in (self.names, self.colors, self.groups):
            if row and len(row) != len(self.meshes):
                raise ValueError("every mesh has a name, a colour and groups, or none has")
        for mesh, groups in zip(self.meshes, self.groups, strict=False):
            if groups and sum(group.count for group in groups) != len(mesh.faces):
                raise ValueError("groups must hold all triangles of their mesh")

    def standing(self) -> MeshState:
        """Return the state with its meshes in millimetres and upright."""
        turn = Z_UP if self.up == "y" else Placement().rotation
        placement = Placement(turn, MM_PER[self.unit])
        if placement.is_identity:
            return self
        return replace(self, meshes=tuple(mesh.placed(placement) for mesh in self.meshes))


class ImportedMesh(Modeler[MeshState, MeshState]):
    """A mesh from a file. There is nothing to draw and nothing to solve."""

    id = "bozzetto.mesh"
    state_type = MeshState

    @override
    def read_shapes(self, shapes: Shapes) -> MeshState:
        """Return a state with the meshes of a file, and exact surfaces as meshes."""
        shapes = meshed(shapes)
        parts = tuple(shapes.meshes())
        return MeshState(
            tuple(part.mesh for part in parts),
            (True,) * len(shapes.solids) + (False,) * len(shapes.surfaces),
            tuple(part.name for part in parts),
            tuple(part.color for part in parts),
            tuple(part.groups for part in parts),
        )

    @override
    def solve(self, state: MeshState, job: Job) -> MeshState:
        """Return the meshes, in millimetres and upright."""
        return state.standing()

    @override
    def scene(self, state: MeshState, result: MeshState | None) -> Scene:
        """Return the meshes, shaded in their colours or else in clay."""
        shown = result or state.standing()
        colors = shown.colors or (None,) * len(shown.meshes)
        items = tuple(
            Shaded(mesh) if color is None else Shaded(mesh, color)
            for mesh, color in zip(shown.meshes, colors, strict=True)
        )
        return Scene((Layer("mesh", items),))

    @override
    def shapes(self, state: MeshState, result: MeshState) -> Shapes:
        """Return the meshes with the names, colours and groups that they came with."""
        count = len(result.meshes)
        solids, surfaces = [], []
        for mesh, closed, name, color, groups in zip(
            result.meshes,
            result.closed,
            result.names or ("",) * count,
            result.colors or (None,) * count,
            result.groups or ((),) * count,
            strict=True,
        ):
            if closed:
                solids.append(Solid(mesh, name or "solid", color, groups=groups))
            else:
                surfaces.append(Surface(mesh, name or "surface", color, groups))
        return Shapes(solids=tuple(solids), surfaces=tuple(surfaces))
