"""Linear finite elements on a plan: what Laplace's operator is on its triangles."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto_silhouette.outline.domain_mesh import Plan

if TYPE_CHECKING:
    from scipy.sparse import csc_array


SLIVER = 1e-14
"""Twice the area (in squares of the size) below which a triangle counts as having that area."""


LOOSE = 1e-12
"""Diagonal of a point that is tied to nothing."""


BANDED = 2e8
"""Points times the square of the width of the band up to which a band has the quicker factors."""


PANEL = 4
"""Columns that sparse factors take at a time: limbs have few alike."""


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
        # By coordinates: products of pairs take twice as long.
        x, y = (column[plan.triangles] for column in plan.points.T)
        x, y = x[:, [2, 0, 1]] - x[:, [1, 2, 0]], y[:, [2, 0, 1]] - y[:, [1, 2, 0]]
        twice = np.maximum(x[:, 0] * y[:, 1] - x[:, 1] * y[:, 0], SLIVER)
        local = x[:, :, None] * x[:, None, :] + y[:, :, None] * y[:, None, :]
        local /= (2.0 * twice)[:, None, None]
        corners, shares = plan.triangles.ravel(), np.repeat(twice / 6.0, 3)
        mass: Array = np.bincount(corners, shares, len(plan.points)).astype(np.float64)
        return cls(plan, local, mass)

    def stiffness(self, weight: Array | None = None, first: int = 0) -> csc_array[Any]:
        """Assemble the matrix (n, n), each triangle multiplied by its weight (t,).

        Only the rows and columns from `first` on: (n - first, n - first).
        """
        from scipy.sparse import coo_array

        t, count = self.plan.triangles - first, len(self.plan.points) - first
        local = self.local if weight is None else self.local * weight[:, None, None]
        rows, columns, shares = (
            np.repeat(t, 3, axis=1).ravel(),
            np.tile(t, (1, 3)).ravel(),
            local.ravel(),
        )
        if first:
            inner = (rows >= 0) & (columns >= 0)
            rows, columns, shares = rows[inner], columns[inner], shares[inner]
        matrix = coo_array((shares, (rows, columns)), shape=(count, count)).tocsc()
        return matrix


class Factors(Protocol):
    """A matrix in factors."""

    def solve(self, right: Array) -> Array:
        """Return x (n,) with ``A x = right``."""
        ...


@dataclass(frozen=True, eq=False)
class _BandFactors:
    """Cholesky's factor of a matrix whose rows were put in another order.

    Attributes
    ----------
    band : (w, n) float array
        Diagonals of the factor, from the main one downwards.
    order : (n,) int array
        The row of the matrix at each place.
    """

    band: Array = field(repr=False)
    order: Index = field(repr=False)

    def solve(self, right: Array) -> Array:
        from scipy.linalg import cho_solve_banded

        result = np.empty(len(right))
        result[self.order] = cho_solve_banded(
            (self.band, True), right[self.order], overwrite_b=True, check_finite=False
        )
        return result


def factorised(matrix: csc_array[Any]) -> Factors:
    """Factorise a symmetric positive definite matrix (n, n).

    Notes
    -----
    In the order of Cuthill and McKee (1969), reversed, the matrix of a plan is a narrow band, for
    which Cholesky's factors take half the time of sparse ones. Wide plans of many points have
    sparse factors. Rows of points that no triangle uses (degenerate ink) make neither singular.
    """
    from scipy.linalg import LinAlgError, cholesky_banded
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import reverse_cuthill_mckee

    matrix.sum_duplicates()
    count = matrix.shape[0]
    columns = np.repeat(np.arange(count), np.diff(matrix.indptr))
    # The matrix is symmetric: its columns are its rows.
    rows = csr_array((matrix.data, matrix.indices, matrix.indptr), shape=matrix.shape)
    order = reverse_cuthill_mckee(rows, symmetric_mode=True).astype(np.intp)
    place = np.empty(count, np.intp)
    place[order] = np.arange(count)
    row, column = place[matrix.indices], place[columns]
    below = row >= column
    row, column = row[below], column[below]
    width = int((row - column).max(initial=0)) + 1
    if count * width**2 <= BANDED:
        band = np.zeros((width, count))
        band[row - column, column] = matrix.data[below]
        np.maximum(band[0], LOOSE, out=band[0])
        try:
            lower = cholesky_banded(band, overwrite_ab=True, lower=True, check_finite=False)
        except LinAlgError:
            pass  # rounding of slivers: pivots do not stop the sparse factors
        else:
            return _BandFactors(lower, order)
    return _sparse_factors(matrix)


def _sparse_factors(matrix: csc_array[Any]) -> Factors:
    from scipy.sparse.linalg import splu

    matrix.setdiag(np.maximum(matrix.diagonal(), LOOSE))
    factors: Factors = splu(
        matrix,
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
        panel_size=PANEL,
    )
    return factors
