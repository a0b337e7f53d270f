"""Shapes of a body for other programs: exact faces for CAD, and a closed mesh."""

from __future__ import annotations

import numpy as np

from bozzetto.geometry import Brep, Color, Mesh, Solid, Surface, plane_face, sewn
from bozzetto_polyhedron.solid.planar_body import PlanarBody
from bozzetto_polyhedron.solid.triangulation import triangles_of


def brep_of(body: PlanarBody, name: str = "body", color: Color | None = None) -> Brep:
    """Return plane faces that share straight edges, for STEP and IGES.

    Parameters
    ----------
    body : PlanarBody
        A solid or a sheet.
    name : str
        What it is called.
    color : (r, g, b), optional
        sRGB.

    Raises
    ------
    UserError
        If the rings of a face cross.
    """
    faces = [
        plane_face([body.vertices[list(ring)] for ring in face], normal=normal, name=name)
        for face, normal in zip(body.faces, body.normals, strict=True)
    ]
    return sewn(faces, name, color)


def mesh_of(body: PlanarBody) -> Mesh:
    """Return triangles over the vertices that faces use."""
    triangles, _ = triangles_of(body)
    used, numbers = np.unique(triangles, return_inverse=True)
    corners = numbers.reshape(-1, 3).astype(np.int32)
    return Mesh(body.vertices[used].astype(np.float32), corners)


def solid_of(body: PlanarBody, name: str = "body", color: Color | None = None) -> Solid | Surface:
    """Return the triangles of a body for printing; those of a sheet are a surface."""
    mesh = mesh_of(body)
    return Solid(mesh, name, color) if body.closed else Surface(mesh, name, color)
