"""The triangles of a body by the parts that they came from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from bozzetto.arrays import Faces
from bozzetto.geometry import FaceGroup, Solid, Texture
from bozzetto_silhouette.model.state import Node, SilhouetteState
from bozzetto_silhouette.solids.body import Body


def with_groups(state: SilhouetteState, body: Body, solid: Solid) -> Solid:
    """Return a solid of a body with a group of triangles for each part that adds to it.

    The walls of what is carved belong to the part that they lie in: the nearest of the others.
    A body of a single part stays as it is.
    """
    owners = _owners(state, body)
    corners = owners[body.faces]
    face_owners = np.where(corners[:, 1] == corners[:, 2], corners[:, 1], corners[:, 0])
    if len(np.unique(face_owners)) < 2:
        return solid
    order = np.argsort(face_owners, kind="stable")
    names = {part.id: part.name for part in state.parts}
    numbers, counts = np.unique(face_owners, return_counts=True)
    groups = tuple(
        FaceGroup(names.get(body.sources[number], solid.name), count)
        for number, count in zip(numbers.tolist(), counts.tolist(), strict=True)
    )
    texture = solid.texture
    if texture is not None:
        texture = Texture(texture.pixels, texture.corners[order])
    mesh = replace(solid.mesh, faces=solid.mesh.faces[order])
    return replace(solid, mesh=mesh, texture=texture, groups=groups)


def _owners(state: SilhouetteState, body: Body) -> Faces:
    """Return for every vertex the number in `sources` of a part that adds to the body, (v,)."""
    by_id = {node.id: node for node in state.nodes}
    own = np.array([not _is_carved(by_id.get(source), by_id) for source in body.sources])
    known = own[body.origins]
    if known.all() or not known.any():
        return body.origins
    from scipy.spatial import cKDTree

    owners = body.origins.copy()
    _, nearest = cKDTree(body.vertices[known]).query(body.vertices[~known])
    owners[~known] = body.origins[known][nearest]
    return owners


def _is_carved(node: Node | None, by_id: Mapping[str, Node]) -> bool:
    """Whether a node, or a group around it, is taken away from the others."""
    while node is not None:
        if node.operation == "carve":
            return True
        node = by_id.get(node.within)
    return False
