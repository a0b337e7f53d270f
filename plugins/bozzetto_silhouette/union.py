"""Several solids as one, for programs that want a single body."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bozzetto.geometry import Mesh

__all__ = ["united"]


def united(meshes: Sequence[Mesh]) -> Mesh:
    """The boundary of everything inside at least one of the closed meshes.

    A single mesh is returned as it is. Vertex normals are dropped where meshes are cut.
    """
    if len(meshes) == 1:
        return meshes[0]
    from manifold3d import Manifold, OpType
    from manifold3d import Mesh as ManifoldMesh

    bodies = [
        Manifold(ManifoldMesh(np.array(mesh.vertices), np.array(mesh.faces, np.uint32)))
        for mesh in meshes
    ]
    whole = Manifold.batch_boolean(bodies, OpType.Add).to_mesh()
    return Mesh(np.asarray(whole.vert_properties)[:, :3], np.asarray(whole.tri_verts))
