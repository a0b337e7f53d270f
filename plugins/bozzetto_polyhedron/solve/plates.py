"""Faces of folded sheet as thin plates that meet others."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from manifold3d import CrossSection, FillRule

from bozzetto.arrays import Array
from bozzetto.geometry import Mesh
from bozzetto_polyhedron.mechanism.assembly import square_to
from bozzetto_polyhedron.mechanism.convex_parts import Polytope, convex_parts
from bozzetto_polyhedron.reconstruction.answer import Rings

THIN: Final = 5e-5
"""Thickness of plates without any of their own, by the extent of all of them."""


def plate_parts(
    vertices: Array, faces: Sequence[Rings], thickness: float
) -> tuple[tuple[Polytope, ...], tuple[int, ...]]:
    """Return convex parts of plates in the middle of which faces lie, and the face of each part.

    Parameters
    ----------
    vertices : (n, 3) float64
        mm.
    faces : sequence of Rings
        Numbers of vertices.
    thickness : float
        mm; 0 for as thin as it may be.
    """
    thick = thickness or THIN * float(np.linalg.norm(np.ptp(vertices, axis=0)))
    parts: list[Polytope] = []
    numbers: list[int] = []
    for number, rings in enumerate(faces):
        ring = vertices[list(rings[0])]
        area = np.cross(ring - ring[0], np.roll(ring, -1, axis=0) - ring[0]).sum(axis=0)
        normal = area / max(float(np.linalg.norm(area)), 1e-300)
        axes = np.stack((*square_to(normal), normal))
        flat = [(vertices[list(each)] - ring[0]) @ axes[:2].T for each in rings]
        plate = CrossSection(flat, FillRule.EvenOdd).extrude(thick)
        if plate.is_empty():
            continue
        made = plate.to_mesh()
        corners = np.asarray(made.vert_properties, float)[:, :3] - [0.0, 0.0, 0.5 * thick]
        found = convex_parts(Mesh(corners @ axes + ring[0], np.asarray(made.tri_verts)))
        parts += found
        numbers += [number] * len(found)
    return tuple(parts), tuple(numbers)
