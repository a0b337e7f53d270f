"""Two bodies become one: sharp by manifold3d, or with a blend around the crease."""

from __future__ import annotations

import numpy as np

from bozzetto_silhouette.body import Body
from bozzetto_silhouette.shell import vertex_normals
from bozzetto_silhouette.solid import Checkpoint, ignore
from bozzetto_silhouette.soundness import as_manifold
from bozzetto_silhouette.state import Operation

__all__ = ["combined"]


def combined(
    first: Body,
    second: Body,
    operation: Operation,
    blend: float,
    checkpoint: Checkpoint = ignore,
) -> Body | None:
    """One body of two.

    Parameters
    ----------
    first, second : Body
        In the same frame.
    operation : {"add", "merge", "carve", "intersect"}
        What the second does to the first.
    blend : float
        Radius of the blend as a share of the smaller `radius` of the two; 0 is a sharp crease.
    checkpoint : callable

    Returns
    -------
    Body or None
        None where nothing is left.
    """
    from manifold3d import OpType

    kind = {"carve": OpType.Subtract, "intersect": OpType.Intersect}.get(operation, OpType.Add)
    whole = as_manifold(first.vertices, first.faces).batch_boolean(
        [as_manifold(b.vertices, b.faces) for b in (first, second)], kind
    )
    if whole.is_empty():
        return None
    mesh = whole.to_mesh64()
    vertices = np.asarray(mesh.vert_properties, np.float64)[:, :3]
    faces = np.asarray(mesh.tri_verts).astype(np.int32)
    return Body(
        vertices,
        faces,
        vertex_normals(vertices, faces),
        np.zeros(len(vertices), np.int32),
        first.sources + second.sources,
        first.implicit,
        max(first.radius, second.radius),
        min(first.step, second.step),
    )
