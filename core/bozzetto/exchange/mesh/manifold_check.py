"""Checks that a mesh bounds a volume, before anybody prints it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.errors import UserError
from bozzetto.geometry.mesh import Mesh
from bozzetto.geometry.shapes import Solid


@dataclass(frozen=True)
class SolidFacts:
    """Facts about a checked solid.

    Attributes
    ----------
    volume : float
        mm³.
    genus : int
        Handles (holes through), summed over the parts.
    parts : int
        Closed skins; a ball with a hollow inside has two.
    """

    volume: float
    genus: int
    parts: int


def _unpaired_edges(mesh: Mesh) -> int:
    """Return how many directed edges lack exactly one partner of the opposite direction."""
    forth = np.concatenate([mesh.faces[:, [k, (k + 1) % 3]] for k in range(3)]).astype(np.int64)
    count = np.int64(len(mesh.vertices))
    keys, times = np.unique(forth[:, 0] * count + forth[:, 1], return_counts=True)
    back = (keys % count) * count + keys // count
    found = np.minimum(np.searchsorted(keys, back), max(len(keys) - 1, 0))
    paired = (keys[found] == back) & (times == 1)
    return int((~paired).sum())


def enclosed_volume(mesh: Mesh) -> float:
    """Return the signed volume inside a closed mesh, mm³: positive where faces look outwards."""
    return signed_volume(mesh, mesh.vertices[0]) if len(mesh.faces) else 0.0


def signed_volume(mesh: Mesh, apex: ArrayLike) -> float:
    """Return the volume between triangles and a point, mm³: positive where they look away.

    Over meshes that close together, with one apex, these add up to what they enclose.
    """
    corners = mesh.vertices[mesh.faces].astype(np.float64) - np.asarray(apex, float)
    return float(np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6)


def bounds_volume(mesh: Mesh) -> bool:
    """Whether a mesh is closed, wound one way, and encloses a positive volume."""
    return not no_volume_because(mesh)


def no_volume_because(mesh: Mesh) -> str:
    """Return why a mesh bounds no volume, after "is" or "it is", for who made it; "" if it does."""
    if not len(mesh.faces):
        return "without triangles"
    if loose := _unpaired_edges(mesh):
        return f"not closed: {loose} of its edges are not run once in each direction"
    if (volume := enclosed_volume(mesh)) <= 0:
        return f"inside out or flat: its volume is {volume:.4g} mm³"
    return ""


def check_solid(solid: Solid) -> SolidFacts:
    """Check that a solid is one.

    Every edge must be used by exactly two triangles, once in each direction; the volume
    must be positive; and manifold3d, which slicers and booleans rely on, must accept it.

    Raises
    ------
    UserError
        Names the solid, what is wrong and what to do.
    """
    import manifold3d

    mesh = solid.mesh
    if not len(mesh.faces):
        raise UserError(f"“{solid.name}” has no surface yet. Draw it first, then export.")
    loose = _unpaired_edges(mesh)
    if loose:
        raise UserError(
            f"“{solid.name}” is not closed: {loose} edges lack a neighbour. Undo the last "
            "step on it, or export it as a surface."
        )
    volume = enclosed_volume(mesh)
    if volume <= 0:
        raise UserError(
            f"“{solid.name}” is inside out or flat (its volume is {volume:.4g} mm³). "
            "Draw its outline again, or turn it over."
        )
    made = manifold3d.Manifold(
        # Copies: the binding does not take read-only arrays.
        manifold3d.Mesh(np.array(mesh.vertices, np.float32), np.array(mesh.faces, np.uint32))
    )
    status = made.status()
    if status != manifold3d.Error.NoError:
        raise UserError(
            f"“{solid.name}” is not a valid solid ({status.name}). Undo the last step on it, "
            "or solve it again at a finer quality."
        )
    parts = made.decompose()
    return SolidFacts(volume, sum(part.genus() for part in parts), len(parts))
