"""The silhouette modeler's place in the program: state in; solid, picture and shapes out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from bozzetto.errors import UserError
from bozzetto.geometry import Mesh, Shapes, Skeleton, Solid
from bozzetto.ink import Drawing
from bozzetto.plugin import Context, Job
from bozzetto.scene import Layer, Lines, Scene, Shaded
from bozzetto_silhouette.fidelity import measure
from bozzetto_silhouette.ink_to_outline import outline_of
from bozzetto_silhouette.memory import Memory
from bozzetto_silhouette.sheet import sheet_under
from bozzetto_silhouette.solid import SilhouetteSolid, solidify
from bozzetto_silhouette.state import Part, SilhouetteState
from bozzetto_silhouette.tools import DrawOutline
from bozzetto_silhouette.union import united

__all__ = ["Silhouette", "SilhouetteResult"]

PREVIEW_RESOLUTION = 64
"""Cells along the longest side for an answer within a blink."""

INK_WIDTH = (1.0, 3.0)
"""Width of ghost ink at no and at full pressure, pixels."""

_solids: Memory[SilhouetteSolid] = Memory(limit=64)


@dataclass(frozen=True, eq=False)
class SilhouetteResult:
    """One solid for every part: in its object frame, and as a mesh in the world."""

    solids: tuple[SilhouetteSolid, ...]
    meshes: tuple[Mesh, ...]


class Silhouette:
    """Closed outlines become convolution solids (Kukelova & Durikovic 2007)."""

    id = "bozzetto.silhouette"
    title = "Silhouette"
    state_type = SilhouetteState
    state_version = 1

    def create(self, context: Context) -> SilhouetteState:
        """No part yet."""
        return SilhouetteState()

    def tools(self) -> Sequence[DrawOutline]:
        """Drawing outlines is all that it takes."""
        return (DrawOutline(),)

    def read_drawing(self, drawing: Drawing, context: Context) -> SilhouetteState:
        """All strokes of a drawing as one part; nested outlines are holes.

        Raises
        ------
        UserError
            If the drawing is empty or does not close.
        """
        if not len(drawing.strokes):
            raise UserError("The drawing has no strokes. Draw a closed outline first.")
        part = Part(drawing.strokes, sheet_under(drawing.strokes[0], context))
        outline_of(part)
        return SilhouetteState(parts=(part,))

    def solve(self, state: SilhouetteState, job: Job) -> SilhouetteResult:
        """One watertight solid for every part; parts that did not change are remembered."""
        resolution = state.resolution
        if job.quality == "preview":
            resolution = min(resolution, PREVIEW_RESOLUTION)
        solids = []
        for number, part in enumerate(state.parts):

            def checkpoint(fraction: float, step: str, number: int = number) -> None:
                job.checkpoint((number + fraction) / len(state.parts), step)

            def work(part: Part = part) -> SilhouetteSolid:
                return solidify(
                    outline_of(part),
                    resolution=resolution,
                    softness=state.softness,
                    inflation=state.inflation,
                    checkpoint=checkpoint,
                )

            question = (part, resolution, state.softness, state.inflation)
            solids.append(_solids.recall(question, work))
        meshes = [
            Mesh(
                part.sheet.to_world(solid.vertices).astype(np.float32),
                solid.faces,
                part.sheet.turn(solid.normals).astype(np.float32),
            )
            for part, solid in zip(state.parts, solids, strict=True)
        ]
        return SilhouetteResult(tuple(solids), tuple(meshes))

    def scene(self, state: SilhouetteState, result: SilhouetteResult | None) -> Scene:
        """The solids in clay and the ink that made them, as a ghost."""
        layers = []
        if result is not None:
            layers.append(Layer("shape", tuple(Shaded(mesh) for mesh in result.meshes)))
        if state.parts:
            layers.append(Layer("ink", tuple(_ghost(part) for part in state.parts)))
        return Scene(tuple(layers))

    def shapes(self, state: SilhouetteState, result: SilhouetteResult) -> Shapes:
        """One solid, the union of all parts, and the skeleton of each."""
        if not result.meshes:
            return Shapes()
        skeletons = []
        for part, solid in zip(state.parts, result.solids, strict=True):
            nodes, bones = solid.skeleton.nodes, solid.skeleton.edges.astype(np.int32)
            joints = part.sheet.to_world(nodes[:, :2])
            skeletons.append(Skeleton(joints, nodes[:, 2], bones))
        return Shapes(solids=(Solid(united(result.meshes)),), skeletons=tuple(skeletons))

    def report(self, state: SilhouetteState, result: SilhouetteResult) -> Mapping[str, Any]:
        """How truly every part keeps its outline."""
        return {
            "parts": [
                asdict(measure(solid, outline_of(part)))
                for part, solid in zip(state.parts, result.solids, strict=True)
            ]
        }

    def upgrade(self, state: dict[str, Any], version: int) -> dict[str, Any]:
        """There is no older form yet."""
        return state


def _ghost(part: Part) -> Lines:
    """A part's ink on its sheet, as wide as the hand pressed."""
    points, starts, widths, count = [], [], [], 0
    thin, thick = INK_WIDTH
    for stroke in part.strokes:
        on_sheet = part.sheet.from_pixels(stroke.points, stroke.camera)
        points.append(part.sheet.to_world(on_sheet))
        widths.append(thin + (thick - thin) * np.clip(stroke.pressure, 0.0, 1.0))
        starts.append(count)
        count += len(on_sheet)
    return Lines(
        np.concatenate(points),
        np.array(starts),
        color="ghost",
        width=np.concatenate(widths),
        hidden="faint",
    )
