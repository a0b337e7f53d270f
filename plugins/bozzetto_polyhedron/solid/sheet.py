"""Sheets with a thickness: faces become plates that print (the paper, Figure 3b)."""

from __future__ import annotations

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.geometry import Color, Mesh, Solid
from bozzetto_polyhedron.solid.face_rings import flat_rings, tangents
from bozzetto_polyhedron.solid.planar_body import PlanarBody


def sheet_solid(
    body: PlanarBody, thickness: float, name: str = "sheet", color: Color | None = None
) -> Solid:
    """Return a watertight solid of plates, one a face, half the thickness to either side.

    Each face is widened by half the thickness, with pointed corners, so that plates that meet at
    an edge overlap there.

    Parameters
    ----------
    body : PlanarBody
        A sheet or a solid, of which the walls are taken.
    thickness : float
        mm.
    name : str
        What it is called.
    color : (r, g, b), optional
        sRGB.

    Raises
    ------
    UserError
        If the thickness is none, or the faces cross.
    """
    import manifold3d

    size = float(np.linalg.norm(np.ptp(body.vertices, axis=0)))
    if not (np.isfinite(thickness) and 0 < thickness < size):
        raise UserError("A sheet needs a thickness above zero, and less than its size.")
    plates = []
    for face, normal in zip(body.faces, body.normals, strict=True):
        outline = manifold3d.CrossSection(
            [np.array(ring) for ring in flat_rings(body.vertices, face, normal)],
            manifold3d.FillRule.EvenOdd,
        )
        widened = outline.offset(thickness / 2, manifold3d.JoinType.Miter, 2.0)
        plates.append(
            widened.extrude(thickness).transform(_stood(body, face[0][0], normal, thickness))
        )
    whole = manifold3d.Manifold.batch_boolean(plates, manifold3d.OpType.Add)
    if whole.status() != manifold3d.Error.NoError or whole.is_empty():
        raise UserError("No solid comes of these faces. Choose another answer.")
    mesh = whole.to_mesh()
    return Solid(
        Mesh(
            np.ascontiguousarray(mesh.vert_properties[:, :3], np.float32),
            np.asarray(mesh.tri_verts).astype(np.int32),
        ),
        name,
        color,
    )


def _stood(body: PlanarBody, corner: int, normal: Array, thickness: float) -> Array:
    """Return the motion that takes a plate laid flat to its face, (3, 4)."""
    across, up = tangents(normal)
    origin = body.vertices[corner] - normal * thickness / 2
    return np.column_stack((across, up, normal, origin))
