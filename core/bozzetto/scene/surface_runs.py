"""Runs of samples on one unbroken surface, as an eye sees them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from bozzetto.arrays import Array, Flags, Index

BROKEN: Final = 5.0
"""Difference in depth per distance across the line of sight by which the step between neighbours
must differ from the slopes of the surface at both, for one to lie behind the other. (A bound on
the slope alone would break every round surface before its rim, where it is seen edge-on.)"""

EDGE_ON: Final = 1e-6
"""Least cosine between normal and line of sight at which a surface counts as seen."""


def depth_breaks(points: Array, normals: Array, sight: Array) -> Flags:
    """Return whether no surface can lead from one sample to the next.

    On one surface the step in depth lies between those on the tangent planes of both samples.

    Parameters
    ----------
    points, normals : (n, 3) float
        mm and unit vectors towards the eye; of samples that met nothing any numbers.
    sight : (n, 3) float
        Unit directions of the rays.

    Returns
    -------
    (n − 1,) bool
    """
    step, along = np.diff(points, axis=0), sight[:-1]
    depth = (step * along).sum(axis=1)
    across = step - depth[:, None] * along
    slack = BROKEN * np.linalg.norm(across, axis=1)
    ways = []
    for beside in (normals[:-1], normals[1:]):
        facing = np.minimum((beside * along).sum(axis=1), -EDGE_ON)
        ways.append(-(beside * across).sum(axis=1) / facing)
    low, high = np.minimum(*ways), np.maximum(*ways)
    return np.asarray((depth < low - slack) | (depth > high + slack))  # False beside NaN


def unbroken_runs(hit: Flags, apart: Flags) -> list[Index]:
    """Return the numbers of samples of each run of neighbours on one surface.

    Parameters
    ----------
    hit : (n,) bool
        Samples that met a surface.
    apart : (n − 1,) bool
        Whether a sample and the next are on different surfaces, if both met one.
    """
    kept = np.flatnonzero(hit)
    cut = (np.diff(kept) > 1) | apart[kept[:-1]]
    return [run for run in np.split(kept, np.flatnonzero(cut) + 1) if len(run)]
