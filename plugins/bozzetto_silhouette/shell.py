"""From a plan with heights to a closed surface: lifted, mirrored, oriented, with normals."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bozzetto_silhouette.plan import Plan

__all__ = ["mirrored_shell", "vertex_normals"]

Points = NDArray[np.float64]
Faces = NDArray[np.int32]


def mirrored_shell(plan: Plan, heights: Points) -> tuple[Points, Faces]:
    """Front and back of a height field over a plan, sewn along the rim.

    Parameters
    ----------
    plan : Plan
        Counter-clockwise triangles; the rim's samples come first.
    heights : (n,) float array
        Half thickness at the plan's points; that of the rim is not used.

    Returns
    -------
    vertices : (v, 3) float array
        Rim at z = 0, then the front (z > 0), then the back.
    faces : (f, 3) int32 array
        Oriented outwards.
    """
    rim, count = len(plan.after), len(plan.points)
    inner = plan.points[rim:]
    z = heights[rim:, None]
    vertices = np.vstack([
        np.column_stack([plan.points[:rim], np.zeros(rim)]),
        np.hstack([inner, z]),
        np.hstack([inner, -z]),
    ])  # fmt: skip
    front = plan.triangles
    back = np.where(front >= rim, front + (count - rim), front)[:, ::-1]
    return vertices, np.concatenate([front, back]).astype(np.int32)


def vertex_normals(vertices: Points, faces: Faces) -> Points:
    """Unit normals (v, 3), each face weighted by its angle at the vertex."""
    corner = vertices[faces]
    edge = np.roll(corner, -1, axis=1) - corner
    normal = np.cross(edge[:, 0], edge[:, 1])
    normal /= np.maximum(np.sqrt((normal**2).sum(axis=1)), 1e-300)[:, None]
    edge /= np.maximum(np.sqrt((edge**2).sum(axis=2)), 1e-300)[..., None]
    cosine = -(edge * np.roll(edge, 1, axis=1)).sum(axis=2)
    angle = np.arccos(np.clip(cosine, -1.0, 1.0))
    index = faces.ravel()
    total = np.stack([
        np.bincount(index, (angle * normal[:, k : k + 1]).ravel(), len(vertices)) for k in range(3)
    ], axis=1)  # fmt: skip
    unit: Points = total / np.maximum(np.sqrt((total**2).sum(axis=1)), 1e-300)[:, None]
    return unit
