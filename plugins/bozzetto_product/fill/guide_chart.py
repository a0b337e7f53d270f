"""The plane over which the patches of a fill lie."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto.plugin import cached_property
from bozzetto_product.fill.domain_mesh import parameters_of
from bozzetto_product.fill.feet import feet_on
from bozzetto_product.fill.fill_mesh import places_and_normals
from bozzetto_product.fill.patch_fill import PatchFill

if TYPE_CHECKING:
    import shapely
    from scipy.spatial import cKDTree

SEEDS: Final = 2
"""Places of a grid from which the nearest place of the guide is sought: it does not fold."""


@dataclass(frozen=True, eq=False)
class GuideChart:
    """The domain of a fill as a plane in mm.

    Parameters
    ----------
    guide : PatchFill
    """

    guide: PatchFill

    @cached_property
    def scale(self) -> float:
        """Length of a unit of the domain, mm."""
        quads = self.guide.solution.space.domain.quads
        after = np.roll(quads, -1, axis=1)
        area = 0.5 * float((quads[..., 0] * after[..., 1] - quads[..., 1] * after[..., 0]).sum())
        return float(np.sqrt(self.guide.area / area))

    def flat(self, patches: Index, parameters: Array) -> Array:
        """Return the places of parameters of patches, (n, 2)."""
        u, v = parameters.T
        shares = np.stack(((1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v), axis=1)
        quads = self.guide.solution.space.domain.quads[patches]
        return np.asarray(self.scale * np.einsum("nc,ncd->nd", shares, quads))

    def surface(self, flat: Array) -> tuple[Array, Array]:
        """Return places of the guide, and its unit normals, (n, 3) each."""
        patches, parameters = parameters_of(self.guide.solution.space.domain, flat / self.scale)
        places, normals = np.empty((2, len(flat), 3))
        for number in np.unique(patches).tolist():
            own = patches == number
            places[own], normals[own] = places_and_normals(
                self.guide.patches[number], parameters[own]
            )
        return places, normals

    @cached_property
    def outline(self) -> shapely.Polygon:
        """Region that the loop of the fill encloses."""
        import shapely

        domain = self.guide.solution.space.domain
        ring = np.stack((domain.corners, domain.middles), axis=1).reshape(-1, 2)
        return shapely.Polygon(self.scale * ring)

    def farthest(self, points: Array) -> float:
        """Return the distance from the guide of the point farthest from it, mm.

        It is that of the point farthest from the vertices of its mesh.
        """
        far = self._tree.query(points)[0]
        point = points[[int(np.argmax(far))]]
        foot = feet_on(self.guide.patches, point, SEEDS).places
        return float(np.linalg.norm(foot - point))

    @cached_property
    def _tree(self) -> cKDTree:
        from scipy.spatial import cKDTree

        return cKDTree(self.guide.mesh.vertices)

    def feet(self, points: Array) -> tuple[Array, Array]:
        """Return the flat places nearest to points, and unit normals of the guide there."""
        feet = feet_on(self.guide.patches, points, SEEDS)
        normals = np.empty_like(points)
        for number in np.unique(feet.patches).tolist():
            own = feet.patches == number
            normals[own] = places_and_normals(self.guide.patches[number], feet.parameters[own])[1]
        return self.flat(feet.patches, feet.parameters), normals
