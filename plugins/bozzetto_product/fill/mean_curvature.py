"""Mean curvature of patches and how it varies."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Final

import numpy as np

from bozzetto.arrays import Array, cross_product
from bozzetto_product.fill.patch_space import PatchSpace
from bozzetto_product.fill.quintic import NODES, POINTS, WEIGHTS, bernstein

CUBIC: Final = 5
"""Sides from which on a cubic may explain how the mean curvature varies: with fewer, what is held
along the sides does not tell one."""

FOLD_GRID: Final = 9
"""Places along each direction of a patch at which folds are looked for."""

FINE_GRID: Final = 4 * FOLD_GRID - 3
"""Places at which what looks like a fold is looked at again."""


@dataclass(frozen=True, eq=False)
class Curvature:
    """A surface at its Gauss points.

    Parameters
    ----------
    factors : (n, 49, 5) float
        Of the derivatives by u, v, uu, uv, vv in the Laplace–Beltrami operator.
    areas : (n, 49) float
        That each Gauss point stands for.
    normals : (n, 49, 3) float
        Unit normals.
    mean : (n, 49) float
        Mean curvature.
    """

    factors: Array
    areas: Array
    normals: Array
    mean: Array

    @property
    def operator(self) -> Array:
        """Rows of the Laplace–Beltrami operator for control points of patches, (n, 49, 36)."""
        jets = _tables()[1]
        return np.asarray(np.matmul(self.factors[:, :, None], jets.transpose(1, 0, 2))[:, :, 0])


@cache
def _tables() -> tuple[Array, Array]:
    """Return weights (49,) and the jets (5, 49, 36) by u, v, uu, uv, vv."""
    values = [bernstein(NODES, order) for order in range(3)]
    orders = ((1, 0), (0, 1), (2, 0), (1, 1), (0, 2))
    jets = [np.einsum("ai,bj->abij", values[a], values[b]) for a, b in orders]
    return np.outer(WEIGHTS, WEIGHTS).ravel(), np.reshape(jets, (5, len(NODES) ** 2, POINTS**2))


def curvature_of(nets: Array) -> Curvature:
    """Return the curvature of the surface of control nets, (n, 6, 6, 3)."""
    weights, jets = _tables()
    points = nets.reshape(len(nets), -1, 3)
    by_u, by_v, by_uu, by_uv, by_vv = (jet @ points for jet in jets)
    first, mixed, second = (
        (a * b).sum(axis=-1) for a, b in ((by_u, by_u), (by_u, by_v), (by_v, by_v))
    )
    square = first * second - mixed**2
    square = np.maximum(square, 1e-14 * (first + second) ** 2 + 1e-30)
    a, b, c = second / square, -mixed / square, first / square
    bend = a[..., None] * by_uu + 2 * b[..., None] * by_uv + c[..., None] * by_vv
    along_u, along_v = (bend * by_u).sum(axis=-1), (bend * by_v).sum(axis=-1)
    lower_u, lower_v = a * along_u + b * along_v, b * along_u + c * along_v
    factors = np.stack((-lower_u, -lower_v, a, 2 * b, c), axis=-1)
    normals = cross_product(by_u, by_v)
    area = np.linalg.norm(normals, axis=-1)
    normals /= np.maximum(area, 1e-15)[..., None]
    mean = 0.5 * (bend * normals).sum(axis=-1)
    return Curvature(factors, area * weights, normals, mean)


def even_terms(space: PatchSpace) -> Array:
    """Return the polynomials of the domain at the Gauss points of all patches, (m, 6 or 10).

    Those that the mean curvature may be: quadratic, and cubic from `CUBIC` sides on.
    """
    u, v = (x.ravel() for x in np.meshgrid(NODES, NODES, indexing="ij"))
    s, t = np.moveaxis(space.domain.places(u, v).reshape(-1, 2), 1, 0)
    terms = [np.ones_like(s), s, t, s * s, s * t, t * t]
    if space.count >= CUBIC:
        terms += [s**3, s * s * t, s * t * t, t**3]
    return np.column_stack(terms)


def variation(curvature: Curvature, space: PatchSpace) -> float:
    """Return the root mean square of what of the mean curvature no polynomial explains.

    Per area, times the size of the loop; 0 of planes, spheres and all of constant mean curvature.
    """
    root = np.sqrt(np.maximum(curvature.areas, 1e-14)).ravel()
    height = curvature.mean.ravel() * root
    terms = even_terms(space) * root[:, None]
    rest = height - terms @ np.linalg.lstsq(terms, height, rcond=None)[0]
    return float(np.linalg.norm(rest) / np.linalg.norm(root))


def is_folded(nets: Array) -> bool:
    """Whether normals of places beside one another in a patch point to opposite sides.

    What looks like a fold is looked at again on a finer grid: it may be a bend.
    """
    return _turns_over(nets, FOLD_GRID) and _turns_over(nets, FINE_GRID)


def normals_of(nets: Array, at: Array) -> Array:
    """Return normals of patches on a grid of parameters, of any length, (n, k, k, 3)."""
    values, slopes = bernstein(at), bernstein(at, 1)
    by_u = np.einsum("ai,kijd,bj->kabd", slopes, nets, values, optimize=True)
    by_v = np.einsum("ai,kijd,bj->kabd", values, nets, slopes, optimize=True)
    return cross_product(by_u, by_v)


def _turns_over(nets: Array, count: int) -> bool:
    normals = normals_of(nets, np.linspace(0.03, 0.97, count))
    along = (normals[:, 1:] * normals[:, :-1]).sum(axis=-1).min()
    return bool(min(along, (normals[:, :, 1:] * normals[:, :, :-1]).sum(axis=-1).min()) < 0.0)
