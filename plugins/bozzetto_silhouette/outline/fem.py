"""Linear finite elements on a plan: what Laplace's operator is on its triangles."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from bozzetto.arrays import Array
from bozzetto_silhouette.outline.domain_mesh import Plan

if TYPE_CHECKING:
    from scipy.sparse import csc_array


SLIVER = 1e-14
"""Twice the area (in squares of the size) below which a triangle counts as having that area."""


LOOSE = 1e-12
"""Diagonal of a point that is tied to nothing."""


@dataclass(frozen=True, eq=False)
class Elements:
    """Stiffness and mass of a plan's triangles.

    Attributes
    ----------
    local : (t, 3, 3) float array
        Stiffness of each triangle: the integral of the products of the gradients.
    mass : (n,) float array
        Lumped: a third of the area of the triangles around each point.
    """

    plan: Plan
    local: Array = field(repr=False)
    mass: Array = field(repr=False)

    @classmethod
    def of(cls, plan: Plan) -> Elements:
        """Integrate over a plan's triangles."""
        corner = plan.points[plan.triangles]
        opposite = np.roll(corner, -2, axis=1) - np.roll(corner, -1, axis=1)
        e1, e2 = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
        twice = np.maximum(e1[:, 0] * e2[:, 1] - e1[:, 1] * e2[:, 0], SLIVER)
        local = opposite @ opposite.transpose(0, 2, 1) / (2.0 * twice)[:, None, None]
        corners, shares = plan.triangles.ravel(), np.repeat(twice / 6.0, 3)
        mass: Array = np.bincount(corners, shares, len(plan.points)).astype(np.float64)
        return cls(plan, local, mass)

    def stiffness(self, weight: Array | None = None) -> csc_array[Any]:
        """Assemble the matrix (n, n), each triangle multiplied by its weight (t,)."""
        from scipy.sparse import coo_array

        t, count = self.plan.triangles, len(self.plan.points)
        local = self.local if weight is None else self.local * weight[:, None, None]
        rows, columns = np.repeat(t, 3, axis=1).ravel(), np.tile(t, (1, 3)).ravel()
        matrix = coo_array((local.ravel(), (rows, columns)), shape=(count, count)).tocsc()
        return matrix


def factorised(matrix: csc_array[Any]) -> Any:
    """Factorise a symmetric positive definite matrix; the result has ``solve``.

    Rows of points that no triangle uses (degenerate ink) do not make it singular.
    """
    from scipy.sparse.linalg import splu

    matrix.setdiag(np.maximum(matrix.diagonal(), LOOSE))
    return splu(
        matrix,
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )
