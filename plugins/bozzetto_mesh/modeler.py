"""The modeler of imported meshes: it keeps them, shows them and hands them on."""

from __future__ import annotations

from dataclasses import dataclass

from bozzetto.geometry import Mesh, Shapes, Solid, Surface, meshed
from bozzetto.plugin import Job, Modeler, override
from bozzetto.scene import Layer, Scene, Shaded


@dataclass(frozen=True)
class MeshState:
    """Meshes as they were read.

    Parameters
    ----------
    meshes : tuple of Mesh
    closed : tuple of bool
        For each, whether its file said that it bounds a volume.
    """

    meshes: tuple[Mesh, ...] = ()
    closed: tuple[bool, ...] = ()

    def __post_init__(self) -> None:
        if len(self.closed) != len(self.meshes):
            raise ValueError("every mesh is closed or is not")


class ImportedMesh(Modeler[MeshState, MeshState]):
    """A mesh from a file. There is nothing to draw and nothing to solve."""

    id = "bozzetto.mesh"
    state_type = MeshState

    @override
    def read_shapes(self, shapes: Shapes) -> MeshState:
        """Return a state with the meshes of a file, and exact surfaces as meshes."""
        shapes = meshed(shapes)
        meshes = tuple(part.mesh for part in shapes.meshes())
        return MeshState(meshes, (True,) * len(shapes.solids) + (False,) * len(shapes.surfaces))

    @override
    def solve(self, state: MeshState, job: Job) -> MeshState:
        """Return the meshes: the state holds them already."""
        return state

    @override
    def scene(self, state: MeshState, result: MeshState | None) -> Scene:
        """Return the meshes, shaded in clay."""
        return Scene((Layer("mesh", tuple(Shaded(mesh) for mesh in state.meshes)),))

    @override
    def shapes(self, state: MeshState, result: MeshState) -> Shapes:
        """Return the meshes as they were read."""
        pairs = list(zip(state.meshes, state.closed, strict=True))
        return Shapes(
            solids=tuple(Solid(mesh) for mesh, closed in pairs if closed),
            surfaces=tuple(Surface(mesh) for mesh, closed in pairs if not closed),
        )
