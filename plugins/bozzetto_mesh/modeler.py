"""The modeler of imported meshes and curves: it keeps them, shows them and hands them on."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Annotated, Final, Literal, TypeVar

import numpy as np

from bozzetto.geometry import (
    Curve,
    FaceGroup,
    Mesh,
    Placement,
    Shapes,
    Skin,
    Solid,
    Surface,
    Texture,
    meshed,
)
from bozzetto.plugin import Job, Modeler, Parameter, override
from bozzetto.scene import Layer, Lines, Scene, shaded_part

MM_PER: Final = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4}
"""Millimetres in a unit."""

STEPS: Final = 24
"""Steps in which a span of a curve is shown."""

Z_UP: Final = (1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0)
"""Rows of the turn that makes the second axis of a file our z."""


@dataclass(frozen=True)
class MeshState:
    """Meshes and curves as they were read.

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
    textures : tuple of Texture or None
        Of each; none in such documents, and where no mesh has one.
    skins : tuple of Skin or None
        Of each, likewise.
    paths : tuple of tuple of str
        What each was in, as `Solid.path`; likewise.
    curves : tuple of Curve
        As they were read.
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
    textures: tuple[Texture | None, ...] = ()
    skins: tuple[Skin | None, ...] = ()
    paths: tuple[tuple[str, ...], ...] = ()
    curves: tuple[Curve, ...] = ()
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
        for row in (self.names, self.colors, self.groups, self.textures, self.skins, self.paths):
            if row and len(row) != len(self.meshes):
                raise ValueError("every mesh has a name, a colour and so on, or none has")
        self.parts()  # they say what does not fit

    def parts(self) -> tuple[Solid | Surface, ...]:
        """Return the meshes with all that they came with.

        Raises
        ------
        ValueError
            If groups, a texture or a skin do not fit their mesh.
        """
        found: list[Solid | Surface] = []
        for number, (mesh, closed) in enumerate(zip(self.meshes, self.closed, strict=True)):
            kind = Solid if closed else Surface
            name = self.names[number] if self.names else ""
            found.append(
                kind(
                    mesh,
                    name or ("solid" if closed else "surface"),
                    self.colors[number] if self.colors else None,
                    texture=self.textures[number] if self.textures else None,
                    skin=self.skins[number] if self.skins else None,
                    groups=self.groups[number] if self.groups else (),
                    path=self.paths[number] if self.paths else (),
                )
            )
        return tuple(found)

    def standing(self) -> MeshState:
        """Return the state with its meshes in millimetres and upright."""
        turn = Z_UP if self.up == "y" else Placement().rotation
        placement = Placement(turn, MM_PER[self.unit])
        if placement.is_identity:
            return self
        parts = [part.placed(placement) for part in self.parts()]
        return replace(
            self,
            meshes=tuple(part.mesh for part in parts),
            textures=_where_any(part.texture for part in parts),
            skins=_where_any(part.skin for part in parts),
            curves=tuple(curve.placed(placement) for curve in self.curves),
        )


_Kept = TypeVar("_Kept", Skin, Texture)


def _where_any(row: Iterable[_Kept | None]) -> tuple[_Kept | None, ...]:
    """Return a row; nothing where it is one of nothing."""
    kept = tuple(row)
    return () if all(one is None for one in kept) else kept


class ImportedMesh(Modeler[MeshState, MeshState]):
    """A mesh from a file. There is nothing to draw and nothing to solve."""

    id = "bozzetto.mesh"
    state_type = MeshState

    @override
    def read_shapes(self, shapes: Shapes) -> MeshState:
        """Return a state with the meshes and curves of a file, and exact surfaces as meshes."""
        shapes = meshed(shapes)
        parts = tuple(shapes.meshes())
        return MeshState(
            tuple(part.mesh for part in parts),
            (True,) * len(shapes.solids) + (False,) * len(shapes.surfaces),
            tuple(part.name for part in parts),
            tuple(part.color for part in parts),
            tuple(part.groups for part in parts),
            _where_any(part.texture for part in parts),
            _where_any(part.skin for part in parts),
            tuple(part.path for part in parts) if any(part.path for part in parts) else (),
            shapes.curves,
        )

    @override
    def solve(self, state: MeshState, job: Job) -> MeshState:
        """Return the meshes, in millimetres and upright."""
        return state.standing()

    @override
    def scene(self, state: MeshState, result: MeshState | None) -> Scene:
        """Return the meshes, shaded in their colours or else in clay, and the curves."""
        shown = result or state.standing()
        items = tuple(item for part in shown.parts() for item in shaded_part(part))
        layers = [Layer("mesh", items)]
        if shown.curves:
            layers.append(Layer("curves", tuple(map(_line, shown.curves))))
        return Scene(tuple(layers))

    @override
    def shapes(self, state: MeshState, result: MeshState) -> Shapes:
        """Return the meshes with all that they came with, and the curves."""
        parts = result.parts()
        return Shapes(
            solids=tuple(part for part in parts if isinstance(part, Solid)),
            surfaces=tuple(part for part in parts if isinstance(part, Surface)),
            curves=result.curves,
        )

    @override
    def curves(self, state: MeshState, result: MeshState) -> tuple[Curve, ...]:
        """Return the curves, for the tools of other models to snap to."""
        return result.curves


def _line(curve: Curve) -> Lines:
    """Return a curve as it is shown, in its colour or else in that of ink."""
    spans = np.unique(
        curve.knots[(curve.knots >= curve.range[0]) & (curve.knots <= curve.range[1])]
    )
    steps = 1 if curve.degree == 1 else STEPS
    shares = np.arange(steps) / steps
    inner = (spans[:-1, None] + np.diff(spans)[:, None] * shares).ravel()
    points = curve.value(np.append(inner, spans[-1]))
    return Lines(points.astype(np.float32), color=curve.color or "ink")
