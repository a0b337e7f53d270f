"""The look of a surface: the colours of its parts, and a picture over them."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto.geometry import Mesh, Texture
from bozzetto.plugin import remembered
from bozzetto_silhouette.appearance.picture_projection import axes_of, projection_of, texel_of
from bozzetto_silhouette.appearance.texture_baking import baked
from bozzetto_silhouette.appearance.vertex_colors import (
    Coat,
    Creases,
    bare,
    coat_of_origins,
    creases_between,
    part_coat,
)
from bozzetto_silhouette.inflation.solidify import Checkpoint, ignore
from bozzetto_silhouette.model.state import Picture, SilhouetteState
from bozzetto_silhouette.solids.body import Body
from bozzetto_silhouette.solids.draft import Drafted


class Painted(NamedTuple):
    """A body's mesh with the colours of its vertices.

    Attributes
    ----------
    mesh : Mesh
        Closed, for files.
    shown : Mesh
        For the screen: where colours meet at a crease it has a vertex for each.
    """

    mesh: Mesh
    shown: Mesh


def painted(state: SilhouetteState, body: Body, checkpoint: Checkpoint = ignore) -> Painted:
    """Color a body's mesh, for the screen and for files."""
    checkpoint(1.0, "colours")  # the last step, and a short one
    plain = Mesh(body.vertices.astype(np.float32), body.faces, body.normals.astype(np.float32))
    parts = part_coat(state, body)
    checkpoint(1.0, "colours")
    picture = _picture_coat(state, body)
    if parts is None and picture is None:
        return Painted(plain, creased(body) if len(body.creases) else plain)
    coat = parts or bare(len(body.vertices))
    mesh = _colored(plain, coat if picture is None else picture.over(coat))
    checkpoint(1.0, "colours")
    creases = None if parts is None else creases_between(state, body, parts)
    if creases is None:
        return Painted(mesh, mesh)
    return Painted(mesh, _split(plain, coat, creases, picture))


def sketched(state: SilhouetteState, draft: Drafted, checkpoint: Checkpoint = ignore) -> Mesh:
    """Color a draft: every surface in it as the part that it belongs to."""
    checkpoint(1.0, "colours")
    body = draft.body
    plain = Mesh(body.vertices.astype(np.float32), body.faces, body.normals.astype(np.float32))
    walls = coat_of_origins(state, body)
    under = coat_of_origins(state, replace(body, origins=draft.under.astype(np.int32)))
    picture = _picture_coat(state, body)
    if walls is None or under is None:
        coat = bare(len(body.vertices))
        if picture is None:
            return plain
    else:
        coat = walls.over(under)
    return _colored(plain, coat if picture is None else picture.over(coat))


def _split(plain: Mesh, coat: Coat, creases: Creases, picture: Coat | None) -> Mesh:
    """Add a vertex to the mesh for every corner that has a colour of its own."""
    count = len(plain.vertices)
    faces = plain.faces.copy()
    copied = faces[creases.face, creases.corner]
    faces[creases.face, creases.corner] = count + np.arange(len(copied))
    order = np.concatenate([np.arange(count), copied])
    whole = coat.joined(creases.coat)
    if picture is not None:
        whole = picture.at(order).over(whole)
    normals = plain.vertex_normals()[order]
    return _colored(Mesh(plain.vertices[order], faces, normals), whole)


def _colored(mesh: Mesh, coat: Coat) -> Mesh:
    colors, cover = coat.bytes()
    return replace(mesh, colors=colors, cover=None if (cover == 255).all() else cover)


def _picture_coat(state: SilhouetteState, body: Body) -> Coat | None:
    if state.picture is None:
        return None
    projection = projection_of(state.picture, body.radius, body.step)
    return projection.coat(body.vertices, body.normals)


def texture_of(state: SilhouetteState, body: Body) -> Texture | None:
    """Return a body's colours as a texture; None where no picture is projected.

    Colours of parts alone are smooth enough for vertices.
    """
    picture = state.picture
    if picture is None:
        return None
    return _baked(state, body, picture)


# By the content; a large one takes 64 MB.
@remembered(limit=2, key=lambda state, body, picture: (state.nodes, picture, body))
def _baked(state: SilhouetteState, body: Body, picture: Picture) -> Texture:
    under = _corner_coat(state, body)
    places = np.concatenate([body.vertices, body.normals], axis=1)

    def paint(face: Index, weights: Array, detail: float) -> Coat:
        corners = body.faces[face]
        there = sum(weights[:, k, None] * places[corners[:, k]] for k in range(3))
        points, normals = np.hsplit(np.asarray(there), 2)
        length = np.sqrt(np.einsum("nd,nd->n", normals, normals))
        normals = normals / np.maximum(length, 1e-300)[:, None]
        coat = projection_of(picture, body.radius, detail).coat(points, normals)
        if under is None:
            return coat
        below = np.einsum("nk,nkd->nd", weights, under[face])
        return coat.over(Coat(below[:, :3], below[:, 3]))

    return baked(body.vertices, body.faces, axes_of(picture), 1.0 / texel_of(picture), paint)


def _corner_coat(state: SilhouetteState, body: Body) -> Array | None:
    """Return the colours and cover of the corners of the faces, (f, 3, 4), by the parts alone."""
    coat = part_coat(state, body)
    if coat is None:
        return None
    corners = np.column_stack([coat.rgb, coat.cover])[body.faces]
    creases = creases_between(state, body, coat)
    if creases is not None:
        own = np.column_stack([creases.coat.rgb, creases.coat.cover])
        corners[creases.face, creases.corner] = own
    return corners


def creased(body: Body) -> Mesh:
    """Return a body's mesh for the screen, with a vertex for every face at its creases.

    There every face gets the normal of its own side.
    """
    vertices, faces, normals = body.split_at_creases()
    return Mesh(vertices.astype(np.float32), faces, normals.astype(np.float32))
