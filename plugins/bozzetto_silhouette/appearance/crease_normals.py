"""Sharp edges on the screen: every face at a crease gets the normal of its own side."""

from __future__ import annotations

import numpy as np

from bozzetto.geometry import Mesh
from bozzetto_silhouette.numerics.isotropic_remeshing import unit
from bozzetto_silhouette.solids.body import Body

__all__ = ["creased"]

_INTO = 0.3
"""Where a side's normal is looked up: so far from the crease to the middle of the face."""


def creased(body: Body) -> Mesh:
    """The mesh of a body for the screen, with a vertex for every face at its creases."""
    on_crease = np.zeros(len(body.vertices), dtype=bool)
    on_crease[body.creases] = True
    face, corner = np.nonzero(on_crease[body.faces])
    copied = body.faces[face, corner]
    middle = body.vertices[body.faces[face]].mean(axis=1)
    at = body.vertices[copied] + _INTO * (middle - body.vertices[copied])
    inwards = body.implicit.sample(at).gradient if len(at) else np.zeros((0, 3))
    faces = body.faces.copy()
    faces[face, corner] = len(body.vertices) + np.arange(len(copied))
    return Mesh(
        np.vstack([body.vertices, body.vertices[copied]]).astype(np.float32),
        faces,
        np.vstack([body.normals, -unit(inwards)]).astype(np.float32),
    )
