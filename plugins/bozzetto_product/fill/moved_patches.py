"""Patches moved to places by the change that bends least."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto_product.fill.exact_patches import exact_patches
from bozzetto_product.fill.fair_solution import RIDGE
from bozzetto_product.fill.patch_fill import PatchFill
from bozzetto_product.fill.patch_space import PLATE, side_nodes
from bozzetto_product.fill.quintic import bernstein
from bozzetto_product.fill.side_conditions import TANGENCY

FIRM: Final = 3000.0
"""Weight of the places against the bending of the change: they are followed within a hair, and the
shake of a hand is not."""


@dataclass(frozen=True, eq=False)
class Offsets:
    """Places of a fill that are to move, and by how much.

    Parameters
    ----------
    patches : (n,) int
    parameters : (n, 2) float
        Where they are.
    ways : (n, 3) float
        Unit, along which they move.
    heights : (n,) float
        How far along it they are too far, mm.
    weights : (n,) float
    """

    patches: Index
    parameters: Array
    ways: Array
    heights: Array
    weights: Array


def moved_patches(fill: PatchFill, made: PatchFill, offsets: Offsets) -> PatchFill:
    """Return a fill changed by the bump that bends least and takes places to where they belong.

    Parameters
    ----------
    fill : PatchFill
        As it was first.
    made : PatchFill
        The same as changed so far.
    offsets : Offsets
        Of that.
    """
    from scipy.linalg import cho_factor, cho_solve

    solution = fill.solution
    space, loop = solution.space, solution.loop
    stiffness, _ = space.stiffness(PLATE)
    size = len(stiffness)
    scale = float(np.trace(stiffness)) / size
    values = np.einsum(
        "ki,kj->kij", bernstein(offsets.parameters[:, 0]), bernstein(offsets.parameters[:, 1])
    ).reshape(len(offsets.patches), 1, -1)
    basis = (values @ space.own_basis[offsets.patches])[:, 0]
    matrix = np.kron(np.eye(3), stiffness)
    held: Flags = np.isfinite(loop.normals[..., 0])
    if held.any():
        weights = np.sqrt(np.broadcast_to(side_nodes()[1], held.shape)[held])[:, None]
        normals = loop.normals[held] * weights
        rows = (normals[:, :, None] * space.across[0][held][:, None, :]).reshape(len(normals), -1)
        matrix += TANGENCY * scale * (rows.T @ rows)
    rows = (offsets.ways[:, :, None] * basis[:, None, :]).reshape(len(basis), -1)
    weighted = FIRM * scale * offsets.weights[:, None] / len(rows)
    matrix += rows.T @ (weighted * rows)
    matrix[np.diag_indices_from(matrix)] += RIDGE * scale
    so_far = space.basis.T @ (made.solution.free - solution.free)
    wanted = rows @ so_far.T.ravel() - offsets.heights / loop.size
    right = (weighted * rows).T @ wanted
    factor = cho_factor(matrix, lower=True, overwrite_a=True, check_finite=False)
    found = cho_solve(factor, right, check_finite=False).reshape(3, size).T
    changed = replace(solution, free=solution.free + space.basis @ found)
    return replace(fill, solution=changed, patches=exact_patches(changed))
