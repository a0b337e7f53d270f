"""Sheets with a thickness: faces become plates that print (the paper, Figure 3b)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.geometry import Color, Mesh, Solid
from bozzetto_polyhedron.graph.planar_embedding import Ring
from bozzetto_polyhedron.reconstruction.answer import Rings
from bozzetto_polyhedron.solid.face_rings import flat_rings, sides_of, tangents
from bozzetto_polyhedron.solid.planar_body import PlanarBody

BEYOND: Final = 0.501
"""Width, in thicknesses, of what is cut off a plate beyond a side on the rim: a little more than
it was widened by."""

EVEN: Final = 1e-6
"""Length, in sizes, below which corners where plates meet are one: files keep no more digits."""


def sheet_solid(
    body: PlanarBody, thickness: float, name: str = "sheet", color: Color | None = None
) -> Solid:
    """Return a watertight solid of plates, one a face, half the thickness to either side.

    Each face is widened by half the thickness, with pointed corners, so that plates that meet at
    an edge overlap there. A side that no other face shares is the rim: there the plate ends.

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
    rim = _rim(body.faces)
    plates = []
    for face, normal in zip(body.faces, body.normals, strict=True):
        rings = flat_rings(body.vertices, face, normal)
        outline = manifold3d.CrossSection(rings, manifold3d.FillRule.EvenOdd)
        widened = outline.offset(thickness / 2, manifold3d.JoinType.Miter, 2.0)
        strips = [
            strip
            for ring, corners in zip(face, rings, strict=True)
            for strip in _beyond_rim(ring, corners, rim, thickness)
        ]
        if strips:
            widened -= manifold3d.CrossSection(strips, manifold3d.FillRule.NonZero)
            widened += outline
        plates.append(
            widened.extrude(thickness).transform(_stood(body, face[0][0], normal, thickness))
        )
    whole = manifold3d.Manifold.batch_boolean(plates, manifold3d.OpType.Add)
    whole = whole.simplify(EVEN * size)
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


def _rim(faces: Sequence[Rings]) -> frozenset[frozenset[int]]:
    """Return the edges that one face alone has."""
    uses = Counter(frozenset(side) for face in faces for ring in face for side in sides_of(ring))
    return frozenset(edge for edge, count in uses.items() if count == 1)


def _beyond_rim(
    ring: Ring, corners: Array, rim: frozenset[frozenset[int]], thickness: float
) -> list[Array]:
    """Return where a plate would stand out over its sides on the rim, each (4, 2).

    At corners that stand out the strips go on as far as pointed corners may reach.
    """
    sides = np.roll(corners, -1, axis=0) - corners
    along = sides / np.linalg.norm(sides, axis=1, keepdims=True)
    before = np.roll(along, 1, axis=0)
    stands_out = before[:, 0] * along[:, 1] - before[:, 1] * along[:, 0] > 0.0
    reach = np.where(stands_out, thickness, 0.0)
    strips = []
    for number, side in enumerate(sides_of(ring)):
        if frozenset(side) not in rim:
            continue
        x, y = along[number]
        out = np.array((y, -x)) * thickness * BEYOND
        after = (number + 1) % len(ring)
        first = corners[number] - reach[number] * along[number]
        last = corners[after] + reach[after] * along[number]
        strips.append(np.stack((first, first + out, last + out, last)))
    return strips


def _stood(body: PlanarBody, corner: int, normal: Array, thickness: float) -> Array:
    """Return the motion that takes a plate laid flat to its face, (3, 4)."""
    across, up = tangents(normal)
    origin = body.vertices[corner] - normal * thickness / 2
    return np.column_stack((across, up, normal, origin))
