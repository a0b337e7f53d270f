"""The places of patches that are nearest to points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto.geometry import BSplineSurface

GRID: Final = 13
"""Places along each parameter of a surface from which the nearest one is sought."""

NEAREST: Final = 4
"""Seeds of each point from which the nearest place is sought."""

ROUNDS: Final = 25
"""Most steps to the nearest place."""

STILL: Final = 1e-13
"""Change of parameters at which a place is found."""


@dataclass(frozen=True, eq=False)
class Feet:
    """The places of patches nearest to points.

    Parameters
    ----------
    patches : (n,) int
        Numbers of the patches.
    parameters : (n, 2) float
        u and v.
    places : (n, 3) float
        mm.
    """

    patches: Index
    parameters: Array
    places: Array


def grid_parameters() -> tuple[Array, Array]:
    """Return u and v of the grid from which the nearest places are sought, (n,) each."""
    at = (np.arange(GRID) + 0.5) / GRID
    u, v = (grid.ravel() for grid in np.meshgrid(at, at, indexing="ij"))
    return u, v


def feet_on(patches: Sequence[BSplineSurface], points: Array, nearest: int = NEAREST) -> Feet:
    """Return the places of patches over 0 … 1 that are nearest to points, (n, 3).

    It is sought from so many of the nearest places of a grid.
    """
    from scipy.spatial import cKDTree

    u, v = grid_parameters()
    starts = np.column_stack((u, v))
    seeds = np.concatenate([patch.value(u, v) for patch in patches])
    near = np.asarray(cKDTree(seeds).query(points, k=nearest)[1], int)
    best = np.full(len(points), np.inf)
    made = Feet(np.zeros(len(points), int), np.zeros((len(points), 2)), np.zeros((len(points), 3)))
    for column in near.reshape(len(points), -1).T:
        for number in np.unique(column // len(u)).tolist():
            rows = np.flatnonzero(column // len(u) == number)
            foot = foot_of(patches[number], points[rows], starts[column[rows] % len(u)])
            places = patches[number].value(*foot.T)
            gaps = np.linalg.norm(places - points[rows], axis=1)
            nearer = gaps < best[rows]
            own = rows[nearer]
            best[own], made.patches[own] = gaps[nearer], number
            made.parameters[own], made.places[own] = foot[nearer], places[nearer]
    return made


def foot_of(surface: BSplineSurface, points: Array, start: Array) -> Array:
    """Return parameters of the nearest places, from given ones on, by Gauss-Newton steps."""
    at = np.array(start, float)
    low, high = np.transpose(surface.ranges)
    going = np.arange(len(at))
    for _ in range(ROUNDS):
        here = at[going]
        off = points[going] - surface.value(*here.T)
        x, y = (surface.derivative(here[:, 0], here[:, 1], i, 1 - i) for i in (1, 0))
        xx, xy, yy = ((a * b).sum(axis=1) for a, b in ((x, x), (x, y), (y, y)))
        px, py = (off * x).sum(axis=1), (off * y).sum(axis=1)
        whole = np.maximum(xx * yy - xy * xy, 1e-12 * xx * yy + 1e-300)
        step = np.column_stack(((px * yy - py * xy) / whole, (xx * py - xy * px) / whole))
        at[going] = np.clip(here + np.clip(step, -0.25, 0.25), low, high)
        going = going[np.abs(at[going] - here).max(axis=1) > STILL]
        if not len(going):
            break
    return at
