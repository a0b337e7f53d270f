"""Shapes in the size and of the triangles that are wanted in files, made once for all formats."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from bozzetto.arrays import Array
from bozzetto.cached_properties import cached_property
from bozzetto.exchange.cad.cad_curves import points_on
from bozzetto.exchange.handover import AS_USUAL, LEVELS, Handover
from bozzetto.exchange.mesh.picture_places import Checkpoint, no_checkpoint
from bozzetto.exchange.mesh.polygons import without_degenerate
from bozzetto.exchange.triangle_budget import triangle_count, within_budget
from bozzetto.geometry.meshed_shapes import meshed
from bozzetto.geometry.placement import Placement
from bozzetto.geometry.resting_place import lying_flat
from bozzetto.geometry.shapes import Shapes

if TYPE_CHECKING:
    from bozzetto.exchange.quad_budget import Quadrangulated


@dataclass(frozen=True, eq=False)
class Recording:
    """How parts moved before they were where they are now.

    Parameters
    ----------
    motions : sequence of sequence of Placement
        For each mesh of the shapes as triangles (`meshed`) where it was at each time, as seen from
        where it is now.
    seconds : sequence of float
        These times, growing.
    """

    motions: Sequence[Sequence[Placement]]
    seconds: Sequence[float]


@dataclass(frozen=True, eq=False)
class Ready:
    """Shapes as a person wants to hand them over, for files of any format.

    What all files have in common is made once: the same triangles are in each.

    Parameters
    ----------
    shapes : Shapes
        As they are in the world, mm.
    handover : Handover
        What the person wants.
    checkpoint : callable
        Called with the fraction done (0 … 1) and the step's name where a file takes long; may raise
        to stop it.
    recording : Recording, optional
        How the shapes moved, for formats that hold motions.
    """

    shapes: Shapes
    handover: Handover = AS_USUAL
    checkpoint: Checkpoint = no_checkpoint
    recording: Recording | None = None

    @cached_property
    def _placed(self) -> tuple[Shapes, Placement]:
        """The shapes in the size that is wanted, lying flat if they should, and what did that."""
        shapes, wanted, change = self.shapes, self.handover, Placement()
        if wanted.scale != 1.0:
            change = Placement(scale=wanted.scale)
            shapes = shapes.placed(change)
        if wanted.lay_flat:
            lying = lying_flat(_points(shapes))
            shapes, change = shapes.placed(lying), lying.after(change)
        return shapes, change

    @property
    def placed(self) -> Shapes:
        """The shapes in the size that is wanted, lying flat if they should."""
        return self._placed[0]

    def motions_of(self, written: Shapes) -> dict[str, Any]:
        """Return where the drawn meshes of a file were at each time; nothing if not recorded.

        With coarser levels of detail there are none: these are parts of their own in a file.
        """
        if self.recording is None or self.handover.levels:
            return {}
        if len(list(written.meshes())) != len(self.recording.motions):
            return {}  # parts that were taken apart for the file
        change = self._placed[1]
        back = change.inverse()
        rows = zip(written.meshes(), self.recording.motions, strict=True)
        motions = [
            [change.after(pose).after(back) for pose in motion]
            for part, motion in rows
            if len(without_degenerate(part.mesh.faces))
        ]
        return {"motions": motions, "seconds": self.recording.seconds}

    @cached_property
    def points(self) -> Array:
        """Points that tell how far it reaches, (n, 3), mm."""
        return _points(self.placed)

    @property
    def size(self) -> tuple[float, float, float]:
        """Width, depth and height of the box around it, mm; zeros if there is nothing."""
        points = self.points
        x, y, z = np.ptp(points, axis=0).tolist() if len(points) else (0.0, 0.0, 0.0)
        return x, y, z

    @cached_property
    def triangles(self) -> Shapes:
        """Shapes of triangles, no more than are wanted; two for each quad that is wanted."""
        if self.quads is not None:
            return self.quads.shapes
        shapes = meshed(self.placed)
        most = self.handover.triangles
        return shapes if most is None else within_budget(shapes, most)

    @cached_property
    def quads(self) -> Quadrangulated | None:
        """Shapes of quads, about as many as are wanted; None where none are."""
        count = self.handover.quads
        if count is None:
            return None
        from bozzetto.exchange.quad_budget import within_quads

        return within_quads(meshed(self.placed), count, self.checkpoint)

    @cached_property
    def coarser(self) -> tuple[Shapes, ...]:
        """Shapes with fewer and fewer triangles, as many levels as are wanted besides."""
        if not self.handover.levels:
            return ()
        count = triangle_count(self.triangles)
        return tuple(within_budget(self.triangles, count // fewer) for fewer in LEVELS)


def _points(shapes: Shapes) -> Array:
    """Return points that tell how far shapes reach, (n, 3), mm."""
    found = [part.mesh.vertices.astype(np.float64) for part in meshed(shapes).meshes()]
    found += [points_on(curve) for curve in shapes.curves]
    return np.concatenate(found) if found else np.zeros((0, 3))
