"""Groups of meshes as parts of their own, for programs in which a part is picked as an object."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Index
from bozzetto.exchange.mesh.creases import divided
from bozzetto.exchange.mesh.manifold_check import bounds_volume
from bozzetto.geometry.corner_normals import CornerNormals
from bozzetto.geometry.mesh import Mesh
from bozzetto.geometry.rig import Skin
from bozzetto.geometry.shapes import FaceGroup, Shapes, Solid, Surface
from bozzetto.geometry.texture import Texture


def separate_parts(levels: Sequence[Shapes]) -> list[Shapes]:
    """Return shapes with a part for each name of a group, in what the group was a part of.

    Shading stays smooth where parts meet. A part that bounds no volume by itself is a surface.

    Parameters
    ----------
    levels : sequence of Shapes
        The same parts, with fewer and fewer triangles; so are those that come back. Where a
        coarser one has lost a group, the group is as the finest has it.
    """
    rows = [[_pieces(part) for part in shapes.meshes()] for shapes in levels]
    found = []
    for shapes, row in zip(levels, rows, strict=True):
        parts = [
            pieces.get(name, finest)
            for pieces, first in zip(row, rows[0], strict=True)
            for name, finest in first.items()
        ]
        found.append(
            replace(
                shapes,
                solids=tuple(part for part in parts if isinstance(part, Solid)),
                surfaces=tuple(part for part in parts if isinstance(part, Surface)),
            )
        )
    return found


def _pieces(part: Solid | Surface) -> dict[str, Solid | Surface]:
    """Return the pieces of a part by their names; itself where it has no groups of several."""
    names = np.array([group.name for group in part.groups])
    told = [name for name in dict.fromkeys(names.tolist()) if _count(part, name)]
    if len(told) < 2:
        return {"": part}
    mesh, skin = part.mesh, part.skin
    normals = part.normals
    if normals is None and mesh.normals is None and part.texture is None and skin is None:
        vertex, faces = divided(mesh)
        split = Mesh(mesh.vertices[vertex], faces.astype(np.int32))
        normals = CornerNormals(split.vertex_normals(), faces.astype(np.int32))
    else:
        mesh = replace(mesh, normals=mesh.vertex_normals())
    if skin is not None and skin.rest is not None:
        skin = replace(skin, rest=replace(skin.rest, normals=skin.rest.vertex_normals()))
    whole = replace(part, mesh=mesh, normals=normals, skin=skin, exact=None)
    counts = [group.count for group in part.groups]
    of_row = np.repeat(np.arange(len(counts)), counts)
    found: dict[str, Solid | Surface] = {}
    for name in told:
        rows = np.flatnonzero(names == name)
        groups = tuple(part.groups[row] for row in rows.tolist() if part.groups[row].count)
        found[name] = _piece(whole, np.flatnonzero(np.isin(of_row, rows)), name, groups)
    return found


def _count(part: Solid | Surface, name: str) -> int:
    return sum(group.count for group in part.groups if group.name == name)


def _piece(
    part: Solid | Surface, triangles: Index, name: str, groups: tuple[FaceGroup, ...]
) -> Solid | Surface:
    """Return some of the triangles of a part."""
    used, faces = np.unique(part.mesh.faces[triangles], return_inverse=True)
    kept = used.astype(np.intp)
    corners = faces.reshape(-1, 3).astype(np.int32)
    mesh = _some(part.mesh, kept, corners)
    skin, texture, normals = part.skin, part.texture, part.normals
    if skin is not None:
        rest = None if skin.rest is None else _some(skin.rest, kept, corners)
        skin = Skin(skin.rig, skin.joints[kept], skin.weights[kept], rest, skin.clips)
    kind = Solid if isinstance(part, Solid) and bounds_volume(mesh) else Surface
    return kind(
        mesh,
        name,
        part.color,
        texture=None if texture is None else Texture(texture.pixels, texture.corners[triangles]),
        skin=skin,
        groups=groups,
        path=(*part.path, part.name),
        normals=None
        if normals is None
        else CornerNormals(normals.vectors, normals.corners[triangles]),
    )


def _some(mesh: Mesh, kept: Index, faces: NDArray[np.int32]) -> Mesh:
    """Return the triangles of a mesh over some of its vertices."""
    return Mesh(
        mesh.vertices[kept],
        faces,
        None if mesh.normals is None else mesh.normals[kept],
        None if mesh.colors is None else mesh.colors[kept],
        None if mesh.cover is None else mesh.cover[kept],
    )
