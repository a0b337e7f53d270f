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

LEAST: Final = 12
"""Triangles that each part keeps where it has as many: a box has so many."""


def triangle_count(shapes: Shapes) -> int:
    """Return how many triangles the meshes of shapes have."""
    return sum(len(part.mesh.faces) for part in shapes.meshes())


def within_budget(shapes: Shapes, triangles: int) -> Shapes:
    """Return shapes whose meshes have at most so many triangles, as far as they hold together.

    Each part gets its share of them. Colours and bones stay with their vertices; pictures on
    parts that lose triangles go, for they belong to the triangles.

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
    mesh = part.mesh
    groups = np.repeat(np.arange(len(part.groups)), [group.count for group in part.groups])
    made = decimated(mesh, triangles, groups if part.groups else None)
    kept = made.vertices
    counts = np.bincount(made.groups, minlength=len(part.groups))
    named = tuple(
        replace(group, count=int(count)) for group, count in zip(part.groups, counts, strict=False)
    )
    fewer = _some(mesh, kept, made.faces)
    if isinstance(part, Surface):
        return replace(part, mesh=fewer, groups=named, exact=None)
    skin = part.skin
    if skin is not None:
        rest = None if skin.rest is None else _some(skin.rest, kept, made.faces)
        skin = Skin(skin.rig, skin.joints[kept], skin.weights[kept], rest)
    return replace(part, mesh=fewer, groups=named, skin=skin, texture=None, exact=None)


def _some(mesh: Mesh, kept: Index, faces: NDArray[np.int32]) -> Mesh:
    """Return a mesh of some vertices of another; it is shaded anew."""
    colors = None if mesh.colors is None else mesh.colors[kept]
    cover = None if mesh.cover is None else mesh.cover[kept]
    return Mesh(mesh.vertices[kept], faces, None, colors, cover)
