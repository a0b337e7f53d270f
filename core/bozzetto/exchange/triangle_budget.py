"""Meshes of shapes with no more triangles than a person allows, all together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Index
from bozzetto.geometry.decimation import decimated
from bozzetto.geometry.mesh import Mesh
from bozzetto.geometry.rig import Skin
from bozzetto.geometry.shapes import Shapes, Solid, Surface
from bozzetto.geometry.texture_charts import charts, on_fewer

LEAST: Final = 12
"""Triangles that each part keeps where it has as many: a box has so many."""


def triangle_count(shapes: Shapes) -> int:
    """Return how many triangles the meshes of shapes have."""
    return sum(len(part.mesh.faces) for part in shapes.meshes())


def within_budget(shapes: Shapes, triangles: int) -> Shapes:
    """Return shapes whose meshes have at most so many triangles, as far as they hold together.

    Each part gets its share of them. Colours and bones stay with their vertices, and pictures
    where they are: the seams of a picture are kept as edges are. A picture goes where its seams
    leave more triangles than are allowed.

    Parameters
    ----------
    shapes : Shapes
        Without exact surfaces; see `bozzetto.geometry.meshed`.
    triangles : int
        The most, of all parts together.
    """
    parts = list(shapes.meshes())
    counts = [len(part.mesh.faces) for part in parts]
    if sum(counts) <= triangles:
        return shapes
    shares = _shares(counts, triangles)
    fewer = [
        part if share >= count else _with_fewer(part, share)
        for part, count, share in zip(parts, counts, shares, strict=True)
    ]
    return replace(
        shapes,
        solids=tuple(part for part in fewer if isinstance(part, Solid)),
        surfaces=tuple(part for part in fewer if isinstance(part, Surface)),
    )


def _shares(counts: Sequence[int], triangles: int) -> list[int]:
    """Return how many triangles each part may have: its share, but not less than `LEAST`."""
    size = np.array(counts, float)
    floor = np.minimum(size, LEAST)
    spare = max(0.0, triangles - float(floor.sum()))
    above = size - floor
    part = min(1.0, spare / max(1.0, float(above.sum())))
    return [int(share) for share in np.floor(floor + above * part)]


def _with_fewer(part: Solid | Surface, triangles: int) -> Solid | Surface:
    mesh, texture = part.mesh, part.texture
    groups = np.repeat(np.arange(len(part.groups)), [group.count for group in part.groups])
    if not part.groups:
        groups = np.zeros(len(mesh.faces), np.intp)
    chart = np.zeros(len(groups), np.intp) if texture is None else charts(mesh, texture)
    many = int(chart.max(initial=0)) + 1
    made = decimated(mesh, triangles, groups * many + chart)
    if texture is not None and len(made.faces) > triangles:
        texture, many = None, 1  # so many seams leave no room
        made = decimated(mesh, triangles, groups)
    kept = made.vertices
    counts = np.bincount(made.groups // many, minlength=len(part.groups))
    named = tuple(
        replace(group, count=int(count)) for group, count in zip(part.groups, counts, strict=False)
    )
    fewer = _some(mesh, kept, made.faces)
    if texture is not None:
        corners = kept[made.faces]
        texture = on_fewer(mesh, texture, chart, corners, made.groups % many)
    skin = part.skin
    if skin is not None:
        rest = None if skin.rest is None else _some(skin.rest, kept, made.faces)
        skin = Skin(skin.rig, skin.joints[kept], skin.weights[kept], rest, skin.clips)
    return replace(
        part, mesh=fewer, groups=named, skin=skin, texture=texture, exact=None, normals=None,
        polygons=None,
    )  # fmt: skip


def _some(mesh: Mesh, kept: Index, faces: NDArray[np.int32]) -> Mesh:
    """Return a mesh of some vertices of another; it is shaded anew."""
    colors = None if mesh.colors is None else mesh.colors[kept]
    cover = None if mesh.cover is None else mesh.cover[kept]
    return Mesh(mesh.vertices[kept], faces, None, colors, cover)
