"""Outline to solid: the whole line in one function."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bozzetto_silhouette.fairing import faired
from bozzetto_silhouette.field import ConvolutionField, convolution_field, with_correction
from bozzetto_silhouette.outline import Outline
from bozzetto_silhouette.plan import plan_of
from bozzetto_silhouette.sampling import sample_rim
from bozzetto_silhouette.shell import mirrored_shell, shell_normals
from bozzetto_silhouette.skeleton import Skeleton
from bozzetto_silhouette.soundness import Soundness, soundness_of

__all__ = ["Checkpoint", "SilhouetteSolid", "ignore", "solidify"]

Points = NDArray[np.float64]
Checkpoint = Callable[[float, str], None]

PITCH = 1.1
"""Spacing of the plan in cells: a triangular lattice at this pitch has about as many
points as the square one."""

FINEST = 0.2
"""Smallest spacing along the outline, in cells."""

_ATTEMPTS = ((1.0, False), (0.6, False), (0.6, True))
"""What is tried until the solid is sound: the spacing as a share of the one asked for, and
whether every drawn vertex is kept."""


def ignore(fraction: float, step: str) -> None:
    """Checkpoint that does nothing."""


@dataclass(frozen=True, eq=False)
class SilhouetteSolid:
    """A closed surface whose front view is the drawn outline.

    Attributes
    ----------
    vertices : (v, 3) float64 array
        In the object frame: the outline lies in z = 0.
    faces : (f, 3) int32 array
        Oriented outwards, watertight.
    normals : (v, 3) float64 array
        Unit, outwards.
    skeleton : Skeleton
        In the object frame.
    outline : Outline
        As drawn.
    field : ConvolutionField
        The field whose zero surface this is, but for the fairing.
    soundness : Soundness
        What the check of the mesh found; never hidden.
    """

    vertices: Points
    faces: NDArray[np.int32]
    normals: Points
    skeleton: Skeleton
    outline: Outline
    field: ConvolutionField
    soundness: Soundness


def solidify(
    outline: Outline,
    *,
    resolution: int = 128,
    softness: float = 1.4,
    inflation: float = 1.0,
    checkpoint: Checkpoint = ignore,
) -> SilhouetteSolid:
    """Inflate an outline.

    Parameters
    ----------
    outline : Outline
        What was drawn.
    resolution : int
        Cells along the longest side; where walls or gaps are thin the mesh is finer.
    softness : float
        Support of the kernel in radii, 1.25 to 2: how far limbs blend into each other.
    inflation : float
        Factor on the depth; the silhouette stays.
    checkpoint : callable
        Called with (fraction, step) between steps; may raise `Cancelled`.

    Returns
    -------
    SilhouetteSolid
    """
    checkpoint(0.0, "skeleton")
    raw, axis = convolution_field(outline, softness=softness, inflation=inflation)
    inner = outline.transformed(1.0 / raw.scale, -raw.origin / raw.scale)
    for share, every_vertex in _ATTEMPTS:
        step = share * PITCH / resolution
        checkpoint(0.15, "plan")
        rim = sample_rim(inner.rings, step, FINEST * step, every_vertex=every_vertex)
        if not rim.simple and not every_vertex:
            continue
        plan = plan_of(rim, axis, step)
        checkpoint(0.4, "field")
        field = with_correction(raw, rim)
        square = np.zeros(len(plan.points))
        first = len(plan.after)
        square[first:] = field.heights_inner(plan.points[first:]) ** 2
        checkpoint(0.6, "fairing")
        square = faired(plan, square)
        checkpoint(0.8, "surface")
        vertices, faces = mirrored_shell(plan, np.sqrt(square))
        vertices[:, :2] = vertices[:, :2] * raw.scale + raw.origin
        vertices[:, 2] *= raw.scale * inflation
        soundness = soundness_of(vertices, faces, outline)
        if soundness.ok:
            break
    normals = shell_normals(plan, square, inflation)
    checkpoint(1.0, "done")
    return SilhouetteSolid(vertices, faces, normals, field.skeleton, outline, field, soundness)
