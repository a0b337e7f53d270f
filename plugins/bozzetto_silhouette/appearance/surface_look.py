"""The look of a surface: the colours of its parts, a picture over them, and paint over both."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto.geometry import Mesh, Texture
from bozzetto.plugin import remembered
from bozzetto_silhouette.appearance.live_canvas import Unpainted
from bozzetto_silhouette.appearance.paint_layer import (
    Group,
    Track,
    laid_strokes,
    paint_at,
    paint_on_mesh,
    tracks_of,
)
from bozzetto_silhouette.appearance.paint_refinement import Refinement, refined
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

TEXELS = 4.0
"""Texels that the radius of the finest stroke of paint takes in a texture, if there is room."""


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


class Ground(NamedTuple):
    """A body's meshes before strokes of paint, and the colours of parts and picture on them.

    Attributes
    ----------
    mesh, shown : Mesh
        As in `Painted`, without colours.
    coat, shown_coat : Coat or None
        Of their vertices; None where all have the object's colour.
    """

    mesh: Mesh
    shown: Mesh
    coat: Coat | None
    shown_coat: Coat | None


def painted(state: SilhouetteState, body: Body, checkpoint: Checkpoint = ignore) -> Painted:
    """Color a body's mesh, for the screen and for files."""
    checkpoint(1.0, "colours")  # the last step, and a short one
    ground = ground_of(state, body, checkpoint)
    checkpoint(1.0, "colours")
    strokes = laid_strokes(state)
    mesh = _colored(ground.mesh, _with_paint(strokes, ground.mesh, ground.coat, body))
    if ground.shown is ground.mesh:
        return Painted(mesh, mesh)
    shown = _with_paint(strokes, ground.shown, ground.shown_coat, body)
    return Painted(mesh, _colored(ground.shown, shown))


# One more stroke of paint leaves what is under it.
@remembered(limit=8, key=lambda state, body, checkpoint: (state.unpainted, state.picture, body))
def ground_of(state: SilhouetteState, body: Body, checkpoint: Checkpoint = ignore) -> Ground:
    """Return a body's meshes with the colours of its parts, and of a picture over them."""
    plain = Mesh(body.vertices.astype(np.float32), body.faces, body.normals.astype(np.float32))
    parts = part_coat(state, body)
    checkpoint(1.0, "colours")
    picture = _picture_coat(state, body)
    if parts is None and picture is None:
        return Ground(plain, creased(body) if len(body.creases) else plain, None, None)
    coat = parts or bare(len(body.vertices))
    whole = coat if picture is None else picture.over(coat)
    checkpoint(1.0, "colours")
    creases = None if parts is None else creases_between(state, body, parts)
    if creases is None:
        return Ground(plain, plain, whole, whole)
    shown, shown_coat = _split(plain, coat, creases, picture)
    return Ground(plain, shown, whole, shown_coat)


def paint_edges(
    state: SilhouetteState, body: Body, checkpoint: Checkpoint = ignore
) -> Refinement | None:
    """Return finer triangles for the shown mesh where strokes of paint end; None without any."""
    strokes = laid_strokes(state)
    return _refined(strokes, ground_of(state, body).shown, body, checkpoint) if strokes else None


# Stroke by stroke, so that one more takes no longer than the first.
@remembered(limit=4, key=lambda strokes, shown, body, checkpoint: (strokes, shown))
def _refined(
    strokes: tuple[Group, ...], shown: Mesh, body: Body, checkpoint: Checkpoint
) -> Refinement:
    known = _refined.known(strokes[:-1], shown, body, checkpoint) if len(strokes) > 1 else None
    fine = Refinement.of(shown) if known is None else known
    for track in tracks_of(strokes if known is None else strokes[-1:], body):
        checkpoint(1.0, "paint")
        fine = refined(fine, track, body.step)
    return fine


def finely_shown(state: SilhouetteState, body: Body, fine: Refinement, shown: Mesh) -> Mesh:
    """Return a shown mesh, as its joints are turned, with finer triangles where paint ends."""
    under = ground_of(state, body).shown_coat
    coat = fine.paint if under is None else fine.paint.over(_spread(fine, under))
    return _colored(fine.applied(shown), coat)


def canvas_of(state: SilhouetteState, body: Body, seen: Callable[[Mesh], Mesh]) -> Unpainted:
    """Return a body's mesh to paint on, with the paint that is on it.

    Parameters
    ----------
    state : SilhouetteState
        What was drawn and painted.
    body : Body
        The whole shape.
    seen : callable
        Gives a mesh of the body, vertex for vertex, as its joints are turned.
    """
    strokes, ground = laid_strokes(state), ground_of(state, body)
    return _unpainted(state, body, ground, strokes, _soon(strokes, ground, body), seen)


# Found while a pen hovers: where it goes down, the stroke begins at once.
@remembered(
    limit=2,
    key=lambda state, body, ground, strokes, fine, seen: (
        state.unpainted,
        state.picture,
        state.turns,
        ground.mesh,
        strokes,
        fine,
    ),
)
def _unpainted(
    state: SilhouetteState,
    body: Body,
    ground: Ground,
    strokes: tuple[Group, ...],
    fine: Refinement | None,
    seen: Callable[[Mesh], Mesh],
) -> Unpainted:
    under = bare(len(ground.mesh.vertices)) if ground.coat is None else ground.coat
    if fine is None:
        paint = paint_on_mesh(strokes, ground.mesh, body, body.step)
        return Unpainted.of(ground.mesh, seen(ground.mesh), under, paint, body.step)
    rest, there = fine.applied(ground.mesh), fine.applied(seen(ground.mesh))
    return Unpainted.of(rest, there, _spread(fine, under), fine.paint, body.step)


