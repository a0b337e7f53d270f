"""Which view says best what a curve is, and whether other views say the same."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto_symmetry.interpretation.candidate import Read
from bozzetto_symmetry.stereo.mirror_camera import MIRROR

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

AGREED: Final = 0.1
"""Greatest median distance, in sizes of the curve, between the places that two views give it;
beyond that the worse view's reading is a mistake, and only its ink counts."""

EVIDENCE: Final = ("pair", "self", "plane")
"""Readings, ordered by how unlikely each is to be a mistake of a view with little ink."""


def main_view(readings: Sequence[Sequence[Read]]) -> int:
    """Return the view that says best what the curve is: two sides say more than one stroke."""
    solved = [k for k, found in enumerate(readings) if found[0].reading != "half"]
    if not solved:
        return 0
    return min(
        solved, key=lambda k: (EVIDENCE.index(readings[k][0].reading), _trouble(readings[k][0]))
    )


def _trouble(reading: Read) -> float:
    """Return the median variance of what one view says, mm² per px²."""
    return float(np.median(np.trace(reading.covariances, axis1=1, axis2=2)))


def facing(found: Read, first: Read) -> Read:
    """Return a reading with the same half in front as the first one has.

    In this view the other side may have been drawn first.
    """
    if first.reading == "plane":
        return found
    image = found.points * MIRROR
    if first.reading == "pair":
        tree = tree_of(first.points)
        turned = bool(np.median(tree.query(image)[0]) < np.median(tree.query(found.points)[0]))
    else:
        turned = _side(found) != _side(first)
    if not turned:
        return found
    reflected = found.covariances * (MIRROR[:, None] * MIRROR)
    return replace(found, points=image, covariances=reflected, near=found.far, far=found.near)


def agree(found: Read, first: Read) -> bool:
    """Return whether two views put a curve in about the same place."""
    extent = float(np.linalg.norm(np.ptp(first.points, axis=0)))
    apart = [tree_of(a).query(b)[0] for a, b in ((found.points, first.points),
                                               (first.points, found.points))]  # fmt: skip
    return bool(max(np.median(each) for each in apart) < AGREED * extent)


def _side(across: Read) -> bool:
    """Return whether the half that was drawn first is on the positive side."""
    return bool(across.points[: len(across.points) // 2, 1].sum() > 0.0)


def tree_of(points: Array) -> cKDTree:
    """Return a tree of points (n, 3), to find the nearest one in."""
    from scipy.spatial import cKDTree

    return cKDTree(points)
