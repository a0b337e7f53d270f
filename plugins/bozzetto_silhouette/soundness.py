"""Whether the mesh is a solid, and the one that was drawn."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from bozzetto_silhouette.outline import Outline

if TYPE_CHECKING:
    from manifold3d import Manifold

__all__ = ["Soundness", "as_manifold", "soundness_of"]


@dataclass(frozen=True)
class Soundness:
    """What was found and what was expected.

    Attributes
    ----------
    status : str
        manifold3d's verdict, ``"NoError"`` when the mesh is a manifold.
    volume : float
        In cubed outline units; negative means inside out.
    genus, expected_genus : int
        Handles of the solid and holes of the drawing.
    components, expected_components : int
        Bodies of the solid and outer rings of the drawing.
    """

    status: str
    volume: float
    genus: int
    expected_genus: int
    components: int
    expected_components: int

    @property
    def watertight(self) -> bool:
        """Whether the mesh bounds a solid."""
        return self.status == "NoError"

    @property
    def ok(self) -> bool:
        """Whether the solid is sound and has the topology of the drawing."""
        return (
            self.watertight
            and self.volume > 0.0
            and self.genus == self.expected_genus
            and self.components == self.expected_components
        )


def as_manifold(vertices: NDArray[np.float64], faces: NDArray[np.int32]) -> Manifold:
    """The mesh as manifold3d sees it, in double precision."""
    import manifold3d

    mesh = manifold3d.Mesh64(
        np.ascontiguousarray(vertices, dtype=np.float64),
        np.ascontiguousarray(faces, dtype=np.uint64),
    )
    return manifold3d.Manifold(mesh)


def soundness_of(
    vertices: NDArray[np.float64], faces: NDArray[np.int32], outline: Outline
) -> Soundness:
    """Check a mesh (v, 3), (f, 3) against the outline it was made from."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    solid = as_manifold(vertices, faces)
    # Two edges join the three corners of a face.
    a, b = faces[:, [0, 1, 1, 2]].reshape(-1, 2).T
    links = coo_array((np.ones(len(a), dtype=np.int32), (a, b)), shape=(len(vertices),) * 2)
    components, _ = connected_components(links, directed=False)
    # manifold3d counts the handles of several bodies as if they were one.
    genus = solid.genus() + components - 1
    return Soundness(
        solid.status().name,
        float(solid.volume()),
        int(genus),
        outline.genus,
        int(components),
        outline.components,
    )