def _soon(strokes: tuple[Group, ...], ground: Ground, body: Body) -> Refinement | None:
    """Return the finer triangles of strokes, if at most the last one is to be worked out."""
    if not strokes or ground.shown is not ground.mesh:
        return None
    asked = (strokes,) if len(strokes) == 1 else (strokes, strokes[:-1])
    known = [_refined.known(some, ground.shown, body, ignore) for some in asked]
    if len(strokes) > 1 and all(fine is None for fine in known):
        return None
    return _refined(strokes, ground.shown, body, ignore)


def _spread(fine: Refinement, coat: Coat) -> Coat:
    columns = fine.spread(np.column_stack([coat.rgb, coat.cover]))
    return Coat(columns[:, :3], columns[:, 3])


def sketched(state: SilhouetteState, draft: Drafted, checkpoint: Checkpoint = ignore) -> Mesh:
    """Color a draft: every surface in it as the part that it belongs to."""
    checkpoint(1.0, "colours")
    body = draft.body
    plain = Mesh(body.vertices.astype(np.float32), body.faces, body.normals.astype(np.float32))
    walls = coat_of_origins(state, body)
    under = coat_of_origins(state, replace(body, origins=draft.under.astype(np.int32)))
    picture = _picture_coat(state, body)
    coat = None if walls is None or under is None else walls.over(under)
    if picture is not None:
        coat = picture if coat is None else picture.over(coat)
    strokes = laid_strokes(state)
    if strokes:
        paint = paint_at(tracks_of(strokes, None), body.vertices, body.normals, body.step)
        coat = paint if coat is None else paint.over(coat)
    return _colored(plain, coat)


def _with_paint(
    strokes: tuple[Group, ...], mesh: Mesh, under: Coat | None, body: Body
) -> Coat | None:
    """Return colours with strokes of paint over them; None where there are neither."""
    if not strokes:
        return under
    paint = paint_on_mesh(strokes, mesh, body, body.step)
    return paint if under is None else paint.over(under)


def _split(plain: Mesh, coat: Coat, creases: Creases, picture: Coat | None) -> tuple[Mesh, Coat]:
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
    return Mesh(plain.vertices[order], faces, normals), whole


def _colored(mesh: Mesh, coat: Coat | None) -> Mesh:
    if coat is None:
        return mesh
    colors, cover = coat.bytes()
    return replace(mesh, colors=colors, cover=None if (cover == 255).all() else cover)


def _picture_coat(state: SilhouetteState, body: Body) -> Coat | None:
    if state.picture is None:
        return None
    projection = projection_of(state.picture, body.radius, body.step)
    return projection.coat(body.vertices, body.normals)


def texture_of(
    state: SilhouetteState, body: Body, checkpoint: Checkpoint = ignore
) -> Texture | None:
    """Return a body's colours as a texture; None without a picture and strokes of paint.

    Colours of parts alone are smooth enough for vertices.
    """
    strokes = laid_strokes(state)
    if state.picture is None and not strokes:
        return None
    return _baked(state, body, strokes, checkpoint)


def known_texture(state: SilhouetteState, body: Body) -> Texture | None:
    """Return a body's texture if it was worked out lately."""
    return _baked.known(state, body, laid_strokes(state), ignore)


# By the content; a large one takes 64 MB.
@remembered(
    limit=2,
    key=lambda state, body, strokes, checkpoint: (state.unpainted, state.picture, body, strokes),
)
def _baked(
    state: SilhouetteState, body: Body, strokes: tuple[Group, ...], checkpoint: Checkpoint
) -> Texture:
    picture, tracks = state.picture, tracks_of(strokes, body)
    under = _corner_coat(state, body)
    places = np.concatenate([body.vertices, body.normals], axis=1)

    def paint(face: Index, weights: Array, detail: float) -> Coat:
        checkpoint(1.0, "colours")
        corners = body.faces[face]
        there = sum(weights[:, k, None] * places[corners[:, k]] for k in range(3))
        points, normals = np.hsplit(np.asarray(there), 2)
        length = np.sqrt(np.einsum("nd,nd->n", normals, normals))
        normals = normals / np.maximum(length, 1e-300)[:, None]
        coat = paint_at(tracks, points, normals, detail)
        if picture is not None:
            coat = coat.over(projection_of(picture, body.radius, detail).coat(points, normals))
        if under is None:
            return coat
        below = np.einsum("nk,nkd->nd", weights, under[face])
        return coat.over(Coat(below[:, :3], below[:, 3]))

    return baked(body.vertices, body.faces, *_axes_and_density(picture, tracks), paint)


def _axes_and_density(picture: Picture | None, tracks: list[Track]) -> tuple[Array, float]:
    """Return the axes to lay the surface out along, and the texels per mm that are wanted."""
    radii = [float(track.segments.radii.max()) for track in tracks]
    density = TEXELS / max(min(radii), 1e-300) if radii else 0.0
    if picture is None:
        return np.eye(3), density
    return axes_of(picture), max(density, 1.0 / texel_of(picture))


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
