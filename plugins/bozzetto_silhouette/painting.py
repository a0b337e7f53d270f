"""What a surface looks like: the colours of its parts, and a picture over them."""

from __future__ import annotations

import numpy as np

from bozzetto.geometry import Mesh
from bozzetto_silhouette.body import Body
from bozzetto_silhouette.coloring import Coat, bare, part_coat
from bozzetto_silhouette.projection import projection_of
from bozzetto_silhouette.state import SilhouetteState

__all__ = ["painted_mesh"]


def painted_mesh(state: SilhouetteState, body: Body) -> Mesh:
    """A body for the screen and for files, with colours at its vertices where it has any."""
    vertices, normals = body.vertices.astype(np.float32), body.normals.astype(np.float32)
    coat = _coat(state, body)
    if coat is None:
        return Mesh(vertices, body.faces, normals)
    colors, cover = coat.bytes()
    return Mesh(vertices, body.faces, normals, colors, None if (cover == 255).all() else cover)


def _coat(state: SilhouetteState, body: Body) -> Coat | None:
    under = part_coat(state, body)
    if state.picture is None:
        return under
    projection = projection_of(state.picture, body.radius, body.step)
    upper = projection.coat(body.vertices, body.normals)
    return upper.over(bare(len(body.vertices)) if under is None else under)
