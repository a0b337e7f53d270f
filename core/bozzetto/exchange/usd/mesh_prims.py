"""Meshes of a USD scene: triangles with normals, places in pictures, colours and materials."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Array, Floats, Index
from bozzetto.exchange.color import WHITE, srgb_to_linear
from bozzetto.exchange.mesh.face_groups import proper_groups
from bozzetto.exchange.mesh.picture_places import Places
from bozzetto.exchange.mesh.polygon_corners import corner_runs
from bozzetto.exchange.mesh.polygons import is_degenerate
from bozzetto.exchange.usd.looks import Looks, linear
from bozzetto.exchange.usd.prims import DIRECTIONS, PLACES, Names, Prim, numbers, quoted, tuples
from bozzetto.geometry.mesh import Mesh
from bozzetto.geometry.shapes import FaceGroup, Solid, Surface
from bozzetto.scene.renderer.normals import corner_normals

BINDING = "MaterialBindingAPI"


def mesh_prim(name: str, part: Solid | Surface, looks: Looks, laid: Places | None) -> Prim:
    """Return the mesh of a part, at rest if it has a skin.

    Parameters
    ----------
    name : str
        Its identifier.
    part : Solid or Surface
        In the unit and the axes of the file.
    looks : Looks
        Its materials are added there.
    laid : (f, 3, 2) float32 array, optional
        Places in a picture to come, of its proper triangles.
    """
    mesh, skin = part.mesh, part.skin
    if skin is not None and skin.rest is not None:
        mesh = replace(mesh, vertices=skin.rest.vertices, normals=skin.rest.normals)
    proper = ~is_degenerate(mesh.faces)
    faces = mesh.faces[proper]
    made = Prim("Mesh", name, part.name, (BINDING,))
    if isinstance(part, Surface):
        made.put("uniform bool doubleSided", "1")
    made.put("uniform token subdivisionScheme", quoted("none"))
    box = np.array([mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)])
    made.put("float3[] extent", tuples(box, PLACES))
    corners = laid if part.texture is None else part.texture.corners[proper]
    groups = proper_groups(part) or (FaceGroup(part.name, len(faces)),)
    ends = np.cumsum([0, *(group.count for group in groups)]).tolist()
    runs = [list(corner_runs(part, begin, end, corners)) for begin, end in pairwise(ends)]
    every = [run for own in runs for run in own]
    none = np.zeros(0, np.intp)
    flat = np.concatenate([none, *(run.ravel() for run in every)])
    sizes = np.concatenate([none, *(np.full(len(run), run.shape[1]) for run in every)])
    made.put("int[] faceVertexCounts", numbers(sizes))
    made.put("int[] faceVertexIndices", numbers(faces.ravel()[flat]))
    made.put("point3f[] points", tuples(mesh.vertices, PLACES))
    _put_normals(made, part, mesh, proper, flat)
    if corners is not None:
        rows = corners.reshape(-1, 2)[flat] * (1.0, -1.0) + (0.0, 1.0)
        made.put("texCoord2f[] primvars:st", _interpolated(tuples(rows, "%.7g"), "faceVarying"))
    _put_colors(made, part)
    if len(groups) == 1:
        made.lines.append(f"rel material:binding = <{looks.bound_to(part, groups[0])}>")
        return made
    made.put("uniform token subsetFamily:materialBind:familyType", quoted("partition"))
    names, begin = Names(), 0
    for group, own in zip(groups, runs, strict=True):
        count = sum(map(len, own))
        subset = Prim("GeomSubset", names.new(group.name, "group"), group.name, (BINDING,))
        subset.put("uniform token elementType", quoted("face"))
        subset.put("uniform token familyName", quoted("materialBind"))
        subset.put("int[] indices", numbers(np.arange(begin, begin + count)))
        subset.lines.append(f"rel material:binding = <{looks.bound_to(part, group)}>")
        made.children.append(subset)
        begin += count
    return made


def _put_normals(
    made: Prim, part: Solid | Surface, mesh: Mesh, proper: NDArray[np.bool_], flat: Index
) -> None:
    """Add normals: of vertices where bones bend them or nothing has an edge, else of corners.

    Parameters
    ----------
    made : Prim
        They are put there.
    part, mesh
        The mesh is at rest.
    proper : (f,) bool
        Triangles that are written.
    flat : (k,) int
        Corners of these, in the order of the file.
    """
    if part.skin is not None:
        vectors, interpolation = mesh.vertex_normals(), "vertex"
    else:
        known = (part.normals or corner_normals(mesh)).of_faces(proper)
        vectors, interpolation = known.vectors, "vertex"
        whole = len(vectors) == len(mesh.vertices)
        if not whole or not np.array_equal(known.corners, mesh.faces[proper]):
            vectors, interpolation = vectors[known.corners.ravel()[flat]], "faceVarying"
    rows = tuples(_unit(vectors), DIRECTIONS)
    made.put("normal3f[] normals", _interpolated(rows, interpolation))


def _unit(vectors: Floats) -> Array:
    """Return unit vectors; some one where there is none."""
    rows = vectors.astype(np.float64)
    length = np.linalg.norm(rows, axis=1, keepdims=True)
    return np.where(length > 0, rows / np.where(length > 0, length, 1.0), (0.0, 1.0, 0.0)) + 0.0


def _put_colors(made: Prim, part: Solid | Surface) -> None:
    """Add colours of vertices, or that of the whole for programs that show no materials."""
    colors = None if part.texture is not None else part.mesh.colors_over(part.color or WHITE)
    if colors is None:
        if part.color is not None and part.texture is None:
            made.put("color3f[] primvars:displayColor", f"[{linear(part.color)}]")
        return
    light = tuples(srgb_to_linear(colors[:, :3]), DIRECTIONS)
    made.put("color3f[] primvars:displayColor", _interpolated(light, "vertex"))
    if (colors[:, 3] < 255).any():
        shares = numbers(colors[:, 3] / 255.0, DIRECTIONS)
        made.put("float[] primvars:displayOpacity", _interpolated(shares, "vertex"))


def _interpolated(value: str, interpolation: str) -> str:
    return f'{value} (\n        interpolation = "{interpolation}"\n    )'
