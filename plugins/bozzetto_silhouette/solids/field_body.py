"""A body made anew from the function of space that it is to be the zero set of.

The way that is left where meshes could not be put together: it is coarser along edges, and
closed whatever the meshes were like.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bozzetto.arrays import Array, Faces, Index
from bozzetto.errors import UserError
from bozzetto_silhouette.implicit.implicit_solid import Implicit
from bozzetto_silhouette.inflation.manifold_check import topology_of
from bozzetto_silhouette.inflation.solidify import Checkpoint, ignore
from bozzetto_silhouette.solids.body import Body
from bozzetto_silhouette.solids.polygonize import extract

EDGE = 0.8
"""Cosine between the normals of a face and of its corner below which the corner is on an edge."""


def field_body(
    implicit: Implicit,
    bodies: Sequence[Body],
    radius: float,
    step: float,
    checkpoint: Checkpoint = ignore,
) -> Body | None:
    """Polygonize a solid that bodies were to make.

    Parameters
    ----------
    implicit : Implicit
        The solid.
    bodies : sequence of Body
        Of which its surface consists, in the order of their sources.
    radius, step : float
        As in `Body`.
    checkpoint : callable
        Called with (fraction, step) between steps; may raise `Cancelled`.

    Returns
    -------
    Body or None
        None where nothing is inside.

    Raises
    ------
    UserError
        If not even that is sound.
    """
    from scipy.spatial import cKDTree

    surface = extract(implicit, implicit.bounds, step, checkpoint)
    if not len(surface.faces):
        return None
    sound = topology_of(surface.vertices, surface.faces)
    if not sound.watertight or not sound.volume > 0.0:
        raise UserError(
            "These parts do not join into a sound solid. Move one of them a little, or change "
            "its size."
        )
    starts = np.cumsum([0, *(len(body.sources) for body in bodies)])
    origins = np.concatenate([
        body.origins + np.int32(start) for body, start in zip(bodies, starts, strict=False)
    ])  # fmt: skip
    _, nearest = cKDTree(np.concatenate([body.vertices for body in bodies])).query(surface.vertices)
    return Body(
        *surface,
        origins[nearest].astype(np.int32),
        tuple(source for body in bodies for source in body.sources),
        implicit,
        radius,
        step,
        _on_edges(*surface),
        resampled=True,
    )


def _on_edges(vertices: Array, faces: Faces, normals: Array) -> Index:
    """Return the vertices where one normal does not suit all faces around."""
    one, two, three = vertices[faces].transpose(1, 0, 2)
    normal = np.cross(two - one, three - one)
    normal /= np.maximum(np.sqrt((normal**2).sum(axis=1)), 1e-300)[:, None]
    cosine = np.einsum("fk,fck->fc", normal, normals[faces])
    return np.unique(faces[cosine < EDGE]).astype(np.intp)
