"""What a surface looks like: the colours of its parts, and a picture over them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bozzetto.geometry import Mesh, Texture
from bozzetto_silhouette.baking import baked
from bozzetto_silhouette.body import Body
from bozzetto_silhouette.coloring import Coat, bare, part_coat
from bozzetto_silhouette.projection import axes_of, projection_of, texel_of
from bozzetto_silhouette.state import SilhouetteState

__all__ = ["painted_mesh", "texture_of"]

Array = NDArray[np.float64]
Index = NDArray[np.int64]


def painted_mesh(state: SilhouetteState, body: Body) -> Mesh:
    """A body for the screen and for files, with colours at its vertices where it has any."""
    vertices, normals = body.vertices.astype(np.float32), body.normals.astype(np.float32)
    coat = _coat(state, body)
    if coat is None:
        return Mesh(vertices, body.faces, normals)
    colors, cover = coat.bytes()
    return Mesh(vertices, body.faces, normals, colors, None if (cover == 255).all() else cover)


def texture_of(state: SilhouetteState, body: Body) -> Texture | None:
    """The colours of a body as a picture wrapped around it; None where no picture is laid on.

    Colours of parts alone are smooth enough for vertices.
    """
    picture = state.picture
    if picture is None:
        return None
    under = part_coat(state, body) or bare(len(body.vertices))

    def paint(face: Index, weights: Array, detail: float) -> Coat:
        corners = body.faces[face]

        def between(values: Array) -> Array:
            return np.asarray(np.einsum("nk,nkd->nd", weights, values[corners]))

        normals = between(body.normals)
        normals /= np.maximum(np.linalg.norm(normals, axis=1), 1e-300)[:, None]
        projection = projection_of(picture, body.radius, detail)
        below = Coat(between(under.rgb), between(under.cover[:, None])[:, 0])
        return projection.coat(between(body.vertices), normals).over(below)

    return baked(body.vertices, body.faces, axes_of(picture), 1.0 / texel_of(picture), paint)


def _coat(state: SilhouetteState, body: Body) -> Coat | None:
    under = part_coat(state, body)
    if state.picture is None:
        return under
    projection = projection_of(state.picture, body.radius, body.step)
    upper = projection.coat(body.vertices, body.normals)
    return upper.over(bare(len(body.vertices)) if under is None else under)
