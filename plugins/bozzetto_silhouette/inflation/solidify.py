"""Outline to solid: the whole line in one function."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from bozzetto.arrays import Array, Faces
from bozzetto.errors import UserError
from bozzetto.plugin import remembered
from bozzetto_silhouette.inflation.closed_surface import sewn_shell, shell_normals
from bozzetto_silhouette.inflation.inflation import ConvolutionHeights, HeightModel
from bozzetto_silhouette.inflation.manifold_check import Soundness, soundness_of
from bozzetto_silhouette.inflation.thickness import Thickness, Uniform
from bozzetto_silhouette.outline.boundary_sampling import Rim, sample_rim
from bozzetto_silhouette.outline.domain_mesh import Plan, plan_of
from bozzetto_silhouette.outline.medial_axis import Skeleton
from bozzetto_silhouette.outline.mirror_symmetry import mirrored_plan
from bozzetto_silhouette.outline.normalized import Frame, SkeletonRule, frame_of
from bozzetto_silhouette.outline.outline import Outline

Checkpoint = Callable[[float, str], None]

PITCH = 1.1
"""Spacing of the plan in cells: a triangular lattice at this pitch has about as many
points as the square one."""

FINEST = 0.2
"""Smallest spacing along the outline, in cells."""

_ATTEMPTS = ((1.0, False), (0.6, False), (0.6, True))
"""Attempts until the solid is sound: the spacing as a share of the one asked for, and
whether every drawn vertex is kept."""


Layout = tuple[Rim, Plan]


CONVOLUTION = ConvolutionHeights()
UNIFORM = Uniform()


def ignore(fraction: float, step: str) -> None:
    """Do nothing: the checkpoint of those who have none."""


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
    outline : Outline
        As drawn.
    skeleton : Skeleton
        In the object frame.
    plan : Plan
        In the object frame.
    front, back : (n,) float64 array
        Squared heights and depths at the plan's points, 0 on the rim.
    step : float
        Spacing of the plan in the thick places.
    soundness : Soundness
        What the check of the mesh found; never hidden.
    """

    vertices: Array
    faces: Faces
    normals: Array
    outline: Outline
    skeleton: Skeleton
    plan: Plan
    front: Array
    back: Array
    step: float
    soundness: Soundness


# Neither plan nor squares depend on the thickness, and the plan on nothing but the outline: who
# drags one of them does not wait for the others.
@remembered(limit=64)
def _laid_out(frame: Frame, step: float, every_vertex: bool) -> Layout | None:
    """Sample an outline and triangulate its inside; None where the samples cross themselves."""
    rim = sample_rim(frame.inner.rings, step, FINEST * step, every_vertex=every_vertex)
    if not rim.simple and not every_vertex:
        return None
    plan = plan_of(rim, frame.axis, step)
    coordinate = frame.mirrored
    return rim, plan if coordinate is None else mirrored_plan(plan, coordinate)


@remembered(limit=64, key=lambda model, frame, rim, plan: (plan, model))
def _squares(model: HeightModel, frame: Frame, rim: Rim, plan: Plan) -> Array:
    squares = model.squares(frame, rim, plan)
    return squares if plan.partner is None else 0.5 * (squares + squares[plan.partner])


def solidify(
    outline: Outline,
    *,
    resolution: int = 128,
    height_model: HeightModel = CONVOLUTION,
    thickness: Thickness = UNIFORM,
    rule: SkeletonRule = "exact",
    checkpoint: Checkpoint = ignore,
) -> SilhouetteSolid:
    """Inflate an outline.

    Parameters
    ----------
    outline : Outline
        What was drawn.
    resolution : int
        Cells along the longest side; where walls or gaps are thin the mesh is finer.
    height_model : HeightModel
        The kind of surface.
    thickness : Thickness
        Factors on the height and on the depth; the silhouette stays.
    rule : {"exact", "paper"}
        How the skeleton is taken from the outline's triangles.
    checkpoint : callable
        Called with (fraction, step) between steps; may raise `Cancelled`.

    Returns
    -------
    SilhouetteSolid

    Raises
    ------
    UserError
        If the outline is so ragged that no spacing gives a solid.
    """
    checkpoint(0.0, "skeleton")
    frame = frame_of(outline, rule)
    for share, every_vertex in _ATTEMPTS:
        step = share * PITCH / resolution
        checkpoint(0.15, "plan")
        layout = _laid_out(frame, step, every_vertex)
        if layout is None:
            continue
        rim, plan = layout
        checkpoint(0.4, "surface")
        square = _squares(height_model, frame, rim, plan)
        checkpoint(0.8, "mesh")
        up, down = thickness.factors(frame, plan, square, square)
        front = square * up**2
        back = front if up is down else square * down**2
        vertices, faces = sewn_shell(plan, np.sqrt(front), np.sqrt(back))
        vertices *= frame.scale
        vertices[:, :2] += frame.origin
        soundness = soundness_of(vertices, faces, outline)
        if soundness.ok:
            break
    if not soundness.watertight or not soundness.volume > 0.0:
        raise UserError(
            "This outline is too ragged for a solid. Smooth it, or draw it again with fewer turns."
        )
    normals = shell_normals(plan, front, back)
    checkpoint(1.0, "done")
    square_scale = frame.scale**2
    return SilhouetteSolid(
        vertices,
        faces,
        normals,
        outline,
        frame.skeleton.transformed(frame.scale, frame.origin),
        replace(plan, points=plan.points * frame.scale + frame.origin),
        front * square_scale,
        back * square_scale,
        step * frame.scale,
        soundness,
    )
